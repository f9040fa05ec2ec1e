"""Owns the parts that move: volumes, moments, the command, and how an extension follows it within one segment.

A segment is a stretch of time in which every command is one straight line and every part follows one law, so that no
step of the integrator straddles a corner. `drive` holds, for each part, [mode, rate, target, target_slope, start], and
in its last row the profile of the current in force.
"""

from __future__ import annotations

import math

from models.kernel.choice import select
from models.kernel.jit import compiled, inlined, internal
from models.kernel.params import EXTENSIONS, Q, U, W, Z
from models.kernel.search import last_not_above

STEADY, LAGGING = 0.0, 1.0
MODE, RATE, TARGET, SLOPE, START = range(5)
SAME_TIME = 1e-12
"""Times closer than this, relative to the larger of them and 1 s, are one time."""


@internal
def cubic_and_slope(row, e):
    """Return V(e) and dV/de by one piece of a volume law."""
    h = e - row[0]
    return row[1] + h * (row[2] + h * (row[3] + h * row[4])), row[2] + h * (2.0 * row[3] + h * 3.0 * row[4])


@internal
def piece_at(part, e, p):
    """Return which piece of a part's volume law holds extension e."""
    k = select(e >= p.volume_law[part.law_start + 1, 0], part.law_start + 1, part.law_start)
    for j in range(part.law_start + 2, part.law_start + part.law_count):
        k = select(e >= p.volume_law[j, 0], j, k)
    return k


@inlined
def volume_and_slope(part, e, p):
    """Return V(e) (m3) and dV/de (m2) of one part."""
    if part.law_count == 1:
        return cubic_and_slope(p.volume_law[part.law_start], e)
    return cubic_and_slope(p.volume_law[piece_at(part, e, p)], e)


@internal
def part_at(part, e, p):
    """Return V, dV/de, the stack's volume, the moving mass's x and z, and the travel from neutral, at extension e."""
    V, slope = volume_and_slope(part, e, p)
    travel = e - part.neutral
    return (
        V,
        slope,
        V - part.core_volume,
        part.moving_x + travel * part.axis_x,
        part.moving_z + travel * part.axis_z,
        travel,
    )


@inlined
def balance_with_parts(y, p):
    """Return mass_x, mass_z, inertia_yy, volume, volume_x, volume_z of the vehicle at the state's extensions."""
    b = p.body[0]
    mass_x, mass_z, inertia = b.mass_x, b.mass_z, b.inertia_yy
    volume, volume_x, volume_z = b.volume, b.volume_x, b.volume_z
    for i in range(p.parts.shape[0]):
        part = p.parts[i]
        V, _slope, stack, x_m, z_m, travel = part_at(part, y[EXTENSIONS + i], p)
        growth = 0.5 * part.grows * travel * stack
        mass_x += part.moving_mass * x_m
        mass_z += part.moving_mass * z_m
        inertia += part.moving_mass * (x_m * x_m + z_m * z_m)
        volume += V
        volume_x += V * part.x + growth * part.axis_x
        volume_z += V * part.z + growth * part.axis_z
    return mass_x, mass_z, inertia, volume, volume_x, volume_z


@internal
def extension_rate(t, e, part, d):
    """Return de/dt of one part in the present segment, m/s."""
    wanted = (d[TARGET] + d[SLOPE] * (t - d[START]) - e) * part.inverse_lag
    return select(d[MODE] == STEADY, d[RATE], min(max(wanted, -part.rate), part.rate))


@internal
def move_parts(t, y, p, drive, dy, s, c):
    """Write the extension rates into `dy`; return what `balance_with_parts` does, and the power of the actuators.

    The power is the sum of (dU/de + nu^T dM_RB/de nu / 2) e' over the parts, W.
    """
    b = p.body[0]
    u, w, q = y[U], y[W], y[Q]
    mass_x, mass_z, inertia = b.mass_x, b.mass_z, b.inertia_yy
    volume, volume_x, volume_z = b.volume, b.volume_x, b.volume_z
    power = 0.0
    for i in range(p.parts.shape[0]):
        part = p.parts[i]
        e = y[EXTENSIONS + i]
        V, slope, stack, x_m, z_m, travel = part_at(part, e, p)
        mass_x += part.moving_mass * x_m
        mass_z += part.moving_mass * z_m
        inertia += part.moving_mass * (x_m * x_m + z_m * z_m)
        growth = 0.5 * part.grows * travel * stack
        volume += V
        volume_x += V * part.x + growth * part.axis_x
        volume_z += V * part.z + growth * part.axis_z
        rate = extension_rate(t, e, part, drive[i])
        dy[EXTENSIONS + i] = rate
        swelling = 0.5 * part.grows * (travel * slope + stack)
        net_x = part.moving_mass * part.axis_x - b.density * (slope * part.x + swelling * part.axis_x)
        net_z = part.moving_mass * part.axis_z - b.density * (slope * part.z + swelling * part.axis_z)
        potential = b.gravity * (b.density * slope * y[Z] + s * net_x - c * net_z)
        kinetic = q * (u * part.axis_z - w * part.axis_x + q * (part.axis_x * x_m + part.axis_z * z_m))
        power += rate * (potential + part.moving_mass * kinetic)
    return mass_x, mass_z, inertia, volume, volume_x, volume_z, power


