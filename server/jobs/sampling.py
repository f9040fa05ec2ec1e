"""Owns the values of the cases: each sampler answers any range of rows as a pure function of seed and case number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri
from scipy.stats import qmc

from server.jobs.parameters import CaseSeed, Distribution, Levels, Normal, Range, TruncatedNormal, Uniform

Array = NDArray[np.float64]
Row = tuple[Any, ...]
WORDS_A_BLOCK = 4
"""Numbers that one step of the Philox generator's counter gives."""


class Sampler(Protocol):
    """What gives the values of the cases."""

    @property
    def count(self) -> int:
        """How many cases there are."""
        ...

    def rows(self, first: int, last: int) -> list[Row]:
        """Return the values of cases `first` to `last` - 1, one for each parameter."""
        ...


@dataclass(frozen=True)
class OneCase:
    """The design as it stands."""

    count: int = 1

    def rows(self, first: int, last: int) -> list[Row]:
        """Return rows without values."""
        return [()] * (last - first)


@dataclass(frozen=True)
class Combinations:
    """Every combination of levels by arithmetic on the case's number: a billion take no more memory than one."""

    parameters: Sequence[Levels]

    @cached_property
    def count(self) -> int:
        """The product of the numbers of levels."""
        return math.prod(parameter.levels for parameter in self.parameters)

    def rows(self, first: int, last: int) -> list[Row]:
        """Return combinations; the last parameter changes fastest."""
        return [self._row(case) for case in range(first, last)]

    def _row(self, case: int) -> Row:
        values = []
        for parameter in reversed(self.parameters):
            case, level = divmod(case, parameter.levels)
            values.append(parameter.level(level))
        return tuple(reversed(values))


@dataclass(frozen=True)
class Listed:
    """Rows as they were given."""

    given: Sequence[Row]

    @property
    def count(self) -> int:
        """How many were given."""
        return len(self.given)

    def rows(self, first: int, last: int) -> list[Row]:
        """Return them."""
        return list(self.given[first:last])


@dataclass(frozen=True)
class Spread:
    """Points spread over a box as a whole: a Latin hypercube, or scrambled Sobol points."""

    kind: str
    parameters: Sequence[Range]
    count: int
    seed: int

    @cached_property
    def _matrix(self) -> Array:
        size = len(self.parameters)
        engine: qmc.QMCEngine
        engine = (qmc.Sobol if self.kind == "sobol" else qmc.LatinHypercube)(size, rng=np.random.default_rng(self.seed))
        return scaled(engine.random(self.count), self.parameters)

    def rows(self, first: int, last: int) -> list[Row]:
        """Return points."""
        return [tuple(row) for row in self._matrix[first:last].tolist()]


def scaled(unit: Array, parameters: Sequence[Range]) -> Array:
    """Return points of the unit box (cases, parameters) in the ranges of the parameters, never beyond by rounding."""
    low = np.array([parameter.low for parameter in parameters])
    high = np.array([parameter.high for parameter in parameters])
    return np.asarray(np.clip(low + (high - low) * unit, low, high))


@dataclass(frozen=True)
class Draws:
    """Random cases: the numbers of case i come from the seed and i alone (Philox, a generator with a counter).

    Parameter j reads the generator's stream j at place i. Its 52 bits give a uniform number strictly between 0 and 1,
    the inverse of the normal distribution a normal one, `factor` (lower triangular) correlated ones.
    """

    distributions: Sequence[Distribution]
    factor: Array | None
    count: int
    seed: int

    def rows(self, first: int, last: int) -> list[Row]:
        """Return draws."""
        columns = [self._column(j, first, last).tolist() for j in range(len(self.distributions))]
        return list(zip(*columns, strict=True))

    def _column(self, j: int, first: int, last: int) -> Array:
        distribution = self.distributions[j]
        if isinstance(distribution, CaseSeed):
            return (self._bits(j, first, last) >> np.uint64(11)).astype(np.float64)
        together = [k for k in range(j + 1) if self._factor(j, k) != 0.0]
        if together == [j]:
            return placed(distribution, self._uniform(j, first, last))
        # term by term: a product of matrices may round by how many cases there are
        normal = np.zeros(last - first)
        for k in together:
            normal = normal + self._factor(j, k) * ndtri(self._uniform(k, first, last))
        return placed(distribution, ndtr(normal), normal)

    def _factor(self, j: int, k: int) -> float:
        return float(j == k) if self.factor is None else float(self.factor[j, k])

    def _uniform(self, j: int, first: int, last: int) -> Array:
        return ((self._bits(j, first, last) >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52

    def _bits(self, j: int, first: int, last: int) -> NDArray[np.uint64]:
        block, skipped = divmod(first, WORDS_A_BLOCK)
        generator = np.random.Philox(
            key=np.array([self.seed, 0], dtype=np.uint64), counter=np.array([block, j, 0, 0], dtype=np.uint64)
        )
        return np.asarray(generator.random_raw(skipped + last - first)[skipped:], dtype=np.uint64)


def placed(distribution: Distribution, uniform: Array, normal: Array | None = None) -> Array:
    """Return numbers of a distribution by its inverse, from uniform ones or the standard normal ones behind those."""
    match distribution:
        case Normal(mean=mean, sd=sd):
            return mean + sd * (ndtri(uniform) if normal is None else normal)
        case Uniform(low=low, high=high):
            return np.clip(low + (high - low) * uniform, low, high)
        case TruncatedNormal():
            return _truncated(distribution, uniform)
        case CaseSeed():
            raise TypeError("a seed for each case has no inverse")


def _truncated(distribution: TruncatedNormal, uniform: Array) -> Array:
    mean, sd = distribution.mean, distribution.sd
    low, high = (distribution.low - mean) / sd, (distribution.high - mean) / sd
    if low > 0.0:  # the upper tail is mirrored to the lower one, where probabilities keep their digits
        p, q = ndtr(-low), ndtr(-high)
        values = mean - sd * ndtri(p + uniform * (q - p))
    else:
        p, q = ndtr(low), ndtr(high)
        values = mean + sd * ndtri(p + uniform * (q - p))
    return np.clip(values, distribution.low, distribution.high)


def triangular_factor(correlation: Array) -> Array:
    """Return the lower triangular L with L L^T = R of a positive semidefinite matrix (Cholesky; dependent rows give 0).

    Written out, so that it does not depend on the linear algebra library of the machine.
    """
    size = len(correlation)
    L = np.zeros((size, size))
    for j in range(size):
        rest = correlation[j, j] - math.fsum(L[j, k] ** 2 for k in range(j))
        L[j, j] = math.sqrt(rest) if rest > 1e-12 else 0.0
        for i in range(j + 1, size):
            if L[j, j] > 0.0:
                L[i, j] = (correlation[i, j] - math.fsum(L[i, k] * L[j, k] for k in range(j))) / L[j, j]
    return L
