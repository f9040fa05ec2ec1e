"""Owns which parts lie absurdly far from all others: a slip of the unit puts them kilometres off the hull."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from models.components import Component, RollingMass
from models.design import Vehicle
from models.vehicle_length import SHORTEST, extent_along_x, span_along_x

SLENDER = 5.0
"""Length of a slender body, ten times as long as wide, by the cube root of its volume."""
POINTS = {"position": "position", "center_of_mass": "centre of mass", "pivot": "pivot"}
"""Fields that say where a part is, in words."""
FAR = 3.0
"""How many times the vehicle's size a part lies from the middle of all to be far off."""


@dataclass(frozen=True, slots=True)
class StrayPart:
    """One of a part's `POINTS` along one axis (0 to 2), m, and the vehicle's length without the parts that stray, m."""

    component: int
    field: str
    axis: int
    place: float
    vehicle_length: float


def stray_parts(vehicle: Vehicle, volume: float) -> Iterator[StrayPart]:
    """Yield the parts of a vehicle of this displaced volume (m3) that lie far off the others.

    Its size is told without positions, which may be the wrong ones: from its volume, or by its longest part.
    """
    parts = vehicle.components
    by_volume = SLENDER * math.cbrt(max(volume, 0.0))
    if max(abs(v) for part in parts for _, point in _points(part) for v in point) <= 0.5 * FAR * by_volume:
        return  # the usual case: all are near the body origin, and so near each other
    size = max(by_volume, *(_longest_shape(part) for part in parts))
    far = FAR * size
    middle = min(parts, key=lambda part: (math.fsum(_apart(part, other) for other in parts), -part.mass))
    near = [part for part in parts if _apart(part, middle) <= far]
    length = extent_along_x(near)
    for i, part in enumerate(parts):
        for field, point in _points(part):
            for axis, (place, center) in enumerate(zip(point, middle.position, strict=True)):
                if abs(place - center) > far:
                    yield StrayPart(i, field, axis, place, length if length > SHORTEST else size)


def _points(part: Component) -> Iterator[tuple[str, tuple[float, float, float]]]:
    yield "position", part.position
    if part.center_of_mass is not None:
        yield "center_of_mass", part.center_of_mass
    if isinstance(part, RollingMass):
        yield "pivot", part.pivot


def _longest_shape(part: Component) -> float:
    spans = [span_along_x(part, shape) for shape in getattr(part, "shapes", ())]
    return max((high - low for low, high in spans), default=0.0)


def _apart(one: Component, other: Component) -> float:
    return math.dist(one.position, other.position)
