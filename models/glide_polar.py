"""Owns the glide polar: speed against glide angle at fixed buoyancy, the envelope over the strokes, its best points.

A curve belongs to one heave force of the cells (a change of net buoyancy from neutral, by `models.allocation`), its
points to pitching moments of theirs. The envelope is made of such curves, from a share of the stroke to the stops, on
dives and on climbs. Trims as in `models.trim`: still water, one depth; angles in rad, SI units.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from models.allocation import Effectiveness
from models.assemble import Assembly
from models.components import MovableMass, RollingMass
from models.design import Design
from models.kernel.steady import HEAVE, ROWS, SURGE, TURN
from models.polar_sweep import NO_AUTHORITY, CellSetter, Swept, sweep_pitch, sweep_roll
from models.problems import DesignError, Problem, pointer_to
from models.steady_problem import SteadyProblem, assembly_of, steady_problem
from models.trim import STRAIGHT, Trim, trim_of

Array = NDArray[np.float64]
MOST_POINTS = 2000
LEVELS = (0.25, 0.5, 0.75, 1.0)
"""Heave levels of the envelope, as shares of the largest heave to either side."""
GLIDING = math.radians(25.0)
"""A turn at a larger angle of attack is a stalled fall, tighter than any glide, and not counted as one, rad."""
TURNING_STARTS = 9
"""Glides of each curve that are rolled to find the tightest turn."""
CYCLE_DEPTH = 200.0
"""Depth of a dive cycle where none is stated, m; a shallower bed ends it there."""


@dataclass(frozen=True, eq=False)
class PolarCurve:
    """Trims at one heave force of the cells (N from neutral, up positive), by angle of attack.

    `moments` (points,) are the pitching moments of the cells, N m from neutral, nose up; `left_out` says how many
    points have no solution, and why.
    """

    heave: float
    points: tuple[Trim, ...]
    moments: Array
    left_out: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class EnergyPoint:
    """A trim and what a kilometre takes from the battery in it, J: by the hotel load, and by pumping."""

    trim: Trim
    hotel: float
    pump: float

    @property
    def per_km(self) -> float:
        """Energy per kilometre of horizontal way, J/km."""
        return self.hotel + self.pump


@dataclass(frozen=True, eq=False)
class GlidePolar:
    """Curves and the best points on them; of each, stable trims are taken before unstable ones.

    `best_range` has the flattest path, `slowest_sink` the least vertical speed of the dives of all levels,
    `best_energy` the least energy per kilometre, `tightest_turn` the smallest radius as the cells' rolling moment goes
    to its stops, up to `GLIDING` of attack (None without any, and for a planar design); `best_energy` is None too where
    all sink upright. `energy` says in words what the bill assumes.
    """

    cells: tuple[str, ...]
    curves: tuple[PolarCurve, ...]
    best_range: Trim | None
    best_energy: EnergyPoint | None
    slowest_sink: Trim | None
    tightest_turn: Trim | None
    cycle_depth: float
    energy: str

    @property
    def points(self) -> tuple[Trim, ...]:
        """The trims of all curves."""
        return tuple(chain.from_iterable(curve.points for curve in self.curves))

    @property
    def left_out(self) -> dict[str, int]:
        """How many points of all curves have no solution, by reason."""
        total: Counter[str] = Counter()
        for curve in self.curves:
            total.update(curve.left_out)
        return dict(total)


def polar_curve(
    design: Design | Assembly, heave: float, *, points: int = 50, cells: Sequence[str] | None = None,
    extensions: Mapping[str, float] | None = None, depth: float | None = None,
) -> PolarCurve:  # fmt: skip
    """Return one curve: the chosen cells (all that move, if none are) make `heave` (N from neutral) and any moment.

    The other cells stay at given extensions (m or rad, by name), or as the mission starts.

    Raises
    ------
    DesignError
        Where a cell, an extension, the depth or the number of points is not what it may be.

    """
    setter = _setter(design, cells, extensions, depth, points)
    return _curve(setter, heave, points)[0]


def glide_polar(
    design: Design | Assembly, *, points: int = 50, cells: Sequence[str] | None = None,
    cycle_depth: float | None = None, levels: Sequence[float] = LEVELS,
    extensions: Mapping[str, float] | None = None, depth: float | None = None,
) -> GlidePolar:  # fmt: skip
    """Return the envelope: curves of `points` trims at each level of heave, down and up, and the best points.

    Energy per kilometre is that of a symmetric dive cycle to `cycle_depth` (m): a dive and a climb on the same path
    angle with opposite net buoyancy B, hence one pump stroke of the volume 2 |B| / (rho g) against the gauge pressure
    at that depth, over 2 cycle_depth / tan |gamma| of way:

        E / way = P_hotel / (V cos gamma) + p |B| tan |gamma| / (eta rho g cycle_depth)

    eta is the mean efficiency of the chosen cells by what their strokes displace; what moving masses take is left out.
    `levels` are shares of the largest heave to either side; without authority in heave there is one curve, at the given
    net weight.

    Raises
    ------
    DesignError
        Where a cell, an extension, a depth, a level or the number of points is not what it may be.

    """
    setter = _setter(design, cells, extensions, depth, points)
    problem = setter.problem
    below = _cycle_depth(problem, cycle_depth)
    found = [_curve(setter, heave, points) for heave in _heaves(setter, levels)]
    curves = tuple(curve for curve, _ in found)
    trims = tuple(chain.from_iterable(curve.points for curve in curves))
    bill = _bill(problem, setter.cells, below)
    under_way = [trim for trim in trims if math.isfinite(bill(trim).per_km)]  # who sinks upright gets nowhere
    cheapest = _best(under_way, lambda trim: bill(trim).per_km)
    return GlidePolar(
        setter.cells.cells, curves,
        best_range=_best(trims, lambda trim: abs(trim.glide_angle)),
        best_energy=None if cheapest is None else bill(cheapest),
        slowest_sink=_best([t for t in trims if t.sink_rate > 0.0] or trims, lambda trim: abs(trim.sink_rate)),
        tightest_turn=_tightest_turn(setter, found), cycle_depth=below, energy=_assumed(problem, setter.cells, below),
    )  # fmt: skip


def _setter(
    design: Design | Assembly, cells: Sequence[str] | None, extensions: Mapping[str, float] | None,
    depth: float | None, points: int,
) -> CellSetter:  # fmt: skip
    """Return what sets the cells, after the checks."""
    assembly = assembly_of(design)
    problems = []
    if not 2 <= points <= MOST_POINTS:
        limit = 2 if points < 2 else MOST_POINTS
        problems.append(
            Problem("/options/points", f"{points} points a curve are not within 2 to {MOST_POINTS}", limit=limit)
        )
    for i, name in enumerate(cells or ()):
        if name not in assembly.cells:
            known = ", ".join(f"'{cell}'" for cell in assembly.cells) or "none"
            message = f"no component that moves is named '{name}'"
            problems.append(Problem(pointer_to("options", "cells", i), message, hint=f"those are: {known}"))
        elif name in (cells or ())[:i]:
            problems.append(Problem(pointer_to("options", "cells", i), f"'{name}' is named twice", hint="name it once"))
    if problems:
        raise DesignError(problems)
    return CellSetter(steady_problem(assembly, extensions=extensions, depth=depth), cells)


def _cycle_depth(problem: SteadyProblem, depth: float | None) -> float:
    """Return the depth of a cycle, m: as stated, or the usual one; above the bed."""
    bed = problem.assembly.design.mission.environment.bed_depth
    if depth is None:
        return min(CYCLE_DEPTH, bed or math.inf)
    if not 0.0 < depth <= (bed or 2e4):
        limit = 0.0 if not depth > 0.0 else (bed or 2e4)
        message = f"a cycle to {depth:g} m is not within 0 and {bed or 2e4:g} m"
        raise DesignError([Problem("/options/cycle_depth", message, limit=limit, hint="stay above the bed")])
    return depth


def _heaves(setter: CellSetter, levels: Sequence[float]) -> list[float]:
    """Return the heave forces of the envelope's curves, N from neutral: dives, deepest first, then climbs."""
    for i, level in enumerate(levels):
        if not 0.0 < level <= 1.0:
            message = f"a level of {level:g} is not above 0 and at most 1"
            raise DesignError([Problem(f"/options/levels/{i}", message, limit=1.0, hint="1 is at the stops")])
    low, high = setter.heave_ends()
    least = NO_AUTHORITY * setter.problem.weight
    down = [level * low for level in sorted(levels, reverse=True)] if low < -least else []
    up = [level * high for level in sorted(levels)] if high > least else []
    return [*down, *up] or [0.0]


