"""Owns stopping at a wanted confidence width: after how many cases a statistic is known well enough.

A pure function of the values in the order of the cases, so that chunks and workers have no say. Intervals: of the mean
Student's t; of percentiles two order statistics, whose ranks the binomial distribution gives whatever the metric's;
of the standard deviation chi-square, exact where the metric is normal. As in any sequential rule, looking often makes
the interval at the stop cover the truth a little less often than it says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2
from scipy.stats import t as student

from server.jobs.spec import Statistic, Stop

Values = NDArray[np.float64] | Sequence[float]
QUANTILES: dict[Statistic, float] = {"median": 0.5, "p5": 0.05, "p25": 0.25, "p75": 0.75, "p95": 0.95}


def stop_at(values: Values, rule: Stop, *, after: int = 0) -> int | None:
    """Return after how many cases the rule is met for the first time, None where it is not yet.

    Parameters
    ----------
    values
        The metric of cases 0, 1, 2, ... without a gap; not a number where a case has none, which counts as a case only.
    rule
        When to stop.
    after
        So many cases are known not to meet it.

    """
    column = np.asarray(values, dtype=np.float64)
    for cases in range((after // rule.every + 1) * rule.every, len(column) + 1, rule.every):
        half = half_width(column[:cases], rule)
        if half is not None and 2.0 * half <= rule.width:
            return cases
    return None


def half_width(values: Values, rule: Stop) -> float | None:
    """Return half the width of the interval so far, None while there are too few values for one."""
    column = np.asarray(values, dtype=np.float64)
    finite = column[np.isfinite(column)]
    if len(finite) < rule.least:
        return None
    ends = interval(finite, rule.statistic, rule.confidence)
    return None if ends is None else 0.5 * (ends[1] - ends[0])


def interval(values: NDArray[np.float64], statistic: Statistic, confidence: float) -> tuple[float, float] | None:
    """Return the confidence interval of a statistic of finite values, None where they are too few to have one."""
    count = len(values)
    if count < 2:
        return None
    if statistic == "mean":
        reach = float(student.ppf(0.5 + 0.5 * confidence, count - 1)) * float(values.std(ddof=1)) / count**0.5
        middle = float(values.mean())
        return middle - reach, middle + reach
    if statistic == "sd":
        squares = float(values.var(ddof=1)) * (count - 1)
        most, least = (float(chi2.ppf(0.5 + sign * 0.5 * confidence, count - 1)) for sign in (1.0, -1.0))
        return (squares / most) ** 0.5, (squares / least) ** 0.5
    return _between_ranks(values, QUANTILES[statistic], confidence)


def _between_ranks(values: NDArray[np.float64], share: float, confidence: float) -> tuple[float, float] | None:
    """Return the values of the ranks between which the quantile lies with at least the confidence.

    With B the number of values below the quantile, binomial(n, share), it lies between the values of ranks l and u
    (from 1) where l <= B < u (Hahn and Meeker, 1991, Statistical Intervals, section 5.2).
    """
    count, tail = len(values), 0.5 - 0.5 * confidence
    low, high = int(binom.ppf(tail, count, share)), int(binom.ppf(1.0 - tail, count, share)) + 1
    if low < 1 or high > count:
        return None
    ordered = np.partition(values, (low - 1, high - 1))
    return float(ordered[low - 1]), float(ordered[high - 1])
