"""Owns tables of gains over a family of trims: a design at each, in one controller that goes from trim to trim."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from models.assemble import Assembly
from models.controller_design import RATES, ControllerDesign, design_about, trim_of_options
from models.controller_options import ControllerOptions, TrimOptions
from models.controllers import SetPoint, StateFeedback
from models.design import Design
from models.feedback_problem import feedback_problem
from models.limits import DEFAULT_LIMITS, Limits
from models.loop_response import feedback_of, gain_point, mission_from
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem
from models.sampled_model import radius_of
from models.simulate import Control
from models.steady_problem import assembly_of
from models.targeted_trim import trim_for
from models.trim import Trim

UNITS = {"glide_angle": "rad", "pitch": "rad", "speed": "m/s", "sink_rate": "m/s"}
Values = Sequence[float]


@dataclass(frozen=True, eq=False)
class GainTable:
    """Designs at rising values of a set point, and the controller that blends them linearly between."""

    target: str
    values: tuple[float, ...]
    designs: tuple[ControllerDesign, ...]
    controller: StateFeedback
    warnings: tuple[str, ...]

    def mission(self, *, duration: float, interval: float = 0.5) -> Design:
        """Return the design with a mission under the table, starting in the trim nearest to the first set point."""
        first = self.controller.set_points[0].value if self.controller.set_points else self.values[0]
        start = self.designs[min(range(len(self.values)), key=lambda k: abs(self.values[k] - first))]
        problem = start.problem
        return mission_from(problem.design, problem.point, self.controller, duration=duration, interval=interval)

    def as_dict(self) -> dict[str, Any]:
        """Return the table as a JSON object."""
        return {
            "target": self.target, "values": list(self.values), "controller": self.controller.model_dump(mode="json"),
            "designs": [each.as_dict() for each in self.designs], "warnings": list(self.warnings),
        }  # fmt: skip


def design_table(
    design: Design | Assembly, options: ControllerOptions, *, limits: Limits = DEFAULT_LIMITS,
    control: Control | None = None,
) -> GainTable:  # fmt: skip
    """Return a table of gains over the target and values of `options.table`; other targets of the trim stay.

    Each trim is sought next to the one before it, and all feed back the states of the first. `control` stops it
    between two rows.

    Raises
    ------
    DesignError
        Where there is no table in the options, a response is asked for beside it, one of the trims or designs does not
        exist, or it was stopped.

    """
    table = options.table
    if table is None:
        raise DesignError([Problem("/options/table", "no table is asked for", hint="give its target and values")])
    for name in ("step", "departures"):
        if getattr(options, name):
            hint = "ask for it about one trim, or fly the table's mission"
            raise DesignError([Problem(f"/options/{name}", "a table is made without flights", hint=hint)])
    assembly = assembly_of(design)
    points: list[OperatingPoint] = []
    designs: list[ControllerDesign] = []
    each = options.model_copy(update={"table": None})
    for i, value in enumerate(table.values):
        _stop_where_cancelled(control)
        trim = _trim_at(assembly, each, table.target, value, points[-1] if points else None, i)
        points.append(point_of(trim, heading=options.trim.heading))
        designs.append(design_about(assembly, points[-1], each, limits=limits, control=control))
        each = each.model_copy(update={"states": designs[0].problem.states})
    by = f"{table.target.replace('_', ' ')}, {UNITS[table.target]}"
    return table_of(designs, table.values, target=table.target, set_points=table.set_points, by=by, control=control)


def table_of(
    designs: Sequence[ControllerDesign], values: Values, *, target: str = "", set_points: Sequence[SetPoint] = (),
    by: str = "", control: Control | None = None,
) -> GainTable:  # fmt: skip
    """Return the table of designs at rising values of a set point, which `by` explains.

    Raises
    ------
    DesignError
        Where values do not rise, or the designs differ in cells, states, integrals or sample time.

    """
    problems = [each.problem for each in designs]
    first = problems[0]
    for i, problem in enumerate(problems):
        same = (problem.states, problem.cells.cells, problem.options.integrals, problem.options.sample_time)
        if same != (first.states, first.cells.cells, first.options.integrals, first.options.sample_time):
            message = "cells, states, integrals or sample time are not those of the first design"
            raise DesignError([Problem(f"/designs/{i}", message, hint="name states and cells in the options")])
    if any(not a < b for a, b in pairwise(values)) or len(values) != len(designs):
        raise DesignError([Problem("/options/table/values", "values must rise, one a design")])
    rows = tuple(
        gain_point(each.problem, each.gains, each.problem.point, value)
        for each, value in zip(designs, values, strict=True)
    )
    controller = feedback_of(first, rows, set_points=tuple(set_points) or (SetPoint(time=0.0, value=values[0]),), by=by)
    said = [
        f"at {value:.4g}: {warning}" for each, value in zip(designs, values, strict=True) for warning in each.warnings
        if warning != RATES
    ]  # fmt: skip
    said += [RATES] if RATES in designs[0].warnings else []
    said += _between(designs, values, target, control)
    return GainTable(target, tuple(values), tuple(designs), controller, tuple(said))


def _stop_where_cancelled(control: Control | None) -> None:
    if control is not None and control.cancelled:
        raise DesignError([Problem("/options/table", "the table was stopped before it was whole", hint="ask again")])


def _trim_at(
    assembly: Assembly, options: ControllerOptions, target: str, value: float, before: OperatingPoint | None, i: int
) -> Trim:
    """Return the trim of one row, next to the one before."""
    changed = {"targets": options.trim.targets | {target: value}, "free": options.trim.free or options.cells}
    near: dict[str, Any] = {} if before is None else {"extensions": dict(before.extensions)}
    wanted: TrimOptions = options.trim.model_copy(update=changed | near)
    try:
        return trim_of_options(assembly, options.model_copy(update={"trim": wanted}))
    except DesignError as error:
        reason = "; ".join(problem.message for problem in error.problems)
        raise DesignError([Problem(f"/options/table/values/{i}", f"{target} {value:g}: {reason}")]) from error


def _between(
    designs: Sequence[ControllerDesign], values: Values, target: str, control: Control | None
) -> Iterator[str]:
    """Yield where the blended controller is not stable, or not in trim, half way between two rows."""
    for (a, low), (b, high) in pairwise(zip(designs, values, strict=True)):
        _stop_where_cancelled(control)
        problem, middle = a.problem, 0.5 * (low + high)
        gains = 0.5 * (a.gains + b.gains)
        unstable = [radius_of(each.problem.whole().closed(each.problem.widened(gains))) >= 1.0 for each in (a, b)]
        if any(unstable):
            yield f"gains half way between {low:g} and {high:g} do not stabilise both ends: set rows closer"
            continue
        if not target:
            continue
        wanted = problem.options.trim.targets | {target: middle}
        free = problem.options.trim.free or problem.cells.cells
        point = problem.point
        found = trim_for(problem.assembly, wanted, free, extensions=point.extensions, depth=point.depth)
        if not isinstance(found, Trim):
            yield f"at {middle:g}, between two rows, there is no trim"
            continue
        here = feedback_problem(problem.assembly, point_of(found, heading=point.yaw), problem.options)
        if radius_of(here.whole().closed(here.widened(gains))) >= 1.0:
            yield f"at {middle:g}, between two rows, the loop is not stable: set rows closer"
        blended = 0.5 * (a.problem.extensions + b.problem.extensions)
        off = float((np.abs(blended - here.extensions) / here.strokes).max())
        if off > 0.02:
            yield f"at {middle:g} the blended trim is off by {100.0 * off:.2g} % of a stroke: set rows closer"
