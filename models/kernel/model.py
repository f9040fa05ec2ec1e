"""Owns the choice between the planar and the spatial equations, for an integrator that knows neither."""

from __future__ import annotations

from models.kernel.jit import compiled, internal
from models.kernel.planar import derivative as planar_derivative
from models.kernel.planar import energies as planar_energies
from models.kernel.planar import planar_loads
from models.kernel.spatial import attitude, normalise, spatial_derivative, spatial_energies, spatial_loads
from models.kernel.spatial_layout import EXTENSIONS
from models.kernel.spatial_parts import energy_taken, work_of_jump


@compiled
def derivative(t, y, p, drive, dy):
    """Write dy/dt into `dy`; `drive` says how each part moves in this segment (actuators.py)."""
    if p.space[0].spatial != 0:
        spatial_derivative(t, y, p, drive, dy)
    else:
        planar_derivative(t, y, p, drive, dy)


@compiled
def energies(t, y, p):
    """Return the kinetic and the potential energy of a state, J."""
    if p.space[0].spatial != 0:
        return spatial_energies(t, y, p)
    return planar_energies(y, p)


@compiled
def loads(t, y, p, out):
    """Write the forces and moments X, Y, Z, K, M, N that are out of balance into `out` (6,); zero where one is none."""
    if p.space[0].spatial != 0:
        spatial_loads(t, y, p, out)
    else:
        for j in range(6):
            out[j] = 0.0
        planar_loads(y, p, out)


@internal
def settle(y, p):
    """Bring an accepted state back to where the equations keep it: the quaternion's length is 1."""
    if p.space[0].spatial != 0:
        normalise(y)


@compiled
def bill_jump(before, y, p):
    """Charge the battery for parts that jumped from the extensions of `before` to those of `y`."""
    if p.space[0].spatial == 0:
        return
    rot = attitude(y)
    n = p.parts.shape[0]
    for i in range(n):
        if y[EXTENSIONS + i] != before[EXTENSIONS + i]:
            work = work_of_jump(before, y, i, rot[6], rot[7], rot[8], p)
            y[EXTENSIONS + n + i] += energy_taken(work, i, p)
