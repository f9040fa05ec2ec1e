"""One design for each kind of water, current and force data, for the studio's tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.studio.spiral import spiral_document

ANGLES = (-180.0, -90.0, -20.0, -10.0, 0.0, 10.0, 20.0, 90.0, 180.0)
SLIPS = (0.0, 10.0, 90.0)


def angle_table(alpha_deg: tuple[float, ...] = ANGLES) -> dict[str, Any]:
    """Return a table of the forces of a drag of 2 V^2, a lift of 9 sin(2 alpha) V^2 and a moment of -sin(2 alpha)."""
    a, b = np.radians(alpha_deg)[:, None], np.radians(SLIPS)[None, :]
    lift, still = 9.0 * np.sin(2.0 * a) * np.cos(b), np.zeros((len(alpha_deg), len(SLIPS)))
    grids = {
        "surge": lift * np.sin(a) - 2.0 * np.cos(a) * np.cos(b),
        "sway": still - 20.0 * np.sin(b),
        "heave": -lift * np.cos(a) - 2.0 * np.sin(a) * np.cos(b),
        "roll": still,
        "pitch": -np.sin(2.0 * a) * np.cos(b),
        "yaw": still + 3.0 * np.sin(b),
    }
    return {
        "kind": "angle_table", "provenance": {"title": "A table", "source": "made up for this test"},
        "alpha_deg": list(alpha_deg), "beta_deg": list(SLIPS),
    } | {name: grid.tolist() for name, grid in grids.items()}  # fmt: skip


PROFILE = {"kind": "density_profile", "depths": [0.0, 20.0, 300.0], "densities": [998.0, 999.5, 1002.0],
           "source": "a made-up lake"}  # fmt: skip
TEOS10 = {"kind": "teos10", "depths": [0.0, 30.0, 300.0], "temperatures": [20.0, 8.0, 5.0], "latitude": 35.0}
UNIFORM_CURRENT = {"kind": "uniform", "velocity": [0.05, -0.02]}
SHEARED = {"kind": "sheared", "surface_velocity": [0.1, 0.0], "shear": [-0.001, 0.0]}
TABULATED = {"kind": "tabulated", "depths": [0.0, 50.0], "north": [[0.1, 0.0]], "east": [[0.0, 0.0]]}


def documents() -> dict[str, dict[str, Any]]:
    """Return the designs by name."""
    made = {}
    for name, place, value in (
        ("coefficients", ("vehicle", "hydrodynamics"), None),
        ("angle_table", ("vehicle", "hydrodynamics"), angle_table()),
        ("density_profile", ("mission", "environment"), {"water": PROFILE}),
        ("teos10", ("mission", "environment"), {"water": TEOS10}),
        ("uniform_current", ("mission", "environment"), {"current": UNIFORM_CURRENT}),
        ("sheared_current", ("mission", "environment"), {"current": SHEARED}),
        ("tabulated_current", ("mission", "environment"), {"current": TABULATED}),
        ("no_gravity", ("mission", "environment"), {}),
    ):
        document = spiral_document(duration=20.0)
        if value is not None:
            document[place[0]][place[1]] = value
        made[name] = document
    return made
