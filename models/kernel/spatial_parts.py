"""Owns what the parts add up to in space: mass, its moments, displaced water, and the power of the actuators."""

from __future__ import annotations

from models.kernel.actuators import extension_rate, volume_and_slope
from models.kernel.choice import any_of, select
from models.kernel.jit import internal
from models.kernel.scalar import sincos
from models.kernel.spatial_layout import EXTENSIONS, P, Q, R, U, V, W, Z
from models.kernel.spatial_water import felt_by_part
from models.kernel.vectors import cross, times_symmetric


@internal
def moving_mass_at(travel, i, p):
    """Return where the mass of part i is, how that changes with its extension, and cos and sin of its angle."""
    m = p.members[i]
    if m.rolls == 0.0:
        return (
            m.base_x + travel * m.axis_x, m.base_y + travel * m.axis_y, m.base_z + travel * m.axis_z,
            m.axis_x, m.axis_y, m.axis_z, 1.0, 0.0,
        )  # fmt: skip
    s, c = sincos(travel)
    return (
        m.base_x + c * m.perp_x + s * m.cross_x,
        m.base_y + c * m.perp_y + s * m.cross_y,
        m.base_z + c * m.perp_z + s * m.cross_z,
        c * m.cross_x - s * m.perp_x,
        c * m.cross_y - s * m.perp_y,
        c * m.cross_z - s * m.perp_z,
        c, s,
    )  # fmt: skip


@internal
def own_inertia(i, j, c, s, p):
    """Return entry j (xx yy zz xy xz yz) of part i's inertia about its own centre, turned by the angle of c, s."""
    n = p.inertias[i]
    return n[0, j] + c * n[1, j] + s * n[2, j] + (c * c - s * s) * n[3, j] + 2.0 * s * c * n[4, j]


@internal
def cell_at(e, travel, i, p):
    """Return V, dV/de, and along the axis: the centre of buoyancy, the stack's first moment, and that one's slope.

    The centre of a cell that is nearly empty runs away, its first moment does not: the centre stays within half the
    travel, and only says in which water the cell is.
    """
    part = p.parts[i]
    volume, slope = volume_and_slope(part, e, p)
    half = 0.5 * part.grows * travel
    stack = volume - part.core_volume
    moment = half * stack
    reach = abs(half)
    shift = select(volume > 0.0, min(max(moment / select(volume > 0.0, volume, 1.0), -reach), reach), 0.0)
    return volume, slope, shift, moment, 0.5 * part.grows * stack + half * slope


@internal
def masses_at(y, p):
    """Return S_x, S_y, S_z and I_xx, I_yy, I_zz, I_xy, I_xz, I_yz about the origin at the state's extensions."""
    b = p.space[0]
    sx, sy, sz = b.mass_x, b.mass_y, b.mass_z
    xx, yy, zz, xy, xz, yz = b.ixx, b.iyy, b.izz, b.ixy, b.ixz, b.iyz
    for i in range(p.parts.shape[0]):
        if p.members[i].moves != 0.0:
            mass = p.members[i].moving_mass
            travel = y[EXTENSIONS + i] - p.parts[i].neutral
            cx, cy, cz, _ax, _ay, _az, c, s = moving_mass_at(travel, i, p)
            sx += mass * cx
            sy += mass * cy
            sz += mass * cz
            xx += mass * (cy * cy + cz * cz) + own_inertia(i, 0, c, s, p)
            yy += mass * (cx * cx + cz * cz) + own_inertia(i, 1, c, s, p)
            zz += mass * (cx * cx + cy * cy) + own_inertia(i, 2, c, s, p)
            xy += own_inertia(i, 3, c, s, p) - mass * cx * cy
            xz += own_inertia(i, 4, c, s, p) - mass * cx * cz
            yz += own_inertia(i, 5, c, s, p) - mass * cy * cz
    return sx, sy, sz, xx, yy, zz, xy, xz, yz


