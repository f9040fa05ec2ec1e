"""Owns the answer to how a vehicle weighs and floats, whole and component by component."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from models.components import Rigid
from models.design import Design
from models.mass_properties import (
    component_center_of_buoyancy,
    component_center_of_mass,
    initial_extensions,
    mass_balance,
)
from models.problems import Problem
from models.volumes import volume
from models.water import gravity_of, surface_density
from server.schemas import ComponentMass, ErrorItem, MassProperties


def weigh(design: Design, extensions: Mapping[str, float] | None = None) -> MassProperties:
    """Return mass properties at the given extensions (m, by name), and at the initial ones where not named."""
    at = initial_extensions(design) | dict(extensions or {})
    balance = mass_balance(design.vehicle, at)
    environment = design.mission.environment
    return MassProperties(
        mass=balance.mass,
        center_of_mass=balance.center_of_mass.tolist(),
        inertia=balance.inertia.tolist(),
        volume=balance.volume,
        center_of_buoyancy=balance.center_of_buoyancy.tolist(),
        net_buoyancy=balance.net_buoyancy(surface_density(environment.water), gravity_of(environment)),
        components=[
            ComponentMass(
                name=component.name,
                kind=component.kind,
                mass=component.mass,
                center_of_mass=component_center_of_mass(component, extension).tolist(),
                volume=volume(component, extension),
                center_of_buoyancy=component_center_of_buoyancy(component, extension).tolist(),
                extension=None if isinstance(component, Rigid) else extension,
            )
            for component in design.vehicle.components
            for extension in (at.get(component.name, 0.0),)
        ],
    )


def as_items(problems: Iterable[Problem]) -> list[ErrorItem]:
    """Return problems (or warnings) as they go on the wire."""
    return [ErrorItem(**problem.as_dict()) for problem in problems]
