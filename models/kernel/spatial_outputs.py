"""Owns the second pass of the spatial model: everything a result shows that is not a state, from the saved states."""

from __future__ import annotations

import math

from models.kernel.actuators import command
from models.kernel.jit import compiled, internal
from models.kernel.scalar import TINY, atan2
from models.kernel.search import last_not_above
from models.kernel.spatial import attitude, bed_force, normalise, spatial_energies, times6, water_velocity
from models.kernel.spatial_forces import counted_twice, source_forces
from models.kernel.spatial_layout import WORK_ACTUATORS, WORK_BED, WORK_WATER, P, Q, R, U, V, W, Z
from models.kernel.spatial_parts import displaced_water, masses_at, volume_under_pressure
from models.kernel.spatial_water import current_at, density_and_pressure
from models.kernel.vectors import cross

FORCES = ("hydro", "damping", "weight", "buoyancy")
"""Kinds of force and moment, in the order in which they are kept."""
COLUMNS = (
    "phi", "theta", "psi",
    "x_dot", "y_dot", "z_dot", "current_x", "current_y",
    "alpha", "beta", "flow_angle", "speed", "lift", "drag", "side_force", "moment", "net_buoyancy",
    "turn_rate", "turn_radius", "density", "pressure",
    "kinetic_energy", "potential_energy", "energy_residual",
    "com_x", "com_y", "com_z", "cob_x", "cob_y", "cob_z",
    *(f"{kind}_{axis}" for kind in FORCES for axis in ("X", "Y", "Z", "K", "M", "N")),
    "bed_force",
)  # fmt: skip
"""What the columns of `out` are, in this order."""
FIRST_FORCE = COLUMNS.index("hydro_X")
SLOWEST_TURN = 1e-9
"""A turn rate below this (rad/s) has no radius."""


@internal
def write_attitude(row, rot):
    """Write roll, pitch and yaw (Z-Y-X), rad."""
    row[0] = math.atan2(rot[7], rot[8])
    row[1] = math.asin(min(max(-rot[6], -1.0), 1.0))
    row[2] = math.atan2(rot[3], rot[0])


@internal
def write_motion(t, y, rot, row, p):
    """Write velocities in the world, the current, and the turn; return the velocity through the water, body axes."""
    u, v, w = y[U], y[V], y[W]
    x_dot = rot[0] * u + rot[1] * v + rot[2] * w
    y_dot = rot[3] * u + rot[4] * v + rot[5] * w
    z_dot = rot[6] * u + rot[7] * v + rot[8] * w
    j = last_not_above(t, p.current_times)
    (cx, cy, cz), _shear, _change = water_velocity(t, y, j, p, rot)
    row[3], row[4], row[5] = x_dot, y_dot, z_dot
    row[6], row[7], _x, _y, _xt, _yt = current_at(y[Z], t, j, p)
    level = math.hypot(x_dot - row[6], y_dot - row[7])
    turn_rate = rot[6] * y[P] + rot[7] * y[Q] + rot[8] * y[R]
    row[10] = math.atan2(z_dot, level)
    row[17] = turn_rate
    row[18] = level / abs(turn_rate) if abs(turn_rate) > SLOWEST_TURN else math.nan
    return u - cx, v - cy, w - cz


@internal
def write_flow(u, v, w, force, row):
    """Write angle of attack, sideslip, speed, and the force in the flow frame: lift, drag, side force."""
    chord = math.sqrt(u * u + w * w)
    speed = math.sqrt(chord * chord + v * v)
    ca, sa = (u / chord, w / chord) if chord > TINY else (1.0, 0.0)
    cb, sb = (chord / speed, v / speed) if speed > TINY else (1.0, 0.0)
    along = ca * force[0] + sa * force[2]
    row[8], row[9], row[11] = atan2(w, u), math.atan2(v, chord), speed
    row[12] = sa * force[0] - ca * force[2]
    row[13] = -(cb * along + sb * force[1])
    row[14] = cb * force[1] - sb * along


@internal
def write_forces(t, y, rot, u, v, w, row, p):
    """Write the forces and moments by kind, body axes, and what follows from them."""
    s = p.space[0]
    kx, ky, kz = rot[6], rot[7], rot[8]
    density, pressure = density_and_pressure(y[Z], p)
    row[19], row[20] = density, pressure
    forces = source_forces(u, v, w, y[P], y[Q], y[R], density, p)
    write_flow(u, v, w, forces, row)
    row[15] = forces[4] - counted_twice(u, v, w, p)[1]
    damping = times6(p.damping, u, v, w, y[P], y[Q], y[R])
    sx, sy, sz, _xx, _yy, _zz, _xy, _xz, _yz = masses_at(y, p)
    B, Bx, By, Bz, _potential = displaced_water(y, kx, ky, kz, p)
    g = s.gravity
    weight = cross(sx, sy, sz, g * kx, g * ky, g * kz)
    lift = cross(Bx, By, Bz, -g * kx, -g * ky, -g * kz)
    for j in range(6):
        row[FIRST_FORCE + j] = forces[j]
        row[FIRST_FORCE + 6 + j] = -damping[j]
    for j in range(3):
        row[FIRST_FORCE + 12 + j] = g * s.mass * rot[6 + j]
        row[FIRST_FORCE + 15 + j] = weight[j]
        row[FIRST_FORCE + 18 + j] = -g * B * rot[6 + j]
        row[FIRST_FORCE + 21 + j] = lift[j]
    row[FIRST_FORCE + 24] = bed_force(y[Z], row[5], p)
    row[16] = g * (B - s.mass)
    row[24], row[25], row[26] = sx / s.mass, sy / s.mass, sz / s.mass
    per = 1.0 / B if B > 0.0 else 0.0
    row[27], row[28], row[29] = Bx * per, By * per, Bz * per


@internal
def write_parts(t, y, i, rot, commands, volumes, p):
    """Write the command of every part and the volume that it displaces under pressure."""
    for j in range(p.parts.shape[0]):
        commands[i, j] = command(p.parts[j], t, p)
        volumes[i, j] = volume_under_pressure(y, j, rot[6], rot[7], rot[8], p)


@compiled
def spatial_outputs(times, states, p, out, commands, volumes):
    """Fill `out` (samples, columns), `commands` and `volumes` (samples, parts); give quaternions length 1."""
    kinetic, potential = spatial_energies(times[0], states[0], p)
    works = states[0, WORK_ACTUATORS] + states[0, WORK_WATER] + states[0, WORK_BED]
    # what the state held before any work: a jump at time zero has already been charged
    reference = kinetic + potential - works
    for i in range(times.shape[0]):
        t, y, row = times[i], states[i], out[i]
        normalise(y)
        rot = attitude(y)
        write_attitude(row, rot)
        u, v, w = write_motion(t, y, rot, row, p)
        write_forces(t, y, rot, u, v, w, row, p)
        kinetic, potential = spatial_energies(t, y, p)
        row[21], row[22] = kinetic, potential
        row[23] = kinetic + potential - reference - y[WORK_ACTUATORS] - y[WORK_WATER] - y[WORK_BED]
        write_parts(t, y, i, rot, commands, volumes, p)