@internal
def solids_in_water(y, kx, ky, kz, p):
    """Return B, B_x, B_y, B_z and the potential energy (J) of the buoyancy of parts that do not move."""
    mass, mx, my, mz, potential = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(p.solids.shape[0]):
        row = p.solids[i]
        density, head = felt_by_part(y[Z] + kx * row[1] + ky * row[2] + kz * row[3], row[5], p)
        share, integral = squeezed_by(head, row[4])
        held = density * row[0] * (1.0 - share)
        mass += held
        mx += held * row[1]
        my += held * row[2]
        mz += held * row[3]
        potential += row[0] * integral
    return mass, mx, my, mz, potential


@internal
def squeezed_by(head, per_bulk):
    """Return by which share compression takes a volume away, and the integral of what is left over the head (Pa).

    The law ends where nothing is left.
    """
    pressed = max(head, 0.0)
    share = pressed * per_bulk
    integral = head - 0.5 * share * pressed
    gone = share >= 1.0
    if any_of(gone):
        return select(gone, 1.0, share), select(gone, 0.5 / per_bulk, integral)
    return share, integral


@internal
def cell_in_water(e, depth, i, kx, ky, kz, p):
    """Return what cell i displaces (kg), its moment (kg m), potential energy (J), and two forces by its extension.

    The forces are dU/de, and the part of it that costs energy, head times dV/de (N).
    """
    m = p.members[i]
    volume, slope, shift, moment, moment_slope = cell_at(e, e - p.parts[i].neutral, i, p)
    along = kx * m.axis_x + ky * m.axis_y + kz * m.axis_z
    density, head = felt_by_part(depth + kx * m.x + ky * m.y + kz * m.z + shift * along, m.half_height, p)
    share, integral = squeezed_by(head, m.per_bulk)
    density *= 1.0 - share
    push = density * p.space[0].gravity * along
    potential = volume * integral + (moment - volume * shift) * push
    force = slope * integral + (moment_slope - slope * shift) * push
    held, arm = density * volume, density * moment
    return (
        held, held * m.x + arm * m.axis_x, held * m.y + arm * m.axis_y, held * m.z + arm * m.axis_z,
        potential, force, slope * max(head, 0.0) * (1.0 - share),
    )  # fmt: skip


@internal
def displaced_water(y, kx, ky, kz, p):
    """Return B, B_x, B_y, B_z and the potential energy of all buoyancy (J), each part at its own depth."""
    mass, mx, my, mz, potential = solids_in_water(y, kx, ky, kz, p)
    for i in range(p.parts.shape[0]):
        cell = cell_in_water(y[EXTENSIONS + i], y[Z], i, kx, ky, kz, p)
        mass += cell[0]
        mx += cell[1]
        my += cell[2]
        mz += cell[3]
        potential += cell[4]
    return mass, mx, my, mz, potential


@internal
def work_of_mass(y, i, kx, ky, kz, p):
    """Return dU/de of part i's weight, and nu^T dM_RB/de nu / 2, N or N m."""
    m = p.members[i]
    cx, cy, cz, ax, ay, az, c, s = moving_mass_at(y[EXTENSIONS + i] - p.parts[i].neutral, i, p)
    weight = -m.moving_mass * p.space[0].gravity * (kx * ax + ky * ay + kz * az)
    wx, wy, wz = y[P], y[Q], y[R]
    vx, vy, vz = cross(wx, wy, wz, cx, cy, cz)
    tx, ty, tz = cross(wx, wy, wz, ax, ay, az)
    kinetic = m.moving_mass * ((y[U] + vx) * tx + (y[V] + vy) * ty + (y[W] + vz) * tz)
    if m.rolls != 0.0:
        hx, hy, hz = times_symmetric(
            own_inertia(i, 0, c, s, p), own_inertia(i, 1, c, s, p), own_inertia(i, 2, c, s, p),
            own_inertia(i, 3, c, s, p), own_inertia(i, 4, c, s, p), own_inertia(i, 5, c, s, p), wx, wy, wz,
        )  # fmt: skip
        gx, gy, gz = cross(m.axis_x, m.axis_y, m.axis_z, hx, hy, hz)
        kinetic += wx * gx + wy * gy + wz * gz
    return weight, kinetic


