"""Owns the forces of the water in space, from any source: X, Y, Z, K, M, N about the body origin, body axes.

Sources: a table over the angle of attack with lateral coefficients, a table over both angles, or the coefficient form
(Leonard, Graver, 2001; Zhang et al., 2013). Moments that already hold the Munk moment are relieved of it here.
"""

from __future__ import annotations

import math

from models.kernel.choice import any_of, select
from models.kernel.jit import compiled, internal
from models.kernel.planar import evaluate_law
from models.kernel.scalar import TINY, atan2, sincos
from models.kernel.search import last_not_above
from models.kernel.spatial_layout import ANGLES, COEFFICIENTS
from models.kernel.vectors import cross


@internal
def polar_forces(u, v, w, p):
    """Return the forces per density share by the table over the angle of attack and the lateral coefficients."""
    in_plane = u * u + w * w
    per_speed = 1.0 / (math.sqrt(in_plane) + TINY)
    ca, sa = u * per_speed, w * per_speed
    lift, drag, moment = evaluate_law(atan2(w, u), p)
    x = (lift * sa - drag * ca) * in_plane
    z = -(drag * sa + lift * ca) * in_plane
    c = p.coefficients
    speed = math.sqrt(in_plane + v * v)
    across, crossed = speed * v, abs(v) * v
    b = p.space[0]
    return (
        x, c[0] * across + c[1] * crossed, z,
        c[2] * across + c[3] * crossed,
        moment * in_plane + b.reference_z * x - b.reference_x * z,
        c[4] * across + c[5] * crossed,
    )  # fmt: skip


@internal
def coefficient_forces(u, v, w, wx, wy, wz, p):
    """Return the forces per density share by the coefficient form: flow frame, then turned to body axes."""
    in_plane = u * u + w * w
    v2 = in_plane + v * v
    chord, speed = math.sqrt(in_plane), math.sqrt(v2)
    alpha, beta = atan2(w, u), atan2(v, chord)
    ca, sa = (u + TINY) / (chord + TINY), w / (chord + TINY)  # at rest and straight across both angles are 0
    cb, sb = (chord + TINY) / (speed + TINY), v / (speed + TINY)
    b, c = p.space[0], p.coefficients
    turning = b.rate_none + b.rate_speed * speed + b.rate_speed2 * v2
    drag = (c[0] + c[1] * alpha * alpha + c[2] * beta * beta) * v2
    side = c[3] * beta * v2
    lift = (c[4] + c[5] * alpha) * v2
    roll = c[6] * beta * v2 + c[7] * wx * turning
    pitch = (c[8] + c[9] * alpha) * v2 + (c[10] + c[11] * abs(wy)) * wy * turning
    yaw = c[12] * beta * v2 + c[13] * wz * turning
    x = -ca * cb * drag - ca * sb * side + sa * lift
    y = -sb * drag + cb * side
    z = -sa * cb * drag - sa * sb * side - ca * lift
    mx, my, mz = cross(b.reference_x, b.reference_y, b.reference_z, x, y, z)
    return (
        x, y, z,
        ca * cb * roll - ca * sb * pitch - sa * yaw + mx,
        sb * roll + cb * pitch + my,
        sa * cb * roll - sa * sb * pitch + ca * yaw + mz,
    )  # fmt: skip


@internal
def bicubic(row, j, s, t):
    """Return quantity j of a cell of the table at s, t beyond its corner; `row` holds c_kl of ds^k dt^l of each."""
    total = 0.0
    for k in range(16 * j + 12, 16 * j - 1, -4):
        total = total * s + row[k] + t * (row[k + 1] + t * (row[k + 2] + t * row[k + 3]))
    return total


@internal
def from_flow(alpha, beta, x, y, z):
    """Return a vector of the flow frame in body axes."""
    sa, ca = sincos(alpha)
    sb, cb = sincos(beta)
    return ca * cb * x - ca * sb * y - sa * z, sb * x + cb * y, sa * cb * x - sa * sb * y + ca * z


@internal
def to_flow(alpha, beta, x, y, z):
    """Return a vector of body axes in the flow frame."""
    sa, ca = sincos(alpha)
    sb, cb = sincos(beta)
    return ca * cb * x + sb * y + sa * cb * z, -ca * sb * x + cb * y - sa * sb * z, ca * z - sa * x


