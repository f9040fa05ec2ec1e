"""Owns what only one of the two models can do: a planar run refuses what would leave its plane or its still water."""

from __future__ import annotations

from collections.abc import Iterator

from models.design import Design
from models.hydrodynamics_angles import AngleTable
from models.problems import Problem, pointer_to

USE_SPATIAL = "use the spatial model (/mission/solver/model), or "


def model_problems(design: Design) -> Iterator[Problem]:
    """Yield what the design asks for that its model cannot do."""
    if design.mission.solver.model == "planar":
        yield from _out_of_plane(design)
        yield from _not_still_water(design)
        yield from _parts_and_forces(design)


def _out_of_plane(design: Design) -> Iterator[Problem]:
    initial = design.mission.initial
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
                limit=0.0, hint=f"{USE_SPATIAL}set it to 0",
            )  # fmt: skip


def _not_still_water(design: Design) -> Iterator[Problem]:
    environment = design.mission.environment
    asked = (
        ("water/kind", environment.water.kind != "uniform", "water that changes with depth", "take uniform water"),
        ("current", environment.current is not None, "current", "set it to null"),
        ("surface", environment.surface != "end", "floating at the surface", "let the surface end the run"),
        ("bed_contact", environment.bed_contact != "end", "sliding on the bed", "let the bed end the run"),
    )
    for field, given, what, hint in asked:
        if given:
            yield Problem(f"/mission/environment/{field}", f"the planar model knows no {what}", hint=USE_SPATIAL + hint)


def _parts_and_forces(design: Design) -> Iterator[Problem]:
    vehicle = design.vehicle
    for i, component in enumerate(vehicle.components):
        if component.kind == "rolling_mass":
            yield Problem(
                pointer_to("vehicle", "components", i, "kind"),
                f"'{component.name}' rolls out of the vertical plane, which the planar model cannot",
                hint=f"{USE_SPATIAL}make it a movable_mass",
            )
        elif getattr(component, "bulk_modulus", None) is not None:
            yield Problem(
                pointer_to("vehicle", "components", i, "bulk_modulus"),
                f"the planar model knows no compression, such as that of '{component.name}'",
                hint=f"{USE_SPATIAL}set it to null",
            )
    if isinstance(vehicle.hydrodynamics, AngleTable):
        yield Problem(
            "/vehicle/hydrodynamics/kind", "the planar model needs lift, drag and moment over the angle of attack",
            hint=f"{USE_SPATIAL}give a polar_table or coefficients",
        )  # fmt: skip
    if vehicle.damping.matrix is not None:
        yield Problem(
            "/vehicle/damping/matrix", "the planar model knows only the damping of surge, heave and pitch",
            hint=f"{USE_SPATIAL}set it to null",
        )  # fmt: skip
