"""Owns trims with targets: the extensions of free cells for a wanted motion, or what keeps them from it, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.bounded_motion import BoundedSearch, off_target, typical_speed
from models.components import extension_unit
from models.design import Design
from models.kernel.steady import EXTENSIONS, LOADS, ROLL, ROWS, SWAY, TURN
from models.problems import DesignError, Problem, pointer_to
from models.steady_problem import (
    BALANCED,
    IN_PLANE,
    IN_PLANE_LOADS,
    IN_SPACE,
    SLOWEST,
    SteadyProblem,
    assembly_of,
    speed_of,
    steady_problem,
    upright,
)
from models.trim import AXES, STRAIGHT, Trim, trim_of
from models.trim_search import DEGREES
from models.trim_targets import (
    TURN_ROW,
    UNITS,
    USUAL_PATH,
    Targets,
    distance_in_strokes,
    driven,
    starts_for,
    targets_of,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
MET = 1e-9
"""A target counts as met within this (rad, m/s, rad/s; of a radius as a share)."""
AT_STOP = 1e-6
"""An extension within this share of its stroke from a stop is at it."""
NOT_TOLD = 1e-3
"""Loads below this share of the largest are left out of the words."""
AT_ONCE = 2
"""How many starts go to Newton's method together."""


@dataclass(frozen=True, slots=True)
class ActiveBound:
    """A cell at a stop: `stop` is `lower` or `upper`, `extension` where that is, m (rad of a part that rolls)."""

    cell: str
    stop: str
    extension: float
    unit: str

    def __str__(self) -> str:
        shown = f"{self.extension * 1e3:z.4g} mm" if self.unit == "m" else f"{self.extension * DEGREES:z.4g} deg"
        return f"'{self.cell}' is at its {self.stop} stop, {shown}"


@dataclass(frozen=True, slots=True)
class Missed:
    """A target that is not met: what was wanted and what the nearest motion reaches, in `UNITS`."""

    target: str
    wanted: float
    reached: float

    def __str__(self) -> str:
        words = self.target.replace("_", " ")
        unit, factor = UNITS[self.target], 1.0
        if unit.startswith("rad"):
            unit, factor = unit.replace("rad", "deg"), DEGREES
        reached = self.reached * factor if abs(self.reached) > MET else 0.0  # below is rounding, of either sign
        wanted = self.wanted * factor
        digits = 4 if f"{reached:.4g}" != f"{wanted:.4g}" else 9
        return f"{words} {reached:+z.{digits}g} {unit} in place of {wanted:+z.{digits}g}"


@dataclass(frozen=True, eq=False)
class TrimFailure:
    """Why no trim meets the targets.

    `nearest` is the steady motion within the stops that misses them least (scaled by what is wanted), or None where
    none was found; `missed` what it misses, `active` which free cells are at a stop in it. `residual` is what would be
    out of balance by axis (N, N m) were the targets held with the extensions that come nearest to that.
    """

    residual: Mapping[str, float]
    missed: tuple[Missed, ...]
    active: tuple[ActiveBound, ...]
    nearest: Trim | None
    why: str

    def __str__(self) -> str:
        least = NOT_TOLD * max(map(abs, self.residual.values()))
        left = ", ".join(
            f"{axis} {value:+.3g} {'N' if axis in 'XYZ' else 'N m'}"
            for axis, value in self.residual.items() if abs(value) > least
        )  # fmt: skip
        parts = [self.why, *map(str, self.active)]
        if left:
            parts.append(f"with the targets held there would be left {left}")
        if self.nearest is not None:
            parts.append(f"the nearest steady motion is a {self.nearest} with {', '.join(map(str, self.missed))}")
        return "; ".join(parts)


def trim_for(
    design: Design | Assembly, targets: Mapping[str, float], free: Sequence[str], *,
    extensions: Mapping[str, float] | None = None, depth: float | None = None,
) -> Trim | TrimFailure:  # fmt: skip
    """Return a steady motion that meets targets by moving the free cells, the others staying at given extensions.

    Targets are any of glide_angle (rad, climb positive), speed, sink_rate (m/s), turn_rate (rad/s), pitch, roll (rad)
    and turn_radius (m), the last and the turn rate positive to the right; without one of a turn the trim is straight.
    Extensions (m or rad, by name) that are not given are those with which the mission starts. Of several trims a stable
    one is taken before an unstable one, and then the one with the extensions nearest to the given ones, in strokes.
    Where no speed or sink rate is wanted and the given ones drive it with less than a quarter of the net weight that
    the free cells could add (or the other way), it is the nearest to those that have half of what can be had: nearer
    ones would crawl.

    Raises
    ------
    DesignError
        Where a target, a cell, an extension or the depth is not what it may be. That no trim meets the targets is told
        by the `TrimFailure`.

    """
    assembly = assembly_of(design)
    cells = _free_indices(assembly.cells, free)
    problem = steady_problem(assembly, extensions=extensions, depth=depth)
    wish = targets_of(targets, spatial=problem.spatial)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of trials that run away, and are not taken
        search = _TargetSearch(problem, wish, cells)
        found = search.best() or _on_usual_path(problem, wish, cells)
        return found if found is not None else search.failure()


