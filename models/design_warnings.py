"""Owns what does not stop a run, yet may surprise: each warning with the number that shows it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from models.added_mass import damping_matrix
from models.allocation import allocate, authority
from models.assemble_control import controlled_cells
from models.controllers import Cascade, DepthBand, HoldHeave
from models.design import Design
from models.hydrodynamics import PolarTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.mass_properties import MassBalance, inertia_matrix, mass_balance, smallest_moment
from models.problems import Problem, pointer_to
from models.stray_parts import POINTS, stray_parts
from models.water import gravity_of, surface_density, unstable_layers


def warnings_for(design: Design) -> Iterator[Problem]:
    """Yield everything about a design that its maker should know before it runs."""
    balance = mass_balance(design.vehicle)
    yield from _floating(design, balance)
    yield from _far_off(design, balance)
    yield from _masses(design, balance)
    yield from _inertias(design, balance)
    yield from _water(design)
    yield from _sideways(design)
    yield from _damping(design)
    yield from _late_points(design)
    yield from _control(design)


def _floating(design: Design, balance: MassBalance) -> Iterator[Problem]:
    environment = design.mission.environment
    gravity = gravity_of(environment)
    weight = balance.mass * gravity
    net = balance.net_buoyancy(surface_density(environment.water), gravity)
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


def _far_off(design: Design, balance: MassBalance) -> Iterator[Problem]:
    """Yield a warning of positions far off the vehicle; `limit` is its length without the parts that are there."""
    for stray in stray_parts(design.vehicle, balance.volume):
        name, length = design.vehicle.components[stray.component].name, stray.vehicle_length
        yield Problem(
            pointer_to("vehicle", "components", stray.component, stray.field, stray.axis),
            f"'{name}' is far off the vehicle: its {POINTS[stray.field]} {'xyz'[stray.axis]} is {stray.place:.6g} m, "
            f"and without it the vehicle is {length:.3g} m long",
            limit=length, hint="check the number and its unit",
        )  # fmt: skip


def _masses(design: Design, balance: MassBalance) -> Iterator[Problem]:
    vehicle = design.vehicle
    if vehicle.mass_properties.kind != "declared":
        return
    parts = math.fsum(c.mass for c in vehicle.components)
    if abs(parts - balance.mass) > 1e-3 * balance.mass:
        yield Problem(
            "/vehicle/mass_properties/mass",
            f"declared are {1e3 * balance.mass:.4g} g, the parts weigh {1e3 * parts:.4g} g: only the declared counts",
            limit=parts, hint="declare the sum, or use composite mass properties",
        )  # fmt: skip
    if any(c.kind in ("movable_mass", "rolling_mass") for c in vehicle.components):
        yield Problem(
            "/vehicle/mass_properties", "declared mass properties are frozen: movable masses have no effect",
            hint="use composite mass properties",
        )  # fmt: skip


def _inertias(design: Design, balance: MassBalance) -> Iterator[Problem]:
    if design.vehicle.mass_properties.kind == "declared":
        yield from _triangle(balance.inertia, "/vehicle/mass_properties/inertia", "the vehicle", design)
        return
    for i, component in enumerate(design.vehicle.components):
        pointer, smallest = pointer_to("vehicle", "components", i, "inertia"), smallest_moment(component.inertia)
        if smallest < 0.0:
            yield Problem(
                pointer, f"the inertia of '{component.name}' has a negative principal moment, {smallest:.4g} kg m2",
                limit=0.0, hint="check the products of inertia",
            )  # fmt: skip
        else:
            yield from _triangle(inertia_matrix(component.inertia), pointer, f"'{component.name}'", design)


def _triangle(inertia: NDArray[np.float64], pointer: str, whose: str, design: Design) -> Iterator[Problem]:
    """Yield a warning where no distribution of mass has these moments: the largest exceeds the sum of the others."""
    if design.mission.solver.model == "planar":
        return  # only the moment in pitch counts
    small, middle, large = (float(value) for value in np.linalg.eigvalsh(inertia))
    if large > (small + middle) * (1.0 + 1e-9) + 1e-12:
        yield Problem(
            pointer,
            f"the inertia of {whose} breaks the triangle inequality: {large:.4g} exceeds {small:.4g} + {middle:.4g} "
            "kg m2",
            limit=small + middle, hint="no body has such moments: check them",
        )  # fmt: skip


def _water(design: Design) -> Iterator[Problem]:
    layer = unstable_layers(design.mission.environment.water)
    if layer is not None:
        yield Problem(
            "/mission/environment/water/depths",
            f"the water is unstable between {layer.top:g} and {layer.bottom:g} m: its density falls by "
            f"{layer.drop:.3g} kg/m3",
            limit=0.0, hint="check the profile, or smooth it",
        )  # fmt: skip


def _sideways(design: Design) -> Iterator[Problem]:
    vehicle = design.vehicle
    if design.mission.solver.model == "planar":
        if any(abs(c.position[1]) > 0.0 for c in vehicle.components):
            yield Problem("/mission/solver/model", "the planar model ignores offsets to port and starboard")
        return
    source = vehicle.hydrodynamics
    if isinstance(source, PolarTable) and source.lateral is None:
        pointer, hint = "/vehicle/hydrodynamics/lateral", "state lateral coefficients, or use the planar model"
    elif isinstance(source, CoefficientForm) and source.side_sideslip == 0.0 and source.yaw_sideslip == 0.0:
        pointer, hint = "/vehicle/hydrodynamics/yaw_sideslip", "state K_beta and K_MY, or use the planar model"
    else:
        return
    yield Problem(
        pointer, "there is no side force or yaw moment data: nothing holds the glider against sideslip", hint=hint
    )


def _damping(design: Design) -> Iterator[Problem]:
    """Yield a warning where linear damping would feed the motion instead of damping it."""
    D = damping_matrix(design)
    smallest = float(np.linalg.eigvalsh(0.5 * (D + D.T))[0])
    if smallest < -1e-9 * float(np.abs(D).max()):
        yield Problem(
            "/vehicle/damping/matrix",
            f"the damping feeds some motion with energy: its symmetric part has the eigenvalue {smallest:.4g}",
            limit=0.0, hint="check the signs: forces are minus the matrix times the velocity",
        )  # fmt: skip


def _control(design: Design) -> Iterator[Problem]:
    """Yield a warning where a controller asks for what it cannot get: depth below the bed, heave beyond the strokes."""
    controller, bed = design.mission.control.controller, design.mission.environment.bed_depth
    if not isinstance(controller, Cascade):
        return
    at, vertical = "/mission/control/controller/vertical", controller.vertical
    if isinstance(vertical, DepthBand) and bed is not None and vertical.bottom >= bed:
        yield Problem(
            f"{at}/bottom", f"the band ends at {vertical.bottom:g} m, at or below the bed at {bed:g} m",
            limit=bed, hint="end it above the bed, or no climb begins",
        )  # fmt: skip
    cells = controlled_cells(design, controller)
    wanted = (
        {"heave": vertical.heave} if isinstance(vertical, HoldHeave)
        else {"dive_heave": vertical.dive_heave, "climb_heave": vertical.climb_heave}
    )  # fmt: skip
    for field, heave in wanted.items():
        if not allocate(cells, (heave, 0.0, 0.0)).short:
            continue  # the usual case, told in microseconds; what the cells can do at most takes linear programmes
        most = authority(cells).alone["heave"]
        if not most[0] - 1e-9 <= heave <= most[1] + 1e-9:
            yield Problem(
                f"{at}/{field}",
                f"{heave:+.3g} N are asked of cells that make {most[0]:+.3g} to {most[1]:+.3g} N level",
                limit=most[0] if heave < 0.0 else most[1], hint="ask for less, or give the cells longer strokes",
            )  # fmt: skip


def _late_points(design: Design) -> Iterator[Problem]:
    mission = design.mission
    for i, schedule in enumerate(mission.control.schedules):
        if schedule.points[-1].time > mission.duration:
            yield Problem(
                pointer_to("mission", "control", "schedules", i, "points", len(schedule.points) - 1, "time"),
                f"'{schedule.cell}' has points after the mission's end at {mission.duration:g} s",
                limit=mission.duration, hint="lengthen the mission",
            )  # fmt: skip
