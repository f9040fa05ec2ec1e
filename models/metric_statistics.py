"""Owns statistics over time of what is known at samples and goes straight between them: exact for such lines.

A piece is a pair of arrays, times (n,) s and values (n,), all finite; what is not a number separates pieces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from models.metric_requests import StatisticName

Array = NDArray[np.float64]
Piece = tuple[Array, Array]
Interval = tuple[float, float]
FINEST_PERCENTILE = 1e-12
"""A percentile is found to this share of the range of values."""


def pieces_of(times: Array, values: Array, *, absolute: bool = False) -> list[Piece]:
    """Return the pieces of an output in which it is a number, or those of its magnitude."""
    finite = np.isfinite(values)
    if finite.all():
        pieces = [(times, values)]
    else:
        edges = np.flatnonzero(np.diff(finite.astype(np.int8), prepend=0, append=0))
        pieces = [(times[a:b], values[a:b]) for a, b in edges.reshape(-1, 2)]
    return [_magnitude(*piece) for piece in pieces] if absolute else pieces


def _magnitude(times: Array, values: Array) -> Piece:
    """Return |values| with a sample at each crossing of zero, between which it goes straight."""
    k = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    crossings = times[k] + (times[k + 1] - times[k]) * values[k] / (values[k] - values[k + 1])
    return np.insert(times, k + 1, crossings), np.abs(np.insert(values, k + 1, 0.0))


def changes(values: Array) -> Array:
    """Return what `np.diff` does, which for a few hundred values takes longer to be called than to be computed."""
    return values[1:] - values[:-1]


def duration(pieces: Sequence[Piece]) -> float:
    """Return the time that pieces take together, s."""
    return math.fsum(t[-1] - t[0] for t, _ in pieces)


def beyond(pieces: Sequence[Piece], limit: float, *, below: bool) -> list[Interval]:
    """Return the intervals of time in which values are larger than a limit, or smaller."""
    return [interval for t, v in pieces for interval in (_above(t, -v, -limit) if below else _above(t, v, limit))]


def _above(times: Array, values: Array, limit: float) -> list[Interval]:
    inside = values > limit
    k = np.flatnonzero(inside[1:] != inside[:-1])
    edges = times[k] + (times[k + 1] - times[k]) * (limit - values[k]) / (values[k + 1] - values[k])
    marks = [*times[:1][inside[:1]].tolist(), *edges.tolist(), *times[-1:][inside[-1:]].tolist()]
    return [(a, b) for a, b in zip(marks[::2], marks[1::2], strict=True) if b > a]


def statistic(pieces: Sequence[Piece], name: StatisticName, *, percent: float | None = None) -> float:
    """Return a statistic of pieces; not a number where there are none."""
    if not pieces:
        return math.nan
    return percentile(pieces, percent) if percent is not None else STATISTICS[name](pieces)


def maximum(pieces: Sequence[Piece]) -> float:
    """Return the largest value."""
    return max(float(v.max()) for _, v in pieces)


def minimum(pieces: Sequence[Piece]) -> float:
    """Return the smallest value."""
    return min(float(v.min()) for _, v in pieces)


def time_integral(pieces: Sequence[Piece]) -> float:
    """Return the integral of the values over time."""
    return math.fsum(float(np.dot(changes(t), v[1:] + v[:-1])) / 2.0 for t, v in pieces)


def mean(pieces: Sequence[Piece]) -> float:
    """Return the mean over time; over an instant, that of the values."""
    length = duration(pieces)
    return time_integral(pieces) / length if length > 0.0 else float(np.mean(np.concatenate([v for _, v in pieces])))


def rms(pieces: Sequence[Piece]) -> float:
    """Return the root of the mean square over time."""
    length = duration(pieces)
    if length <= 0.0:
        return abs(mean(pieces))
    squares = (float(np.dot(changes(t), v[1:] ** 2 + v[1:] * v[:-1] + v[:-1] ** 2)) / 3.0 for t, v in pieces)
    return math.sqrt(math.fsum(squares) / length)


def standard_deviation(pieces: Sequence[Piece]) -> float:
    """Return the root mean square over time of the departure from the mean."""
    center = mean(pieces)
    return rms([(t, v - center) for t, v in pieces])


def travel(pieces: Sequence[Piece]) -> float:
    """Return the sum of the magnitudes of all changes."""
    return math.fsum(float(np.abs(changes(v)).sum()) for _, v in pieces)


def percentile(pieces: Sequence[Piece], percent: float) -> float:
    """Return the value below which the output is for a share of the time, by bisection."""
    low, high = minimum(pieces), maximum(pieces)
    wanted, least = 0.01 * percent * duration(pieces), FINEST_PERCENTILE * (high - low)
    if percent in (0.0, 100.0):
        return low if percent == 0.0 else high
    while high - low > least and low < 0.5 * (low + high) < high:
        middle = 0.5 * (low + high)
        if math.fsum(_time_below(t, v, middle) for t, v in pieces) < wanted:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _time_below(times: Array, values: Array, limit: float) -> float:
    low, high = np.minimum(values[1:], values[:-1]), np.maximum(values[1:], values[:-1])
    rise = high - low
    share = np.divide(limit - low, rise, out=(low < limit).astype(np.float64), where=rise > 0.0)
    return float(np.dot(changes(times), np.clip(share, 0.0, 1.0)))


STATISTICS: Mapping[StatisticName, Callable[[Sequence[Piece]], float]] = {
    "maximum": maximum, "minimum": minimum, "mean": mean, "rms": rms, "standard_deviation": standard_deviation,
    "travel": travel, "time_integral": time_integral,
    "first": lambda pieces: float(pieces[0][1][0]),
    "final": lambda pieces: float(pieces[-1][1][-1]),
    "span": lambda pieces: maximum(pieces) - minimum(pieces),
}  # fmt: skip
"""By name; a percentile needs its percent besides."""
