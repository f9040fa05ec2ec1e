"""Owns the equations of motion of six degrees of freedom, as a column of verbs over small functions of scalars.

M_RB nu' + C_RB(nu) nu + M_A nu_r' + C_A(nu_r) nu_r + D nu_r = forces, about the body origin in body axes (Fossen, 2011,
Handbook of Marine Craft Hydrodynamics and Motion Control, 8.2), with M_RB + M_A solved together, and the Coriolis terms
written with the momenta: w x P for the force, w x Pi + v x P for the moment (Kirchhoff).
"""

from __future__ import annotations

import math

from models.kernel.choice import any_of, select, whole
from models.kernel.jit import compiled, internal
from models.kernel.planar import solve_symmetric
from models.kernel.search import last_not_above
from models.kernel.spatial_forces import source_forces
from models.kernel.spatial_layout import (
    Q0,
    Q1,
    Q2,
    Q3,
    WORK_ACTUATORS,
    WORK_BED,
    WORK_WATER,
    P,
    Q,
    R,
    U,
    V,
    W,
    X,
    Y,
    Z,
)
from models.kernel.spatial_parts import displaced_water, masses_at, move_members
from models.kernel.spatial_water import current_at, density_and_pressure
from models.kernel.vectors import cross, inverse_symmetric, rotation, times_symmetric

BED_SOFTNESS = 1e-3
"""Penetration over which the bed's damping sets in, m: contact begins without a blow."""


@internal
def solve_block(m, masses, A, fx, fy, fz, mx, my, mz):
    """Solve (M_RB + M_A) nu' = forces by blocks: the linear part first, then its Schur complement."""
    sx, sy, sz, xx, yy, zz, xy, xz, yz = masses
    i11, i22, i33, i12, i13, i23 = inverse_symmetric(m + A[0, 0], m + A[1, 1], m + A[2, 2], A[0, 1], A[0, 2], A[1, 2])
    # B, the upper right block: A's own and -S(m r_G)
    b11, b12, b13 = A[0, 3], A[0, 4] + sz, A[0, 5] - sy
    b21, b22, b23 = A[1, 3] - sz, A[1, 4], A[1, 5] + sx
    b31, b32, b33 = A[2, 3] + sy, A[2, 4] - sx, A[2, 5]
    c11, c21, c31 = times_symmetric(i11, i22, i33, i12, i13, i23, b11, b21, b31)
    c12, c22, c32 = times_symmetric(i11, i22, i33, i12, i13, i23, b12, b22, b32)
    c13, c23, c33 = times_symmetric(i11, i22, i33, i12, i13, i23, b13, b23, b33)
    gx, gy, gz = times_symmetric(i11, i22, i33, i12, i13, i23, fx, fy, fz)
    wx, wy, wz = solve_symmetric(
        xx + A[3, 3] - (b11 * c11 + b21 * c21 + b31 * c31),
        xy + A[3, 4] - (b11 * c12 + b21 * c22 + b31 * c32),
        xz + A[3, 5] - (b11 * c13 + b21 * c23 + b31 * c33),
        yy + A[4, 4] - (b12 * c12 + b22 * c22 + b32 * c32),
        yz + A[4, 5] - (b12 * c13 + b22 * c23 + b32 * c33),
        zz + A[5, 5] - (b13 * c13 + b23 * c23 + b33 * c33),
        mx - (b11 * gx + b21 * gy + b31 * gz),
        my - (b12 * gx + b22 * gy + b32 * gz),
        mz - (b13 * gx + b23 * gy + b33 * gz),
    )
    return (
        gx - (c11 * wx + c12 * wy + c13 * wz),
        gy - (c21 * wx + c22 * wy + c23 * wz),
        gz - (c31 * wx + c32 * wy + c33 * wz),
        wx, wy, wz,
    )  # fmt: skip


