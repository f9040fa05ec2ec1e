"""Owns the planar equations of motion, as a column of verbs over small functions of scalars.

Body axes: P = (M_RB + A) [u, w, q] and (M_RB + A) nu' + [q P_z, -q P_x, w P_x - u P_z] = forces, which is Eq. 5 of
Canete et al. (their M, V, G with V from the kinetic energy of the added mass too) written about the body origin.
"""

from __future__ import annotations

import math

from models.kernel.actuators import balance_with_parts, move_parts
from models.kernel.choice import select, whole
from models.kernel.jit import compiled, inlined, internal
from models.kernel.params import EXTENSIONS, THETA, WORK_ACTUATORS, WORK_WATER, Q, U, W, X, Z
from models.kernel.scalar import TINY, atan2, sincos


@internal
def find_piece(alpha, p):
    """Return the index of the table's piece that holds alpha in [-pi, pi]."""
    bucket = whole((alpha + math.pi) * p.body[0].lookup_scale)
    bucket = min(max(bucket, 0), p.lookup.shape[0] - 1)
    k = p.lookup[bucket]
    return select(alpha >= p.table[k + 1, 0], k + 1, k)


@inlined
def evaluate_law(alpha, p):
    """Return lift, drag and moment per squared speed at angle of attack alpha (rad)."""
    k = min(find_piece(alpha, p), p.table.shape[0] - 2)
    row = p.table[k]
    s = alpha - row[0]
    n = (row.shape[0] - 1) // 3
    if n == 4:
        lift = row[1] + s * (row[2] + s * (row[3] + s * row[4]))
        drag = row[5] + s * (row[6] + s * (row[7] + s * row[8]))
        moment = row[9] + s * (row[10] + s * (row[11] + s * row[12]))
        return lift, drag, moment
    lift = drag = moment = 0.0
    for j in range(n, 0, -1):
        lift = lift * s + row[j]
        drag = drag * s + row[n + j]
        moment = moment * s + row[2 * n + j]
    return lift, drag, moment


@inlined
def hydrodynamics(u, w, p):
    """Return lift, drag, moment about the origin (N, N, N m), X, Z (N), alpha (rad) and speed (m/s)."""
    b = p.body[0]
    v2 = u * u + w * w
    speed = math.sqrt(v2)
    per_speed = 1.0 / (speed + TINY)
    ca = u * per_speed
    sa = w * per_speed
    alpha = atan2(w, u)
    lift, drag, moment = evaluate_law(alpha, p)
    scale = b.force_scale * v2
    lift *= scale
    drag *= scale
    X_h = -drag * ca + lift * sa
    Z_h = -drag * sa - lift * ca
    moment = moment * scale + b.reference_z * X_h - b.reference_x * Z_h
    return lift, drag, moment, X_h, Z_h, alpha, speed


@internal
def pitch_rate_terms(speed, q, p):
    """Return the force down and the pitching moment by pitch rate, N, N m."""
    s = p.space[0]
    turning = (s.rate_none + s.rate_speed * speed + s.rate_speed2 * speed * speed) * p.body[0].force_scale * q
    return p.rates[2, 1] * turning, (p.rates[4, 1] + p.coefficients[11] * abs(q)) * turning


@internal
def munk_excess(u, w, b):
    """Return the Munk moment that the table and the added mass would both count, N m (0 where only one does)."""
    return b.munk_in_table * ((b.a33 - b.a11) * u * w + b.a13 * (u * u - w * w))


@internal
def solve_symmetric(m11, m12, m13, m22, m23, m33, r1, r2, r3):
    """Solve the symmetric positive definite 3x3 system by elimination without pivoting."""
    per_m11 = 1.0 / m11
    f12 = m12 * per_m11
    f13 = m13 * per_m11
    per_s22 = 1.0 / (m22 - f12 * m12)
    s23 = m23 - f12 * m13
    f23 = s23 * per_s22
    y2 = r2 - f12 * r1
    per_s33 = 1.0 / (m33 - f13 * m13 - f23 * s23)
    x3 = (r3 - f13 * r1 - f23 * y2) * per_s33
    x2 = (y2 - s23 * x3) * per_s22
    return (r1 - m12 * x2 - m13 * x3) * per_m11, x2, x3


