"""Owns the plan of a job: how many cases it has, what varies, and the values of each case."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.metrics import Metric
from models.problems import DesignError, Problem
from models.variation import Target
from server.jobs.plan_checks import Located, case_problems, correlation_matrix, locate, metrics_of, value_problems
from server.jobs.sampling import Combinations, Draws, Listed, OneCase, Row, Sampler, Spread, triangular_factor
from server.jobs.sensitivity import Samples, cases_needed
from server.jobs.spec import (
    Cases,
    FullFactorial,
    JobSpec,
    LatinHypercube,
    MonteCarlo,
    Sensitivity,
    Simulate,
    SobolPoints,
    Sweep,
)  # fmt: skip

MOST_NUMBERS_AT_ONCE = 20_000_000
"""Largest table of points that are laid out together, in numbers (160 MB)."""


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """A parameter as results show it; where not `numeric`, its values are any JSON."""

    name: str
    unit: str
    pointer: str
    meaning: str = ""
    numeric: bool = True


@dataclass(frozen=True, eq=False)
class Plan:
    """All cases of a job: a pure function of the batch document and the design.

    `whole` tells which parameters are whole numbers, `sampler` gives their values.
    """

    spec: JobSpec
    design: Design
    parameters: tuple[ParameterInfo, ...]
    metrics: tuple[Metric, ...]
    count: int
    targets: tuple[tuple[Target, ...], ...]
    sampler: Sampler = field(repr=False)
    whole: tuple[bool, ...] = ()

    def rows(self, first: int, last: int) -> list[Row]:
        """Return the values of cases `first` to `last` - 1, one for each parameter."""
        if not 0 <= first <= last <= self.count:
            raise ValueError(f"cases {first} to {last} are not within 0 to {self.count}")
        rows = self.sampler.rows(first, last)
        if not any(self.whole):
            return rows
        return [tuple(round(v) if w else v for v, w in zip(row, self.whole, strict=True)) for row in rows]


def make_plan(spec: JobSpec, design: Design, *, max_cases: int) -> Plan:
    """Check a batch document against its design, and lay its cases out.

    Raises
    ------
    DesignError
        With everything that is wrong; pointers lead into the batch document.

    """
    located, problems = locate(spec, design)
    count = _count(spec)
    problems += case_problems(spec, count, max_cases)
    metrics, metric_problems = metrics_of(spec, design, [p.name for p in located])
    problems += [*metric_problems, *_size_problems(spec, count)]
    if not problems:
        problems += value_problems(located, design)
    factor = None
    if isinstance(spec, MonteCarlo) and spec.correlations and len(located) == len(spec.parameters):
        correlation, correlation_problems = correlation_matrix(spec, [p.name for p in located])
        problems += correlation_problems
        factor = triangular_factor(correlation)
    if problems:
        raise DesignError(problems)
    return Plan(
        spec=spec,
        design=design,
        parameters=tuple(_info(p) for p in located),
        metrics=metrics,
        count=count,
        targets=tuple(p.parameter.targets for p in located),
        sampler=_sampler(spec, factor),
        whole=tuple(p.rounds for p in located),
    )


def _info(located: Located) -> ParameterInfo:
    told = located.info
    return ParameterInfo(located.name, told.unit, told.pointer, told.meaning, located.numeric)


def _count(spec: JobSpec) -> int:
    match spec:
        case Simulate():
            return 1
        case MonteCarlo():
            return spec.count
        case Sensitivity():
            return cases_needed(spec)
        case Sweep():
            return _count_of(spec.method)


def _count_of(method: FullFactorial | LatinHypercube | SobolPoints | Cases) -> int:
    match method:
        case FullFactorial():
            return Combinations(method.parameters).count
        case Cases():
            return len(method.rows)
        case _:
            return method.count


def _size_problems(spec: JobSpec, count: int) -> list[Problem]:
    """Return a problem where points that are laid out together would not fit in memory."""
    if isinstance(spec, Sensitivity):
        at, parameters = ("/method/base" if spec.method.kind == "sobol" else "/method/trajectories"), spec.parameters
    elif isinstance(spec, Sweep) and isinstance(spec.method, LatinHypercube | SobolPoints):
        at, parameters = "/method/count", spec.method.parameters
    else:
        return []
    size = count * len(parameters)
    if size <= MOST_NUMBERS_AT_ONCE:
        return []
    message = f"{count} cases of {len(parameters)} parameters are {size} numbers laid out together"
    return [Problem(at, message, MOST_NUMBERS_AT_ONCE, "take fewer, or monte_carlo, which lays nothing out")]


def _sampler(spec: JobSpec, factor: NDArray[np.float64] | None) -> Sampler:
    match spec:
        case Simulate():
            return OneCase()
        case MonteCarlo():
            return Draws(tuple(p.distribution for p in spec.parameters), factor, spec.count, spec.seed)
        case Sensitivity():
            return Samples(spec)
        case Sweep():
            return _sampler_of(spec.method, spec.seed)


def _sampler_of(method: FullFactorial | LatinHypercube | SobolPoints | Cases, seed: int) -> Sampler:
    match method:
        case FullFactorial():
            return Combinations(method.parameters)
        case Cases():
            return Listed(method.rows)
        case _:
            return Spread(method.kind, method.parameters, method.count, seed)
