"""Owns the checks of a batch document against its design: pointers, names, values, metrics, correlations, sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.field_info import FieldInfo, field_at
from models.metrics import Metric, metrics_for
from models.problems import DesignError, Problem, echo, pointer_to
from models.variation import Target, Varied, overlaps
from server.jobs.parameters import (
    LARGEST_SEED,
    CaseSeed,
    Drawn,
    Levels,
    Normal,
    Parameter,
    Range,
    TruncatedNormal,
    Uniform,
)  # fmt: skip
from server.jobs.spec import Cases, FullFactorial, JobSpec, MonteCarlo, Sensitivity, Sweep

RESERVED = ("case", "status", "reason")
MOST_CHECKED = 10_000
"""Most values of a parameter that are checked one by one, and half of those of all parameters together."""
MOST_TOLD = 20
"""Most wrong values of a parameter that are told."""
LEAST_EIGENVALUE = -1e-10
Given = tuple[str, Any]
"""A value of a parameter, and the pointer to it in the batch document."""


@dataclass(frozen=True)
class Located:
    """A parameter, where it stands in the batch document, and the field that it leads to."""

    at: str
    parameter: Parameter
    info: FieldInfo
    given: tuple[Given, ...]
    listed: bool

    @property
    def name(self) -> str:
        """Name of its column."""
        return self.parameter.name or self.info.name

    @property
    def numeric(self) -> bool:
        """Whether all its values are numbers."""
        return not self.listed or all(_is_number(value) for _, value in self.given)

    @property
    def rounds(self) -> bool:
        """Whether values between whole numbers become whole ones."""
        return self.info.integer and not self.listed


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def locate(spec: JobSpec, design: Design) -> tuple[list[Located], list[Problem]]:
    """Return the parameters with the fields that they lead to, and what is wrong with pointers and names."""
    located: list[Located] = []
    problems: list[Problem] = []
    for k, (at, parameter) in enumerate(_parameters(spec)):
        infos = []
        for where, target in _targets(at, parameter):
            try:
                infos.append(field_at(design, target.pointer))
            except DesignError as error:
                problems += [Problem(where, f"{target.pointer}: {p.message}", p.limit, p.hint) for p in error.problems]
                continue
            problems += _kind_problems(where, target, parameter, infos[-1])
        if infos and infos[0].pointer == parameter.pointer:
            listed = isinstance(spec, Sweep) and (
                isinstance(spec.method, Cases) or (isinstance(parameter, Levels) and parameter.values is not None)
            )
            located.append(Located(at, parameter, infos[0], tuple(_given(spec, k, at, parameter)), listed))
    if not problems:
        problems += [*_overlaps(located), *_name_problems(located)]
    return located, problems


def _parameters(spec: JobSpec) -> Iterator[tuple[str, Parameter]]:
    if isinstance(spec, Sweep):
        for k, parameter in enumerate(spec.method.parameters):
            yield f"/method/parameters/{k}", parameter
    elif isinstance(spec, MonteCarlo | Sensitivity):
        for k, parameter in enumerate(spec.parameters):
            yield f"/parameters/{k}", parameter


def _targets(at: str, parameter: Parameter) -> Iterator[tuple[str, Target]]:
    for n, target in enumerate(parameter.targets):
        yield f"{at}/pointer" if n == 0 else f"{at}/also/{n - 1}/pointer", target


def _kind_problems(where: str, target: Target, parameter: Parameter, info: FieldInfo) -> Iterator[Problem]:
    """Yield a problem where numbers are meant for a field that holds none."""
    between = isinstance(parameter, Range | Drawn) or (isinstance(parameter, Levels) and parameter.values is None)
    if not info.number and (between or not target.copies):
        hint = "list its values in a sweep instead" if between else "leave factor and offset out"
        yield Problem(where, f"{target.pointer} ('{info.name}') is not a number", hint=hint)
    elif isinstance(parameter, Drawn) and isinstance(parameter.distribution, CaseSeed) and not info.integer:
        message = f"{target.pointer} ('{info.name}') is no whole number, which a seed is"
        yield Problem(where, message, hint="use case_seed for seeds only")


def _given(spec: JobSpec, k: int, at: str, parameter: Parameter) -> Iterator[Given]:
    """Yield the values of parameter `k` that the document states, with their pointers."""
    match parameter:
        case Levels(values=values) if values is not None:
            for n, value in enumerate(values):
                yield f"{at}/values/{n}", value
        case Levels(low=low, high=high) | Range(low=low, high=high):
            yield from ((f"{at}/low", low), (f"{at}/high", high))
        case Drawn(distribution=Normal(mean=mean)):
            yield f"{at}/distribution/mean", mean
        case Drawn(distribution=Uniform(low=low, high=high) | TruncatedNormal(low=low, high=high)):
            yield from ((f"{at}/distribution/low", low), (f"{at}/distribution/high", high))
        case Drawn():
            yield from ((f"{at}/distribution/kind", 0), (f"{at}/distribution/kind", LARGEST_SEED))
        case _ if isinstance(spec, Sweep) and isinstance(spec.method, Cases):
            for n, row in enumerate(spec.method.rows):
                yield f"/method/rows/{n}/{k}", row[k]


def _overlaps(located: Sequence[Located]) -> Iterator[Problem]:
    where = [(at, target.pointer) for p in located for at, target in _targets(p.at, p.parameter)]
    for problem in overlaps(pointer for _, pointer in where):
        at = [at for at, pointer in where if pointer == problem.pointer][-1]
        yield Problem(at, problem.message, problem.limit, problem.hint)


def _name_problems(located: Sequence[Located]) -> Iterator[Problem]:
    seen: dict[str, str] = {}
    for p in located:
        at = f"{p.at}/name"
        if p.name in RESERVED:
            yield Problem(at, f"'{p.name}' is a column of every table of cases", hint="choose another name")
        if p.name in seen:
            yield Problem(at, f"'{p.name}' is the name of {seen[p.name]} too", hint="give each a name of its own")
        seen.setdefault(p.name, p.at)


def value_problems(located: Sequence[Located], design: Design) -> list[Problem]:
    """Return the stated values that the design's schema refuses, each tried alone.

    Where a rule ties several fields and another parameter changes one of them too, only the cases can tell.
    """
    problems: list[Problem] = []
    most = min(MOST_CHECKED, max(2 * MOST_CHECKED // max(len(located), 1), MOST_TOLD))
    for p in located:
        others = [target.pointer for q in located if q is not p for target in q.parameter.targets]
        varied, told = Varied(design, [p.parameter.targets]), 0
        for at, value in _distinct(p.given, most):
            found = _refusal(varied, round(value) if p.rounds else value, others)
            if found is None:
                continue
            problems.append(Problem(at, f"{echo(value)} for '{p.name}': {found.message}", found.limit, found.hint))
            told += 1
            if told == MOST_TOLD:
                break
    return problems


def _distinct(given: Sequence[Given], most: int) -> list[Given]:
    """Return the distinct values; of very many the first, the last and the extremes."""
    distinct = {repr(value): (at, value) for at, value in reversed(given)}
    values = list(distinct.values())[::-1]
    if len(values) <= most:
        return values
    numbers = sorted((item for item in values if _is_number(item[1])), key=lambda item: float(item[1]))
    chosen = [*values[: most - 3], values[-1], *numbers[:1], *numbers[-1:]]
    return list({repr(value): (at, value) for at, value in chosen}.values())


def _refusal(varied: Varied, value: Any, others: Sequence[str]) -> Problem | None:
    """Return why a value is refused, by rules that no other parameter has a say in."""
    try:
        varied.design((value,))
    except DesignError as error:
        for problem in error.problems:
            if not any(other.startswith(f"{problem.pointer}/") for other in others):
                return Problem(problem.pointer, f"{problem.pointer}: {problem.message}", problem.limit, problem.hint)
    return None


def case_problems(spec: JobSpec, count: int, max_cases: int) -> list[Problem]:
    """Return what is wrong with the number of cases, and with those whose trajectories are kept."""
    problems = []
    if count > max_cases:
        at = "/method/parameters" if isinstance(spec, Sweep) and isinstance(spec.method, FullFactorial) else "/method"
        at = "/count" if isinstance(spec, MonteCarlo) else at
        message = f"{count} cases exceed the limit of {max_cases}"
        problems.append(Problem(at, message, max_cases, "take fewer, or raise GLIDER_STUDIO_MAX_CASES"))
    if not isinstance(spec.trajectories, str):
        for k, case in enumerate(spec.trajectories):
            if case >= count:
                at, hint = pointer_to("trajectories", k), "cases count from 0"
                problems.append(Problem(at, f"there is no case {case} of {count}", count - 1, hint))
                break
    return problems


def metrics_of(spec: JobSpec, design: Design, names: Sequence[str]) -> tuple[tuple[Metric, ...], list[Problem]]:
    """Return the metrics of a job, and what is wrong with them, their names beside the parameters', and the stop."""
    try:
        metrics = metrics_for(design, spec.metrics)
    except DesignError as error:
        return (), list(error.problems)
    problems = [
        Problem("/metrics", f"'{m.name}' names a metric and a parameter", hint="give the parameter another name")
        for m in metrics if m.name in names
    ]  # fmt: skip
    stop = spec.stop if isinstance(spec, MonteCarlo) else None
    if stop is not None and stop.metric not in [m.name for m in metrics]:
        known = ", ".join(m.name for m in metrics)
        problems.append(Problem("/stop/metric", f"no metric is named {echo(stop.metric)}", hint=f"those are: {known}"))
    return metrics, problems


