"""Owns mass, centre of mass, inertia, displaced volume and centre of buoyancy as functions of the extensions.

Body axes, SI units. Written apart from the kernel, so that tests can hold one against the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.components import Component, Inertia, MovableMass, Rigid, RollingMass
from models.design import DeclaredMass, Design, Vehicle, parse_design
from models.memory import remembered
from models.problems import DesignError, Problem, pointer_to
from models.volumes import axis_numbers, core_volume, grows_along_axis, unit_axis, volume
from models.water import surface_density

Array = NDArray[np.float64]
Numbers3 = tuple[float, float, float]


@dataclass(frozen=True)
class MassBalance:
    """How the vehicle weighs and floats at given extensions.

    `center_of_mass`, `center_of_buoyancy` (3,) m; `inertia` (3, 3) kg m2 about the centre of mass; `volume` m3.
    """

    mass: float
    center_of_mass: Array
    inertia: Array
    volume: float
    center_of_buoyancy: Array

    @property
    def inertia_about_origin(self) -> Array:
        """Inertia about the body origin, (3, 3) kg m2."""
        return self.inertia + self.mass * point_inertia(self.center_of_mass)

    def net_buoyancy(self, density: float, gravity: float) -> float:
        """Return buoyancy minus weight, N; positive rises."""
        return gravity * (density * self.volume - self.mass)


class Masses(NamedTuple):
    """What the vehicle weighs at given extensions, in plain numbers: those of `MassBalance`, row by row.

    `center` is the centre of mass (m), `inertia` about it (kg m2).
    """

    mass: float
    center: Numbers3
    inertia: tuple[Numbers3, Numbers3, Numbers3]

    @property
    @remembered(most=100)  # declared ones are those of all cases
    def moments(self) -> tuple[float, ...]:
        """First moment about the body origin (kg m), then the inertia xx, yy, zz, xy, xz, yz about it (kg m2)."""
        mass, (x, y, z), rows = self.mass, self.center, self.inertia
        inertia = [a + mass * b for a, b in zip(chain(*rows), point_numbers(x, y, z), strict=True)]
        return mass * x, mass * y, mass * z, *(inertia[k] for k in (0, 4, 8, 1, 2, 5))


def point_inertia(r: Array) -> Array:
    """Return the inertia of a unit point mass at r (3,) about the origin, (3, 3) m2."""
    return np.array(point_numbers(*r.tolist())).reshape(3, 3)


def point_numbers(x: float, y: float, z: float) -> tuple[float, ...]:
    """Return the entries of `point_inertia`, row by row."""
    xy, xz, yz = -x * y, -x * z, -y * z
    return y * y + z * z, xy, xz, xy, x * x + z * z, yz, xz, yz, x * x + y * y


def rotation_about(axis: Array, angle: float) -> Array:
    """Return the rotation by an angle (rad) about a unit axis (3,), right-handed, (3, 3) (Rodrigues)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * (skew @ skew)
    return np.asarray(turn, dtype=np.float64)


def inertia_matrix(inertia: Inertia) -> Array:
    """Return the tensor as a matrix (3, 3), kg m2."""
    return np.array(
        [
            [inertia.xx, inertia.xy, inertia.xz],
            [inertia.xy, inertia.yy, inertia.yz],
            [inertia.xz, inertia.yz, inertia.zz],
        ]
    )


@remembered(most=5_000)
def smallest_moment(inertia: Inertia) -> float:
    """Return the smallest principal moment, kg m2; 0 where only rounding makes it negative."""
    matrix = inertia_matrix(inertia)
    smallest = float(np.linalg.eigvalsh(matrix)[0])
    return min(smallest, 0.0) if abs(smallest) > 1e-9 * max(float(np.abs(matrix).max()), 1e-12) else 0.0


def initial_extensions(design: Design) -> dict[str, float]:
    """Return the extension of every moving component at time zero, before any command, m."""
    given = design.mission.initial.extensions
    return {c.name: given[c.name] if c.name in given else c.neutral for _, c in design.vehicle.actuated}


def component_center_of_mass(component: Component, extension: float) -> Array:
    """Return a component's centre of mass at an extension, (3,) m."""
    return np.array(_center_of_mass(component, extension))


