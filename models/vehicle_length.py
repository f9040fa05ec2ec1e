"""Owns the length of a vehicle, by which its margins are told: from its foremost to its rearmost point along body x.

Points are those of the shapes that components carry, cells at neutral; without any shape, the components' positions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from models.components import Component
from models.design import Vehicle
from models.shapes import BellowsShape, CylinderShape, FinShape, HullShape, Shape, WingShape

SHORTEST = 1e-6
"""A vehicle shorter than this has no length of its own, m."""
UNIT_LENGTH = 1.0
"""Length of a vehicle that has none, m: its margins are in metres then."""


def vehicle_length(vehicle: Vehicle) -> float:
    """Return the length along body x, m; 1 m where neither shapes nor positions have any."""
    length = extent_along_x(vehicle.components)
    return length if length > SHORTEST else UNIT_LENGTH


def extent_along_x(components: Sequence[Component]) -> float:
    """Return how far components reach along body x together, m: their shapes, or positions where none has a shape."""
    ends = [span_along_x(component, shape) for component in components for shape in getattr(component, "shapes", ())]
    if not ends:
        ends = [(component.position[0], component.position[0]) for component in components]
    return max(high for _, high in ends) - min(low for low, _ in ends)


def span_along_x(component: Component, shape: Shape) -> tuple[float, float]:
    """Return where a shape of a component begins and ends along body x, m."""
    middle = component.position[0] + shape.offset[0]
    match shape:
        case HullShape():
            half = 0.5 * shape.length
        case CylinderShape():
            half = _half_of_cylinder(shape.axis, shape.length, shape.radius)
        case BellowsShape():
            half = _half_of_cylinder(getattr(component, "axis", (1.0, 0.0, 0.0)), shape.length, shape.outer_radius)
        case WingShape() | FinShape():
            tip = shape.chord if shape.tip_chord is None else shape.tip_chord
            lead = 0.5 * shape.chord - shape.sweep
            return middle + min(-0.5 * shape.chord, lead - tip), middle + max(0.5 * shape.chord, lead)
    return middle - half, middle + half


def _half_of_cylinder(axis: tuple[float, float, float], length: float, radius: float) -> float:
    along = abs(axis[0]) / math.hypot(*axis)
    return 0.5 * length * along + radius * math.sqrt(max(1.0 - along * along, 0.0))
