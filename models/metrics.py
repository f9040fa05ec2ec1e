"""Owns metrics of a run: numbers with a name, a unit and a meaning, asked for by name or composed, and their values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from models.built_in_metrics import BUILT_IN
from models.design import Design
from models.metric_checks import output_about, unit_of
from models.metric_requests import (
    BuiltInOver,
    Composed,
    EventCount,
    EventTime,
    MetricRequest,
    Statistic,
    TimeBeyond,
    words_of,
)  # fmt: skip
from models.metric_statistics import statistic
from models.metric_windows import Glide, MissingOutputError, limited, picked
from models.problems import DesignError, Problem, problems_from_validation
from models.run import Run

_PLANAR = (
    "range", "maximum_depth", "final_depth", "duration", "glide_ratio", "mean_speed", "mean_horizontal_speed",
    "maximum_pitch", "minimum_pitch", "energy_residual",
)  # fmt: skip
DEFAULT_METRICS: Mapping[str, tuple[str, ...]] = {
    "planar": _PLANAR,
    "spatial": (*_PLANAR[:-1], "maximum_bank", "turn_radius", "energy", "energy_per_km", "energy_residual"),
}
"""Names of the metrics of a batch that asks for none, by model."""
MOST_METRICS = 200
_REQUEST: TypeAdapter[MetricRequest] = TypeAdapter(MetricRequest)


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that a run is judged by, checked against the design whose runs it is of."""

    name: str
    unit: str
    meaning: str
    request: MetricRequest


def metrics_for(
    design: Design, requested: Sequence[Any] | None = None, *, pointer: str = "/metrics"
) -> tuple[Metric, ...]:
    """Return metrics of a design's runs: those requested, as JSON or parsed, or the defaults of its model.

    Raises
    ------
    DesignError
        Where a request is malformed, needs what the design does not have, or where two have one name; `pointer` is the
        JSON Pointer to the requests.

    """
    if requested is None:
        requested = DEFAULT_METRICS[design.mission.solver.model]
    if not 1 <= len(requested) <= MOST_METRICS:
        raise DesignError([Problem(pointer, f"{len(requested)} metrics are asked for, 1 to {MOST_METRICS} can be",
                                   limit=MOST_METRICS, hint="leave the field out for the usual ones")])  # fmt: skip
    metrics: list[Metric] = []
    problems: list[Problem] = []
    for k, request in enumerate(requested):
        try:
            metrics.append(_metric(design, request, f"{pointer}/{k}"))
        except DesignError as error:
            problems += error.problems
    if not problems:
        problems = _repeated(metrics, pointer)
    if problems:
        raise DesignError(problems)
    return tuple(metrics)


def _metric(design: Design, asked: Any, at: str) -> Metric:
    try:
        request = _REQUEST.validate_python(asked)
    except ValidationError as error:
        found = problems_from_validation(error, asked)
        raise DesignError(Problem(at + p.pointer, p.message, p.limit, p.hint) for p in found) from None
    unit = unit_of(design, request, at)
    return Metric(words_of(request), unit, _meaning(design, request), request)


def _repeated(metrics: Sequence[Metric], pointer: str) -> list[Problem]:
    """Return a problem for each name that is given to more than one."""
    counts = Counter(metric.name for metric in metrics)
    return [
        Problem(f"{pointer}/{max(k for k, metric in enumerate(metrics) if metric.name == name)}",
                f"{count} metrics are named '{name}'", hint="give each a name of its own")
        for name, count in counts.items() if count > 1
    ]  # fmt: skip


def _meaning(design: Design, request: MetricRequest) -> str:
    """Return what a metric is, with what its outputs mean."""
    match request:
        case str():
            return BUILT_IN[request].meaning
        case BuiltInOver():
            return f"{request.words}: {BUILT_IN[request.of].meaning}"
        case Statistic() | TimeBeyond():
            return f"{request.words}: {output_about(design, request.of, request.cell, '')[1]}"
        case _:
            return request.words


def evaluate(run: Run, metrics: Sequence[Metric]) -> list[float]:
    """Return the values of metrics; not a number where one does not apply to this run."""
    glide = Glide(run)
    with np.errstate(all="ignore"):  # of a run that diverged anything may overflow
        values = [_value(glide, metric.request) for metric in metrics]
    return [value + 0.0 if math.isfinite(value) else math.nan for value in values]  # none is -0.0


def _value(glide: Glide, request: MetricRequest) -> float:
    try:
        if isinstance(request, str):
            return BUILT_IN[request].value(glide.whole)
        return _joined(glide, request) if isinstance(request, Composed) else _over_phase(glide, request)
    except MissingOutputError:
        return math.nan


def _joined(glide: Glide, request: Composed) -> float:
    values = [_value(glide, part) for part in request.of]
    match request.kind:
        case "ratio":
            return values[0] / values[1] if values[1] != 0.0 else math.nan
        case "difference":
            return values[0] - values[1]
        case "sum":
            return sum(values)
        case "product":
            return math.prod(values)


def _over_phase(glide: Glide, request: Statistic | TimeBeyond | BuiltInOver | EventTime | EventCount) -> float:
    stretches = glide.stretches(request.over)
    if not stretches:
        return math.nan
    match request:
        case Statistic():
            pieces = [
                piece for s in stretches for piece in s.pieces(request.of, request.cell, absolute=request.absolute)
            ]
            return statistic(pieces, request.statistic, percent=request.percent)
        case TimeBeyond():
            return math.fsum(end - begin for s in stretches for begin, end in limited(s, request))
        case BuiltInOver():
            return BUILT_IN[request.of].value(stretches[0])
        case EventTime() | EventCount():
            events = [event for s in stretches for event in s.events(request.event, request.cell)]
    if isinstance(request, EventCount):
        return float(len(events))
    return next((event.time for event in picked(events, request.number)), math.nan)
