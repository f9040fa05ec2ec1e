"""Owns what a design must satisfy beyond its fields' limits before it can be simulated."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from models.assemble_control import control_problems
from models.components import Actuated, extension_unit
from models.design import Design
from models.environment import Environment
from models.hydrodynamic_law import HydrodynamicLaw, law_of
from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.limits import Limits
from models.mass_checks import mass_problems
from models.memory import remembered
from models.mission import Control, Solver
from models.model_checks import model_problems
from models.problems import DesignError, Problem, pointer_to
from models.schedule import Schedule
from models.water import require_known

COLUMNS = {"planar": (33, 4), "spatial": (100, 6)}
"""Numbers kept a sample: the variables over time with the states, and those of each cell with its states."""
CONTROL_COLUMNS = (24, 1)
"""Those beside them under control: what it shows, as recorded and as kept, and the command of each cell."""
Count = tuple[str, str, float, float, str]
"""Where something is counted, what that is, how many, the most there may be, and what to do beyond."""


def check_design(design: Design, limits: Limits) -> HydrodynamicLaw | None:
    """Return the law in the angle of attack of a design that can be simulated, None where its source has another.

    Raises
    ------
    DesignError
        With all problems, where it cannot be simulated.

    """
    mission, vehicle = design.mission, design.vehicle
    beyond = _limit_problems(
        mission.control, mission.environment, vehicle.hydrodynamics, mission.solver, limits,
        mission.duration, len(vehicle.components), len(vehicle.actuated),
    )  # fmt: skip
    if beyond:
        raise DesignError(beyond)
    problems = [
        *_schedule_problems(design), *control_problems(design), *_initial_problems(design), *model_problems(design),
        *mass_problems(design),
    ]  # fmt: skip
    try:
        law = law_of(design.vehicle.hydrodynamics)
        require_known(mission.environment.water)
    except DesignError as error:
        raise DesignError([*problems, *error.problems]) from None
    if problems:
        raise DesignError(problems)
    return law


@remembered(most=100, about=5)
def _limit_problems(
    control: Control, environment: Environment, source: Hydrodynamics, solver: Solver, limits: Limits,
    duration: float, components: int, cells: int,
) -> tuple[Problem, ...]:  # fmt: skip
    counts = [
        ("/vehicle/components", "components", components, limits.components, "remove some"),
        *_length_counts(control, environment, source, limits),
        *_sample_counts(control, solver, limits, duration=duration, cells=cells),
    ]
    return tuple(
        Problem(pointer, f"{value:g} {what} exceed the limit of {bound:g}", limit=bound, hint=hint)
        for pointer, what, value, bound, hint in counts
        if value > bound
    )


def _length_counts(control: Control, environment: Environment, source: Hydrodynamics, limits: Limits) -> list[Count]:
    """Return what counts among the schedules and the tables."""
    points = sum(len(s.points) for s in control.schedules)
    rows, where = table_rows(source)
    levels = len(getattr(environment.water, "depths", ()))
    values = sum(len(profile) for profile in getattr(environment.current, "north", ()))
    return [
        ("/mission/control/schedules", "schedule points", points, limits.schedule_points, "use fewer points"),
        (f"/vehicle/hydrodynamics/{where}", "table rows", rows, limits.table_rows, "thin the table"),
        ("/mission/environment/water/depths", "levels of the water", levels, limits.table_rows, "thin the profile"),
        ("/mission/environment/current/depths", "values of the current", values, limits.table_rows, "thin the table"),
    ]


def _sample_counts(control: Control, solver: Solver, limits: Limits, *, duration: float, cells: int) -> list[Count]:
    """Return what counts over time; `cells` is the number of components that move."""
    fixed, per_cell = COLUMNS[solver.model]
    controller = control.controller
    if controller is not None:
        fixed, per_cell = fixed + CONTROL_COLUMNS[0], per_cell + CONTROL_COLUMNS[1]
    most = min(limits.samples, limits.numbers // (fixed + per_cell * cells))
    samples, hint = math.ceil(duration / solver.output_interval), f"use an interval of at least {duration / most:.3g} s"
    counts: list[Count] = [
        ("/mission/duration", "seconds", duration, limits.duration, "shorten the mission"),
        ("/mission/solver/output_interval", "samples of the result", samples, most, hint),
    ]
    if controller is not None:
        controlled = duration / controller.sample_time
        hint = f"use a sample time of at least {duration / limits.samples:.3g} s"
        counts.append(
            ("/mission/control/controller/sample_time", "samples of the controller", controlled, limits.samples, hint)
        )
    if solver.method == "rk4":
        steps = math.ceil(duration / solver.step)
        hint = f"use a step of at least {duration / limits.steps:.3g} s, or the adaptive method"
        counts.append(("/mission/solver/step", "steps", steps, limits.steps, hint))
    return counts


def table_rows(source: Hydrodynamics) -> tuple[int, str]:
    """Return how many rows of forces a source holds, and which field says so."""
    match source:
        case PolarTable():
            return len(source.row_alpha_deg), "row_alpha_deg"
        case AngleTable():
            return len(source.alpha_deg) * len(source.beta_deg), "alpha_deg"
        case _:
            return 0, "kind"


def _outside(extension: float, stops: tuple[float, float]) -> bool:
    slack = 1e-9 * (stops[1] - stops[0])
    return not stops[0] - slack <= extension <= stops[1] + slack


def _stop_problem(pointer: str, part: Actuated, extension: float) -> Problem:
    low, high = part.stroke
    rolls = extension_unit(part) == "rad"
    scale, unit, what = (math.degrees(1.0), "deg", "angle") if rolls else (1e3, "mm", "extension")
    return Problem(
        pointer,
        f"{what} {extension * scale:g} {unit} of '{part.name}' lies outside its stops [{low * scale:g}, "
        f"{high * scale:g}] {unit}",
        limit=low if extension < low else high,
        hint="stay within the stops, or move them",
    )


def _schedule_problems(design: Design) -> Iterator[Problem]:
    moving = {c.name: c for _, c in design.vehicle.actuated}
    seen: set[str] = set()
    for i, schedule in enumerate(design.mission.control.schedules):
        pointer = f"/mission/control/schedules/{i}"
        part = moving.get(schedule.cell)
        if part is None:
            yield _unknown(f"{pointer}/cell", schedule.cell, moving)
            continue
        if schedule.cell in seen:
            yield Problem(f"{pointer}/cell", f"'{schedule.cell}' has a schedule already", limit=1, hint="merge the two")
        seen.add(schedule.cell)
        k = _first_outside(schedule, part.stroke)
        if k is not None:
            yield _stop_problem(f"{pointer}/points/{k}/extension", part, schedule.points[k].extension)
    yield from _extension_problems(moving, design.mission.initial.extensions, "/mission/initial/extensions")


@remembered(most=1_000)
def _first_outside(schedule: Schedule, stops: tuple[float, float]) -> int | None:
    """Return the first point of a schedule beyond the stops, None where there is none."""
    return next((k for k, point in enumerate(schedule.points) if _outside(point.extension, stops)), None)


def extension_problems(design: Design, extensions: Mapping[str, float], pointer: str) -> Iterator[Problem]:
    """Yield what is wrong with extensions (m, by name) that stand at `pointer`: unknown names, and stops passed."""
    return _extension_problems({c.name: c for _, c in design.vehicle.actuated}, extensions, pointer)


def _extension_problems(
    moving: Mapping[str, Actuated], extensions: Mapping[str, float], pointer: str
) -> Iterator[Problem]:
    for name, extension in extensions.items():
        part = moving.get(name)
        if part is None:
            yield _unknown(pointer + pointer_to(name), name, moving)
        elif _outside(extension, part.stroke):
            yield _stop_problem(pointer + pointer_to(name), part, extension)


def _unknown(pointer: str, name: str, moving: Iterable[str]) -> Problem:
    names = ", ".join(f"'{known}'" for known in moving) or "none"
    return Problem(pointer, f"no component that moves is named '{name}'", hint=f"those are: {names}")


def _initial_problems(design: Design) -> Iterator[Problem]:
    initial, bed = design.mission.initial, design.mission.environment.bed_depth
    depth = initial.position[2]
    if depth < 0.0:
        yield Problem(
            "/mission/initial/position/2", f"the glider starts at z = {depth:g} m, above the surface", limit=0.0,
            hint="z points down: give a depth of 0 or more",
        )  # fmt: skip
    if bed is not None and depth >= bed:
        yield Problem(
            "/mission/initial/position/2", f"the glider starts at z = {depth:g} m, at or below the bed at {bed:g} m",
            limit=bed, hint="start above the bed",
        )  # fmt: skip
