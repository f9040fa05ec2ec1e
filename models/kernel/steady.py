"""Owns steady motions: what is out of balance in one, how that changes, and Newton's method for its zeros.

A steady motion is one in which only position and heading change: a straight glide, or a turn at a constant rate about
the vertical. Its unknowns are s = [roll, pitch, u, v, w, turn rate, e_1 ... e_n] (rad, m/s through still water, rad/s,
m or rad), of which a planar glider has pitch, u, w and the extensions. Its rows are the loads X, Y, Z, K, M, N out of
balance (N, N m), then the quantities by which a motion may be asked for (`ROWS`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.kernel import params, spatial_layout
from models.kernel.jit import compiled, internal
from models.kernel.model import loads

ROLL, PITCH, SURGE, SWAY, HEAVE, TURN = range(6)
EXTENSIONS = 6
"""Index of the first extension among the unknowns."""
ROWS = (
    "X", "Y", "Z", "K", "M", "N", "glide_angle", "speed", "sink_rate", "turn_rate", "pitch", "roll", "curvature",
)  # fmt: skip
"""Loads out of balance, then: path angle (rad, climb positive), speed (m/s), sink rate (m/s), turn rate (rad/s), pitch
and roll (rad), and the curvature of the path over the ground (1/m), to the right."""
LOADS = 6
CONVERGED, WANDERED, STUCK = range(3)
HALVINGS = 12
LEAST = 1e-12
"""Speeds below this have no direction, m/s."""


class SteadyWork(NamedTuple):
    """Scratch arrays, made outside the kernel."""

    y: NDArray[np.float64]  # (states,)
    s: NDArray[np.float64]  # (unknowns,) a trial
    f: NDArray[np.float64]  # (rows,)
    g: NDArray[np.float64]  # (rows,) at a perturbed place
    slope: NDArray[np.float64]  # (rows, unknowns)
    system: NDArray[np.float64]  # (unknowns, unknowns + 1)


def make_steady_work(states: int, parts: int) -> SteadyWork:
    """Return scratch arrays for a state of `states` numbers and `parts` actuated parts."""
    n = EXTENSIONS + parts
    return SteadyWork(
        np.zeros(states), np.zeros(n), np.zeros(len(ROWS)), np.zeros(len(ROWS)), np.zeros((len(ROWS), n)),
        np.zeros((n, n + 1)),
    )  # fmt: skip


@internal
def down(s):
    """Return the unit vector down in body axes."""
    cp = math.cos(s[PITCH])
    return -math.sin(s[PITCH]), cp * math.sin(s[ROLL]), cp * math.cos(s[ROLL])


@compiled
def write_steady(s, depth, y, p):
    """Write the state of the steady motion `s` at a depth (m), heading north in still water, into `y`."""
    for j in range(y.shape[0]):
        y[j] = 0.0
    first = p.space[0].extensions
    for i in range(p.parts.shape[0]):
        y[first + i] = s[EXTENSIONS + i]
    if p.space[0].spatial == 0:
        y[params.Z], y[params.THETA], y[params.U], y[params.W] = depth, s[PITCH], s[SURGE], s[HEAVE]
        return
    sr, cr = math.sin(0.5 * s[ROLL]), math.cos(0.5 * s[ROLL])
    sp, cp = math.sin(0.5 * s[PITCH]), math.cos(0.5 * s[PITCH])
    y[spatial_layout.Z] = depth
    y[spatial_layout.Q0], y[spatial_layout.Q1] = cr * cp, sr * cp
    y[spatial_layout.Q2], y[spatial_layout.Q3] = cr * sp, -sr * sp
    y[spatial_layout.U], y[spatial_layout.V], y[spatial_layout.W] = s[SURGE], s[SWAY], s[HEAVE]
    kx, ky, kz = down(s)
    y[spatial_layout.P], y[spatial_layout.Q], y[spatial_layout.R] = s[TURN] * kx, s[TURN] * ky, s[TURN] * kz


@compiled
def steady_rows(s, depth, y, p, f):
    """Write the rows of the motion `s` into `f`; `y` is scratch, and holds its state afterwards."""
    write_steady(s, depth, y, p)
    loads(0.0, y, p, f)
    kx, ky, kz = down(s)
    u, v, w = s[SURGE], s[SWAY], s[HEAVE]
    speed = math.sqrt(u * u + v * v + w * w)
    sink = kx * u + ky * v + kz * w
    level = math.sqrt(max(speed * speed - sink * sink, 0.0))
    f[6] = -math.atan2(sink, level)
    f[7], f[8], f[9] = speed, sink, s[TURN]
    f[10], f[11] = s[PITCH], s[ROLL]
    f[12] = s[TURN] / max(level, LEAST)


@compiled
def steady_slopes(s, steps, depth, p, work):
    """Write the rows at `s` into `work.f`, and their slopes by central differences of `steps` into `work.slope`."""
    n = s.shape[0]
    for j in range(n):
        work.s[j] = s[j]
    for j in range(n):
        h = steps[j]
        if h == 0.0:
            continue
        work.s[j] = s[j] + h
        steady_rows(work.s, depth, work.y, p, work.f)
        work.s[j] = s[j] - h
        steady_rows(work.s, depth, work.y, p, work.g)
        work.s[j] = s[j]
        for i in range(work.f.shape[0]):
            work.slope[i, j] = (work.f[i] - work.g[i]) / (2.0 * h)
    steady_rows(s, depth, work.y, p, work.f)


@internal
def misfit(f, rows, wanted, scale):
    """Return half the sum of squares of the chosen rows' scaled distance from what is wanted."""
    total = 0.0
    for i in range(rows.shape[0]):
        r = (f[rows[i]] - wanted[rows[i]]) / scale[rows[i]]
        total += 0.5 * r * r
    return total


