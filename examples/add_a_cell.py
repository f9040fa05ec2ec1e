"""Add a third cell to the paper's glider, simulate both, and compare: `python examples/add_a_cell.py`."""

from __future__ import annotations

import math

from models.presets import load_preset
from models.simulate import simulate
from server.editing import apply_patch

design = load_preset("canete-dual-bellows")
cell = {
    "kind": "piston",
    "name": "Middle piston",
    "mass": 0.05,
    "volume": 50e-6,
    "volume_range": [45e-6, 55e-6],
    "position": [0.0, 0.0, 0.0],
}
schedule = {"cell": "Middle piston", "points": [{"time": 0, "extension": -0.002}, {"time": 10, "extension": 0.002}]}
with_cell = apply_patch(
    design,
    [
        {"op": "add", "path": "/vehicle/components/-", "value": cell},
        {"op": "replace", "path": "/vehicle/components/0/volume", "value": design.vehicle.components[0].volume - 50e-6},
        {"op": "add", "path": "/mission/control/schedules/-", "value": schedule},
    ],
)
for name, candidate in (("two cells", design), ("three cells", with_cell)):
    end = simulate(candidate).final
    print(
        f"{name:<12} ends at x {end['x']:.3f} m, depth {end['z']:.3f} m, "
        f"pitch {math.degrees(end['theta']):.1f} deg after {end['t']:.1f} s"
    )