@internal
def unbalanced(u, w, q, s, c, balance, p):
    """Return what is left to accelerate body and added mass (X, Z, M), and the water's share of it, N and N m."""
    b = p.body[0]
    mass_x, mass_z, volume, volume_x, volume_z = balance
    _lift, _drag, moment, X_h, Z_h, _alpha, speed = hydrodynamics(u, w, p)
    moment -= munk_excess(u, w, b)
    Z_q, M_q = pitch_rate_terms(speed, q, p)
    X_w = X_h - b.d11 * u
    Z_w = Z_h - b.d33 * w + Z_q
    M_w = moment - b.d55 * q + M_q

    heaviness = b.gravity * (b.mass - b.density * volume)
    arm_x = mass_x - b.density * volume_x
    arm_z = mass_z - b.density * volume_z
    P_x = (b.mass + b.a11) * u + b.a13 * w + (mass_z + b.a15) * q
    P_z = b.a13 * u + (b.mass + b.a33) * w + (b.a35 - mass_x) * q
    loads = (
        X_w - s * heaviness - q * P_z,
        Z_w + c * heaviness + q * P_x,
        M_w - b.gravity * (arm_z * s + arm_x * c) - (w * P_x - u * P_z),
    )
    return loads, (X_w, Z_w, M_w)


@compiled
def planar_loads(y, p, out):
    """Write the forces and the moment that are out of balance into entries 0, 2 and 4 of `out` (6,), N and N m."""
    s, c = sincos(y[THETA])
    mass_x, mass_z, _inertia, volume, volume_x, volume_z = balance_with_parts(y, p)
    loads, _water = unbalanced(y[U], y[W], y[Q], s, c, (mass_x, mass_z, volume, volume_x, volume_z), p)
    out[0], out[2], out[4] = loads


@internal
def derivative(t, y, p, drive, dy):
    """Write dy/dt into `dy`: kinematics, accelerations, work rates, extension rates.

    `y`, `dy` are states (params.py); `drive` says how each part moves in this segment (actuators.py).
    """
    b = p.body[0]
    u, w, q = y[U], y[W], y[Q]
    s, c = sincos(y[THETA])
    mass_x, mass_z, inertia, volume, volume_x, volume_z, power = move_parts(t, y, p, drive, dy, s, c)
    loads, by_water = unbalanced(u, w, q, s, c, (mass_x, mass_z, volume, volume_x, volume_z), p)
    du, dw, dq = solve_symmetric(
        b.mass + b.a11, b.a13, mass_z + b.a15, b.mass + b.a33, b.a35 - mass_x, inertia + b.a55,
        loads[0], loads[1], loads[2],
    )  # fmt: skip

    dy[X] = c * u + s * w
    dy[Z] = -s * u + c * w
    dy[THETA] = q
    dy[U] = du
    dy[W] = dw
    dy[Q] = dq
    dy[WORK_WATER] = u * by_water[0] + w * by_water[1] + q * by_water[2]
    dy[WORK_ACTUATORS] = power


@internal
def energies(y, p):
    """Return the kinetic energy (with the added mass) and the potential energy of a state, J."""
    b = p.body[0]
    u, w, q = y[U], y[W], y[Q]
    s, c = sincos(y[THETA])
    mass_x, mass_z, inertia, volume, volume_x, volume_z = balance_with_parts(y, p)
    kinetic = 0.5 * ((b.mass + b.a11) * u * u + (b.mass + b.a33) * w * w + (inertia + b.a55) * q * q)
    kinetic += b.a13 * u * w + (mass_z + b.a15) * u * q + (b.a35 - mass_x) * w * q
    net_mass = b.mass - b.density * volume
    net_x = mass_x - b.density * volume_x
    net_z = mass_z - b.density * volume_z
    potential = -b.gravity * (net_mass * y[Z] - s * net_x + c * net_z)
    return kinetic, potential


__all__ = ["EXTENSIONS", "derivative", "energies", "evaluate_law", "find_piece", "hydrodynamics", "munk_excess"]