@internal
def solve_system(a, n):
    """Solve the n equations in the first n rows of `a` (its column n the right-hand side), which then holds the answer.

    By elimination with partial pivoting; returns False where they are singular.
    """
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        if not abs(a[best, k]) > 1e-14:
            return False
        for j in range(k, n + 1):
            a[k, j], a[best, j] = a[best, j], a[k, j]
        per_pivot = 1.0 / a[k, k]
        for i in range(k + 1, n):
            factor = a[i, k] * per_pivot
            for j in range(k, n + 1):
                a[i, j] -= factor * a[k, j]
    for k in range(n - 1, -1, -1):
        total = a[k, n]
        for j in range(k + 1, n):
            total -= a[k, j] * a[j, n]
        a[k, n] = total / a[k, k]
    return True


@internal
def longest_share(step, system, unknowns):
    """Return which share of Newton's step keeps every unknown within its longest step."""
    n = unknowns.shape[0]
    share = 1.0
    for k in range(n):
        size = abs(system[k, n])
        if size > step[unknowns[k]]:
            share = min(share, step[unknowns[k]] / size)
    return share


@compiled
def newton(s, steps, longest, unknowns, rows, wanted, scale, tolerance, depth, p, work):
    """Move the chosen unknowns of `s` until the chosen rows have their wanted values; return a code.

    `steps` are those of the differences, `longest` those of one iteration, each (unknowns,); `wanted` and `scale`
    (rows,). As many rows as unknowns. Each iteration takes Newton's step, halved until the misfit falls.
    """
    n = unknowns.shape[0]
    for _iteration in range(60):
        steady_slopes(s, steps, depth, p, work)
        before = misfit(work.f, rows, wanted, scale)
        if math.sqrt(2.0 * before) <= tolerance:
            return CONVERGED
        for i in range(n):
            for k in range(n):
                work.system[i, k] = work.slope[rows[i], unknowns[k]] * longest[unknowns[k]] / scale[rows[i]]
            work.system[i, n] = (wanted[rows[i]] - work.f[rows[i]]) / scale[rows[i]]
        if not solve_system(work.system, n):
            return STUCK
        for k in range(n):
            work.system[k, n] *= longest[unknowns[k]]
        share = longest_share(longest, work.system, unknowns)
        for _halving in range(HALVINGS):
            for j in range(s.shape[0]):
                work.s[j] = s[j]
            for k in range(n):
                work.s[unknowns[k]] = s[unknowns[k]] + share * work.system[k, n]
            steady_rows(work.s, depth, work.y, p, work.g)
            after = misfit(work.g, rows, wanted, scale)
            if after < before * (1.0 - 1e-4 * share):
                break
            share *= 0.5
        if not after < before:
            return CONVERGED if math.sqrt(2.0 * before) <= 1e3 * tolerance else STUCK
        for j in range(s.shape[0]):
            s[j] = work.s[j]
    return WANDERED


@compiled
def newton_from_each(seeds, steps, longest, unknowns, rows, wanted, scale, tolerance, depth, p, work, codes, left):
    """Run `newton` from every row of `seeds` (m, unknowns) in place; fill `codes` (m,) and what is `left` (m,)."""
    for m in range(seeds.shape[0]):
        codes[m] = newton(seeds[m], steps, longest, unknowns, rows, wanted, scale, tolerance, depth, p, work)
        steady_rows(seeds[m], depth, work.y, p, work.f)
        left[m] = math.sqrt(2.0 * misfit(work.f, rows, wanted, scale))


@compiled
def balance_along(alphas, s, depth, p, work, found):
    """For each angle of attack find the speed and pitch at which the forces of a straight glide balance.

    `s` gives the extensions; `found` (alphas, 4) gets speed (m/s), pitch (rad), the moment left (N m), and the force
    left as a share of the net weight. The quadratic guess is exact where nothing but squared speed resists.
    """
    for j in range(EXTENSIONS):
        s[j] = 0.0
    steady_rows(s, depth, work.y, p, work.f)
    heavy = work.f[2]
    for k in range(alphas.shape[0]):
        s[PITCH], s[SURGE], s[HEAVE] = 0.0, math.cos(alphas[k]), math.sin(alphas[k])
        speed, pitch = 1.0, 0.0
        for _ in range(40):
            steady_rows(s, depth, work.y, p, work.f)
            kx, _ky, kz = down(s)
            fx, fz = work.f[0] - heavy * kx, work.f[2] - heavy * kz
            scale = math.sqrt(abs(heavy) / math.sqrt(fx * fx + fz * fz + 1e-300))
            pitch = math.atan2(math.copysign(fx, fx * heavy), -math.copysign(fz, fz * heavy))
            speed *= scale
            s[PITCH], s[SURGE], s[HEAVE] = pitch, speed * math.cos(alphas[k]), speed * math.sin(alphas[k])
            if abs(scale - 1.0) < 1e-12:
                break
        steady_rows(s, depth, work.y, p, work.f)
        found[k, 0], found[k, 1], found[k, 2] = speed, pitch, work.f[4]
        found[k, 3] = math.hypot(work.f[0], work.f[2]) / (abs(heavy) + 1e-300)