@compiled
def angle_forces(u, v, w, p):
    """Return the forces per density share by the table over both angles.

    Beyond its edges drag, side force and lift are held, so that drag opposes the motion there too; and the moments.
    """
    v2 = u * u + v * v + w * w
    alpha_now, beta_now = atan2(w, u), atan2(v, math.sqrt(u * u + w * w))
    last_alpha, last_beta = p.grid_alpha.shape[0] - 1, p.grid_beta.shape[0] - 1
    alpha = min(max(alpha_now, p.grid_alpha[0]), p.grid_alpha[last_alpha])
    beta = min(max(beta_now, p.grid_beta[0]), p.grid_beta[last_beta])
    i = min(last_not_above(alpha, p.grid_alpha), last_alpha - 1)
    j = min(last_not_above(beta, p.grid_beta), last_beta - 1)
    row = p.grid[i * last_beta + j]
    s, t = alpha - p.grid_alpha[i], beta - p.grid_beta[j]
    x, y, z = v2 * bicubic(row, 0, s, t), v2 * bicubic(row, 1, s, t), v2 * bicubic(row, 2, s, t)
    beyond = (alpha != alpha_now) | (beta != beta_now)
    if any_of(beyond):
        drag, side, lift = to_flow(alpha, beta, x, y, z)
        held_x, held_y, held_z = from_flow(alpha_now, beta_now, drag, side, lift)
        x, y, z = select(beyond, held_x, x), select(beyond, held_y, y), select(beyond, held_z, z)
    b = p.space[0]
    mx, my, mz = cross(b.reference_x, b.reference_y, b.reference_z, x, y, z)
    return (
        x, y, z,
        v2 * bicubic(row, 3, s, t) + mx, v2 * bicubic(row, 4, s, t) + my, v2 * bicubic(row, 5, s, t) + mz,
    )  # fmt: skip


@internal
def with_rates(forces, u, v, w, wx, wy, wz, p):
    """Return the forces with the terms by the rates of turning."""
    b, c = p.space[0], p.rates
    v2 = u * u + v * v + w * w
    scale = b.rate_none + b.rate_speed * math.sqrt(v2) + b.rate_speed2 * v2
    wx, wy, wz = scale * wx, scale * wy, scale * wz
    return (
        forces[0] + c[0, 0] * wx + c[0, 1] * wy + c[0, 2] * wz,
        forces[1] + c[1, 0] * wx + c[1, 1] * wy + c[1, 2] * wz,
        forces[2] + c[2, 0] * wx + c[2, 1] * wy + c[2, 2] * wz,
        forces[3] + c[3, 0] * wx + c[3, 1] * wy + c[3, 2] * wz,
        forces[4] + c[4, 0] * wx + c[4, 1] * wy + c[4, 2] * wz,
        forces[5] + c[5, 0] * wx + c[5, 1] * wy + c[5, 2] * wz,
    )


@internal
def counted_twice(u, v, w, p):
    """Return the Munk moment that the source holds beside the added mass, as v_r x (A11 v_r): what takes it out.

    A table over the angle of attack was measured without sideslip, and knows only the moment in pitch.
    """
    A, b = p.added, p.space[0]
    px = A[0, 0] * u + A[0, 1] * v + A[0, 2] * w
    py = A[1, 0] * u + A[1, 1] * v + A[1, 2] * w
    pz = A[2, 0] * u + A[2, 1] * v + A[2, 2] * w
    roll, pitch, yaw = cross(u, v, w, px, py, pz)
    in_plane = w * (A[0, 0] * u + A[0, 2] * w) - u * (A[2, 0] * u + A[2, 2] * w)
    across = b.munk_whole + b.munk_lateral
    return across * roll, b.munk_whole * pitch + b.munk_plane * in_plane, across * yaw


@internal
def source_forces(u, v, w, wx, wy, wz, density, p):
    """Return X, Y, Z (N), K, M, N (N m) of the source at a velocity through the water and a density."""
    source = p.space[0].source
    if source == COEFFICIENTS:
        forces = coefficient_forces(u, v, w, wx, wy, wz, p)
    else:
        forces = angle_forces(u, v, w, p) if source == ANGLES else polar_forces(u, v, w, p)
        forces = with_rates(forces, u, v, w, wx, wy, wz, p)
    share = density * p.space[0].per_reference_density
    roll, pitch, yaw = counted_twice(u, v, w, p)
    return (
        share * forces[0], share * forces[1], share * forces[2],
        share * forces[3] + roll, share * forces[4] + pitch, share * forces[5] + yaw,
    )  # fmt: skip
