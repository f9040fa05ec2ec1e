"""Owns the second pass: everything a result shows that is not a state, computed from the saved states."""

from __future__ import annotations

from models.kernel.actuators import balance_with_parts, command, volume_and_slope
from models.kernel.jit import compiled
from models.kernel.params import EXTENSIONS, THETA, WORK_ACTUATORS, WORK_WATER, Q, U, W
from models.kernel.planar import energies, hydrodynamics, pitch_rate_terms
from models.kernel.scalar import atan2, sincos

COLUMNS = (
    "x_dot", "z_dot", "alpha", "flow_angle", "speed", "lift", "drag", "moment", "net_buoyancy",
    "kinetic_energy", "potential_energy", "energy_residual", "com_x", "com_z", "cob_x", "cob_z",
)  # fmt: skip
"""What the columns of `out` are, in this order."""


@compiled
def outputs(times, states, p, out, commands, volumes):
    """Fill `out` (samples, columns), `commands` and `volumes` (samples, parts) from the states."""
    b = p.body[0]
    kinetic, potential = energies(states[0], p)
    # what the state held before any work: a jump at time zero has already been charged
    reference = kinetic + potential - states[0, WORK_ACTUATORS] - states[0, WORK_WATER]
    for i in range(times.shape[0]):
        y = states[i]
        s, c = sincos(y[THETA])
        lift, drag, moment, _X, _Z, alpha, speed = hydrodynamics(y[U], y[W], p)
        moment += pitch_rate_terms(speed, y[Q], p)[1]
        mass_x, mass_z, _inertia, volume, volume_x, volume_z = balance_with_parts(y, p)
        kinetic, potential = energies(y, p)
        x_dot = c * y[U] + s * y[W]
        z_dot = -s * y[U] + c * y[W]
        row = out[i]
        row[0], row[1] = x_dot, z_dot
        row[2], row[3], row[4] = alpha, atan2(z_dot, x_dot), speed
        row[5], row[6], row[7] = lift, drag, moment
        row[8] = b.gravity * (b.density * volume - b.mass)
        row[9], row[10] = kinetic, potential
        row[11] = kinetic + potential - reference - y[WORK_ACTUATORS] - y[WORK_WATER]
        row[12], row[13] = mass_x / b.mass, mass_z / b.mass
        row[14] = volume_x / volume if volume > 0.0 else 0.0
        row[15] = volume_z / volume if volume > 0.0 else 0.0
        for j in range(p.parts.shape[0]):
            commands[i, j] = command(p.parts[j], times[i], p)
            volumes[i, j] = volume_and_slope(p.parts[j], y[EXTENSIONS + j], p)[0]
