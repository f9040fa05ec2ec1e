"""Owns one step of each method, and the polynomial between its ends. Both leave y1 and the polynomial's coefficients.

The arrays are those of `Work`; `dense` means y(t + s h) = y + s (d0 + s (d1 + s (d2 + s d3))).
"""

from __future__ import annotations

import math

from models.kernel import tableau
from models.kernel.choice import fused, select
from models.kernel.jit import compiled, inlined, internal
from models.kernel.model import derivative

A = tableau.A
C = tableau.C
D = tableau.D
E = tableau.E


@inlined
def rk4_step(t, h, y, p, work):
    """Advance by the classical Runge-Kutta method; k[0] holds the slope at (t, y), k[4] takes that at the end."""
    n = y.shape[0]
    k, y1 = work.k, work.y1
    half, sixth = 0.5 * h, h / 6.0
    for m in range(4):  # a loop: every place that calls the derivative holds a copy of its machine code
        for j in range(n):
            if m < 3:
                y1[j] = y[j] + (half if m < 2 else h) * k[m, j]
            else:
                y1[j] = y[j] + sixth * (k[0, j] + 2.0 * (k[1, j] + k[2, j]) + k[3, j])
        derivative(t + (half if m < 2 else h), y1, p, work.drive, k[m + 1])


@inlined
def pair_step(t, h, y, p, work):
    """Advance by Dormand-Prince 5(4); return the largest scaled error (1 is `tolerance`) and in which state it is.

    The last slope is k[6].
    """
    n = y.shape[0]
    k, y1 = work.k, work.y1
    for i in range(1, 7):
        for j in range(n):
            y1[j] = A[i, 0] * k[0, j]
        for m in range(1, i):
            a = A[i, m]
            for j in range(n):
                y1[j] += a * k[m, j]
        for j in range(n):
            y1[j] = y[j] + h * y1[j]
        derivative(t + C[i] * h, y1, p, work.drive, k[i])
    worst, where = 0.0, 0
    for j in range(n):
        error = E[0] * k[0, j]
        for m in range(2, 7):
            error += E[m] * k[m, j]
        error = abs(h * error) / p.error_scale[j]
        # no number is the worst error of all, which no later one replaces
        worse = ((error > worst) | (error != error)) & (worst == worst)
        worst, where = select(worse, error, worst), select(worse, j, where)
    return worst, where


@compiled
def make_dense(pair, h, y, work):
    """Set `work.dense` to the polynomial of the step just taken: the pair's own, or the cubic through RK4's ends.

    Rounded alike for one run and for lanes: which of them a sample is taken by depends on what else is in its step.
    """
    k, y1, dense = work.k, work.y1, work.dense
    for j in range(y.shape[0]):
        if pair:
            for r in range(4):
                total = fused(D[0, r], k[0, j], 0.0)
                for m in range(2, 7):  # the slope k[1] has no share
                    total = fused(D[m, r], k[m, j], total)
                dense[r, j] = h * total
        else:
            rise = y1[j] - y[j]
            start = h * k[0, j]
            finish = h * k[4, j]
            dense[0, j] = start
            dense[1, j] = fused(3.0, rise, -2.0 * start) - finish
            dense[2, j] = fused(-2.0, rise, start + finish)
            dense[3, j] = 0.0


@internal
def interpolate_one(s, y, dense, j):
    """Return state j at the fraction s of the step."""
    return fused(s, fused(s, fused(s, fused(s, dense[3, j], dense[2, j]), dense[1, j]), dense[0, j]), y[j])


@compiled
def interpolate(s, y, dense, out):
    """Write the state at the fraction s of the step into `out`."""
    for j in range(y.shape[0]):
        out[j] = interpolate_one(s, y, dense, j)


@inlined
def next_factor(error, previous):
    """Return by how much to change the step: a PI controller (Hairer, Norsett, Wanner, 1993, II.4), 0.2 to 5."""
    if not math.isfinite(error):
        return 0.1
    if error == 0.0:
        return 5.0
    factor = 0.9 * math.pow(error, -0.17) * math.pow(previous, 0.04)
    return min(5.0, max(0.2, factor))
