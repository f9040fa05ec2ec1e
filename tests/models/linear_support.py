"""Owns what the tests of linear models share: pendulums at rest in closed form, and slopes by differences apart."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.design import Design, parse_design
from models.kernel import spatial_layout
from models.kernel.params import Params
from models.operating_point import OperatingPoint
from tests.models.support import document, slope_at

Array = NDArray[np.float64]
GRAVITY, MASS, DENSITY = 9.8, 1.0, 1000.0
INERTIA = {"xx": 0.01, "yy": 0.02, "zz": 0.02}


def body(*, below: float = 0.004, net_weight: float = 0.0, depth_density: float = DENSITY) -> dict[str, Any]:
    """A rigid body with its centre of buoyancy at the origin and that of mass so far below, m."""
    return {
        "kind": "rigid", "name": "Body", "mass": MASS, "volume": (MASS - net_weight / GRAVITY) / depth_density,
        "position": [0.0, 0.0, 0.0], "center_of_mass": [0.0, 0.0, below], "inertia": INERTIA,
    }  # fmt: skip


def resting_design(
    *, below: float = 0.004, added: dict[int, float] | None = None, damping: dict[str, float] | None = None,
    model: str = "spatial", water: dict[str, Any] | None = None, density: float = DENSITY,
) -> Design:  # fmt: skip
    """A neutral body alone, with added mass on the diagonal by axis (0 to 5), and linear damping by name."""
    changed = document(initial={"position": [0.0, 0.0, 10.0]}, duration=1.0)
    matrix = np.zeros((6, 6))
    for axis, value in (added or {}).items():
        matrix[axis, axis] = value
    changed["vehicle"] |= {
        "components": [body(below=below, depth_density=density)], "damping": damping or {},
        "added_mass": {"enabled": True, "matrix": matrix.tolist(), "density": density},
    }  # fmt: skip
    changed["mission"] |= {
        "environment": {"water": water or {"density": density}, "gravity": GRAVITY}, "solver": {"model": model},
    }  # fmt: skip
    return parse_design(changed)


REST = OperatingPoint(depth=10.0)


def euler_of(q: Array) -> Array:
    """Roll, pitch and yaw (Z-Y-X) of a quaternion of any length, rad."""
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(2 * (w * y - x * z)),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    ])  # fmt: skip


def quaternion_of(angles: Array) -> Array:
    """The quaternion of roll, pitch, yaw as a product of three turns."""

    def times(a: Array, b: Array) -> Array:
        return np.array([
            a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])),
        ])  # fmt: skip

    result = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in ((2, angles[2]), (1, angles[1]), (0, angles[0])):
        turn = np.zeros(4)
        turn[0], turn[1 + axis] = math.cos(angle / 2), math.sin(angle / 2)
        result = times(result, turn)
    return result


def minimal_rates(p: Params, length: int, minimal: Array) -> Array:
    """The rates of z, phi, theta, psi, u ... r by the kernel's own derivative of the quaternion, extensions held."""
    n = len(p.parts)
    y = np.zeros(length)
    y[spatial_layout.Z] = minimal[0]
    y[spatial_layout.Q0 : spatial_layout.Q3 + 1] = quaternion_of(minimal[1:4])
    y[spatial_layout.U : spatial_layout.R + 1] = minimal[4:10]
    y[spatial_layout.EXTENSIONS : spatial_layout.EXTENSIONS + n] = minimal[10:]
    dy = slope_at(p, y)
    q, dq, h = y[3:7], dy[3:7], 1e-2
    angles = (8.0 * (euler_of(q + h * dq) - euler_of(q - h * dq))
              - (euler_of(q + 2 * h * dq) - euler_of(q - 2 * h * dq))) / (12.0 * h)  # fmt: skip
    return np.array([dy[spatial_layout.Z], *angles, *dy[spatial_layout.U : spatial_layout.R + 1]])


def differences(assembly: Assembly, minimal: Array, steps: Array) -> Array:
    """Slopes of the minimal rates by plain central differences, (10, 10 + parts)."""
    p, length = assembly.params, len(assembly.initial_state)
    columns = []
    for j, h in enumerate(steps):
        step = np.zeros(len(minimal))
        step[j] = h
        columns.append((minimal_rates(p, length, minimal + step) - minimal_rates(p, length, minimal - step)) / (2 * h))
    return np.array(columns).T