def correlation_matrix(spec: MonteCarlo, names: Sequence[str]) -> tuple[NDArray[np.float64], list[Problem]]:
    """Return the correlations as a matrix over the parameters, and what is wrong with them."""
    matrix, problems = np.eye(len(spec.parameters)), []
    seen: set[frozenset[int]] = set()
    for k, correlation in enumerate(spec.correlations):
        at = f"/correlations/{k}"
        unknown = [name for name in correlation.between if name not in names]
        if unknown:
            hint = f"those are: {', '.join(names)}"
            problems.append(Problem(f"{at}/between", f"no parameter is named {echo(unknown[0])}", hint=hint))
            continue
        i, j = (names.index(name) for name in correlation.between)
        seeds = [n for n in (i, j) if isinstance(spec.parameters[n].distribution, CaseSeed)]
        if i == j or frozenset((i, j)) in seen:
            what = f"'{names[i]}' goes with itself" if i == j else "the two are correlated already"
            problems.append(Problem(f"{at}/between", what, hint="name each pair once"))
        elif seeds:
            problems.append(Problem(f"{at}/between", f"'{names[seeds[0]]}' is a seed, and goes with nothing"))
        seen.add(frozenset((i, j)))
        matrix[i, j] = matrix[j, i] = correlation.value
    least = float(np.linalg.eigvalsh(matrix)[0])
    if not problems and least < LEAST_EIGENVALUE:
        message = f"no numbers have these correlations: the smallest eigenvalue of their matrix is {least:.4g}"
        enough = math.floor(1e3 / (1.0 - least)) / 1e3
        hint = f"bring them together: times {enough:g} all of them would do"
        problems.append(Problem("/correlations", message, 0.0, hint))
    return matrix, problems
