"""A design that turns, for the studio's tests: the Seawing glider, whose mass rolls to bank it.

Numbers from Zhang S., Yu J., Zhang A., Zhang F., 2013, Ocean Engineering 60, 1-13, as
in the preset seawing-spiral; the ballast is a piston here, so that a cell moves too. The
published spiral to which it tends banks by -13.7 deg and turns by 0.0039 rad/s.
"""

from __future__ import annotations

import math
from typing import Any

from models.design import Design, parse_design

ROLL_ANGLE = math.radians(45.0)
BUOYANCY_CHANGE = 3e-4
"""By how much the piston shrinks, m3: it makes the glider 0.3 kg heavy."""


def _parts() -> list[dict[str, Any]]:
    hull = {"kind": "hull", "length": 2.0, "radius": 0.11, "nose_length": 0.3, "tail_length": 0.5}
    wing = {"kind": "wing", "span": 1.2, "chord": 0.18, "tip_chord": 0.1, "sweep": 0.3, "thickness": 0.012,
            "offset": [-0.1, 0.0, 0.0]}  # fmt: skip
    fin = {"kind": "fin", "span": 0.28, "chord": 0.16, "tip_chord": 0.1, "sweep": 0.06, "thickness": 0.01,
           "offset": [-0.85, 0.0, -0.06]}  # fmt: skip
    body = {
        "kind": "rigid", "name": "Body", "mass": 53.28, "volume": 0.06428, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [-0.0829, 0.0, 0.0033], "inertia": {"xx": 0.6, "yy": 15.27, "zz": 15.32},
        "shapes": [hull, wing, fin],
    }  # fmt: skip
    battery = {
        "kind": "rolling_mass", "name": "Battery", "mass": 11.0, "position": [0.4216, 0.0, 0.014],
        "pivot": [0.4216, 0.0, 0.0], "angle_range": [-1.6, 1.6], "rate_limit": 0.1,
        "inertia": {"xx": 0.02, "yy": 0.17, "zz": 0.17},
        "shapes": [{"kind": "cylinder", "length": 0.5, "radius": 0.05, "offset": [0.0, 0.0, 0.03]}],
    }  # fmt: skip
    engine = {
        "kind": "piston", "name": "Engine", "mass": 1.0, "volume": 1e-3, "volume_range": [5e-4, 1.5e-3],
        "position": [0.0, 0.0, 0.0], "area": 0.01, "rate_limit": 0.002,
    }  # fmt: skip
    return [body, battery, engine]


def _hydrodynamics() -> dict[str, Any]:
    return {
        "kind": "coefficients",
        "provenance": {"title": "Seawing coefficients", "source": "Zhang et al., 2013, Ocean Engineering 60, 1-13"},
        "drag_zero": 7.19, "drag_attack": 386.29, "side_sideslip": -115.65, "lift_zero": -0.36, "lift_attack": 440.99,
        "roll_sideslip": -58.27, "roll_rate": -19.83, "pitch_zero": 0.28, "pitch_attack": -65.84,
        "pitch_rate": -205.64, "yaw_sideslip": 34.1, "yaw_rate": -389.3,
    }  # fmt: skip


def _added_mass() -> dict[str, Any]:
    matrix = [[0.0] * 6 for _ in range(6)]
    for i, value in enumerate((1.48, 49.58, 65.92, 0.53, 7.88, 10.18)):
        matrix[i][i] = value
    matrix[1][5] = matrix[5][1] = 3.61
    matrix[2][4] = matrix[4][2] = 2.57
    return {"matrix": matrix}


def spiral_document(*, duration: float = 600.0, model: str = "spatial") -> dict[str, Any]:
    """Return the document: heavy by 0.3 kg from the start, then the battery rolls to 45 degrees."""
    shrunk = -BUOYANCY_CHANGE / 0.01
    schedules = [
        {"cell": "Battery", "points": [{"time": 20.0, "extension": ROLL_ANGLE}]},
        {"cell": "Engine", "points": [{"time": 2.0, "extension": shrunk}]},
    ]
    return {
        "format": "glider-design", "version": 1, "name": "Seawing spiral",
        "vehicle": {
            "components": _parts(), "hydrodynamics": _hydrodynamics(), "added_mass": _added_mass(), "hotel_power": 1.0,
        },
        "mission": {
            "environment": {"gravity": 9.81},
            "initial": {"position": [0.0, 0.0, 2.0], "pitch": -0.4, "velocity": [0.1, 0.0, 0.0]},
            "control": {"schedules": schedules}, "duration": duration,
            "solver": {"model": model, "output_interval": 0.2},
        },
    }  # fmt: skip


def spiral(*, duration: float = 600.0) -> Design:
    """Return the design."""
    return parse_design(spiral_document(duration=duration))
