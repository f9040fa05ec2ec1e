"""Owns the one door between descriptions and numbers: refuses what cannot be simulated, makes the kernel's records."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from models.added_mass import added_mass, damping_matrix
from models.assemble_control import control_records
from models.assemble_spatial import spatial_records
from models.attitude import quaternion_from_rpy_radians, rotation_of
from models.checks import check_design
from models.components import Actuated, MovableMass, RollingMass
from models.design import DeclaredMass, Design
from models.design_warnings import warnings_for
from models.hydrodynamic_law import HydrodynamicLaw
from models.kernel import params, spatial_layout
from models.kernel.params import BODY, PART, Params
from models.limits import DEFAULT_LIMITS, Limits
from models.mass_properties import (
    MassBalance,
    component_center_of_mass,
    initial_extensions,
    mass_balance,
    point_inertia,
)
from models.memory import remembered
from models.problems import Problem
from models.schedule import Schedule
from models.volumes import core_volume, grows_along_axis, unit_axis, volume_law
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
    commands = [_command_rows(_schedule_of(design, part.name), extensions[part.name]) for part in parts]
    curve = law or NO_LAW
    table, lookup, lookup_scale = _law_records(curve)
    balance = mass_balance(design.vehicle)
    body = _body(design, lookup_scale, balance)
    records = Params(
        body=body,
        parts=_parts(design, parts, laws, commands),
        volume_law=_stack(laws, 5),
        commands=_stack(commands, 3),
        table=table,
        lookup=lookup,
        error_scale=_error_scale(design, parts, float(body["mass"][0])),
        **spatial_records(design, parts, balance),
        **control_records(design),
    )
    state = _initial_state(design, [extensions[part.name] for part in parts])
    return Assembly(design, records, state, tuple(part.name for part in parts), law)


def _stack(rows: list[Array], columns: int) -> Array:
    return np.ascontiguousarray(np.concatenate(rows)) if rows else np.zeros((0, columns))


def _body(design: Design, lookup_scale: float, balance: MassBalance) -> NDArray[np.void]:
    vehicle, environment = design.vehicle, design.mission.environment
    density = surface_density(environment.water)
    moving = set() if isinstance(vehicle.mass_properties, DeclaredMass) else _sliding(design)
    still = [c for c in vehicle.components if c.name not in moving]
    if isinstance(vehicle.mass_properties, DeclaredMass):
        moment, inertia = balance.mass * balance.center_of_mass, balance.inertia_about_origin
    else:
        centers = [component_center_of_mass(c, 0.0) for c in still]
        moment = np.sum([c.mass * r for c, r in zip(still, centers, strict=True)], axis=0) + np.zeros(3)
        inertia = np.zeros((3, 3))
        inertia[1, 1] = sum(c.inertia.yy for c in vehicle.components)
        for c, r in zip(still, centers, strict=True):
            inertia += c.mass * point_inertia(r)
    rigid = [c for c in vehicle.components if c.kind == "rigid"]
    volume_moment = np.sum([c.volume * np.array(c.position) for c in rigid], axis=0) + np.zeros(3)
    A, D = added_mass(design), damping_matrix(design)
    table = vehicle.hydrodynamics
    values = {
        "gravity": gravity_of(environment),
        "density": density,
        "bed_depth": math.inf if environment.bed_depth is None else environment.bed_depth,
        "mass": balance.mass,
        "mass_x": moment[0],
        "mass_z": moment[2],
        "inertia_yy": inertia[1, 1],
        "volume": math.fsum(c.volume for c in rigid),
        "volume_x": volume_moment[0],
        "volume_z": volume_moment[2],
        "a11": A[0, 0], "a13": A[0, 2], "a15": A[0, 4], "a33": A[2, 2], "a35": A[2, 4], "a55": A[4, 4],
        "munk_in_table": float(table.includes_munk_moment),
        "d11": D[0, 0], "d33": D[2, 2], "d55": D[4, 4],
        "force_scale": density / table.reference_density,
        "reference_x": table.reference_point[0],
        "reference_z": table.reference_point[2],
        "lookup_scale": lookup_scale,
    }  # fmt: skip
    return np.array([tuple(float(values[name]) for name in BODY.names or ())], dtype=BODY)


def _sliding(design: Design) -> set[str]:
    return {c.name for c in design.vehicle.components if isinstance(c, MovableMass | RollingMass)}


def _parts(design: Design, parts: list[Actuated], laws: list[Array], commands: list[Array]) -> NDArray[np.void]:
    records = np.zeros(len(parts), dtype=PART)
    declared = isinstance(design.vehicle.mass_properties, DeclaredMass)
    law_start = command_start = 0
    for record, part, law, rows in zip(records, parts, laws, commands, strict=True):
        axis, center = unit_axis(part), part.center_of_mass or part.position
        record["axis_x"], record["axis_z"] = axis[0], axis[2]
        record["neutral"] = part.neutral
        record["stop_low"], record["stop_high"] = part.stroke
        record["rate"] = math.inf if part.rate_limit is None else part.rate_limit
        record["inverse_lag"] = 1.0 / part.lag if part.lag > 0.0 else 0.0
        record["moving_mass"] = part.mass if isinstance(part, MovableMass) and not declared else 0.0
        record["moving_x"], record["moving_z"] = center[0], center[2]
        record["x"], record["z"] = part.position[0], part.position[2]
        record["core_volume"] = core_volume(part)
        record["grows"] = float(grows_along_axis(part))
        record["law_start"], record["law_count"] = law_start, len(law)
        record["command_start"], record["command_count"] = command_start, len(rows)
        law_start += len(law)
        command_start += len(rows)
    return records


def _schedule_of(design: Design, name: str) -> Schedule | None:
    return next((s for s in design.mission.control.schedules if s.cell == name), None)


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
    first = spatial_layout.EXTENSIONS if spatial else params.EXTENSIONS
    work = spatial_layout.WORK_ACTUATORS if spatial else params.WORK_ACTUATORS
    energy = mass * REFERENCE_SPEED**2
    scale = np.ones(first + len(parts) * (2 if spatial else 1))
    scale[work:first] = energy
    for i, part in enumerate(parts):
        low, high = part.stroke
        scale[first + i] = high - low
        if spatial:
            scale[first + len(parts) + i] = energy
    return scale * design.mission.solver.tolerance


def _initial_state(design: Design, extensions: list[float]) -> Array:
    initial = design.mission.initial
    x, y, z = initial.position
    if design.mission.solver.model == "planar":
        u, w, q = initial.velocity[0], initial.velocity[2], initial.angular_velocity[1]
        return np.array([x, z, initial.pitch, u, w, q, 0.0, 0.0, *extensions])
    attitude = quaternion_from_rpy_radians(initial.roll, initial.pitch, initial.yaw)
    velocity = np.array(initial.velocity) + rotation_of(attitude).T @ _current_at(design, z)
    return np.array(
        [
            x, y, z, *attitude, *velocity, *initial.angular_velocity,
            0.0, 0.0, 0.0, *extensions, *np.zeros(len(extensions)),
        ]
    )  # fmt: skip


def _current_at(design: Design, depth: float) -> Array:
    """Return the current at time zero, (3,) m/s in the world."""
    table = current_table(design.mission.environment.current)
    profiles = table.rows.reshape(len(table.times), table.levels, 9)
    row = max(int(np.searchsorted(profiles[0, :, 0], depth, side="right")) - 1, 0)
    h = (depth - profiles[0, row, 0]) ** np.arange(4)
    values = profiles[:, row, 1:].reshape(-1, 2, 4) @ h
    return np.array([*(np.interp(0.0, table.times, column) for column in values.T), 0.0])