def _on_usual_path(problem: SteadyProblem, wish: Targets, free: Indices) -> Trim | None:
    """Return a trim that meets the targets and glides at the usual angle, where they say nothing of how steep.

    Held to a path, a search gets on where it stalls without: what is wanted then has more than one way.
    """
    if len(free) <= len(wish.rows) or {"glide_angle", "sink_rate", "pitch"} & set(wish.values):
        return None
    for path in (-USUAL_PATH, USUAL_PATH):
        try:
            steeper = targets_of({**wish.values, "glide_angle": path}, spatial=problem.spatial)
        except DesignError:  # speed, turn rate and radius together leave another path
            return None
        found = _TargetSearch(problem, steeper, free).best()
        if found is not None:
            return found
    return None


def check_wish(design: Design, targets: Mapping[str, float], free: Sequence[str]) -> None:
    """Raise `DesignError` where a target or a free cell of `trim_for` is not what it may be."""
    _free_indices([part.name for _, part in design.vehicle.actuated], free)
    targets_of(targets, spatial=design.mission.solver.model == "spatial")


def _free_indices(cells: Sequence[str], free: Sequence[str]) -> Indices:
    """Return the indices of the free cells among the unknowns."""
    problems = []
    if not free:
        problems.append(Problem("/options/free", "no cell is free to move", hint="name one for each target"))
    for i, name in enumerate(free):
        at = pointer_to("options", "free", i)
        if name not in cells:
            known = ", ".join(f"'{cell}'" for cell in cells) or "none"
            problems.append(Problem(at, f"no component that moves is named '{name}'", hint=f"those are: {known}"))
        elif name in free[:i]:
            problems.append(Problem(at, f"'{name}' is named twice", hint="name it once"))
    if problems:
        raise DesignError(problems)
    return np.array([EXTENSIONS + cells.index(name) for name in free], dtype=np.int64)