@internal
def times6(A, u, v, w, p, q, r):
    """Return a 6x6 matrix times a vector."""
    return (
        A[0, 0] * u + A[0, 1] * v + A[0, 2] * w + A[0, 3] * p + A[0, 4] * q + A[0, 5] * r,
        A[1, 0] * u + A[1, 1] * v + A[1, 2] * w + A[1, 3] * p + A[1, 4] * q + A[1, 5] * r,
        A[2, 0] * u + A[2, 1] * v + A[2, 2] * w + A[2, 3] * p + A[2, 4] * q + A[2, 5] * r,
        A[3, 0] * u + A[3, 1] * v + A[3, 2] * w + A[3, 3] * p + A[3, 4] * q + A[3, 5] * r,
        A[4, 0] * u + A[4, 1] * v + A[4, 2] * w + A[4, 3] * p + A[4, 4] * q + A[4, 5] * r,
        A[5, 0] * u + A[5, 1] * v + A[5, 2] * w + A[5, 3] * p + A[5, 4] * q + A[5, 5] * r,
    )


@internal
def attitude(y):
    """Return R (body to world) of a state, row by row."""
    return rotation(y[Q0], y[Q1], y[Q2], y[Q3])


@internal
def water_velocity(t, y, j, p, rot):
    """Return the water's velocity in body axes, and what its change with depth and time does to it, in body axes.

    `j` is the profile of the current in force (spatial_water.py).
    """
    cx, cy, cx_z, cy_z, cx_t, cy_t = current_at(y[Z], t, j, p)
    sink = rot[6] * y[U] + rot[7] * y[V] + rot[8] * y[W]
    return to_body(rot, cx, cy), to_body(rot, cx_z * sink, cy_z * sink), to_body(rot, cx_t, cy_t)


@internal
def to_body(rot, x, y):
    """Return a horizontal vector of the world in body axes."""
    return rot[0] * x + rot[3] * y, rot[1] * x + rot[4] * y, rot[2] * x + rot[5] * y


@internal
def bed_force(depth, sink, p):
    """Return how hard the bed pushes up, N: a spring with damping that never pulls."""
    s = p.space[0]
    if s.bed_ends != 0:
        return 0.0
    depth -= s.bed_depth
    touching = depth > 0.0
    if not any_of(touching):
        return 0.0
    push = s.bed_stiffness * depth + s.bed_damping * sink * depth / (depth + BED_SOFTNESS)
    return select(touching, max(push, 0.0), 0.0)


@internal
def through_water(y, flow):
    """Return the velocity through the water and the angular velocity, body axes."""
    cx, cy, cz = flow[0]
    return y[U] - cx, y[V] - cy, y[W] - cz, y[P], y[Q], y[R]


@internal
def water_acceleration(y, flow):
    """Return d/dt (R^T v_c): by depth and time, and because the body turns."""
    (cx, cy, cz), (gx, gy, gz), (ax, ay, az) = flow
    jx, jy, jz = cross(y[P], y[Q], y[R], cx, cy, cz)
    return gx + ax - jx, gy + ay - jy, gz + az - jz


@internal
def water_forces(y, nu_r, flow, displaced, p):
    """Return what the water does: source, damping, and what carries displaced water along as the current changes."""
    density, _pressure = density_and_pressure(y[Z], p)
    f = source_forces(nu_r[0], nu_r[1], nu_r[2], nu_r[3], nu_r[4], nu_r[5], density, p)
    d = times6(p.damping, nu_r[0], nu_r[1], nu_r[2], nu_r[3], nu_r[4], nu_r[5])
    B, Bx, By, Bz, _potential = displaced
    ax, ay, az = flow[2]
    tx, ty, tz = cross(Bx, By, Bz, ax, ay, az)
    return (
        f[0] - d[0] + B * ax, f[1] - d[1] + B * ay, f[2] - d[2] + B * az,
        f[3] - d[3] + tx, f[4] - d[4] + ty, f[5] - d[5] + tz,
    )  # fmt: skip


@internal
def still_forces(rot, masses, displaced, bed, p):
    """Return weight, buoyancy and the bed's push along the vertical, and the moment of the first two."""
    s = p.space[0]
    kx, ky, kz = rot[6], rot[7], rot[8]
    B, Bx, By, Bz, _potential = displaced
    down = s.gravity * (s.mass - B) - bed
    g = s.gravity
    tx, ty, tz = cross(masses[0] - Bx, masses[1] - By, masses[2] - Bz, g * kx, g * ky, g * kz)
    return down * kx, down * ky, down * kz, tx, ty, tz