def _curve(setter: CellSetter, heave: float, points: int) -> tuple[PolarCurve, Swept]:
    """Return one curve, and its motions."""
    swept = sweep_pitch(setter, heave, points)
    trims = tuple(trim_of(setter.problem, s) for s in swept.motions)
    return PolarCurve(heave, trims, swept.moments, swept.left_out), swept


def _best(trims: Sequence[Trim], cost: Callable[[Trim], float]) -> Trim | None:
    """Return the trim of the least cost, a stable one if there is any."""
    return min(trims, key=lambda trim: (not trim.stable, cost(trim)), default=None)


def _bill(problem: SteadyProblem, cells: Effectiveness, depth: float) -> Callable[[Trim], EnergyPoint]:
    """Return what prices a trim."""
    pressure, density = gauge_pressure(problem, depth), density_here(problem)
    gravity = float(problem.params.space[0]["gravity"])
    hotel, efficiency = problem.assembly.design.vehicle.hotel_power, mean_efficiency(problem, cells)

    def bill(trim: Trim) -> EnergyPoint:
        per_second = hotel / trim.horizontal_speed if trim.horizontal_speed > 0.0 else math.inf
        slope = 1.0 / trim.glide_ratio if trim.glide_ratio > 0.0 else math.inf
        pumped = abs(trim.net_buoyancy) / (density * gravity) if gravity > 0.0 else 0.0
        return EnergyPoint(trim, 1e3 * per_second, 1e3 * pressure * pumped * slope / (efficiency * depth))

    return bill


