"""Owns the 6x6 matrices of a design at the density of its water: added mass and linear damping.

Designs share them, and none may change them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.hydrodynamics import AddedMass, Damping
from models.memory import remembered
from models.water import surface_density

Array = NDArray[np.float64]
NONE = np.zeros((6, 6))


def added_mass(design: Design) -> Array:
    """Return the added mass (6, 6) at the density of the surface; zeros where it is off."""
    added = design.vehicle.added_mass
    if added is None or not added.enabled:
        return NONE
    return _at_density(added, surface_density(design.mission.environment.water))


@remembered(most=100)
def _at_density(added: AddedMass, density: float) -> Array:
    return np.array(added.matrix) * (density / added.density)


def damping_matrix(design: Design) -> Array:
    """Return the linear damping (6, 6)."""
    return _damping_matrix(design.vehicle.damping)


@remembered(most=100)
def _damping_matrix(d: Damping) -> Array:
    diagonal = np.diag([d.surge, d.sway, d.heave, d.roll, d.pitch, d.yaw])
    return diagonal if d.matrix is None else diagonal + np.array(d.matrix)
