"""Owns sensitivity studies: the samples that SALib's methods need, and the indices from the metrics of the cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from server.jobs.sampling import Row
from server.jobs.spec import MorrisEffects, Sensitivity, SobolIndices

MOST_NAMED = 5
SMALLEST_SPREAD = 1e-12
"""Smallest spread of a metric, beside its size, that is more than rounding."""


def cases_needed(spec: Sensitivity) -> int:
    """Return how many cases a method needs."""
    size = len(spec.parameters)
    if isinstance(spec.method, SobolIndices):
        return spec.method.base * (2 * size + 2 if spec.method.second_order else size + 2)
    return spec.method.trajectories * (size + 1)


def _problem(spec: Sensitivity) -> dict[str, Any]:
    """Return the parameters as SALib has them; numbers stand for names, which columns hold."""
    return {
        "num_vars": len(spec.parameters),
        "names": [str(k) for k in range(len(spec.parameters))],
        "bounds": [[p.low, p.high] for p in spec.parameters],
    }


@dataclass(frozen=True)
class Samples:
    """The cases of a sensitivity study."""

    spec: Sensitivity

    @property
    def count(self) -> int:
        """How many cases there are."""
        return cases_needed(self.spec)

    @cached_property
    def matrix(self) -> NDArray[np.float64]:
        """All values, (cases, parameters)."""
        # imported late: SALib takes more than a second to load
        method, problem, seed = self.spec.method, _problem(self.spec), np.random.default_rng(self.spec.seed)
        if isinstance(method, SobolIndices):
            from SALib.sample import sobol

            values = sobol.sample(problem, method.base, calc_second_order=method.second_order, seed=seed)
        else:
            from SALib.sample import morris

            values = morris.sample(problem, method.trajectories, num_levels=method.levels, seed=self.spec.seed)
        # it may pass a bound by rounding, which a field with that very bound refuses
        bounds = np.array(problem["bounds"])
        return np.asarray(np.clip(values, bounds[:, 0], bounds[:, 1]), dtype=np.float64)

    def rows(self, first: int, last: int) -> list[Row]:
        """Return samples."""
        return [tuple(row) for row in self.matrix[first:last].tolist()]


def indices(spec: Sensitivity, names: Sequence[str], table: Mapping[str, Sequence[float]]) -> dict[str, dict[str, Any]]:
    """Return the indices of every metric.

    Parameters
    ----------
    spec
        The study.
    names
        Names of its parameters.
    table
        For each metric its values, in the order of the cases, all of them; not a number where a case has none.

    Returns
    -------
    dict
        For each metric `{"method", "reason"}`, and where `reason` is None for Sobol `first`, `total` (by parameter:
        `{"value", "half_width"}`, of 95 % confidence) and with second order `interaction` (a list with `between`), for
        Morris `mu`, `sigma` (by parameter, in the metric's unit over the parameter's whole range) and `mu_star`.

    """
    return {metric: _of_metric(spec, names, np.asarray(values, dtype=np.float64)) for metric, values in table.items()}


def _of_metric(spec: Sensitivity, names: Sequence[str], values: NDArray[np.float64]) -> dict[str, Any]:
    reason = _unusable(values, cases_needed(spec))
    found: dict[str, Any] = {"method": spec.method.kind, "reason": reason}
    if reason is not None:
        return found
    if isinstance(spec.method, SobolIndices):
        return found | _sobol(spec, spec.method, names, values)
    return found | _morris(spec, spec.method, names, values)


def _unusable(values: NDArray[np.float64], needed: int) -> str | None:
    """Return why no indices can be had from these values, None where they can."""
    if len(values) != needed:
        return f"{len(values)} of {needed} cases are done; indices need all of them"
    missing = np.flatnonzero(~np.isfinite(values))
    if len(missing):
        named = ", ".join(str(case) for case in missing[:MOST_NAMED])
        more = f" and {len(missing) - MOST_NAMED} more" if len(missing) > MOST_NAMED else ""
        which = f"case {named} has" if len(missing) == 1 else f"cases {named}{more} have"
        return f"{which} no value, and indices need one of each of the {needed} cases: narrow the ranges, or retry"
    if np.ptp(values) <= SMALLEST_SPREAD * np.abs(values).max():
        return f"it is {values[0]:.6g} in every case: no parameter changes it"
    return None


def _sobol(
    spec: Sensitivity, method: SobolIndices, names: Sequence[str], values: NDArray[np.float64]
) -> dict[str, Any]:
    from SALib.analyze import sobol

    # a seed of 0 would be none to SALib
    found = sobol.analyze(_problem(spec), values, calc_second_order=method.second_order, seed=spec.seed + 1)
    indices = {
        "first": _with_widths(names, found["S1"], found["S1_conf"]),
        "total": _with_widths(names, found["ST"], found["ST_conf"]),
    }
    if not method.second_order:
        return indices
    pairs = [
        {"between": [names[i], names[j]], "value": float(found["S2"][i, j]),
         "half_width": float(found["S2_conf"][i, j])}
        for i, j in combinations(range(len(names)), 2)
    ]  # fmt: skip
    return {**indices, "interaction": pairs}


def _morris(
    spec: Sensitivity, method: MorrisEffects, names: Sequence[str], values: NDArray[np.float64]
) -> dict[str, Any]:
    from SALib.analyze import morris

    samples = Samples(spec).matrix
    found = morris.analyze(_problem(spec), samples, values, num_levels=method.levels, seed=spec.seed)
    return {
        "mu": dict(zip(names, map(float, found["mu"]), strict=True)),
        "mu_star": _with_widths(names, found["mu_star"], found["mu_star_conf"]),
        "sigma": dict(zip(names, map(float, found["sigma"]), strict=True)),
    }


def _with_widths(names: Sequence[str], values: Sequence[float], widths: Sequence[float]) -> dict[str, dict[str, float]]:
    return {
        name: {"value": float(value), "half_width": float(width)}
        for name, value, width in zip(names, values, widths, strict=True)
    }