@internal
def coriolis_forces(y, nu_r, masses, momentum, p):
    """Return C_RB(nu) nu + C_A(nu_r) nu_r by the momenta of the body and of the added mass (`momentum`)."""
    sx, sy, sz, xx, yy, zz, xy, xz, yz = masses
    m = p.space[0].mass
    u, v, w, wx, wy, wz = y[U], y[V], y[W], y[P], y[Q], y[R]
    ox, oy, oz = cross(wx, wy, wz, sx, sy, sz)
    px, py, pz = m * u + ox, m * v + oy, m * w + oz
    lx, ly, lz = times_symmetric(xx, yy, zz, xy, xz, yz, wx, wy, wz)
    ix, iy, iz = cross(sx, sy, sz, u, v, w)
    fx, fy, fz = cross(wx, wy, wz, px + momentum[0], py + momentum[1], pz + momentum[2])
    tx, ty, tz = cross(wx, wy, wz, lx + ix + momentum[3], ly + iy + momentum[4], lz + iz + momentum[5])
    bx, by, bz = cross(u, v, w, px, py, pz)
    ax, ay, az = cross(nu_r[0], nu_r[1], nu_r[2], momentum[0], momentum[1], momentum[2])
    return fx, fy, fz, tx + bx + ax, ty + by + ay, tz + bz + az


@internal
def unbalanced(y, nu_r, flow, rot, masses, displaced, bed, p):
    """Return what is left to accelerate body and added mass (N, N m), and what the works need of it.

    These are the forces of the water, the momentum of the added mass, and the water's own acceleration.
    """
    by_water = water_forces(y, nu_r, flow, displaced, p)
    still = still_forces(rot, masses, displaced, bed, p)
    momentum = times6(p.added, nu_r[0], nu_r[1], nu_r[2], nu_r[3], nu_r[4], nu_r[5])
    coriolis = coriolis_forces(y, nu_r, masses, momentum, p)
    a_c = water_acceleration(y, flow)
    carried = times6(p.added, a_c[0], a_c[1], a_c[2], 0.0, 0.0, 0.0)
    loads = (
        by_water[0] + still[0] - coriolis[0] + carried[0], by_water[1] + still[1] - coriolis[1] + carried[1],
        by_water[2] + still[2] - coriolis[2] + carried[2], by_water[3] + still[3] - coriolis[3] + carried[3],
        by_water[4] + still[4] - coriolis[4] + carried[4], by_water[5] + still[5] - coriolis[5] + carried[5],
    )  # fmt: skip
    return loads, by_water, momentum, a_c


@compiled
def spatial_loads(t, y, p, out):
    """Write the forces and moments that are out of balance into `out` (6,), N and N m; parts stand still."""
    rot = attitude(y)
    flow = water_velocity(t, y, last_not_above(t, p.current_times), p, rot)
    sink = rot[6] * y[U] + rot[7] * y[V] + rot[8] * y[W]
    displaced = displaced_water(y, rot[6], rot[7], rot[8], p)
    loads, _water, _momentum, _a = unbalanced(
        y, through_water(y, flow), flow, rot, masses_at(y, p), displaced, bed_force(y[Z], sink, p), p
    )
    for j in range(6):
        out[j] = loads[j]


@compiled
def spatial_derivative(t, y, p, drive, dy):
    """Write dy/dt into `dy`: kinematics, accelerations, work rates, extension and battery rates."""
    rot = attitude(y)
    flow = water_velocity(t, y, whole(drive[p.parts.shape[0], 0]), p, rot)
    nu_r = through_water(y, flow)
    displaced, power = move_members(t, y, p, drive, dy, rot[6], rot[7], rot[8])
    masses = masses_at(y, p)
    sink = rot[6] * y[U] + rot[7] * y[V] + rot[8] * y[W]
    bed = bed_force(y[Z], sink, p)

    loads, by_water, momentum, a_c = unbalanced(y, nu_r, flow, rot, masses, displaced, bed, p)
    nu_dot = solve_block(p.space[0].mass, masses, p.added, loads[0], loads[1], loads[2], loads[3], loads[4], loads[5])

    write_kinematics(y, rot, dy)
    dy[U], dy[V], dy[W], dy[P], dy[Q], dy[R] = nu_dot
    dy[WORK_WATER] = power_of_water(y, flow, a_c, by_water, momentum, nu_dot, p)
    dy[WORK_ACTUATORS] = power
    dy[WORK_BED] = -bed * sink


