"""Owns the choice of samples for a curve of few points that hides no extreme."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

LEAST_POINTS = 2


def choose_samples(columns: Sequence[NDArray[np.float64]], max_points: int) -> NDArray[np.int64]:
    """Return rising indices of at most `max_points` samples (at least 2) that stand for all columns together.

    Where there are no more samples than points, all are taken; else exactly `max_points`, in this order of priority:

    1. the first and the last sample;
    2. the least and the greatest value of each column, column by column in the order given (the first of equals;
       with C columns all are kept from 2 + 2 C points on);
    3. the least and the greatest value of each column within each of B equal stretches of the samples,
       B = (max_points - 2 - 2 C) // (2 C), so that every stretch keeps its extremes;
    4. samples spread evenly over those not chosen yet.

    A value that is not a number is never an extreme.
    """
    if max_points < LEAST_POINTS:
        raise ValueError(f"max_points is {max_points}; a curve needs at least {LEAST_POINTS}")
    count = len(columns[0])
    if count <= max_points:
        return np.arange(count)
    chosen = np.zeros(count, dtype=bool)
    chosen[[0, -1]] = True
    for index in _extremes(columns):
        if chosen.sum() >= max_points:
            break
        chosen[index] = True
    _choose_local_extremes(chosen, columns, max_points)
    rest = np.flatnonzero(~chosen)
    wanted = max_points - int(chosen.sum())
    # the middle of each of `wanted` equal stretches: distinct, since there are at least as many left as wanted
    chosen[rest[((np.arange(wanted) + 0.5) * (len(rest) / max(wanted, 1))).astype(np.int64)]] = True
    return np.flatnonzero(chosen)


def _extremes(columns: Sequence[NDArray[np.float64]]) -> list[int]:
    found: list[int] = []
    for column in columns:
        missing = np.isnan(column)
        if not missing.all():
            found.append(int(np.argmin(np.where(missing, np.inf, column))))
            found.append(int(np.argmax(np.where(missing, -np.inf, column))))
    return found


def _choose_local_extremes(chosen: NDArray[np.bool_], columns: Sequence[NDArray[np.float64]], max_points: int) -> None:
    buckets = (max_points - 2 - 2 * len(columns)) // (2 * len(columns))
    if buckets < 1:
        return
    edges = np.linspace(0, len(chosen), buckets + 1).astype(np.int64)
    for begin, end in pairwise(edges):
        stretch = [column[begin:end] for column in columns]
        chosen[begin + np.array(_extremes(stretch), dtype=np.int64)] = True
