"""Owns the 6x6 matrices of a design at the density of its water: added mass and linear damping."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.water import surface_density

Array = NDArray[np.float64]


def added_mass(design: Design) -> Array:
    """Return the added mass (6, 6) at the density of the surface; zeros where it is off."""
    added = design.vehicle.added_mass
    if added is None or not added.enabled:
        return np.zeros((6, 6))
    return np.array(added.matrix) * (surface_density(design.mission.environment.water) / added.density)


def damping_matrix(design: Design) -> Array:
    """Return the linear damping (6, 6)."""
    d = design.vehicle.damping
    diagonal = np.diag([d.surge, d.sway, d.heave, d.roll, d.pitch, d.yaw])
    return diagonal if d.matrix is None else diagonal + np.array(d.matrix)