@internal
def power_of_water(y, flow, a_c, by_water, momentum, nu_dot, p):
    """Return nu^T tau - nu_c^T (M_A nu_r' + C_A(nu_r) nu_r), W: the current does work through the force alone."""
    cx, cy, cz = flow[0]
    u, v, w, wx, wy, wz = y[U], y[V], y[W], y[P], y[Q], y[R]
    own = u * by_water[0] + v * by_water[1] + w * by_water[2]
    own += wx * by_water[3] + wy * by_water[4] + wz * by_water[5]
    n = times6(p.added, nu_dot[0] - a_c[0], nu_dot[1] - a_c[1], nu_dot[2] - a_c[2], nu_dot[3], nu_dot[4], nu_dot[5])
    tx, ty, tz = cross(wx, wy, wz, momentum[0], momentum[1], momentum[2])
    return own - (cx * (n[0] + tx) + cy * (n[1] + ty) + cz * (n[2] + tz))


@internal
def write_kinematics(y, rot, dy):
    """Write the rates of position and attitude."""
    u, v, w, wx, wy, wz = y[U], y[V], y[W], 0.5 * y[P], 0.5 * y[Q], 0.5 * y[R]
    q0, q1, q2, q3 = y[Q0], y[Q1], y[Q2], y[Q3]
    dy[X] = rot[0] * u + rot[1] * v + rot[2] * w
    dy[Y] = rot[3] * u + rot[4] * v + rot[5] * w
    dy[Z] = rot[6] * u + rot[7] * v + rot[8] * w
    dy[Q0] = -q1 * wx - q2 * wy - q3 * wz
    dy[Q1] = q0 * wx + q2 * wz - q3 * wy
    dy[Q2] = q0 * wy + q3 * wx - q1 * wz
    dy[Q3] = q0 * wz + q1 * wy - q2 * wx


@internal
def normalise(y):
    """Give the quaternion length 1 again."""
    per_length = 1.0 / math.sqrt(y[Q0] * y[Q0] + y[Q1] * y[Q1] + y[Q2] * y[Q2] + y[Q3] * y[Q3])
    y[Q0] *= per_length
    y[Q1] *= per_length
    y[Q2] *= per_length
    y[Q3] *= per_length


@compiled
def spatial_energies(t, y, p):
    """Return the kinetic energy (the added mass by the velocity through the water) and the potential energy, J."""
    s = p.space[0]
    u, v, w, wx, wy, wz = y[U], y[V], y[W], y[P], y[Q], y[R]
    rot = attitude(y)
    (cx, cy, cz), _shear, _change = water_velocity(t, y, last_not_above(t, p.current_times), p, rot)
    sx, sy, sz, xx, yy, zz, xy, xz, yz = masses_at(y, p)
    ox, oy, oz = cross(wx, wy, wz, sx, sy, sz)
    lx, ly, lz = times_symmetric(xx, yy, zz, xy, xz, yz, wx, wy, wz)
    kinetic = s.mass * (u * u + v * v + w * w) + 2.0 * (u * ox + v * oy + w * oz) + wx * lx + wy * ly + wz * lz
    ru, rv, rw = u - cx, v - cy, w - cz
    ex, ey, ez, ek, em, en = times6(p.added, ru, rv, rw, wx, wy, wz)
    kinetic += ru * ex + rv * ey + rw * ez + wx * ek + wy * em + wz * en
    _B, _Bx, _By, _Bz, potential = displaced_water(y, rot[6], rot[7], rot[8], p)
    potential -= s.gravity * (s.mass * y[Z] + rot[6] * sx + rot[7] * sy + rot[8] * sz)
    return 0.5 * kinetic, potential
