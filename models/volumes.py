"""Owns the volume laws of cells as piecewise cubics in the extension, for kernel and mass properties alike."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from models.components import Actuated, Bellows, Bladder, Component, MovableMass, Piston, Rigid, RollingMass
from models.memory import remembered

Array = NDArray[np.float64]


@remembered(most=1_000)
def volume_law(component: Actuated) -> Array:
    """Return the volume law of a component: rows of extension where a piece begins (m), then c0..c3 (m3, m2, m, 1).

    V(e) = c0 + c1 h + c2 h^2 + c3 h^3 with h = e - begin. A movable mass displaces nothing.
    """
    match component:
        case Bellows():
            return np.array([[0.0, component.core_volume, component.section, 0.0, 0.0]])
        case Piston():
            return np.array([[0.0, component.volume, component.area, 0.0, 0.0]])
        case Bladder():
            cubic = PchipInterpolator(component.extensions, component.volumes)
            return np.column_stack([cubic.x[:-1], cubic.c[::-1].T])
        case MovableMass() | RollingMass():
            return np.zeros((1, 5))


def core_volume(component: Actuated) -> float:
    """Return the volume that stays centred at the component's position, m3.

    The rest is the stack, whose centroid moves by half its growth; a bladder swells about its centre.
    """
    match component:
        case Bellows():
            return component.core_volume
        case Piston():
            return component.volume
        case Bladder() | MovableMass() | RollingMass():
            return 0.0


def grows_along_axis(component: Actuated) -> bool:
    """Whether the stack's centroid moves along the axis as the cell extends."""
    return isinstance(component, Bellows | Piston)


def volume(component: Component, extension: float) -> float:
    """Return the displaced volume of a component at an extension (ignored for rigid parts), m3."""
    if isinstance(component, Rigid):
        return component.volume
    law = volume_law(component)
    k = int(law[:, 0].searchsorted(extension, side="right")) - 1 if len(law) > 1 else 0
    begin, c0, c1, c2, c3 = law[max(k, 0)].tolist()
    h = extension - begin
    return float(c0 + h * (c1 + h * (c2 + h * c3)))


def axis_numbers(component: Actuated) -> tuple[float, float, float]:
    """Return the component's axis scaled to length 1."""
    x, y, z = component.axis
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


def unit_axis(component: Actuated) -> Array:
    """Return the component's axis scaled to length 1, (3,)."""
    return np.array(axis_numbers(component))