class _TargetSearch:
    """One search: from every start by Newton's method where unknowns and rows are as many, then within the stops."""

    def __init__(self, problem: SteadyProblem, wish: Targets, free: Indices) -> None:
        given, problem = problem, driven(problem, free, wish)
        self.problem, self.wish, self.free = problem, wish, free
        self.starts = starts_for(problem, wish, at_hand_first=problem is given)
        self.reached: list[tuple[float, Array]] = []
        rows = [*problem.load_rows, *wish.rows]
        if wish.straight:
            rows.append(TURN_ROW)
        self.rows = np.array(rows, dtype=np.int64)
        scale = wish.scale.copy()
        driven_by = abs(problem.net_weight) / problem.weight if problem.weight > 0.0 else 1.0
        scale[:LOADS] = problem.scale[:LOADS] * max(driven_by, 1e-3)
        self.bounded = BoundedSearch(
            problem, self.rows, free, wanted=wish.wanted, scale=scale, speed=typical_speed(self.starts)
        )

    def best(self) -> Trim | None:
        """Return the trim to take, or None."""
        weighed: list[Trim] = []
        if len(self.free) == len(self.wish.rows):
            weighed = self._by_newton()
        if not any(trim.stable for trim in weighed) and len(self.free) >= len(self.wish.rows):
            for trim in self._within_stops():
                weighed.append(trim)
                if trim.stable:
                    break
        return min(weighed, key=lambda trim: not trim.stable, default=None)

    def _by_newton(self) -> list[Trim]:
        """Return trims from the kernel's Newton method, stable and near ones first, straight ones in the plane.

        Starts go in groups, until one of them has led to a stable trim.
        """
        straight = self.wish.straight or not self.problem.spatial
        motion, loads = (IN_PLANE, IN_PLANE_LOADS) if straight else (IN_SPACE, np.arange(LOADS))
        unknowns, rows = np.concatenate([motion, self.free]), np.concatenate([loads, self.wish.rows])
        trims: list[Trim] = []
        for first in range(0, len(self.starts), AT_ONCE):
            seeds = self.starts[first : first + AT_ONCE].copy()
            met = self.problem.newton(seeds, unknowns, rows, wanted=self.wish.wanted)
            held = [s for s in seeds[met] if self._within(s)]
            held.sort(key=lambda s: distance_in_strokes(self.problem, s))
            trims += [trim_of(self.problem, s) for s in _without_repetitions(held)]
            if any(trim.stable for trim in trims):
                break
        return sorted(trims, key=lambda trim: not trim.stable)

    def _within_stops(self) -> Iterator[Trim]:
        """Yield trims that Newton's method within the stops leads to, start by start."""
        for start in self.starts:
            s, size = self.bounded.solve(start)
            self.reached.append((size, s))
            if self._within(s):
                yield trim_of(self.problem, s)

    def _within(self, s: Array) -> bool:
        """Whether a motion is a trim that meets the targets within the stops."""
        p = self.problem
        if p.spatial:
            s[:] = upright(s)  # as the trim will be: past the vertical, roll is another
        stroke = p.high - p.low
        e = s[EXTENSIONS:]
        if not np.all(np.isfinite(s)) or speed_of(s) < SLOWEST:
            return False
        if np.any(e < p.low - 1e-12 * stroke) or np.any(e > p.high + 1e-12 * stroke):
            return False
        s[EXTENSIONS:] = np.clip(e, p.low, p.high)
        if self.wish.straight and p.spatial:
            _straighten(p, s)
        f = p.rows(s)
        loads = np.abs(f[p.load_rows] / p.scale[p.load_rows]).max()
        off = np.abs(
            off_target(f, self.wish.wanted)[self.wish.rows] / np.minimum(1.0, self.wish.scale[self.wish.rows])
        ).max()
        turns = self.wish.straight and abs(s[TURN]) > STRAIGHT
        return bool(loads < 10.0 * BALANCED and off < MET and not turns)

    def failure(self) -> Trim | TrimFailure:
        """Return what keeps the targets from being met; or a trim, should the careful search find one after all."""
        if not self.reached:
            self.reached = [self.bounded.solve(start)[::-1] for start in self.starts]
        self.reached = sorted((item for item in self.reached if np.isfinite(item[0])), key=lambda item: item[0])
        if not self.reached:
            left = self.problem.rows(self.problem.rest(self.problem.extensions))[:LOADS]
            return TrimFailure(dict(zip(AXES, left.tolist(), strict=True)), (), (), None, self._why(None))
        loads = np.isin(self.rows, self.problem.load_rows)
        held, nearest = self.reached[0][1], None
        least = np.inf
        for _size, start in self.reached[:3]:
            s = self.bounded.nearest(start, loads)[None, :]
            if self.problem.newton(s, self.problem.motion_unknowns, self.problem.load_rows)[0]:
                s[0] = upright(s[0]) if self.problem.spatial else s[0]
                missed = float(np.linalg.norm(self.bounded.misfit(s[0])))
                if missed < least:
                    nearest, least = s[0], missed
        if nearest is not None:
            polished, _size = self.bounded.solve(nearest)
            if self._within(polished):
                return trim_of(self.problem, polished)
        left = self.problem.rows(self.bounded.nearest(held, ~loads))[:LOADS]
        trim = None if nearest is None else trim_of(self.problem, nearest)
        return TrimFailure(
            dict(zip(AXES, left.tolist(), strict=True)), tuple(self._missed(nearest)),
            tuple(self._active(held if nearest is None else nearest)), trim, self._why(nearest),
        )  # fmt: skip

    def _missed(self, motion: Array | None) -> Iterator[Missed]:
        """Yield the targets that a motion misses."""
        if motion is None:
            return
        f = self.problem.rows(motion)
        values = dict(self.wish.values)
        if self.wish.straight:
            values["turn_rate"] = 0.0
        for name, wanted in values.items():
            curvature = f[ROWS.index("curvature")]
            got = f[ROWS.index(name)] if name != "turn_radius" else (1.0 / curvature if curvature else np.inf)
            away = math.remainder(got - wanted, math.tau) if name in ("pitch", "roll") else got - wanted
            if not abs(away) <= MET * (max(1.0, abs(wanted)) if name == "turn_radius" else 1.0):
                yield Missed(name, float(wanted), float(got))

    def _active(self, motion: Array) -> Iterator[ActiveBound]:
        """Yield the free cells that a motion has at a stop."""
        parts = [part for _, part in self.problem.assembly.design.vehicle.actuated]
        for index in self.free - EXTENSIONS:
            low, high, e = self.problem.low[index], self.problem.high[index], motion[EXTENSIONS + index]
            for stop, at in (("lower", low), ("upper", high)):
                if abs(e - at) <= AT_STOP * (high - low):
                    yield ActiveBound(self.problem.assembly.cells[index], stop, float(at), extension_unit(parts[index]))

    def _why(self, motion: Array | None) -> str:
        if motion is None:
            return "no steady motion within the stops was found"
        if any(self._active(motion)):
            return "the stops do not allow it"
        wanted = [name.replace("_", " ") for name in self.wish.values] + ["no turn"] * self.wish.straight
        if len(self.free) < len(wanted):
            return f"as many free cells ({len(self.free)}) cannot meet {len(wanted)} conditions ({', '.join(wanted)})"
        return "lift and drag do not allow it, or the free cells do not act on all that is wanted"


def _straighten(problem: SteadyProblem, s: Array) -> None:
    """Take what rounding left of roll, sideslip and turn out of a motion, if it stays balanced without."""
    straight = s.copy()
    straight[[ROLL, SWAY, TURN]] = 0.0
    if np.abs(straight - s).max() < 1e-6 and problem.lateral_balance(straight[None, :])[0]:
        s[:] = straight


def _without_repetitions(motions: list[Array]) -> list[Array]:
    kept: list[Array] = []
    for s in motions:
        if not any(np.allclose(s, other, rtol=1e-7, atol=1e-9) for other in kept):
            kept.append(s)
    return kept
