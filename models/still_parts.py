"""Owns what of a vehicle does not move: what it weighs and displaces about the body origin, summed over components.

Body axes, SI units. The sums go through plain numbers, which for a handful of components is faster than arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from models.components import Component, MovableMass, Rigid, RollingMass
from models.design import Vehicle
from models.mass_properties import Masses, point_numbers
from models.memory import remembered


class StillParts(NamedTuple):
    """First moments of mass, inertia about the origin, volume and its first moments of all that does not move.

    `own_pitch` is the inertia in pitch of every component about its own centre of mass, also of those that move;
    `pitch` adds to that what the distances of the others from the origin do.
    """

    mass_x: float
    mass_y: float
    mass_z: float
    ixx: float
    iyy: float
    izz: float
    ixy: float
    ixz: float
    iyz: float
    volume_x: float
    volume_z: float
    own_pitch: float
    volume: float
    pitch: float


def still_masses(vehicle: Vehicle, weighs: Masses) -> Sequence[float]:
    """Return the first nine of `StillParts`, or those of the whole where masses are declared: then nothing moves."""
    return weighs.moments if vehicle.mass_properties.kind == "declared" else still_parts(vehicle)[:9]


@remembered(most=16)
def still_parts(vehicle: Vehicle) -> StillParts:
    """Return the sums over a vehicle's components."""
    *columns, volumes, about = zip(*map(_share_of, vehicle.components), strict=True)
    sums = [sum(column) for column in columns]
    return StillParts._make((*sums, math.fsum(volumes), sum(about, sums[-1])))


@remembered(most=2_000)
def _share_of(component: Component) -> tuple[float, ...]:
    """Return what a component adds; instead of `pitch`, what its distance from the origin does."""
    i = component.inertia
    if isinstance(component, MovableMass | RollingMass):
        return *[0.0] * 11, i.yy, 0.0, 0.0
    (x, y, z), mass = component.center_of_mass or component.position, component.mass
    xx, xy, xz, _, yy, yz, _, _, zz = (mass * entry for entry in point_numbers(x, y, z))
    displaced, (bx, _, bz) = component.volume if isinstance(component, Rigid) else 0.0, component.position
    return (
        mass * x, mass * y, mass * z,
        i.xx + xx, i.yy + yy, i.zz + zz, i.xy + xy, i.xz + xz, i.yz + yz,
        displaced * bx, displaced * bz, i.yy, displaced, mass * (x * x + z * z),
    )  # fmt: skip