@internal
def command_row(part, t, p):
    """Return the row of the command in force at time t (from its own time on), by bisection."""
    low = part.command_start
    high = part.command_start + part.command_count
    while high - low > 1:
        middle = (low + high) // 2
        if p.commands[middle, 0] <= t + SAME_TIME * max(1.0, abs(t)):
            low = middle
        else:
            high = middle
    return low


@compiled
def command(part, t, p):
    """Return the commanded extension of one part at time t, within its stops, m."""
    row = p.commands[command_row(part, t, p)]
    return min(max(row[1] + row[2] * (t - row[0]), part.stop_low), part.stop_high)


@internal
def lag_corner(gap, slope, rate, lag):
    """Return after how long a lagging part leaves or reaches its rate limit; infinity if it never does.

    `gap` = command - extension. Saturated, the gap changes at (slope -+ rate); free, it tends to slope * lag.
    """
    edge = rate * lag
    if abs(gap) > edge * (1.0 + 1e-12):
        closing = math.copysign(rate, gap) - slope
        remaining = gap - math.copysign(edge, gap)
        return remaining / closing if remaining * closing > 0.0 else math.inf
    tends_to = slope * lag
    # at the edge by rounding, a gap that the command closes is free all the same: it will reach the other edge
    if abs(slope) <= rate or (abs(gap) >= edge and gap * slope > 0.0):
        return math.inf
    return lag * math.log((tends_to - gap) / (tends_to - math.copysign(edge, slope)))


@internal
def next_current_time(t, p):
    """Return the next time at which the current has a corner; infinity if there is none."""
    now = t + SAME_TIME * max(1.0, abs(t))
    if p.current_times[0] > now:
        return p.current_times[0]
    j = last_not_above(now, p.current_times) + 1
    return p.current_times[j] if j < p.current_times.shape[0] else math.inf


@compiled
def begin_segment(t, y, p, drive, told):
    """Set how every part moves from time t on, and return when that ends (infinity if never).

    A part follows its schedule, or the command it is `told`, where that is a number. One without rate limit and lag is
    put on its command here, so `y` may jump.
    """
    drive[p.parts.shape[0], 0] = last_not_above(t + SAME_TIME * max(1.0, abs(t)), p.current_times)
    end = next_current_time(t, p)
    first = p.space[0].extensions
    for i in range(p.parts.shape[0]):
        part = p.parts[i]
        if math.isnan(told[i]):
            k = command_row(part, t, p)
            if k + 1 < part.command_start + part.command_count:
                end = min(end, p.commands[k + 1, 0])
            slope, target = p.commands[k, 2], command(part, t, p)
        else:
            slope, target = 0.0, min(max(told[i], part.stop_low), part.stop_high)
        gap = target - y[first + i]
        d = drive[i]
        d[TARGET], d[SLOPE], d[START] = target, slope, t
        reach = 1e-10 * (part.stop_high - part.stop_low) + (0.0 if math.isinf(part.rate) else 1e-9 * part.rate)
        if part.inverse_lag > 0.0:
            d[MODE] = LAGGING
            end = min(end, t + max(lag_corner(gap, slope, part.rate, 1.0 / part.inverse_lag), 1e-9))
        elif math.isinf(part.rate) or (abs(gap) <= reach and abs(slope) <= part.rate):
            d[MODE], d[RATE] = STEADY, slope
            y[first + i] = target
        else:
            toward = gap if abs(gap) > reach else slope
            d[MODE], d[RATE] = STEADY, math.copysign(part.rate, toward)
            closing = d[RATE] - slope
            if gap * closing > 0.0 and abs(gap) > reach:
                end = min(end, t + gap / closing)
    return max(end, t + SAME_TIME * max(1.0, t))


__all__ = ["balance_with_parts", "begin_segment", "command", "move_parts", "volume_and_slope"]
