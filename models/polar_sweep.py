"""Owns the sweeps behind a glide polar: cells set for a heave force and moments, and the steady motions these give."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.allocation import Effectiveness, effectiveness
from models.kernel import allocate as kernel
from models.kernel.steady import EXTENSIONS, HEAVE, PITCH, ROLL, SURGE, TURN
from models.steady_problem import ALL_LOADS, IN_PLANE, IN_PLANE_LOADS, IN_SPACE, LEAST_NET, SteadyProblem

Array = NDArray[np.float64]
GRID = 721
"""Angles of attack at which the forces are balanced for one curve; cubed spacing, finest about zero."""
STEEPEST = math.radians(89.0)
"""Attitudes steeper than this are left out: there the moment of a cell along the hull vanishes."""
FIRM = 1e3
"""Weight of the axes that are kept over the one that is driven to the stops."""
NO_AUTHORITY = 1e-9
"""Changes of heave below this share of the weight are none; so are moments, of the weight over 1 m."""
TURN_STEPS = 8
OUT_OF_REACH = "the moment is out of the cells' reach"
UNDRIVEN = "the glider weighs what it displaces: nothing drives a glide"
NOT_FOUND = "no steady motion was found"


class CellSetter:
    """Sets the chosen cells for a wanted [heave, pitch, roll] (N, N m, N m, from neutral), the others as given."""

    def __init__(self, problem: SteadyProblem, cells: Sequence[str] | None) -> None:
        self.problem = problem
        self.cells: Effectiveness = effectiveness(problem.assembly.design, cells, depth=problem.depth)
        self._even = self.cells.rows()
        self._firm = [self.cells.rows(np.where(np.arange(3) == axis, 1.0, FIRM).tolist()) for axis in range(3)]
        self._parts = np.array(self.cells.parts, dtype=np.int64)

    def extensions(self, wanted: Sequence[float] | Array, *, driven: int | None = None) -> Array:
        """Return all extensions (parts,); the `driven` axis gives way to the others where stops limit."""
        rows, per_axis = self._even if driven is None else self._firm[driven]
        x = np.zeros(len(rows))
        if len(rows):
            kernel.allocate(rows, *(per_axis * np.asarray(wanted)).tolist(), x)
        e = self.problem.extensions.copy()
        e[self._parts] = self.cells.neutral + x * self.cells.span
        return np.clip(e, self.problem.low, self.problem.high)

    def reached(self, extensions: Array) -> Array:
        """Return the heave, pitch and roll of extensions (parts,) from neutral, (3,)."""
        return np.asarray(self.cells.matrix @ (extensions[self._parts] - self.cells.neutral), dtype=np.float64)

    def ends(self, axis: int, held: Sequence[float]) -> tuple[float, float]:
        """Return the least and the most of one axis with the others held (3,), or as near to it as the stops allow."""
        found = []
        for sign in (-1.0, 1.0):
            wanted = np.array(held, dtype=np.float64)
            wanted[axis] = 2.0 * sign * self.cells.scale[axis]
            found.append(float(self.reached(self.extensions(wanted, driven=axis))[axis]))
        return found[0], found[1]

    def heave_ends(self) -> tuple[float, float]:
        """Return the least and the most heave, every cell at a stop, N."""
        row, e0 = self.cells.matrix[0], self.cells.neutral
        low, high = row * (self.cells.low - e0), row * (self.cells.high - e0)
        return float(np.minimum(low, high).sum()), float(np.maximum(low, high).sum())


@dataclass(frozen=True)
class Swept:
    """Motions (m, unknowns) of one sweep, the moments asked for (m,) N m, how many points were left out, and why."""

    motions: Array
    moments: Array
    left_out: Mapping[str, int]


def sweep_pitch(setter: CellSetter, heave: float, points: int) -> Swept:
    """Return the upright straight glides at one heave (N) as the cells' pitching moment goes over its range.

    The forces of a glide, and with them speed, pitch and the moment that is missing, follow from its angle of attack
    alone. So the moments are those that hold angles of attack; which one the stops allow is known before.
    """
    problem = setter.problem
    low, high = setter.ends(1, (heave, 0.0, 0.0))
    middle = setter.extensions((heave, 0.5 * (low + high), 0.0))
    if abs(float(problem.rows(problem.rest(middle))[2])) <= LEAST_NET * problem.weight:
        return _none(middle, points, UNDRIVEN)
    at_middle = float(setter.reached(middle)[1])
    t = np.linspace(-1.0, 1.0, GRID + 1)
    alphas = 0.5 * math.pi * t**3
    found = problem.balanced_along(alphas, middle)
    pitch = np.array([math.remainder(angle, 2.0 * math.pi) for angle in found[:, 1]])
    upright = (np.abs(pitch) < STEEPEST) & (found[:, 3] < 1e-6)
    needed = at_middle - found[:, 2] / np.where(upright, np.cos(pitch), 1.0)
    slack = 1e-9 * max(abs(low), abs(high), 1e-300)
    within = np.flatnonzero(upright & (needed >= low - slack) & (needed <= high + slack))
    if not len(within):  # the stops leave one moment, or nearly so: the angles on either side of those that hold it
        above = needed > 0.5 * (low + high)
        within = np.flatnonzero((above[:-1] != above[1:]) & upright[:-1] & upright[1:])
    if not len(within):
        return _none(middle, points, OUT_OF_REACH)
    chosen = within[_evenly(found[within, 0], pitch[within] - alphas[within], points)]
    moments = np.clip(needed[chosen], low, high)
    seeds = np.zeros((len(chosen), EXTENSIONS + len(middle)))
    seeds[:, PITCH] = pitch[chosen]
    seeds[:, SURGE] = found[chosen, 0] * np.cos(alphas[chosen])
    seeds[:, HEAVE] = found[chosen, 0] * np.sin(alphas[chosen])
    seeds[:, EXTENSIONS:] = [setter.extensions((heave, moment, 0.0)) for moment in moments]
    met = _settled(problem, seeds)
    left = Counter({OUT_OF_REACH: points - len(chosen), NOT_FOUND: int((~met).sum())})
    return Swept(seeds[met], moments[met], {reason: count for reason, count in left.items() if count})


def _evenly(speed: Array, path: Array, points: int) -> NDArray[np.intp]:
    """Return the indices of points that lie evenly along the curve of vertical over horizontal speed."""
    steps = np.hypot(np.diff(speed * np.cos(path)), np.diff(speed * np.sin(path)))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    return np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], points) * (1.0 - 1e-12)))


def _none(extensions: Array, points: int, reason: str) -> Swept:
    return Swept(np.zeros((0, EXTENSIONS + len(extensions))), np.zeros(0), {reason: points})


def _settled(problem: SteadyProblem, seeds: Array) -> NDArray[np.bool_]:
    """Bring starts into balance in place, in the plane and then, where that is not enough, in space."""
    met = problem.newton(seeds, IN_PLANE, IN_PLANE_LOADS)
    if problem.spatial and met.any():
        tilted = np.flatnonzero(met)[~problem.lateral_balance(seeds[met])]
        moved = seeds[tilted]
        met[tilted] = problem.newton(moved, IN_SPACE, ALL_LOADS)
        seeds[tilted] = moved
    return met & (np.abs(seeds[:, PITCH]) < 0.5 * math.pi) & (seeds[:, SURGE] > 0.0)


def sweep_roll(setter: CellSetter, start: Array, heave: float, moment: float) -> list[Array]:
    """Return the turns to either side, from a straight glide, as the cells' rolling moment goes to its ends."""
    found = []
    for end in setter.ends(2, (heave, moment, 0.0)):
        s = start.copy()
        for step in range(1, TURN_STEPS + 1):
            s = s.copy()
            s[EXTENSIONS:] = setter.extensions((heave, moment, end * step / TURN_STEPS))
            if not setter.problem.newton(s[None, :], IN_SPACE, ALL_LOADS)[0] or abs(s[ROLL]) > 0.5 * math.pi:
                break
            if s[TURN] != 0.0 and s[SURGE] > 0.0:
                found.append(s)
    return found
