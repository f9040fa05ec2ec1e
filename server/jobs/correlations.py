"""Owns how parameters and metrics go together: Pearson's correlation, and Spearman's of their ranks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

Array = NDArray[np.float64]


def correlations(
    parameters: Array, metrics: Array, names: Sequence[str], metric_names: Sequence[str]
) -> list[dict[str, Any]]:
    """Return the correlations of every parameter with every metric, over the cases that have both.

    Parameters
    ----------
    parameters, metrics
        Values (cases, parameters) and (cases, metrics), not a number where a case has none.
    names, metric_names
        Names of their columns.

    Returns
    -------
    list of dict
        `parameter`, `metric`, `count` of cases, `pearson` and `spearman`, None where one of the two is the same in all.

    """
    found: dict[tuple[int, int], tuple[int, float | None, float | None]] = {}
    for rows, some, others in _alike(np.isfinite(parameters), np.isfinite(metrics)):
        x, y = parameters[rows][:, some], metrics[rows][:, others]
        pearson, spearman = _products(x, y), _products(_ranked(x), _ranked(y))
        for i, parameter in enumerate(some):
            for k, metric in enumerate(others):
                found[parameter, metric] = len(rows), _finite(pearson[i, k]), _finite(spearman[i, k])
    return [
        {"parameter": name, "metric": metric, "count": found[i, k][0], "pearson": found[i, k][1],
         "spearman": found[i, k][2]}
        for i, name in enumerate(names) for k, metric in enumerate(metric_names)
    ]  # fmt: skip


def _alike(
    parameters: NDArray[np.bool_], metrics: NDArray[np.bool_]
) -> Iterator[tuple[NDArray[np.intp], list[int], list[int]]]:
    """Yield cases with the parameters and metrics that have values in just those, so that each is ranked once."""
    for some in _grouped(parameters):
        for others in _grouped(metrics):
            yield np.flatnonzero(parameters[:, some[0]] & metrics[:, others[0]]), some, others


def _grouped(present: NDArray[np.bool_]) -> list[list[int]]:
    groups: dict[bytes, list[int]] = {}
    for column in range(present.shape[1]):
        groups.setdefault(np.packbits(present[:, column]).tobytes(), []).append(column)
    return list(groups.values())


def _ranked(values: Array) -> Array:
    ranks = np.empty_like(values)
    for k in range(values.shape[1]):  # one by one: ranking takes several times the memory of what is ranked
        ranks[:, k] = rankdata(values[:, k])
    return ranks


def _products(x: Array, y: Array) -> Array:
    """Return the correlations of the columns of x with those of y; not a number where one is constant."""
    if len(x) < 2:
        return np.full((x.shape[1], y.shape[1]), np.nan)
    return _standard(x).T @ _standard(y)


def _standard(values: Array) -> Array:
    with np.errstate(all="ignore"):  # of runs that went wild anything may overflow
        apart = values - values.mean(axis=0)
        apart /= np.abs(apart).max(axis=0)
        apart[:, np.ptp(values, axis=0) == 0.0] = np.nan
        apart /= np.sqrt(np.einsum("ij,ij->j", apart, apart))
    return np.asarray(apart)


def _finite(value: float) -> float | None:
    return float(np.clip(value, -1.0, 1.0)) if np.isfinite(value) else None
