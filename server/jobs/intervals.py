"""Owns the confidence interval of a mean: the bootstrap's, or the normal one where values are many.

Bootstrap: bias-corrected and accelerated (Efron, 1987, "Better bootstrap confidence intervals", J. Am. Stat. Assoc. 82,
section 3). Its ends differ from the normal ones by about skewness / (6 sqrt(n)) standard errors times (z^2 - 1), which
beyond a few thousand values is nothing, and its cost grows with n.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

Array = NDArray[np.float64]
RESAMPLES = 2000
MOST_RESAMPLED = 5000
"""Most values that are resampled."""
DRAWS_AT_ONCE = 500_000
SEED = 20_250_101
"""Any number: the same values always give the same interval."""


@dataclass(frozen=True, slots=True)
class Interval:
    """An interval that covers the mean with about the probability `confidence`."""

    low: float
    high: float
    method: str
    confidence: float


def interval_of_mean(values: Array, *, confidence: float = 0.95) -> Interval | None:
    """Return the interval of the mean of finite values, None where there are fewer than two."""
    count = len(values)
    if count < 2:
        return None
    if count > MOST_RESAMPLED:
        return normal_interval(float(values.mean()), float(values.std(ddof=1)), count, confidence=confidence)
    mean, tail = float(values.mean()), 0.5 - 0.5 * confidence
    if np.ptp(values) == 0.0:
        return Interval(mean, mean, "bootstrap", confidence)
    apart = values - mean
    scale = float(np.abs(apart).max())  # powers of values that are far out would overflow
    apart /= scale
    means = _resampled_means(apart)
    below = np.count_nonzero(means < 0.0) + 0.5 * np.count_nonzero(means == 0.0)
    bias = ndtri(np.clip(below, 0.5, RESAMPLES - 0.5) / RESAMPLES)
    acceleration = float(np.sum(apart**3)) / (6.0 * float(apart @ apart) ** 1.5)
    z = bias + ndtri(np.array([tail, 1.0 - tail]))
    low, high = scale * np.quantile(means, ndtr(bias + z / (1.0 - acceleration * z)))
    return Interval(mean + float(low), mean + float(high), "bootstrap", confidence)


def normal_interval(mean: float, sd: float, count: int, *, confidence: float = 0.95) -> Interval:
    """Return the interval of a mean by the central limit theorem."""
    reach = float(ndtri(0.5 + 0.5 * confidence)) * sd / count**0.5
    return Interval(mean - reach, mean + reach, "normal", confidence)


def _resampled_means(values: Array) -> Array:
    """Return the means of samples drawn from the values with replacement, each as large as they are."""
    generator, count = np.random.default_rng(SEED), len(values)
    means = np.empty(RESAMPLES)
    rows = max(1, DRAWS_AT_ONCE // count)
    for first in range(0, RESAMPLES, rows):
        last = min(first + rows, RESAMPLES)
        drawn = generator.integers(0, count, (last - first, count), dtype=np.int32)
        means[first:last] = values[drawn].mean(axis=1)
    return means
