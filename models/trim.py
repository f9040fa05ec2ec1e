"""Owns trims: steady glides, turns and spirals of a design at given extensions, each marked stable or not.

In a trim only position and heading change. It is sought in still water at one depth: a uniform current would only
carry it along, and where density, pressure or compression change with depth it drifts slowly as depth does. World z is
down, body x to the nose, y to starboard, z through the keel; SI units and radians.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.design import Design, parse_design
from models.kernel.steady import EXTENSIONS, HEAVE, LOADS, PITCH, ROLL, ROWS, SURGE, SWAY, TURN
from models.mission import Control, Initial
from models.modes import NEUTRAL
from models.motion_growth import growth_of
from models.operating_point import down_in_body
from models.steady_problem import (
    LEAST_NET,
    SteadyProblem,
    assembly_of,
    steady_problem,
    upright,
)
from models.trim_search import DEGREES, Found, Search, search_motions

Array = NDArray[np.float64]
AXES = ROWS[:LOADS]
"""Axes of the loads out of balance: forces X, Y, Z (N), moments K, M, N (N m)."""
STRAIGHT = 1e-9
"""Slower turns than this count as none, rad/s: a turn in two hundred years."""


@dataclass(frozen=True, eq=False)
class Trim:
    """One steady motion.

    `extensions` by name, m (rad of a part that rolls); `roll`, `pitch` rad; `velocity` (3,) m/s of the body origin
    through the water in body axes; `turn_rate` rad/s about the vertical, to the right positive; `depth` m; `residual`
    what is left out of balance by axis, N and N m; `net_buoyancy` N, up positive; `growth` 1/s, the largest real part
    of the eigenvalues of small disturbances, with extensions and depth held.
    """

    extensions: Mapping[str, float]
    roll: float
    pitch: float
    velocity: Array
    turn_rate: float
    depth: float
    net_buoyancy: float
    residual: Mapping[str, float]
    growth: float

    @property
    def stable(self) -> bool:
        """Whether every small disturbance dies out, faster than rounding can tell (`models.modes.NEUTRAL`)."""
        return self.growth < -NEUTRAL

    @property
    def speed(self) -> float:
        """Speed through the water, m/s."""
        return math.hypot(*self.velocity)

    @property
    def sink_rate(self) -> float:
        """Vertical speed, down positive, m/s."""
        return float(down_in_body(self.roll, self.pitch) @ self.velocity)

    @property
    def horizontal_speed(self) -> float:
        """Speed over the ground in still water, m/s."""
        return math.sqrt(max(self.speed**2 - self.sink_rate**2, 0.0))

    @property
    def glide_angle(self) -> float:
        """Angle of the path to the horizon, climb positive, rad."""
        return -math.atan2(self.sink_rate, self.horizontal_speed)

    @property
    def angle_of_attack(self) -> float:
        """atan2(w, u), rad."""
        return math.atan2(self.velocity[2], self.velocity[0])

    @property
    def sideslip(self) -> float:
        """asin(v / V), rad."""
        return math.asin(max(-1.0, min(1.0, self.velocity[1] / self.speed)))

    @property
    def glide_ratio(self) -> float:
        """Horizontal way per change of depth, 1; infinite on a level path."""
        return self.horizontal_speed / abs(self.sink_rate) if self.sink_rate != 0.0 else math.inf

    @property
    def turn_radius(self) -> float | None:
        """Radius of the path over the ground, to the right positive, m; None where it is straight."""
        return self.horizontal_speed / self.turn_rate if abs(self.turn_rate) > STRAIGHT else None

    @property
    def kind(self) -> str:
        """`glide` where the path is straight, `spiral` where it turns."""
        return "glide" if self.turn_radius is None else "spiral"

    def as_initial(self) -> Initial:
        """Return the state in which a mission would start in this trim, heading north."""
        p, q, r = (self.turn_rate * down_in_body(self.roll, self.pitch)).tolist()
        u, v, w = (float(value) for value in self.velocity)
        return Initial(
            position=(0.0, 0.0, self.depth), roll=self.roll, pitch=self.pitch, velocity=(u, v, w),
            angular_velocity=(p, q, r), extensions=dict(self.extensions),
        )  # fmt: skip

    def __str__(self) -> str:
        turn = (
            ""
            if self.turn_radius is None
            else f", turning at {self.turn_rate:.4g} rad/s (radius {self.turn_radius:.4g} m)"
        )
        return (
            f"{self.kind} at {self.speed:.4g} m/s, path {self.glide_angle * DEGREES:+z.2f} deg, pitch "
            f"{self.pitch * DEGREES:+z.2f} deg, roll {self.roll * DEGREES:+z.2f} deg{turn}, "
            f"{'stable' if self.stable else 'unstable'}"
        )


@dataclass(frozen=True)
class RestAttitude:
    """How a glider that weighs what it displaces hangs at rest, rad; the moment that rights it is `stiffness` sin, N m.

    `stiffness` is the weight times the distance from the centre of buoyancy down to that of mass.
    """

    roll: float
    pitch: float
    stiffness: float


@dataclass(frozen=True)
class TrimSearch:
    """All trims found, the stable ones first, then by angle of attack from nose first; and in words what was searched.

    `net_buoyancy` N, up positive; `depth` where it was searched, m. `rest` stands in place of solutions where weight
    and buoyancy are equal: then nothing drives a glide.
    """

    solutions: tuple[Trim, ...]
    searched: str
    net_buoyancy: float
    depth: float
    rest: RestAttitude | None = None

    @property
    def stable(self) -> tuple[Trim, ...]:
        """The stable ones."""
        return tuple(trim for trim in self.solutions if trim.stable)


def find_trims(
    design: Design | Assembly, *, extensions: Mapping[str, float] | None = None, depth: float | None = None,
    search: Search | None = None,
) -> TrimSearch:  # fmt: skip
    """Return every steady motion that the search finds at given extensions (m or rad, by name) and a depth (m).

    Extensions that are not given are those with which the mission starts; a schedule may command others. The depth is
    by default the mission's first, made deep enough that all parts are immersed.

    Raises
    ------
    DesignError
        Where an extension names no part or lies beyond its stops, or the depth is not in open water.

    """
    problem = steady_problem(assembly_of(design), extensions=extensions, depth=depth)
    chosen = search or Search()
    if abs(problem.net_weight) <= LEAST_NET * problem.weight:
        rest = rest_attitude(problem)
        return TrimSearch((), _no_glide(problem, rest), -problem.net_weight, problem.depth, rest)
    found = search_motions(problem, chosen)
    trims = [trim_of(problem, motion) for motion in found.motions]
    trims.sort(key=lambda trim: (not trim.stable, trim.kind != "glide", abs(trim.angle_of_attack)))
    return TrimSearch(tuple(trims), _searched(problem, chosen, found), -problem.net_weight, problem.depth)


def trim_of(problem: SteadyProblem, motion: Array) -> Trim:
    """Return the trim of a motion, whether or not it is in balance."""
    s = upright(motion) if problem.spatial else motion.copy()
    s[PITCH] = math.remainder(s[PITCH], 2.0 * math.pi)
    residual = problem.rows(s)[:LOADS]
    still = s.copy()
    still[SURGE : HEAVE + 1], still[TURN] = 0.0, 0.0
    net = -float(problem.rows(still)[:3] @ down_in_body(s[ROLL], s[PITCH]))
    return Trim(
        extensions=dict(zip(problem.assembly.cells, s[EXTENSIONS:].tolist(), strict=True)),
        roll=float(s[ROLL]) + 0.0, pitch=float(s[PITCH]) + 0.0, velocity=s[[SURGE, SWAY, HEAVE]],
        turn_rate=float(s[TURN]), depth=problem.depth, net_buoyancy=net,
        residual=dict(zip(AXES, residual.tolist(), strict=True)), growth=growth_of(problem, s),
    )  # fmt: skip


def motion_of(trim: Trim) -> Array:
    """Return a trim as the kernel's motion, (unknowns,)."""
    u, v, w = trim.velocity
    return np.array([trim.roll, trim.pitch, u, v, w, trim.turn_rate, *trim.extensions.values()])