def _assumed(problem: SteadyProblem, cells: Effectiveness, depth: float) -> str:
    pressure, efficiency = gauge_pressure(problem, depth), mean_efficiency(problem, cells)
    return (
        f"per kilometre of a symmetric dive cycle to {depth:g} m: hotel load "
        f"{problem.assembly.design.vehicle.hotel_power:g} W over the horizontal speed, and one pump stroke a cycle "
        f"against {pressure / 1e5:.3g} bar at an efficiency of {efficiency:.3g}"
    )


def mean_efficiency(problem: SteadyProblem, cells: Effectiveness) -> float:
    """Return the mean efficiency of the cells that displace water, by what their strokes do in heave."""
    parts = [part for _, part in problem.assembly.design.vehicle.actuated]
    weights = np.abs(cells.matrix[0]) * cells.span
    efficiencies = np.array([parts[i].efficiency for i in cells.parts])
    displacing = np.array([not isinstance(parts[i], MovableMass | RollingMass) for i in cells.parts], dtype=bool)
    weights = np.where(displacing, weights, 0.0)
    return float(weights @ efficiencies / weights.sum()) if weights.sum() > 0.0 else 1.0


def density_here(problem: SteadyProblem) -> float:
    """Return the density at the depth of the trims, kg/m3."""
    return _water(problem, problem.depth)[0]


def gauge_pressure(problem: SteadyProblem, depth: float) -> float:
    """Return the gauge pressure at a depth, Pa."""
    return _water(problem, depth)[1]


def _water(problem: SteadyProblem, depth: float) -> tuple[float, float]:
    """Return density and gauge pressure at a depth by the table of the run: cubics, and their integral."""
    p, space = problem.params, problem.params.space[0]
    k = math.floor((depth - float(space["water_top"])) * float(space["per_spacing"])) + 1
    z, *c, pressure = (float(value) for value in p.water[min(max(k, 0), len(p.water) - 1)])
    h = depth - z
    density = sum(a * h**n for n, a in enumerate(c))
    return density, pressure + float(space["gravity"]) * sum(a * h ** (n + 1) / (n + 1) for n, a in enumerate(c))


def _tightest_turn(setter: CellSetter, found: Sequence[tuple[PolarCurve, Swept]]) -> Trim | None:
    """Return the turn of the smallest radius from some glides of every curve, the flattest to the steepest."""
    problem = setter.problem
    low, high = setter.ends(2, (0.0, 0.0, 0.0))
    if not problem.spatial or high - low <= NO_AUTHORITY * problem.weight:
        return None
    turns: list[Array] = []
    for curve, swept in found:
        order = sorted(range(len(curve.points)), key=lambda i: abs(curve.points[i].glide_angle))
        chosen = np.linspace(0, len(order) - 1, min(TURNING_STARTS, len(order))).round().astype(int)
        for i in {order[k] for k in chosen}:
            turns += sweep_roll(setter, swept.motions[i], curve.heave, float(swept.moments[i]))
    gliding = (s for s in turns if abs(s[TURN]) > STRAIGHT and abs(math.atan2(s[HEAVE], s[SURGE])) <= GLIDING)
    tightest = sorted(gliding, key=lambda s: _radius(problem, s))
    for s in tightest:
        if (trim := trim_of(problem, s)).stable:
            return trim
    return trim_of(problem, tightest[0]) if tightest else None


def _radius(problem: SteadyProblem, s: Array) -> float:
    """Return the radius of a turn over the ground, m."""
    return 1.0 / abs(float(problem.rows(s)[ROWS.index("curvature")]))
