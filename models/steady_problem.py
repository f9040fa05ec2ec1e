"""Owns the numbers in which steady motions of one assembly are sought: constants, scales, scratch, calls of the kernel.

A motion is an array s = [roll, pitch, u, v, w, turn rate, e_1 ... e_n] as in `models.kernel.steady`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.checks import extension_problems
from models.design import Design
from models.kernel import steady
from models.kernel.params import Params
from models.kernel.steady import EXTENSIONS, HEAVE, LOADS, PITCH, ROLL, ROWS, SURGE, SWAY, TURN, SteadyWork
from models.mass_properties import initial_extensions
from models.problems import DesignError
from models.still_water import in_still_water, trim_depth

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
IN_PLANE: Indices = np.array([PITCH, SURGE, HEAVE])
"""Unknowns of a straight glide without roll or sideslip."""
IN_PLANE_LOADS: Indices = np.array([0, 2, 4])
LATERAL_LOADS: Indices = np.array([1, 3, 5])
IN_SPACE: Indices = np.arange(6)
ALL_LOADS: Indices = np.arange(LOADS)
TOLERANCE = 1e-14
"""What Newton's method aims at, in units of the weight (and of the weight times the size, of moments)."""
BALANCED = 1e-11
"""Loads below this share of the weight count as balanced: a hundred times what rounding leaves."""
LEAST_NET = 1e-8
"""Below this share of the weight, weight less buoyancy is none: what is left moves a glider by millimetres a second."""
STEP = 1e-6
"""Step of the differences in angles (rad), velocities (m/s) and turn rate (rad/s)."""
STROKE_STEP = 1e-5
"""Step in extension, as a share of the stroke."""
LONGEST_ANGLE = 0.3
"""Longest change of an angle in one iteration, rad."""
LONGEST_TURN = 0.1
"""Longest change of the turn rate in one iteration, rad/s."""
SLOWEST = 1e-6
"""Slower than this is no steady glide, m/s."""


@dataclass(frozen=True, eq=False)
class SteadyProblem:
    """An assembly in still water at a depth (m), with given extensions (parts,) and the scales of what is sought.

    `weight` is m g (N) and `net_weight` what buoyancy leaves of it (N, down positive) at the given extensions; `scale`
    (rows,) what 1 means in each row of the kernel; `steps` (unknowns,) are those of the differences.
    """

    assembly: Assembly
    params: Params
    depth: float
    extensions: Array
    weight: float
    net_weight: float
    spatial: bool
    scale: Array
    steps: Array
    low: Array
    high: Array
    work: SteadyWork

    @property
    def motion_unknowns(self) -> Indices:
        """Unknowns of any steady motion of this model."""
        return IN_SPACE if self.spatial else IN_PLANE

    @property
    def load_rows(self) -> Indices:
        """Rows that a steady motion of this model has to balance."""
        return ALL_LOADS if self.spatial else IN_PLANE_LOADS

    def rest(self, extensions: Array) -> Array:
        """Return the motion without motion: level, at the given extensions."""
        return np.concatenate([np.zeros(EXTENSIONS), extensions])

    def rows(self, motion: Array) -> Array:
        """Return the rows of a motion, (rows,)."""
        f = np.zeros(len(ROWS))
        steady.steady_rows(motion, self.depth, self.work.y, self.params, f)
        return f

    def slopes(self, motion: Array, steps: Array) -> tuple[Array, Array]:
        """Return the rows of a motion, and their slopes (rows, unknowns); columns without a step are zero."""
        self.work.slope[:] = 0.0
        steady.steady_slopes(motion, steps, self.depth, self.params, self.work)
        return self.work.f.copy(), self.work.slope.copy()

    def longest(self, speed: float) -> Array:
        """Return the longest change of each unknown in one iteration, for motions of about a speed (m/s)."""
        longest = np.full(len(self.steps), LONGEST_ANGLE)
        longest[SURGE : HEAVE + 1] = max(0.5 * speed, 1e-3)
        longest[TURN] = LONGEST_TURN
        longest[EXTENSIONS:] = 0.2 * (self.high - self.low)
        return longest

    def newton(
        self, seeds: Array, unknowns: Indices, rows: Indices, *, wanted: Array | None = None, speed: float | None = None
    ) -> NDArray[np.bool_]:
        """Move the chosen unknowns of every seed (m, unknowns) in place; return which converged, (m,)."""
        if not len(seeds):
            return np.zeros(0, dtype=bool)
        if speed is None:
            speed = float(np.linalg.norm(seeds[:, SURGE : HEAVE + 1], axis=1).max())
        steps = np.zeros(len(self.steps))
        steps[unknowns] = self.steps[unknowns]
        codes, left = np.zeros(len(seeds), dtype=np.int64), np.zeros(len(seeds))
        steady.newton_from_each(
            seeds, steps, self.longest(speed), unknowns, rows, np.zeros(len(ROWS)) if wanted is None else wanted,
            self.scale, TOLERANCE, self.depth, self.params, self.work, codes, left,
        )  # fmt: skip
        moving = np.linalg.norm(seeds[:, SURGE : HEAVE + 1], axis=1) > SLOWEST
        return np.asarray((codes == steady.CONVERGED) & (left < BALANCED) & moving, dtype=bool)

    def balanced_along(self, alphas: Array, extensions: Array) -> Array:
        """Return speed, pitch, moment left and share of the net weight left at each angle of attack, (alphas, 4)."""
        found = np.zeros((len(alphas), 4))
        steady.balance_along(alphas, self.rest(extensions), self.depth, self.params, self.work, found)
        return found

    def lateral_balance(self, motions: Array) -> NDArray[np.bool_]:
        """Return which of the motions (m, unknowns) leave no side force, roll and yaw moment."""
        if not self.spatial:
            return np.ones(len(motions), dtype=bool)
        left = [np.abs(self.rows(s)[LATERAL_LOADS] / self.scale[LATERAL_LOADS]).max() for s in motions]
        return np.array(left) < BALANCED


