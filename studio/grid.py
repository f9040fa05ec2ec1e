"""Owns where the lines of depth and distance run that make a path readable: a plane, or walls and rungs in space.

World axes (z down), metres. A line is a pair of points; a label is its text and its place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Label = tuple[str, tuple[float, float, float]]

MAX_DEPTH_LINES = 24
MAX_LABELS = 112
MAX_RUNGS = 160
MAX_RUNG_LABELS = 60
WALL_STEPS = 8
MOST_SQUARES = 24
RUNG = 0.6
"""Half the length of a rung, in lengths of the vehicle."""


@dataclass(frozen=True)
class Lines:
    """Lines (n, 2, 3) and their labels."""

    lines: NDArray[np.float32]
    labels: list[Label] = field(default_factory=list)


def nice_step(span: float, most: int) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that divides a span into at most `most` steps."""
    least = span / most
    power = 10.0 ** math.floor(math.log10(least))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= least * (1.0 - 1e-12))


def segments(points: Array) -> NDArray[np.float32]:
    """Return a line through points as segments (n - 1, 2, 3)."""
    line = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    return np.stack([line[:-1], line[1:]], axis=1).astype(np.float32)


def plane(low: float, high: float, begin: float, end: float, *, step: float, apart: float) -> Lines:
    """Return depth lines in the plane of a planar glide, labels about every `apart`.

    In that plane itself: behind it, perspective would put the glider at another line than its own.
    """
    depths = _multiples(low, high, step)
    lines = np.array([[(begin, 0.0, z), (end, 0.0, z)] for z in depths], dtype=np.float32).reshape(-1, 2, 3)
    # where the glider passes there should always be a label in sight
    columns = max(1, min(round((end - begin) / apart), MAX_LABELS // max(len(depths), 1)))
    places = np.linspace(begin, end, columns + 1)[:-1]
    return Lines(lines, [(f"{z:g} m", (float(x), 0.0, float(z))) for x in places for z in depths])


def rungs(points: Array, length: float) -> Lines:
    """Return a short level line across a path in space wherever it passes a round depth, and that depth beside it.

    Level lines show a bank, and a turn as the rungs of a ladder do.
    """
    travel = float(np.abs(np.diff(points[:, 2])).sum())
    step = max(nice_step(4.0 * length, 5), nice_step(travel + length, MAX_RUNGS))
    begin, end = points[:-1], points[1:]
    lines, labels = [], []
    for level in _multiples(float(points[:, 2].min()), float(points[:, 2].max()), step):
        above, below = begin[:, 2] - level, end[:, 2] - level
        for k in np.flatnonzero((above <= 0.0) != (below <= 0.0)):
            place = begin[k] + above[k] / (above[k] - below[k]) * (end[k] - begin[k])
            across = RUNG * length * _to_starboard(end[k] - begin[k])
            lines.append((place - across, place + across))
            x, y, z = place + across
            labels.append((f"{level:g} m", (float(x), float(y), float(z))))
    labels = labels[:: max(1, math.ceil(len(labels) / MAX_RUNG_LABELS))]
    return Lines(np.array(lines, dtype=np.float32).reshape(-1, 2, 3), labels)


def room(low: Array, high: Array) -> Lines:
    """Return the lines of two walls (west and south of the path) and a floor around the box from `low` to `high` (3,).

    The box's sides are multiples of the steps that `room_box` chose.
    """
    north, east, depth = (nice_step(float(high[i] - low[i]), WALL_STEPS) for i in range(3))
    xs, ys, zs = (_multiples(float(low[i]), float(high[i]), step) for i, step in enumerate((north, east, depth)))
    (x0, y0, z0), (x1, y1, z1) = low, high
    lines = [((x0, y0, z), (x1, y0, z)) for z in zs] + [((x0, y0, z), (x0, y1, z)) for z in zs]
    lines += [((x, y0, z0), (x, y0, z1)) for x in xs] + [((x0, y, z0), (x0, y, z1)) for y in ys]
    lines += [((x, y0, z1), (x, y1, z1)) for x in xs] + [((x0, y, z1), (x1, y, z1)) for y in ys]
    # on the floor every other line, or their names would lie over each other
    labels: list[Label] = [(f"{z:g} m", (float(x0), float(y1), float(z))) for z in zs if z < z1]
    labels += [(_toward(x, "N", "S"), (float(x), float(y1), float(z1))) for x in xs[2::2]]
    labels += [(_toward(y, "E", "W"), (float(x1), float(y), float(z1))) for y in ys[2::2] if y < y1]
    return Lines(np.array(lines, dtype=np.float32).reshape(-1, 2, 3), labels)


def room_box(points: Array, length: float, bed: float | None) -> tuple[Array, Array]:
    """Return the corners (3,) of a box around a path, at round numbers."""
    low, high = points.min(axis=0) - 2.0 * length, points.max(axis=0) + 2.0 * length
    for i in range(3):
        step = nice_step(float(high[i] - low[i]), WALL_STEPS)
        low[i], high[i] = step * math.floor(low[i] / step), step * math.ceil(high[i] / step)
    low[2] = max(low[2], 0.0)
    high[2] = high[2] if bed is None else min(high[2], bed)
    return low, high


def level_grid(x: tuple[float, float], y: tuple[float, float], length: float) -> NDArray[np.float32]:
    """Return the lines of a level grid at z = 0 over and around a rectangle: squares that tell how fast it passes."""
    low, high = (np.array([a[k] for a in (x, y)]) for k in (0, 1))
    around = 12.0 * length
    step = max(nice_step(around, 8), nice_step(float((high - low).max()) + 2.0 * around, MOST_SQUARES))
    xs, ys = (_multiples(float(low[k] - around), float(high[k] + around), step) for k in (0, 1))
    lines = [((a, ys[0], 0.0), (a, ys[-1], 0.0)) for a in xs] + [((xs[0], b, 0.0), (xs[-1], b, 0.0)) for b in ys]
    return np.array(lines, dtype=np.float32).reshape(-1, 2, 3)


def _toward(value: float, positive: str, negative: str) -> str:
    return "0" if abs(value) < 1e-9 else f"{abs(value):g} m {positive if value > 0.0 else negative}"


def _to_starboard(step: Array) -> Array:
    """Return the level direction to the right of a step; east for one straight down."""
    size = math.hypot(step[0], step[1])
    return np.array([-step[1] / size, step[0] / size, 0.0]) if size > 1e-12 else np.array([0.0, 1.0, 0.0])


def _multiples(low: float, high: float, step: float) -> Array:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.round(step * np.arange(first, last + 1, dtype=np.float64), 9)