def _center_of_mass(component: Component, extension: float) -> Numbers3:
    home = component.center_of_mass or component.position
    if isinstance(component, MovableMass):
        (x, y, z), (a, b, c), travel = home, axis_numbers(component), extension - component.neutral
        return x + travel * a, y + travel * b, z + travel * c
    if isinstance(component, RollingMass):
        turn, pivot = rotation_about(unit_axis(component), extension - component.neutral), np.array(component.pivot)
        x, y, z = (pivot + turn @ (np.array(home) - pivot)).tolist()
        return x, y, z
    return home


def component_inertia(component: Component, extension: float) -> Array:
    """Return a component's inertia about its own centre of mass at an extension, (3, 3) kg m2; it turns with it."""
    own = inertia_matrix(component.inertia)
    if not isinstance(component, RollingMass):
        return own
    turn = rotation_about(unit_axis(component), extension - component.neutral)
    return np.asarray(turn @ own @ turn.T, dtype=np.float64)


def component_center_of_buoyancy(component: Component, extension: float) -> Array:
    """Return a component's centre of buoyancy at an extension, (3,) m; its position where it displaces nothing."""
    total = volume(component, extension)
    shift = np.array(_stack_moment(component, extension, total)) / total if total > 0.0 else np.zeros(3)
    return np.asarray(np.array(component.position) + shift, dtype=np.float64)


def component_volume_moment(component: Component, extension: float) -> Array:
    """Return the first moment of the displaced volume about the origin, (3,) m4; it exists where V = 0 too."""
    return np.array(_volume_moment(component, extension, volume(component, extension)))


def _volume_moment(component: Component, extension: float, displaced: float) -> Numbers3:
    (x, y, z), (dx, dy, dz) = component.position, _stack_moment(component, extension, displaced)
    return displaced * x + dx, displaced * y + dy, displaced * z + dz


def _stack_moment(component: Component, extension: float, displaced: float) -> Numbers3:
    """Return the stack's first moment about the component's position, m4: its centre moves by half its growth.

    `displaced` is the component's volume at the extension, m3.
    """
    if isinstance(component, Rigid | MovableMass | RollingMass) or not grows_along_axis(component):
        return 0.0, 0.0, 0.0
    a, b, c = axis_numbers(component)
    moment = 0.5 * (extension - component.neutral) * (displaced - core_volume(component))
    return moment * a, moment * b, moment * c


@remembered(most=2_000)
def _volume_share(component: Component, extension: float) -> tuple[float, ...]:
    """Return what a component adds to the volume and its first moment about the origin."""
    displaced = volume(component, extension)
    return displaced, *_volume_moment(component, extension, displaced)


@remembered(most=2_000)
def _mass_share(component: Component, extension: float) -> tuple[float, ...]:
    """Return what a component adds to mass, its first moment, and the inertia about the origin, row by row."""
    (x, y, z), mass = _center_of_mass(component, extension), component.mass
    if isinstance(component, RollingMass):
        own = component_inertia(component, extension).ravel().tolist()
    else:
        i = component.inertia
        own = [i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz]
    inertia = [a + mass * b for a, b in zip(own, point_numbers(x, y, z), strict=True)]
    return mass, mass * x, mass * y, mass * z, *inertia


def _placed(vehicle: Vehicle, extensions: tuple[float, ...]) -> Iterable[tuple[Component, float]]:
    """Return every component with its extension; 0 for those that do not move."""
    places = iter(extensions)
    return [(c, 0.0 if isinstance(c, Rigid) else next(places)) for c in vehicle.components]


def masses(vehicle: Vehicle, extensions: Mapping[str, float] | None = None) -> Masses:
    """Return what `mass_balance` does of mass alone."""
    declared, given = vehicle.mass_properties, extensions or {}
    if isinstance(declared, DeclaredMass):
        return _declared(declared)
    return _composed(vehicle, tuple(given.get(c.name, c.neutral) for _, c in vehicle.actuated))


@remembered(most=100)
def _declared(declared: DeclaredMass) -> Masses:
    i = declared.inertia
    return Masses(declared.mass, declared.center_of_mass, ((i.xx, i.xy, i.xz), (i.xy, i.yy, i.yz), (i.xz, i.yz, i.zz)))


