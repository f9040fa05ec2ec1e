"""Owns what a design must satisfy beyond its fields' limits before it can be simulated, and what is worth a warning."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.hydrodynamic_law import HydrodynamicLaw, build_law
from models.limits import Limits
from models.mass_properties import MassBalance, inertia_matrix, initial_extensions, mass_balance
from models.problems import DesignError, Problem, pointer_to

FIXED_COLUMNS, COLUMNS_PER_CELL = 33, 4
"""Numbers kept a sample: the variables over time with the states, and those of each cell with its state."""


def check_design(design: Design, limits: Limits) -> HydrodynamicLaw:
    """Return the hydrodynamic law of a design that can be simulated; else raise `DesignError` with all problems."""
    problems = list(_limit_problems(design, limits))
    if problems:
        raise DesignError(problems)
    problems = [*_control_problems(design), *_initial_problems(design), *_mass_problems(design)]
    try:
        law = build_law(design.vehicle.hydrodynamics)
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
    columns = FIXED_COLUMNS + COLUMNS_PER_CELL * len(vehicle.actuated)
    most = min(limits.samples, limits.numbers // columns)
    counts = [
        ("/vehicle/components", "components", len(vehicle.components), limits.components, "remove some"),
        ("/mission/control/schedules", "schedule points", points, limits.schedule_points, "use fewer points"),
        (
            "/vehicle/hydrodynamics/row_alpha_deg", "table rows",
            len(vehicle.hydrodynamics.row_alpha_deg), limits.table_rows, "thin the table",
        ),
        ("/mission/duration", "seconds", mission.duration, limits.duration, "shorten the mission"),
        (
            "/mission/solver/output_interval", "samples of the result",
            math.ceil(samples), most,
            f"use an interval of at least {mission.duration / most:.3g} s",
        ),
    ]  # fmt: skip
    if solver.method == "rk4":
        steps = math.ceil(mission.duration / solver.step)
        hint = f"use a step of at least {mission.duration / limits.steps:.3g} s, or the adaptive method"
        counts.append(("/mission/solver/step", "steps", steps, limits.steps, hint))
    for pointer, what, value, bound, hint in counts:
        if value > bound:
            yield Problem(pointer, f"{value:g} {what} exceed the limit of {bound:g}", limit=bound, hint=hint)


def _outside(extension: float, stops: tuple[float, float]) -> bool:
    slack = 1e-9 * (stops[1] - stops[0])
    return not stops[0] - slack <= extension <= stops[1] + slack


def _stop_problem(pointer: str, name: str, extension: float, stops: tuple[float, float]) -> Problem:
    bound = stops[0] if extension < stops[0] else stops[1]
    low, high = (1e3 * stop for stop in stops)
    return Problem(
        pointer,
        f"extension {extension * 1e3:g} mm of '{name}' lies outside its stops [{low:g}, {high:g}] mm",
        limit=bound,
        hint="stay within the stops, or move them",
    )


def _control_problems(design: Design) -> Iterator[Problem]:
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
                yield _stop_problem(f"{pointer}/points/{k}/extension", part.name, point.extension, part.stroke)
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
            yield _stop_problem(at, name, extension, part.stroke)


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
    across = {
        "position/1": initial.position[1],
        "roll": initial.roll,
        "yaw": initial.yaw,
        "velocity/1": initial.velocity[1],
        "angular_velocity/0": initial.angular_velocity[0],
        "angular_velocity/2": initial.angular_velocity[2],
    }
    for field, value in across.items():
        if value != 0.0:
            yield Problem(
                f"/mission/initial/{field}", f"{value:g} leaves the vertical plane, which the planar model cannot",
                limit=0.0, hint="set it to 0",
            )  # fmt: skip


def _mass_problems(design: Design) -> Iterator[Problem]:
    vehicle = design.vehicle
    problems = list(_added_mass_problems(design))
    yield from problems
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
    added = vehicle.added_mass
    A = np.array(added.matrix) if added is not None and added.enabled else np.zeros((6, 6))
    pitch = _turning_inertia(balance, A)
    if not problems and pitch <= 1e-12 * balance.mass:
        yield Problem(
            pointer, f"the moment of inertia in pitch is {pitch:.4g} kg m2: the equations are singular",
            limit=0.0, hint="give the components inertia, or put them apart",
        )  # fmt: skip


def _turning_inertia(balance: MassBalance, A: NDArray[np.float64]) -> float:
    """Return the last pivot of the planar M: the inertia in pitch about the point that turns most freely, kg m2."""
    x, _, z = balance.mass * balance.center_of_mass
    m = balance.mass
    M = np.array([[m, 0.0, z], [0.0, m, -x], [z, -x, balance.inertia_about_origin[1, 1]]])
    M += A[np.ix_([0, 2, 4], [0, 2, 4])]
    return float(M[2, 2] - M[2, :2] @ np.linalg.solve(M[:2, :2], M[:2, 2]))


def _added_mass_problems(design: Design) -> Iterator[Problem]:
    added = design.vehicle.added_mass
    if added is None:
        return
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


def warnings_for(design: Design) -> Iterator[Problem]:
    """Yield what does not stop a run, yet may surprise: each with the number that shows it."""
    vehicle, mission = design.vehicle, design.mission
    balance = mass_balance(vehicle)
    weight = balance.mass * mission.environment.gravity
    net = balance.net_buoyancy(mission.environment.water.density, mission.environment.gravity)
    if weight > 0.0 and abs(net) > 0.02 * weight:
        yield Problem(
            "/vehicle/components",
            f"net buoyancy with neutral cells is {net:+.3g} N, {100 * net / weight:+.1f} % of weight",
            limit=0.02, hint="trim the ballast",
        )  # fmt: skip
    below = 1e3 * float(balance.center_of_mass[2] - balance.center_of_buoyancy[2])
    if below <= 0.0:
        yield Problem(
            "/vehicle/components",
            f"the centre of mass lies {-below:.3g} mm above the centre of buoyancy: it turns over",
            limit=0.0, hint="put weight lower or volume higher",
        )  # fmt: skip
    if any(abs(c.position[1]) > 0.0 for c in vehicle.components):
        yield Problem("/mission/solver/model", "the planar model ignores offsets to port and starboard")
    declared = vehicle.mass_properties.kind == "declared"
    parts = math.fsum(c.mass for c in vehicle.components)
    if declared and abs(parts - balance.mass) > 1e-3 * balance.mass:
        yield Problem(
            "/vehicle/mass_properties/mass",
            f"declared are {1e3 * balance.mass:.4g} g, the parts weigh {1e3 * parts:.4g} g: only the declared counts",
            limit=parts, hint="declare the sum, or use composite mass properties",
        )  # fmt: skip
    if declared and any(c.kind == "movable_mass" for c in vehicle.components):
        yield Problem(
            "/vehicle/mass_properties", "declared mass properties are frozen: movable masses have no effect",
            hint="use composite mass properties",
        )  # fmt: skip
    if not declared and any(_has_negative_moment(c.inertia) for c in vehicle.components):
        yield Problem("/vehicle/components", "a component's inertia has a negative principal moment", limit=0.0)
    for i, schedule in enumerate(mission.control.schedules):
        if schedule.points[-1].time > mission.duration:
            yield Problem(
                pointer_to("mission", "control", "schedules", i, "points", len(schedule.points) - 1, "time"),
                f"'{schedule.cell}' has points after the mission's end at {mission.duration:g} s",
                limit=mission.duration, hint="lengthen the mission",
            )  # fmt: skip


def _has_negative_moment(inertia: object) -> bool:
    matrix = inertia_matrix(inertia)  # type: ignore[arg-type]
    return bool(np.linalg.eigvalsh(matrix)[0] < -1e-9 * max(float(np.abs(matrix).max()), 1e-12))