@internal
def work_of_part(y, i, cell, kx, ky, kz, p):
    """Return the force that part i's actuator works against, the part of it that costs energy, and the kinetic part.

    The first two are dU/de: of a cell (`cell_in_water`) the second is head times dV/de alone, of a mass its weight. The
    third is nu^T dM_RB/de nu / 2. N, or N m of a part that rolls.
    """
    force, billed = cell[5], cell[6]
    if p.members[i].moves != 0.0:
        weight, kinetic = work_of_mass(y, i, kx, ky, kz, p)
        return force + weight, billed + weight, kinetic
    return force, billed, 0.0


@internal
def work_of_jump(before, after, i, kx, ky, kz, p):
    """Return what part i's jump costs before efficiency: mean pressure times the rise of V, or the weight lifted."""
    m = p.members[i]
    work = 0.0
    if m.moves != 0.0:
        neutral = p.parts[i].neutral
        ax, ay, az, _x, _y, _z, _c, _s = moving_mass_at(before[EXTENSIONS + i] - neutral, i, p)
        bx, by, bz, _x, _y, _z, _c, _s = moving_mass_at(after[EXTENSIONS + i] - neutral, i, p)
        lifted = kx * (bx - ax) + ky * (by - ay) + kz * (bz - az)
        work = -m.moving_mass * p.space[0].gravity * lifted
    start, first, taken = cell_under_pressure(before, i, kx, ky, kz, p)
    finish, last, taken_after = cell_under_pressure(after, i, kx, ky, kz, p)
    return work + 0.5 * (first * (1.0 - taken) + last * (1.0 - taken_after)) * (finish - start)


@internal
def cell_under_pressure(y, i, kx, ky, kz, p):
    """Return the volume of cell i (m3), the head that it feels (Pa), and the share that compression takes away."""
    m = p.members[i]
    e = y[EXTENSIONS + i]
    volume, _slope, shift, _moment, _moment_slope = cell_at(e, e - p.parts[i].neutral, i, p)
    along = kx * m.axis_x + ky * m.axis_y + kz * m.axis_z
    _density, head = felt_by_part(y[Z] + kx * m.x + ky * m.y + kz * m.z + shift * along, m.half_height, p)
    return volume, max(head, 0.0), squeezed_by(head, m.per_bulk)[0]


@internal
def volume_under_pressure(y, i, kx, ky, kz, p):
    """Return the volume that cell i displaces at its depth, m3."""
    volume, _head, share = cell_under_pressure(y, i, kx, ky, kz, p)
    return volume * (1.0 - share)


@internal
def energy_taken(work, i, p):
    """Return what the battery gives for `work` of part i's actuator; where that is negative, what it gets back."""
    m = p.members[i]
    return work * select(work > 0.0, m.per_efficiency, m.recovery)


@internal
def move_members(t, y, p, drive, dy, kx, ky, kz):
    """Write the rates of extensions and of energy spent into `dy`; return what `displaced_water` does, and the power.

    One pass over the parts: `displaced_water` and the work of each part would both work out where each cell floats.
    """
    mass, mx, my, mz, potential = solids_in_water(y, kx, ky, kz, p)
    power = 0.0
    n = p.parts.shape[0]
    for i in range(n):
        e = y[EXTENSIONS + i]
        cell = cell_in_water(e, y[Z], i, kx, ky, kz, p)
        mass += cell[0]
        mx += cell[1]
        my += cell[2]
        mz += cell[3]
        potential += cell[4]
        rate = extension_rate(t, e, p.parts[i], drive[i])
        dy[EXTENSIONS + i] = rate
        dy[EXTENSIONS + n + i] = 0.0
        moving = rate != 0.0
        if any_of(moving):
            force, billed, kinetic = work_of_part(y, i, cell, kx, ky, kz, p)
            power += select(moving, rate * (force + kinetic), 0.0)
            dy[EXTENSIONS + n + i] = select(moving, energy_taken(rate * billed, i, p), 0.0)
    return (mass, mx, my, mz, potential), power