@remembered(most=16)
def _composed(vehicle: Vehicle, extensions: tuple[float, ...]) -> Masses:
    shares = [_mass_share(component, extension) for component, extension in _placed(vehicle, extensions)]
    mass, x, y, z, *inertia = (sum(column) for column in zip(*shares, strict=True))
    center = (x / mass, y / mass, z / mass) if mass > 0.0 else (0.0, 0.0, 0.0)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = (
        entry - mass * moved for entry, moved in zip(inertia, point_numbers(*center), strict=True)
    )
    return Masses(mass, center, ((xx, xy, xz), (yx, yy, yz), (zx, zy, zz)))


def mass_balance(vehicle: Vehicle, extensions: Mapping[str, float] | None = None) -> MassBalance:
    """Compose the components at the given extensions (m, by name; neutral where not named).

    m = sum m_i; r_G = sum m_i r_i / m; I_O = sum (I_i - m_i S(r_i)^2), then moved to the centre of mass.
    Declared mass properties replace the first three.
    """
    given = extensions or {}
    return _balance(vehicle, tuple(given.get(c.name, c.neutral) for _, c in vehicle.actuated))


@remembered(most=16)
def _balance(vehicle: Vehicle, extensions: tuple[float, ...]) -> MassBalance:
    shares = [_volume_share(component, extension) for component, extension in _placed(vehicle, extensions)]
    total_volume, *moment = (sum(column) for column in zip(*shares, strict=True))
    buoyancy_center = np.array(moment) / total_volume if total_volume > 0.0 else np.zeros(3)
    declared = vehicle.mass_properties
    found = _declared(declared) if isinstance(declared, DeclaredMass) else _composed(vehicle, extensions)
    center, inertia = np.array(found.center), np.array(found.inertia)
    for array in (center, inertia, buoyancy_center):
        array.flags.writeable = False  # many share it
    return MassBalance(found.mass, center, inertia, total_volume, buoyancy_center)


@dataclass(frozen=True)
class BallastChange:
    """What `trim_ballast` changed."""

    component: str
    pointer: str
    before: float
    after: float

    def __str__(self) -> str:
        return (
            f"volume of '{self.component}' changed from {self.before * 1e6:.3f} to {self.after * 1e6:.3f} cm3 "
            f"({(self.after - self.before) * 1e6:+.3f} cm3): neutral with every cell at its neutral extension"
        )


def trim_ballast(design: Design, component: str | None = None) -> tuple[Design, BallastChange]:
    """Set one rigid component's volume so that the glider is neutral with every cell at its neutral extension.

    `component` names the body or ballast to change; by default it is the rigid one with the largest volume.

    Raises
    ------
    DesignError
        Where there is no such rigid component, or the volume would have to be negative.

    """
    vehicle = design.vehicle
    rigid = [(i, c) for i, c in enumerate(vehicle.components) if isinstance(c, Rigid)]
    if component is not None:
        rigid = [(i, c) for i, c in rigid if c.name == component]
    if not rigid:
        wanted = f"named '{component}'" if component else "to take the ballast"
        raise DesignError([Problem("/vehicle/components", f"there is no rigid component {wanted}", hint="add one")])
    index, body = max(rigid, key=lambda item: item[1].volume)
    balance = mass_balance(vehicle)
    needed = balance.mass / surface_density(design.mission.environment.water) - (balance.volume - body.volume)
    pointer = pointer_to("vehicle", "components", index, "volume")
    if needed < 0.0:
        raise DesignError(
            [
                Problem(
                    pointer,
                    f"'{body.name}' would need a volume of {needed:.6g} m3: the others displace more than the mass",
                    limit=0.0,
                    hint="add mass, or make the cells smaller",
                )
            ]
        )
    trimmed = body.model_copy(update={"volume": needed})
    components = (*vehicle.components[:index], trimmed, *vehicle.components[index + 1 :])
    changed = design.model_copy(update={"vehicle": vehicle.model_copy(update={"components": components})})
    changed = parse_design(changed.model_dump(mode="json"))  # a copy is not checked against the fields' limits
    return changed, BallastChange(body.name, pointer, body.volume, needed)
