"""Owns the one door between descriptions and numbers: refuses what cannot be simulated, makes the kernel's records."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.added_mass import added_mass, damping_matrix
from models.assemble_control import control_records
from models.assemble_spatial import spatial_records
from models.attitude import quaternion_from_rpy_radians, rotation_of
from models.checks import check_design
from models.components import Actuated, MovableMass
from models.design import DeclaredMass, Design
from models.design_warnings import warnings_for
from models.environment import Current, Environment
from models.hydrodynamic_law import HydrodynamicLaw
from models.hydrodynamic_sources import Hydrodynamics
from models.kernel import params, spatial_layout
from models.kernel.params import BODY, PART, Params
from models.limits import DEFAULT_LIMITS, Limits
from models.mass_properties import Masses, initial_extensions, masses
from models.memory import remembered
from models.problems import Problem
from models.records import named_bytes, record_bytes, records
from models.schedule import Schedule
from models.still_parts import still_masses, still_parts
from models.volumes import axis_numbers, core_volume, grows_along_axis, volume_law
from models.water import current_table, gravity_of, surface_density

Array = NDArray[np.float64]
NO_LAW = HydrodynamicLaw(np.array([-np.pi, np.pi]), np.zeros((1, 3, 4)), ())
"""Stands in the records where the forces come from a table over both angles."""
REFERENCE_SPEED = 0.1
"""Speed whose kinetic energy scales errors in the work states, m/s."""


@dataclass(frozen=True)
class Assembly:
    """A design made ready for the kernel: its constants, its initial state, and what the user should be warned of.

    `law` is that of the angle of attack; None for a table over both angles, which has one of its own.
    """

    design: Design
    params: Params
    initial_state: Array
    cells: tuple[str, ...]
    law: HydrodynamicLaw | None

    @cached_property
    def warnings(self) -> tuple[Problem, ...]:
        """What may surprise; found when it is asked for, since batches of thousands never do."""
        return tuple(warnings_for(self.design))


def assemble(design: Design, limits: Limits = DEFAULT_LIMITS) -> Assembly:
    """Turn a design into the kernel's records.

    Raises
    ------
    DesignError
        With the numbers, where the design cannot be simulated or exceeds a limit.

    """
    law = check_design(design, limits)
    parts = [component for _, component in design.vehicle.actuated]
    extensions = initial_extensions(design)
    laws = [volume_law(part) for part in parts]
    schedules = {schedule.cell: schedule for schedule in design.mission.control.schedules}
    commands = [_command_rows(schedules.get(part.name), extensions[part.name]) for part in parts]
    table, lookup, lookup_scale = _law_records(law or NO_LAW)
    weighs, added, damping = masses(design.vehicle, extensions), added_mass(design), damping_matrix(design)
    constants = Params(
        body=_body(design, weighs, A=added, D=damping, lookup_scale=lookup_scale),
        parts=_parts(design, parts, laws, commands),
        volume_law=_stack(laws, 5),
        commands=_stack(commands, 3),
        table=table,
        lookup=lookup,
        error_scale=_error_scale(design, parts, weighs.mass),
        **spatial_records(design, parts, weighs, added=added, damping=damping),
        **control_records(design),
    )
    state = _initial_state(design, [extensions[part.name] for part in parts])
    return Assembly(design, constants, state, tuple(part.name for part in parts), law)


def _stack(rows: list[Array], columns: int) -> Array:
    return np.ascontiguousarray(np.concatenate(rows)) if rows else np.zeros((0, columns))


def _body(
    design: Design, weighs: Masses, *, A: Array, D: Array, lookup_scale: float
) -> NDArray[np.void]:  # fmt: skip
    vehicle = design.vehicle
    still, (mass_x, _, mass_z, _, inertia_yy, *_) = still_parts(vehicle), still_masses(vehicle, weighs)
    if vehicle.mass_properties.kind != "declared":
        inertia_yy = still.pitch
    values = {
        **_surroundings(design.mission.environment, vehicle.hydrodynamics, A, D),
        "lookup_scale": lookup_scale,
        "mass": weighs.mass,
        "mass_x": mass_x, "mass_z": mass_z, "inertia_yy": inertia_yy,
        "volume": still.volume, "volume_x": still.volume_x, "volume_z": still.volume_z,
    }  # fmt: skip
    return records(BODY, [named_bytes(BODY, values)])


@remembered(most=100, about=4)
def _surroundings(environment: Environment, table: Hydrodynamics, A: Array, D: Array) -> dict[str, float]:
    """Return what the water is, and what it does to the vehicle."""
    density = surface_density(environment.water)
    return {
        "gravity": gravity_of(environment),
        "density": density,
        "bed_depth": math.inf if environment.bed_depth is None else environment.bed_depth,
        "a11": A[0, 0], "a13": A[0, 2], "a15": A[0, 4], "a33": A[2, 2], "a35": A[2, 4], "a55": A[4, 4],
        "munk_in_table": float(table.includes_munk_moment),
        "d11": D[0, 0], "d33": D[2, 2], "d55": D[4, 4],
        "force_scale": density / table.reference_density,
        "reference_x": table.reference_point[0],
        "reference_z": table.reference_point[2],
    }  # fmt: skip


def _parts(design: Design, parts: list[Actuated], laws: list[Array], commands: list[Array]) -> NDArray[np.void]:
    declared = isinstance(design.vehicle.mass_properties, DeclaredMass)
    rows: list[bytes] = []
    law_start = command_start = 0
    for part, law, command in zip(parts, laws, commands, strict=True):
        place = (law_start, len(law), command_start, len(command))
        rows.append(record_bytes(PART, (*_part_numbers(part, declared), *place)))
        law_start += len(law)
        command_start += len(command)
    return records(PART, rows)


@remembered(most=1_000)
def _part_numbers(part: Actuated, declared: bool) -> tuple[float, ...]:
    """Return the record of a part up to where its law and its command stand among those of all."""
    axis, center = axis_numbers(part), part.center_of_mass or part.position
    low, high = part.stroke
    values = {
        "axis_x": axis[0], "axis_z": axis[2], "neutral": part.neutral, "stop_low": low, "stop_high": high,
        "rate": math.inf if part.rate_limit is None else part.rate_limit,
        "inverse_lag": 1.0 / part.lag if part.lag > 0.0 else 0.0,
        "moving_mass": part.mass if isinstance(part, MovableMass) and not declared else 0.0,
        "moving_x": center[0], "moving_z": center[2], "x": part.position[0], "z": part.position[2],
        "core_volume": core_volume(part), "grows": float(grows_along_axis(part)),
    }  # fmt: skip
    return tuple(values[name] for name in PART.names or () if name in values)


@remembered(most=1_000)
def _command_rows(schedule: Schedule | None, initial: float) -> Array:
    """Return the command as rows of time, value and slope, each in force until the next."""
    rows = [[0.0, initial, 0.0]]
    for point in schedule.points if schedule else ():
        time, value = rows[-1][0], rows[-1][1]
        if point.shape == "ramp" and point.time > time:
            rows[-1][2] = (point.extension - value) / (point.time - time)
        row = [point.time, point.extension, 0.0]
        if point.time > time:
            rows.append(row)
        else:
            rows[-1] = row
    return np.array(rows)


@remembered(most=100)
def _law_records(law: HydrodynamicLaw) -> tuple[Array, NDArray[np.int64], float]:
    """Return table, lookup and its scale; designs with one law share them."""
    return _table(law), *_lookup(law.breaks)


def _table(law: HydrodynamicLaw) -> Array:
    pieces, _, order = law.coefficients.shape
    table = np.zeros((pieces + 1, 1 + 3 * order))
    table[:, 0] = law.breaks
    table[:-1, 1:] = law.coefficients.reshape(pieces, 3 * order)
    return table


def _lookup(breaks: Array) -> tuple[NDArray[np.int64], float]:
    """Return the piece at the lower edge of equal buckets, each with one break at most, and the buckets per rad."""
    buckets = math.ceil(2.0 * math.pi / float(np.diff(breaks).min()) * 1.001) + 1
    edges = -math.pi + np.arange(buckets) * (2.0 * math.pi / buckets)
    lookup = np.searchsorted(breaks, edges, side="right") - 1
    # the kernel's rounding may put an angle into the bucket before its own: step back to the piece below an edge
    return np.clip(lookup, 0, len(breaks) - 2).astype(np.int64), buckets / (2.0 * math.pi)


def _error_scale(design: Design, parts: list[Actuated], mass: float) -> Array:
    """Return what an error of 1 means in each state; works are scaled by the energy of moving at `REFERENCE_SPEED`."""
    spatial = design.mission.solver.model == "spatial"
    layout: Any = spatial_layout if spatial else params
    work, first = layout.WORK_ACTUATORS, layout.EXTENSIONS
    tolerance = design.mission.solver.tolerance
    energy = mass * REFERENCE_SPEED**2 * tolerance
    strokes = [(high - low) * tolerance for low, high in (part.stroke for part in parts)]
    spent = [energy] * (len(parts) if spatial else 0)
    return np.array([tolerance] * work + [energy] * (first - work) + strokes + spent)


def _initial_state(design: Design, extensions: list[float]) -> Array:
    initial = design.mission.initial
    x, y, z = initial.position
    if design.mission.solver.model == "planar":
        u, w, q = initial.velocity[0], initial.velocity[2], initial.angular_velocity[1]
        return np.array([x, z, initial.pitch, u, w, q, 0.0, 0.0, *extensions])
    attitude, velocity = quaternion_from_rpy_radians(initial.roll, initial.pitch, initial.yaw), initial.velocity
    current = design.mission.environment.current
    if current is not None:
        velocity = (np.array(velocity) + rotation_of(attitude).T @ _current_at(current, z)).tolist()
    return np.array(
        [
            x, y, z, *attitude.tolist(), *velocity, *initial.angular_velocity,
            0.0, 0.0, 0.0, *extensions, *[0.0] * len(extensions),
        ]
    )  # fmt: skip


@remembered(most=100)
def _current_at(current: Current, depth: float) -> Array:
    """Return the current at time zero, (3,) m/s in the world."""
    table = current_table(current)
    profiles = table.rows.reshape(len(table.times), table.levels, 9)
    row = max(int(np.searchsorted(profiles[0, :, 0], depth, side="right")) - 1, 0)
    h = (depth - profiles[0, row, 0]) ** np.arange(4)
    values = profiles[:, row, 1:].reshape(-1, 2, 4) @ h
    return np.array([*(np.interp(0.0, table.times, column) for column in values.T), 0.0])
