"""Owns attitude outside the kernel: unit quaternions, body to world, scalar first (Hamilton).

SciPy's rotations would do; loading them took a third of a second of every start.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def quaternion_from_rpy_radians(roll: float, pitch: float, yaw: float) -> Array:
    """Return the quaternion (4,) of Z-Y-X angles in rad (Fossen, 2011, Eq. 2.72)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2.0), math.sin(a / 2.0)) for a in (roll, pitch, yaw))
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def rotation_of(quaternion: Array) -> Array:
    """Return the rotation (3, 3), body to world, of a unit quaternion (4,)."""
    w, v = quaternion[0], quaternion[1:]
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + 2.0 * (w * skew + skew @ skew), dtype=np.float64)
