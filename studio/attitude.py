"""Owns attitudes for drawing: unit quaternions (w, x, y, z), body to world, in the physics' own axes (z down)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from models.attitude import quaternion_from_rpy_radians
from models.run import Run

Array = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]


def attitude_of(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the attitude of roll, pitch and yaw (Z-Y-X), rad: starboard down, nose up, nose to starboard."""
    w, x, y, z = (float(v) for v in quaternion_from_rpy_radians(roll, pitch, yaw))
    return w, x, y, z


def quaternion_about(axis: tuple[float, float, float], angle: float) -> Quaternion:
    """Return the rotation about an axis of any length by an angle, rad, right-handed."""
    x, y, z = np.array(axis) / np.linalg.norm(axis) * math.sin(angle / 2.0)
    return math.cos(angle / 2.0), float(x), float(y), float(z)


def rotate(points: Array, attitude: Quaternion) -> Array:
    """Turn points (n, 3) by a unit quaternion."""
    w, u = attitude[0], np.array(attitude[1:])
    return np.asarray(points + 2.0 * np.cross(u, np.cross(u, points) + w * points), dtype=np.float64)


def continuous(quaternions: Array) -> Array:
    """Return quaternions (n, 4) with signs such that neighbours are near: q and -q are one attitude."""
    turned = np.cumsum(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0) % 2 == 1
    signs = np.where(np.concatenate([[False], turned]), -1.0, 1.0)
    return np.asarray(quaternions * signs[:, None], dtype=np.float64)


def attitudes(run: Run) -> Array:
    """Return the attitude at each sample (n, 4), neighbours near."""
    if run.model == "spatial":
        return continuous(np.column_stack([run.values[f"q{i}"] for i in range(4)]))
    half = run.values["theta"] / 2.0
    return np.column_stack([np.cos(half), np.zeros_like(half), np.sin(half), np.zeros_like(half)])


def attitude_at(run: Run, t: float) -> Quaternion:
    """Return the attitude at a time: linear between the two samples around it, and of length 1."""
    k = int(np.clip(np.searchsorted(run.times, t, side="right") - 1, 0, max(len(run.times) - 2, 0)))
    times, both = run.times[k : k + 2], run.select(np.arange(k, min(k + 2, len(run.times))))
    q = np.array([np.interp(t, times, column) for column in attitudes(both).T])
    w, x, y, z = (float(v) for v in q / np.linalg.norm(q))
    return w, x, y, z