def assembly_of(design: Design | Assembly) -> Assembly:
    """Return the assembly of a design, or the one given."""
    return design if isinstance(design, Assembly) else assemble(design)


def steady_problem(
    assembly: Assembly, *, extensions: Mapping[str, float] | None = None, depth: float | None = None
) -> SteadyProblem:
    """Return the problem at given extensions (m or rad, by name; others as the mission starts) and a depth (m).

    Raises
    ------
    DesignError
        Where an extension names no part or lies beyond its stops, or the depth is not in open water.

    """
    design = assembly.design
    problems = list(extension_problems(design, extensions or {}, "/options/extensions"))
    if problems:
        raise DesignError(problems)
    chosen = initial_extensions(design) | dict(extensions or {})
    params, at = in_still_water(assembly.params), trim_depth(design, depth)
    e = np.array([chosen[name] for name in assembly.cells], dtype=np.float64)
    space = params.space[0]
    weight = float(space["mass"] * space["gravity"])
    low, high = params.parts["stop_low"].copy(), params.parts["stop_high"].copy()
    size = max(0.05, *(math.hypot(*c.position) for c in design.vehicle.components))
    scale = np.ones(len(ROWS))
    scale[:3], scale[3:6] = weight or 1.0, size * weight or 1.0
    steps = np.concatenate([np.full(EXTENSIONS, STEP), STROKE_STEP * (high - low)])
    work = steady.make_steady_work(len(assembly.initial_state), len(e))
    rest, f = np.concatenate([np.zeros(EXTENSIONS), e]), np.zeros(len(ROWS))
    steady.steady_rows(rest, at, work.y, params, f)
    return SteadyProblem(
        assembly, params, at, np.clip(e, low, high), weight, float(f[2]), bool(space["spatial"]), scale, steps, low,
        high, work,
    )  # fmt: skip


def upright(motion: Array) -> Array:
    """Return the same motion with its pitch within 90 deg of level and its roll within a half turn."""
    s = motion.copy()
    s[PITCH] = math.remainder(s[PITCH], 2.0 * math.pi)
    if abs(s[PITCH]) > 0.5 * math.pi:
        s[PITCH] = math.copysign(math.pi, s[PITCH]) - s[PITCH]
        s[ROLL] += math.pi
    s[ROLL] = math.remainder(s[ROLL], 2.0 * math.pi)
    return s


def speed_of(motion: Array) -> float:
    """Return the speed through the water, m/s."""
    return math.sqrt(motion[SURGE] ** 2 + motion[SWAY] ** 2 + motion[HEAVE] ** 2)