def design_from(trim: Trim, design: Design) -> Design:
    """Return the design with a mission that starts in the trim and holds its extensions: it stays in it.

    Raises
    ------
    DesignError
        Where the trim does not fit the design.

    """
    mission = design.mission.model_copy(update={"initial": trim.as_initial(), "control": Control()})
    return parse_design(design.model_copy(update={"mission": mission}).model_dump(mode="json"))


def rest_attitude(problem: SteadyProblem) -> RestAttitude:
    """Return the attitude in which moments vanish at rest and a small tilt is righted.

    The moment is g d x k with d = m r_G - sum rho V r_B and k the vector down, so that k points along d.
    """
    level, nose_down = problem.rest(problem.extensions), problem.rest(problem.extensions)
    nose_down[PITCH] = -0.5 * math.pi
    flat, steep = problem.rows(level), problem.rows(nose_down)
    x, y, z = -float(flat[4]), float(flat[3]), float(steep[4])
    if not problem.spatial:
        return RestAttitude(0.0, math.atan2(-x, z), math.hypot(x, z))
    return RestAttitude(math.atan2(y, z), math.atan2(-x, math.hypot(y, z)), math.hypot(x, y, z))


def _no_glide(problem: SteadyProblem, rest: RestAttitude) -> str:
    if rest.stiffness <= LEAST_NET * problem.weight:
        how = "any attitude, as both act at one point"
    else:
        roll = f" and roll {rest.roll * DEGREES:+z.2f} deg" if problem.spatial else ""
        how = f"pitch {rest.pitch * DEGREES:+z.2f} deg{roll}"
    return (
        f"at these extensions the glider weighs what it displaces (to {abs(problem.net_weight):.1e} N of "
        f"{problem.weight:.4g} N): there is no steady glide; at rest it hangs at {how}"
    )


def _searched(problem: SteadyProblem, search: Search, found: Found) -> str:
    words = (
        f"still water at {problem.depth:.4g} m; every {search.angle_step * DEGREES:g} deg of angle of attack all "
        f"around: the moment changes sign {found.straight[1]} times, {found.straight[0]} of them a straight glide"
    )
    if problem.spatial:
        banks = ", ".join(f"{bank * DEGREES:g}" for bank in search.banks)
        words += (
            f"; turns from each of those, banked by {banks} deg to either side: {found.turning[0]} of "
            f"{found.turning[1]} starts ended in a steady motion"
        )
    return words + "; others may exist between and beyond these starts"
