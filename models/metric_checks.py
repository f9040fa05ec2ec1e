"""Owns what a metric needs of a design: outputs, cells, the spatial model, a controller; and the unit that it has."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import NoReturn

from models.built_in_metrics import BUILT_IN, WHOLE_ONLY
from models.components import extension_unit
from models.design import Design
from models.metric_phases import BetweenEvents, Both, DivePart, EventAt, Phase, While
from models.metric_requests import BuiltInOver, Composed, EventCount, EventTime, MetricRequest, Statistic, TimeBeyond
from models.metric_units import product_unit, ratio_unit
from models.problems import DesignError, Problem
from models.run import variables_of
from models.variables import (
    ALL_CELL_VARIABLES,
    ALL_VARIABLES,
    CELL_VARIABLES,
    CONTROL_VARIABLES,
    IN_UNITS_OF_EXTENSION,
    About,
)  # fmt: skip

OF_CONTROL = ("dive", "climb", "waypoint")
"""Events that only a controller makes."""
TO_SPATIAL = "set /mission/solver/model to spatial"
ON_OFFER = 8
"""At most as many names are suggested for one that is unknown."""


def unit_of(design: Design, request: MetricRequest, at: str) -> str:
    """Return the unit of a metric of a design's runs; `at` is the JSON Pointer to the metric.

    Raises
    ------
    DesignError
        Where the design has none of what the metric needs.

    """
    match request:
        case str():
            return _built_in_unit(design, request, at)
        case Composed():
            return _composed_unit(design, request, at)
        case _:
            _check_phase(design, request.over, f"{at}/over")
    match request:
        case Statistic():
            unit = output_about(design, request.of, request.cell, at)[0]
            return product_unit(unit, "s") if request.statistic == "time_integral" else unit
        case TimeBeyond():
            output_about(design, request.of, request.cell, at)
            return "s"
        case BuiltInOver():
            _check_one_stretch(request, at)
            return _built_in_unit(design, request.of, f"{at}/of")
        case EventTime() | EventCount():
            _check_event(design, request, at)
            return "s" if isinstance(request, EventTime) else "1"


def _built_in_unit(design: Design, name: str, at: str) -> str:
    built_in, model = BUILT_IN.get(name), design.mission.solver.model
    if built_in is None:
        _refuse(at, f"there is no metric '{name}'", offer(name, {k: (b.unit, b.meaning) for k, b in BUILT_IN.items()}))
    if model not in built_in.models:
        _refuse(at, f"{name} is of spatial runs, this design is {model}", TO_SPATIAL)
    return built_in.unit


def _composed_unit(design: Design, request: Composed, at: str) -> str:
    units = [unit_of(design, part, f"{at}/of/{k}") for k, part in enumerate(request.of)]
    match request.kind:
        case "ratio":
            return ratio_unit(*units)
        case "product":
            return product_unit(*units)
    for k, unit in enumerate(units):
        if unit != units[0]:
            _refuse(f"{at}/of/{k}", f"a {request.kind} of {units[0]} and {unit} means nothing", "give one unit")
    return units[0]


def output_about(design: Design, name: str, cell: str | None, at: str) -> About:
    """Return unit and meaning of an output of a design's runs; raises `DesignError` where they keep none."""
    model = design.mission.solver.model
    flat, of_cells = variables_of(design), CELL_VARIABLES[model]
    if name in flat:
        if cell is not None:
            _refuse(f"{at}/cell", f"{name} is not of cells, so it is not of '{cell}'", "leave the cell out")
        return flat[name]
    if name in of_cells:
        _check_cell(design, cell, at, f"{name} is of cells, and none is named")
        unit, meaning = of_cells[name]
        return (_extension_unit(design, cell) if name in IN_UNITS_OF_EXTENSION else unit), meaning
    if name in CONTROL_VARIABLES:
        _refuse(f"{at}/of", f"{name} is of runs with a controller, this design has none", "add one")
    if name in ALL_VARIABLES or name in ALL_CELL_VARIABLES:
        _refuse(f"{at}/of", f"{name} is of spatial runs, this design is {model}", TO_SPATIAL)
    _refuse(f"{at}/of", f"a run keeps no output '{name}'", offer(name, {**flat, **of_cells}))


def _extension_unit(design: Design, cell: str | None) -> str:
    return next(extension_unit(part) for _, part in design.vehicle.actuated if part.name == cell)


def _check_cell(design: Design, cell: str | None, at: str, lacking: str) -> None:
    cells = [part.name for _, part in design.vehicle.actuated]
    if cell not in cells:
        message = lacking if cell is None else f"there is no cell '{cell}'"
        _refuse(f"{at}/cell", message, f"those are: {', '.join(cells)}" if cells else "the design has no cells")


def _check_one_stretch(request: BuiltInOver, at: str) -> None:
    phase = request.over
    if isinstance(phase, While | Both) or (isinstance(phase, DivePart) and phase.number is None):
        _refuse(f"{at}/over", f"{request.of} is of one stretch, a phase '{phase.kind}' may have several",
                "give a time, last, dive, between_events, or a descent or climb with its number")  # fmt: skip
    if request.of in WHOLE_ONLY and phase.words:
        _refuse(f"{at}/over", f"{request.of} is of whole runs", "leave the phase out")


def _check_phase(design: Design, phase: Phase, at: str) -> None:
    match phase:
        case While():
            output_about(design, phase.of, phase.cell, at)
        case BetweenEvents():
            for field, event in (("begin", phase.begin), ("end", phase.end)):
                if event is not None:
                    _check_event(design, event, f"{at}/{field}")
        case Both():
            for k, part in enumerate(phase.of):
                _check_phase(design, part, f"{at}/of/{k}")


def _check_event(design: Design, event: EventAt | EventCount, at: str) -> None:
    if event.cell is not None:
        _check_cell(design, event.cell, at, "")
    if event.cell is not None and event.event != "end_of_stroke":
        _refuse(f"{at}/cell", f"{event.event} happens to the glider, not to a cell", "leave the cell out")
    if event.event in OF_CONTROL and design.mission.control.controller is None:
        _refuse(f"{at}/event", f"{event.event} is told by a controller, this design has none",
                "use a phase such as dive, descent or climb")  # fmt: skip


def offer(wanted: str, names: Mapping[str, About]) -> str:
    """Return which names there are: those like the one wanted, or whose meaning has the word, else all."""
    word = wanted.replace("_", " ").lower()
    like = get_close_matches(wanted.lower(), names, ON_OFFER)
    like += [name for name, (_, meaning) in names.items() if word in meaning and name not in like]
    return f"did you mean {', '.join(like[:ON_OFFER])}?" if like else f"those are: {', '.join(names)}"


def _refuse(at: str, message: str, hint: str) -> NoReturn:
    raise DesignError([Problem(at, message, hint=hint)])
