"""Owns the water at a depth: density, the head that a part feels, and the current."""

from __future__ import annotations

import math

from models.kernel.choice import any_of, select
from models.kernel.jit import internal


@internal
def density_and_pressure(z, p):
    """Return the density (kg/m3) and the gauge pressure (Pa) at depth z; the pressure is negative above the surface."""
    s = p.space[0]
    k = math.floor((z - s.water_top) * s.per_spacing) + 1
    k = min(max(k, 0), p.water.shape[0] - 1)
    row = p.water[k]
    h = z - row[0]
    density = row[1] + h * (row[2] + h * (row[3] + h * row[4]))
    mean = row[1] + h * (0.5 * row[2] + h * (row[3] / 3.0 + h * 0.25 * row[4]))
    return density, row[5] + s.gravity * h * mean


@internal
def felt_by_part(z, half_height, p):
    """Return density times immersed share (kg/m3), and the head (Pa), of a part centred at depth z.

    Where buoyancy fades, the part emerges as a sphere does: share = s^2 (3 - 2 s), s = (z + h) / 2 h. The head is the
    integral of density times share times g, so that the force is its slope and energy is conserved exactly.
    """
    density, pressure = density_and_pressure(z, p)
    emerging = (z < half_height) & (half_height > 0.0)
    if not any_of(emerging):
        return density, pressure
    s = max(0.5 * (z / half_height + 1.0), 0.0)
    head = p.space[0].gravity * density * 2.0 * half_height * s * s * s * (1.0 - 0.5 * s)
    return select(emerging, density * s * s * (3.0 - 2.0 * s), density), select(emerging, head, pressure)


@internal
def current_row(z, first, p):
    """Return the row of the current that holds at depth z, of the profile that begins at row `first`, by bisection."""
    row, rows = first, p.space[0].levels
    while rows > 1:
        half = rows >> 1
        row = select(p.current[row + half, 0] <= z, row + half, row)
        rows -= half
    return row


@internal
def velocity_of_row(z, row, p):
    """Return the velocity north and east, and their change with depth, by one row of the table."""
    c = p.current[row]
    h = z - c[0]
    return (
        c[1] + h * (c[2] + h * (c[3] + h * c[4])),
        c[5] + h * (c[6] + h * (c[7] + h * c[8])),
        c[2] + h * (2.0 * c[3] + h * 3.0 * c[4]),
        c[6] + h * (2.0 * c[7] + h * 3.0 * c[8]),
    )


@internal
def current_at(z, t, j, p):
    """Return the current north, east (m/s), its change with depth (1/s) and its change with time (m/s2).

    `j` is the profile from which time goes on: within a segment that of its begin, or the last stage of a step would
    read the next one's.
    """
    last = p.current_times.shape[0] - 1
    levels = p.space[0].levels
    row = current_row(z, j * levels, p)
    x, y, x_z, y_z = velocity_of_row(z, row, p)
    changing = (j < last) & (t >= p.current_times[0])
    if not any_of(changing):
        return x, y, x_z, y_z, 0.0, 0.0
    x1, y1, x1_z, y1_z = velocity_of_row(z, select(changing, row + levels, row), p)
    span = p.current_times[select(changing, j + 1, j)] - p.current_times[j]
    per_time = select(changing, 1.0 / span, 0.0)
    share = (t - p.current_times[j]) * per_time
    return (
        x + share * (x1 - x), y + share * (y1 - y), x_z + share * (x1_z - x_z), y_z + share * (y1_z - y_z),
        (x1 - x) * per_time, (y1 - y) * per_time,
    )  # fmt: skip
