"""Owns allocation: which extensions of any number of cells make a wanted heave force, pitch and roll moment.

Bounded least squares, min |A x - b|^2 / 2 + sum effort_i (x_i - x0_i)^2 / 2 with low <= x <= high, by its dual, which
has three unknowns whatever the number of cells: with the misfit l = b - A x, x_i = clip(x0_i + a_i . l / effort_i), so
that the gradient of a convex function of l must vanish. That gradient is piecewise linear, so Newton's method with an
exact search along each step ends after finitely many (Sun, 1997, On piecewise quadratic Newton methods).
"""

from __future__ import annotations

from models.kernel.jit import compiled, internal
from models.kernel.planar import solve_symmetric

AXES = 3
HEAVE, PITCH, ROLL, PREFERRED, LOW, HIGH, EFFORT, SPAN, PART, BASE, COLUMNS = range(11)
"""Columns of a row of `cells`: the scaled column of A; preferred value, bounds and effort of x = (e - base) / span; the
span (m or rad), the index of the part, and its base extension. `COLUMNS` is how many there are."""
ITERATIONS = 60
ENOUGH = 1e-14
ROUNDING = 1e-15


@internal
def pulled(row, lx, ly, lz):
    """Return x of one cell at the multipliers l, and 1 where it is free to move, 0 where a bound holds it."""
    wanted = row[PREFERRED] + (row[HEAVE] * lx + row[PITCH] * ly + row[ROLL] * lz) / row[EFFORT]
    if wanted <= row[LOW]:
        return row[LOW], 0.0
    if wanted >= row[HIGH]:
        return row[HIGH], 0.0
    return wanted, 1.0


@internal
def slope_along(cells, b, at, d, share):
    """Return the slope along d of the convex function of the multipliers, at `at` + share d; it rises with share."""
    lx, ly, lz = at[0] + share * d[0], at[1] + share * d[1], at[2] + share * d[2]
    slope = (lx - b[0]) * d[0] + (ly - b[1]) * d[1] + (lz - b[2]) * d[2]
    for i in range(cells.shape[0]):
        row = cells[i]
        x, _free = pulled(row, lx, ly, lz)
        slope += (row[HEAVE] * d[0] + row[PITCH] * d[1] + row[ROLL] * d[2]) * x
    return slope


@internal
def lowest_along(cells, b, at, d):
    """Return the share of the step d at which the convex function is lowest: the zero of its slope (Illinois)."""
    low, high = 0.0, 1.0
    below, above = slope_along(cells, b, at, d, 0.0), slope_along(cells, b, at, d, 1.0)
    for _doubling in range(20):
        if above >= 0.0:
            break
        low, below = high, above
        high *= 2.0
        above = slope_along(cells, b, at, d, high)
    side = 0
    for _halving in range(80):
        if not above > below or high - low <= 1e-15 * high:
            break
        share = high - above * (high - low) / (above - below)
        slope = slope_along(cells, b, at, d, share)
        if abs(slope) <= 1e-16 * (above - below):
            return share
        if slope > 0.0:
            high, above = share, slope
            if side == 1:
                below *= 0.5
            side = 1
        else:
            low, below = share, slope
            if side == -1:
                above *= 0.5
            side = -1
    return high if abs(above) < abs(below) else low


@compiled
def allocate(cells, bx, by, bz, out):
    """Write x of every row of `cells` into `out` (cells,) for the scaled wish b; return the misfit b - A x."""
    lx = ly = lz = 0.0
    enough = ENOUGH * (1.0 + abs(bx) + abs(by) + abs(bz))
    for _iteration in range(ITERATIONS):
        gx, gy, gz = lx - bx, ly - by, lz - bz
        hxx = hyy = hzz = 1.0
        hxy = hxz = hyz = 0.0
        rounding = 0.0
        for i in range(cells.shape[0]):
            row = cells[i]
            x, free = pulled(row, lx, ly, lz)
            ax, ay, az = row[HEAVE], row[PITCH], row[ROLL]
            gx += ax * x
            gy += ay * x
            gz += az * x
            per = free / row[EFFORT]
            hxx += per * ax * ax
            hyy += per * ay * ay
            hzz += per * az * az
            hxy += per * ax * ay
            hxz += per * ax * az
            hyz += per * ay * az
            rounding += per * (abs(ax) + abs(ay) + abs(az)) * (abs(ax * lx) + abs(ay * ly) + abs(az * lz))
        if abs(gx) + abs(gy) + abs(gz) <= enough + ROUNDING * rounding:
            break
        dx, dy, dz = solve_symmetric(hxx, hxy, hxz, hyy, hyz, hzz, -gx, -gy, -gz)
        share = lowest_along(cells, (bx, by, bz), (lx, ly, lz), (dx, dy, dz))
        if share == 0.0:
            break
        lx, ly, lz = lx + share * dx, ly + share * dy, lz + share * dz
    mx, my, mz = bx, by, bz
    for i in range(cells.shape[0]):
        row = cells[i]
        out[i] = pulled(row, lx, ly, lz)[0]
        mx -= row[HEAVE] * out[i]
        my -= row[PITCH] * out[i]
        mz -= row[ROLL] * out[i]
    return mx, my, mz
