"""Owns the arrows of the current in the scene: the way the water goes, by depth, at the start of the mission."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.environment import Current
from models.water import current_table
from studio.grid import Label, nice_step

Array = NDArray[np.float64]

MOST_ARROWS = 40
LONGEST = 0.9
"""Length of the arrow of the strongest current, in lengths of the vehicle."""
SMALLEST = 1e-6
"""Below this, m/s, the water counts as still."""


@dataclass(frozen=True)
class CurrentArrows:
    """Arrows (n, 2, 3), from tail to head in world axes, and the label of each."""

    arrows: NDArray[np.float32]
    labels: list[Label]


def current_at(current: Current, depths: Array) -> Array:
    """Return the velocity (n, 2) north and east at depths (n,) when the mission begins, m/s."""
    table = current_table(current)
    profiles = table.rows.reshape(len(table.times), table.levels, 9)
    rows = np.maximum(np.searchsorted(profiles[0, :, 0], depths, side="right") - 1, 0)
    h = (depths - profiles[0, rows, 0])[:, None] ** np.arange(4)
    values = np.einsum("tnkp,np->tnk", profiles[:, rows, 1:].reshape(len(table.times), -1, 2, 4), h)
    first = [[np.interp(0.0, table.times, values[:, n, k]) for k in (0, 1)] for n in range(len(depths))]
    return np.array(first, dtype=np.float64).reshape(-1, 2)


def current_arrows(current: Current | None, points: Array, length: float) -> CurrentArrows:
    """Return arrows beside a path at round depths, the longest as long as the vehicle; none in still water."""
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    step = nice_step(max(high - low, length), MOST_ARROWS)
    depths: Array = step * np.arange(max(math.floor(low / step), 0), math.ceil(high / step) + 1, dtype=np.float64)
    velocity = np.zeros((0, 2)) if current is None else current_at(current, depths)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    fastest = float(speed.max(initial=0.0))
    if fastest < SMALLEST:
        return CurrentArrows(np.zeros((0, 2, 3), dtype=np.float32), [])
    moving = speed > 0.02 * fastest
    nearest = [points[np.argmin(np.abs(points[:, 2] - z))] for z in depths]
    # to port of where the path passes this depth, clear of the vehicle
    tails = np.array([(p[0], p[1] - 1.6 * length, z) for p, z in zip(nearest, depths, strict=True)])
    heads = tails + LONGEST * length / fastest * np.column_stack([velocity, np.zeros(len(velocity))])
    labels = [
        (f"{v:.2g} m/s", (float(x), float(y), float(z)))
        for v, (x, y, z), moves in zip(speed, tails, moving, strict=True)
        if moves
    ]
    return CurrentArrows(np.stack([tails, heads], axis=1)[moving].astype(np.float32), labels)
