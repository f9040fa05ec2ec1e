"""Owns count, mean, standard deviation and extremes of columns that come in parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Moments:
    """Statistics of `columns` columns; what is not a number does not count.

    Parts are joined as by Chan, Golub and LeVeque (1983), "Algorithms for computing the sample variance", Am. Stat. 37,
    equations 2.1, so that no digits are lost where the mean is large beside the spread.
    """

    def __init__(self, columns: int) -> None:
        self.count: NDArray[np.int64] = np.zeros(columns, dtype=np.int64)
        self.least: Array = np.full(columns, np.nan)
        self.most: Array = np.full(columns, np.nan)
        self._mean: Array = np.zeros(columns)
        self._squares: Array = np.zeros(columns)

    @property
    def mean(self) -> Array:
        """Means, not a number where nothing counts."""
        return np.where(self.count > 0, self._mean, np.nan)

    @property
    def sd(self) -> Array:
        """Standard deviations (of n - 1), not a number where fewer than two values count."""
        return np.sqrt(np.where(self.count > 1, self._squares / np.maximum(self.count - 1, 1), np.nan))

    def add(self, values: Array) -> None:
        """Add rows (rows, columns)."""
        if not len(values):
            return
        present = np.isfinite(values)
        count = present.sum(axis=0)
        with np.errstate(all="ignore"):  # of runs that went wild anything may overflow
            mean = np.where(present, values, 0.0).sum(axis=0) / np.maximum(count, 1)
            apart = np.where(present, values - mean, 0.0)
            step = mean - self._mean
            both = self.count + count
            share = count / np.maximum(both, 1)
            self._squares += (apart * apart).sum(axis=0) + step * step * self.count * share
            self._mean += step * share
        self.count = both
        self.least = np.fmin(self.least, np.fmin.reduce(values, axis=0))
        self.most = np.fmax(self.most, np.fmax.reduce(values, axis=0))
