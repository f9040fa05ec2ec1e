"""Owns which parts lie absurdly far from all others: a slip of the unit puts them kilometres off the hull."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from models.components import Component
from models.design import Vehicle
from models.vehicle_length import SHORTEST, extent_along_x, span_along_x

SLENDER = 5.0
"""Length of a slender body, ten times as long as wide, by the cube root of its volume."""
FAR = 3.0
"""How many times the vehicle's size a part lies from the middle of all to be far off."""


@dataclass(frozen=True, slots=True)
class StrayPart:
    """A part's position along one axis (0 to 2), m, and the length of the vehicle without the parts that stray, m."""

    component: int
    axis: int
    position: float
    vehicle_length: float


def stray_parts(vehicle: Vehicle, volume: float) -> Iterator[StrayPart]:
    """Yield the parts of a vehicle of this displaced volume (m3) that lie far off the others.

    Its size is told without positions, which may be the wrong ones: from its volume, or by its longest part.
    """
    parts = vehicle.components
    size = max([SLENDER * math.cbrt(max(volume, 0.0)), *(_longest_shape(part) for part in parts)])
    far = FAR * size
    if all(_width(parts, axis) <= far for axis in range(3)):
        return
    middle = min(parts, key=lambda part: (math.fsum(_apart(part, other) for other in parts), -part.mass))
    near = [part for part in parts if _apart(part, middle) <= far]
    length = extent_along_x(near)
    for i, part in enumerate(parts):
        for axis, (place, center) in enumerate(zip(part.position, middle.position, strict=True)):
            if abs(place - center) > far:
                yield StrayPart(i, axis, place, length if length > SHORTEST else size)


def _longest_shape(part: Component) -> float:
    spans = [span_along_x(part, shape) for shape in getattr(part, "shapes", ())]
    return max((high - low for low, high in spans), default=0.0)


def _width(parts: tuple[Component, ...] | list[Component], axis: int) -> float:
    places = [part.position[axis] for part in parts]
    return max(places) - min(places)


def _apart(one: Component, other: Component) -> float:
    return math.dist(one.position, other.position)
