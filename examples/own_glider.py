"""Write a spatial glider from scratch, dive it straight, then bank and turn it: `python examples/own_glider.py`.

Body axes: x to the nose, y to starboard, z down. Every number is made up; SI units and radians throughout.
"""

from __future__ import annotations

import math

from models.design import parse_design
from models.simulate import simulate

AREA = 1e-3  # of a piston, m2: 10 mm of extension are 10 cm3


def cell(side: str, y: float) -> dict[str, object]:
    """Return a piston cell beside the hull; its extension counts from the neutral volume."""
    volume = {"volume": 5e-4, "volume_range": [4e-4, 6e-4], "area": AREA}
    return {
        "kind": "piston",
        "name": f"{side} cell",
        "mass": 0.5,
        "position": [0.0, y, 0.0],
        "rate_limit": 1e-3,
    } | volume


def schedule(side: str, turning: float) -> dict[str, object]:
    """Return the commands of a cell: heavy for the dive, and from 120 s on lighter or heavier than its twin."""
    points = [{"time": 0.0, "extension": -0.05}, {"time": 120.0, "extension": turning}]
    return {"cell": f"{side} cell", "points": points}


hull = {
    "kind": "rigid", "name": "Hull", "mass": 19.0, "volume": 0.019, "position": [0.0, 0.0, 0.0],
    "center_of_mass": [0.0015, 0.0, 0.003], "inertia": {"xx": 0.2, "yy": 3.0, "zz": 3.0},
}  # fmt: skip
forces = {  # per squared speed, angles in rad: D = 6 + 120 alpha^2, L = 150 alpha, side force -60 beta, and moments
    "kind": "coefficients", "provenance": {"title": "Made up", "source": "For this example."},
    "drag_zero": 6.0, "drag_attack": 120.0, "lift_attack": 150.0, "side_sideslip": -60.0, "roll_sideslip": -4.0,
    "roll_rate": -10.0, "pitch_attack": -30.0, "pitch_rate": -40.0, "yaw_sideslip": 25.0, "yaw_rate": -15.0,
}  # fmt: skip
design = parse_design({
    "format": "glider-design", "version": 1, "name": "My glider",
    "vehicle": {
        "components": [hull, cell("Port", -0.2), cell("Starboard", 0.2)], "hydrodynamics": forces,
        "damping": {"roll": 1.0, "pitch": 1.0, "yaw": 1.0},
    },
    "mission": {
        "environment": {"water": {"kind": "uniform", "density": 1000.0}},
        "initial": {"position": [0.0, 0.0, 2.0], "velocity": [0.2, 0.0, 0.0]},
        "control": {"schedules": [schedule("Port", -0.02), schedule("Starboard", -0.08)]},
        "duration": 400.0, "solver": {"model": "spatial", "output_interval": 1.0},
    },
})  # fmt: skip
run = simulate(design)
print(f"{design.name}: {run.status.name} after {run.final['t']:.0f} s, depth {run.final['z']:.1f} m")
for time in (119.0, 400.0):
    now = {name: float(column[int(time)]) for name, column in run.values.items()}
    print(
        f"at {time:.0f} s: pitch {math.degrees(now['theta']):.1f} deg, roll {math.degrees(now['phi']):.1f} deg, "
        f"{now['speed']:.2f} m/s, turning {math.degrees(now['turn_rate']):.2f} deg/s"
    )
