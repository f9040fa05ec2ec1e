"""Owns what a design must satisfy beyond its fields' limits before it can be simulated."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from models.added_mass import added_mass
from models.assemble_control import control_problems
from models.components import Actuated, extension_unit
from models.design import Design
from models.hydrodynamic_law import HydrodynamicLaw, law_of
from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import AddedMass, PolarTable
from models.hydrodynamics_angles import AngleTable
from models.limits import Limits
from models.mass_properties import MassBalance, initial_extensions, mass_balance, smallest_moment
from models.memory import remembered
from models.model_checks import model_problems
from models.problems import DesignError, Problem, pointer_to
from models.water import gravity_of, water_table

COLUMNS = {"planar": (33, 4), "spatial": (100, 6)}
"""Numbers kept a sample: the variables over time with the states, and those of each cell with its states."""
CONTROL_COLUMNS = (24, 1)
"""Those beside them under control: what it shows, as recorded and as kept, and the command of each cell."""


def check_design(design: Design, limits: Limits) -> HydrodynamicLaw | None:
    """Return the law in the angle of attack of a design that can be simulated, None where its source has another.

    Raises
    ------
    DesignError
        With all problems, where it cannot be simulated.

    """
    problems = list(_limit_problems(design, limits))
    if problems:
        raise DesignError(problems)
    problems = [
        *_schedule_problems(design), *control_problems(design), *_initial_problems(design), *model_problems(design),
        *_mass_problems(design),
    ]  # fmt: skip
    try:
        law = law_of(design.vehicle.hydrodynamics)
        water_table(design.mission.environment.water, gravity_of(design.mission.environment))
    except DesignError as error:
        raise DesignError([*problems, *error.problems]) from None
    if problems:
        raise DesignError(problems)
    return law


def _limit_problems(design: Design, limits: Limits) -> Iterator[Problem]:
    mission, vehicle = design.mission, design.vehicle
    solver = mission.solver
    points = sum(len(s.points) for s in mission.control.schedules)
    samples = mission.duration / solver.output_interval
    fixed, per_cell = COLUMNS[solver.model]
    controller = mission.control.controller
    if controller is not None:
        fixed, per_cell = fixed + CONTROL_COLUMNS[0], per_cell + CONTROL_COLUMNS[1]
    controlled = 0.0 if controller is None else mission.duration / controller.sample_time
    columns = fixed + per_cell * len(vehicle.actuated)
    rows, where = table_rows(vehicle.hydrodynamics)
    levels = len(getattr(mission.environment.water, "depths", ()))
    values = sum(len(profile) for profile in getattr(mission.environment.current, "north", ()))
    most = min(limits.samples, limits.numbers // columns)
    counts = [
        ("/vehicle/components", "components", len(vehicle.components), limits.components, "remove some"),
        ("/mission/control/schedules", "schedule points", points, limits.schedule_points, "use fewer points"),
        (f"/vehicle/hydrodynamics/{where}", "table rows", rows, limits.table_rows, "thin the table"),
        ("/mission/environment/water/depths", "levels of the water", levels, limits.table_rows, "thin the profile"),
        ("/mission/environment/current/depths", "values of the current", values, limits.table_rows, "thin the table"),
        ("/mission/duration", "seconds", mission.duration, limits.duration, "shorten the mission"),
        (
            "/mission/solver/output_interval", "samples of the result",
            math.ceil(samples), most,
            f"use an interval of at least {mission.duration / most:.3g} s",
        ),
    ]  # fmt: skip
    if controller is not None:
        hint = f"use a sample time of at least {mission.duration / limits.samples:.3g} s"
        counts.append(
            ("/mission/control/controller/sample_time", "samples of the controller", controlled, limits.samples, hint)
        )
    if solver.method == "rk4":
        steps = math.ceil(mission.duration / solver.step)
        hint = f"use a step of at least {mission.duration / limits.steps:.3g} s, or the adaptive method"
        counts.append(("/mission/solver/step", "steps", steps, limits.steps, hint))
    for pointer, what, value, bound, hint in counts:
        if value > bound:
            yield Problem(pointer, f"{value:g} {what} exceed the limit of {bound:g}", limit=bound, hint=hint)


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
        pointer = pointer_to("mission", "control", "schedules", i)
        part = moving.get(schedule.cell)
        if part is None:
            yield _unknown(f"{pointer}/cell", schedule.cell, moving)
            continue
        if schedule.cell in seen:
            yield Problem(f"{pointer}/cell", f"'{schedule.cell}' has a schedule already", limit=1, hint="merge the two")
        seen.add(schedule.cell)
        for k, point in enumerate(schedule.points):
            if _outside(point.extension, part.stroke):
                yield _stop_problem(f"{pointer}/points/{k}/extension", part, point.extension)
                break
    yield from extension_problems(design, design.mission.initial.extensions, "/mission/initial/extensions")


def extension_problems(design: Design, extensions: Mapping[str, float], pointer: str) -> Iterator[Problem]:
    """Yield what is wrong with extensions (m, by name) that stand at `pointer`: unknown names, and stops passed."""
    moving = {c.name: c for _, c in design.vehicle.actuated}
    for name, extension in extensions.items():
        at = pointer + pointer_to(name)
        part = moving.get(name)
        if part is None:
            yield _unknown(at, name, moving)
        elif _outside(extension, part.stroke):
            yield _stop_problem(at, part, extension)


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


def _mass_problems(design: Design) -> Iterator[Problem]:
    vehicle = design.vehicle
    problems = () if vehicle.added_mass is None else _added_mass_problems(vehicle.added_mass)
    yield from problems
    yield from _component_inertia_problems(design)
    balance = mass_balance(vehicle, initial_extensions(design))
    if balance.mass <= 0.0:
        yield Problem("/vehicle/components", "the components weigh nothing", limit=0.0, hint="give one a mass")
        return
    declared = vehicle.mass_properties.kind == "declared"
    pointer = "/vehicle/mass_properties/inertia" if declared else "/vehicle/components"
    smallest = float(np.linalg.eigvalsh(balance.inertia)[0])
    tolerance = 1e-9 * max(float(np.trace(balance.inertia)), 1e-12)
    if smallest < -tolerance:
        yield Problem(
            pointer, f"the inertia about the centre of mass has a negative principal moment, {smallest:.4g} kg m2",
            limit=0.0, hint="check the products of inertia",
        )  # fmt: skip
    turning = turning_inertia(balance, added_mass(design))
    if design.mission.solver.model == "planar":
        moment, axis = float(turning[1, 1]), "pitch"
    else:
        moments, directions = np.linalg.eigh(turning)
        moment, axis = float(moments[0]), ("roll", "pitch", "yaw")[int(np.abs(directions[:, 0]).argmax())]
    if not problems and moment <= 1e-12 * balance.mass:
        yield Problem(
            pointer, f"the moment of inertia in {axis} is {moment:.4g} kg m2: the equations are singular",
            limit=0.0, hint="give the components inertia, or put them apart",
        )  # fmt: skip


def _component_inertia_problems(design: Design) -> Iterator[Problem]:
    """Yield components whose own inertia no body has: one that rolls would carry it into every attitude."""
    if design.mission.solver.model == "planar" or design.vehicle.mass_properties.kind == "declared":
        return
    for i, component in enumerate(design.vehicle.components):
        smallest = smallest_moment(component.inertia)
        if smallest < 0.0:
            yield Problem(
                pointer_to("vehicle", "components", i, "inertia"),
                f"the inertia of '{component.name}' has a negative principal moment, {smallest:.4g} kg m2",
                limit=0.0, hint="check the products of inertia",
            )  # fmt: skip


def turning_inertia(balance: MassBalance, A: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inertia about the point that turns most freely, (3, 3) kg m2: the Schur complement of M_RB + M_A."""
    mass, (x, y, z) = balance.mass, (balance.mass * balance.center_of_mass).tolist()
    whole = A[:3, :3] + np.array([[mass, 0.0, 0.0], [0.0, mass, 0.0], [0.0, 0.0, mass]])
    mixed = A[:3, 3:] + np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    turning = A[3:, 3:] + balance.inertia_about_origin - mixed.T @ np.linalg.solve(whole, mixed)
    return np.asarray(turning, dtype=np.float64)


@remembered(most=100)
def _added_mass_problems(added: AddedMass) -> tuple[Problem, ...]:
    return tuple(_matrix_problems(added))


def _matrix_problems(added: AddedMass) -> Iterator[Problem]:
    pointer = "/vehicle/added_mass/matrix"
    A = np.array(added.matrix)
    size = float(np.abs(A).max())
    skew = np.abs(A - A.T)
    if skew.max() > 1e-9 * size:
        i, j = (int(k) for k in np.unravel_index(skew.argmax(), skew.shape))
        yield Problem(
            f"{pointer}/{i}/{j}", f"added mass is not symmetric: [{i}][{j}] = {A[i, j]:g}, [{j}][{i}] = {A[j, i]:g}",
            limit=float(A[j, i]), hint="make both entries equal",
        )  # fmt: skip
        return
    smallest = float(np.linalg.eigvalsh(A)[0])
    if smallest < -1e-9 * size:
        yield Problem(
            pointer, f"added mass is not positive semi-definite: its smallest eigenvalue is {smallest:.4g}",
            limit=0.0, hint="check the signs of the couplings",
        )  # fmt: skip
