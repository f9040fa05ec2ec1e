"""Owns the search for a steady motion whose extensions keep within their stops, as near as can be to given ones.

Newton's method on more unknowns than equations (or fewer): each step is the least-squares solution of the linearised
rows, with a small weight on the distance of the extensions from the given ones, which decides what the rows leave open
(Tikhonov); an extension that would pass its stop is held there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from models.kernel.steady import EXTENSIONS, ROWS
from models.steady_problem import SteadyProblem, speed_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
EFFORT = 1e-6
"""Weight of a stroke's distance beside a row that is off by its scale."""
STALLED = 1e-2
"""A start is given up once a step lessens its misfit by a smaller share."""
ENOUGH = 1e-11
"""Scaled misfit at which a motion counts as found."""
ITERATIONS = 40
HALVINGS = 8
FALLS = 0.3
"""Share of what a linear law would lessen that a step has to lessen; a smaller one lets the steps zigzag."""
SNAPS = 1e-4
"""An extension this near to a stop (in strokes) is put there."""
ANGLES = [ROWS.index("pitch"), ROWS.index("roll")]
"""Rows that are the same again after a whole turn."""
DECISIVE = 1e3
"""Weight of the rows that must hold over those that may give."""


class BoundedSearch:
    """The rows (r,) that are wanted of a motion, its unknowns, and the scale of either.

    `wanted` and `scale` are (rows,) as in the kernel; `free` are indices of extensions among the unknowns.
    """

    def __init__(
        self, problem: SteadyProblem, rows: Indices, free: Indices, *, wanted: Array, scale: Array, speed: float
    ) -> None:
        self.problem, self.rows, self.wanted, self.scale = problem, rows, wanted, scale
        self.unknowns = np.concatenate([problem.motion_unknowns, free])
        self.free, self.motions = free, len(problem.motion_unknowns)
        self.span = problem.longest(speed)[self.unknowns]
        stroke = (problem.high - problem.low)[free - EXTENSIONS]
        self.span[self.motions :] = stroke
        self.home = problem.extensions[free - EXTENSIONS] / stroke
        self.low, self.high = problem.low[free - EXTENSIONS] / stroke, problem.high[free - EXTENSIONS] / stroke
        self.steps = np.zeros(len(problem.steps))
        self.steps[self.unknowns] = problem.steps[self.unknowns]

    def misfit(self, motion: Array) -> Array:
        """Return the scaled rows less what is wanted, (r,)."""
        return off_target(self.problem.rows(motion), self.wanted)[self.rows] / self.scale[self.rows]

    def linearised(self, motion: Array) -> tuple[Array, Array]:
        """Return the misfit and its slopes by the scaled unknowns, (r,) and (r, unknowns)."""
        f, slope = self.problem.slopes(motion, self.steps)
        scale = self.scale[self.rows]
        J = slope[np.ix_(self.rows, self.unknowns)] * self.span / scale[:, None]
        return off_target(f, self.wanted)[self.rows] / scale, J

    def solve(self, start: Array) -> tuple[Array, float]:
        """Return the motion reached from a start (unknowns,), and the size of its scaled misfit."""
        s = start.copy()
        s[EXTENSIONS:] = np.clip(s[EXTENSIONS:], self.problem.low, self.problem.high)
        for _iteration in range(ITERATIONS):
            f, J = self.linearised(s)
            size = float(np.linalg.norm(f))
            if size < ENOUGH or not np.all(np.isfinite(J)) or not math.isfinite(size):
                return s, size
            step = self._bounded_step(f, J, s, EFFORT if size > 1e-9 else 0.0)
            trial, after = self._shortened(s, step, size)
            if trial is None:
                return s, size
            s = trial
            if size - after < STALLED * size and size > 1e-6:
                return s, after
        return s, float(np.linalg.norm(self.misfit(s)))

    def _shortened(self, s: Array, step: Array, size: float) -> tuple[Array | None, float]:
        """Return the motion after a share of a step that lessens the misfit enough, and that; None where none does."""
        longest = float(np.abs(step[: self.motions]).max(initial=0.0))
        share = min(1.0, 1.0 / longest) if longest > 0.0 else 1.0
        best, least = None, size
        for _halving in range(HALVINGS):
            trial = s.copy()
            trial[self.unknowns] += share * step * self.span
            trial[self.free] = np.clip(trial[self.free], self.low * self._stroke, self.high * self._stroke)
            after = float(np.linalg.norm(self.misfit(trial)))
            if after < least:
                best, least = trial, after
            if after < size * (1.0 - FALLS * share):
                break
            share *= 0.5
        return best, least

    @property
    def _stroke(self) -> Array:
        return np.asarray(self.span[self.motions :], dtype=np.float64)

    def _bounded_step(self, f: Array, J: Array, s: Array, effort: float) -> Array:
        """Return the scaled step (unknowns,) that lessens the misfit most, extensions kept within their stops."""
        n, m = len(self.unknowns), self.motions
        place = s[self.free] / self._stroke
        A = np.zeros((len(f) + n - m, n))
        A[: len(f)] = J
        A[len(f) :, m:] = effort * np.eye(n - m)
        b = np.concatenate([-f, -effort * (place - self.home)])
        step, held = np.zeros(n), np.zeros(n, dtype=bool)
        low, high = self.low - place, self.high - place
        for _ in range(n - m + 1):
            step[~held] = np.linalg.lstsq(A[:, ~held], b - A[:, held] @ step[held], rcond=1e-13)[0]
            beyond = np.maximum(low - step[m:], step[m:] - high)
            beyond[held[m:]] = 0.0
            worst = int(np.argmax(beyond)) if n > m else 0
            if n == m or beyond[worst] <= 1e-12:
                break
            step[m + worst] = low[worst] if step[m + worst] < low[worst] else high[worst]
            held[m + worst] = True
        return step

    def nearest(self, start: Array, must: NDArray[np.bool_]) -> Array:
        """Return the motion that meets the rows `must` (r,) and misses the others least (trust region, SciPy)."""
        weight = np.where(must, DECISIVE, 1.0)
        base = start.copy()

        def motion(x: Array) -> Array:
            s = base.copy()
            s[self.unknowns] = x * self.span
            return s

        lowest = np.concatenate([np.full(self.motions, -np.inf), self.low])
        highest = np.concatenate([np.full(self.motions, np.inf), self.high])
        x = np.clip(base[self.unknowns] / self.span, lowest, highest)

        def misfits(x: Array) -> Array:
            return np.asarray(weight * self.misfit(motion(x)), dtype=np.float64)

        def slopes(x: Array) -> Array:
            return np.asarray(weight[:, None] * self.linearised(motion(x))[1], dtype=np.float64)

        try:
            found = least_squares(
                misfits, x, slopes, bounds=(lowest, highest), xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=100
            )
        except (ValueError, np.linalg.LinAlgError):  # a trial ran away until slopes were no numbers
            return start
        s = motion(found.x)
        for k, index in enumerate(self.free):  # the trust region keeps a little off the stops
            for stop in (self.low[k], self.high[k]):
                if abs(found.x[self.motions + k] - stop) < SNAPS:
                    s[index] = stop * self._stroke[k]
        return s


def off_target(rows: Array, wanted: Array) -> Array:
    """Return the rows of the kernel less what is wanted of each, (rows,), angles within a half turn."""
    off = rows - wanted
    off[ANGLES] -= math.tau * np.round(off[ANGLES] / math.tau)
    return off


def typical_speed(starts: Array) -> float:
    """Return the median speed of some motions, m/s."""
    return float(np.median([speed_of(s) for s in starts])) if len(starts) else math.nan
