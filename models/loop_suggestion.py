"""Owns first gains for guidance and loops (`Cascade`), computed from the linear model about a glide.

Each axis is taken as J a'' + D a' + S a = M: J, with added inertia, from the angular acceleration that a moment shared
among the cells makes; S and D, hydrostatic and hydrodynamic, from the slopes of that acceleration over angle and rate.
The angle shall answer with w (rad/s), and its integral over some 1 / (c w), c of 0.1 or 0.2:

    D <= 1.6 J w:  k_p = J w^2 - S,  k_d = 1.6 J w - D   (two poles of natural frequency w and damping 0.8)
    D >  1.6 J w:  k_p = D w - J w^2 - S,  k_d = 0       (water damps it more: its slow pole at -w)
    k_p not below 0,  k_i = c w (S + k_p).

w is at most that at which lag, delay and half a sample cost 0.4 rad of phase, and at which a step of 0.1 rad asks the
cells for a quarter of their stroke, and within 1 / w for their rate. A bank for a heading error is k_psi = 1 / (G t), G
being the turn rate that a bank makes in steady flow. Of w, c and t those are taken with which the sampled linear loop
with all states settles fastest, while it is damped by 0.25 and stable at twice the gains. SI units and radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from models.allocation import AXES, Effectiveness, authority, effectiveness
from models.assemble import Assembly
from models.controller_options import ControllerOptions
from models.controllers import Cascade, HeadingLoop, HoldHeading, HoldHeave, Lateral, Loop, Pitch
from models.design import Design
from models.feedback_problem import FeedbackProblem, feedback_problem, ordered
from models.modes import EXTENSION
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem
from models.sampled_model import SampledModel
from models.steady_problem import assembly_of
from models.trim import Trim

Array = NDArray[np.float64]
STEP = 0.1
"""Step of an angle that the cells must be able to answer, rad."""
DAMPING = 0.8
LEAST_DAMPING = 0.25
STROKE_SHARE = 0.25
PHASE_SPENT = 0.4
"""Phase that lag, delay and sample may cost at w, rad."""
TIMES_SLOWER = (6.0, 8.0, 12.0, 16.0, 25.0, 40.0)
"""The heading's time constant in those (1 / w) of the bank's loop."""
INTEGRALS = (0.1, 0.2)
SLOWER = (1.0, 0.7, 0.5, 0.3, 0.2, 0.1)
"""Frequencies tried, as shares of the fastest that the cells allow."""
MOST_STEPS = 200
LARGEST_BANK = 0.35
LARGEST_HEADING_GAIN = 1.5


@dataclass(frozen=True)
class AxisModel:
    """One angle as J a'' + D a' + S a = M: kg m2, N m s, N m; `pattern` (cells,) m per N m of a moment.

    M is what the allocation is asked for, a moment at level attitude: at a pitch it is less by the cosine, and J, D and
    S are more.
    """

    angle: str
    rate: str
    inertia: float
    damping: float
    stiffness: float
    pattern: Array

    def gains(self, frequency: float, integral: float) -> Loop:
        """Return the loop that answers with a frequency w, rad/s; `integral` is c."""
        J, D, S, w = self.inertia, self.damping, self.stiffness, frequency
        slow = D > 2.0 * DAMPING * J * w
        proportional = max((D * w - J * w**2 if slow else J * w**2) - S, 0.0)
        return Loop(
            proportional=proportional, integral=max(integral * w * (S + proportional), 0.0),
            derivative=max(2.0 * DAMPING * w * J - D, 0.0),
        )  # fmt: skip


@dataclass(frozen=True)
class LoopSuggestion:
    """First gains about a glide: the controller, the axes they were found on, and what was found, in words.

    `settling_time` (s) is four time constants of the slowest mode of the sampled linear loop, the glider's own modes
    aside where the loop does not touch them.
    """

    cascade: Cascade
    axes: tuple[AxisModel, ...]
    growth: float
    damping: float
    notes: tuple[str, ...]

    @property
    def settling_time(self) -> float:
        """Four time constants of the slowest mode, s."""
        return 4.0 / -self.growth if self.growth < 0.0 else math.inf

    def as_dict(self) -> dict[str, Any]:
        """Return the suggestion as a JSON object."""
        settling = self.settling_time
        return {
            "cascade": self.cascade.model_dump(mode="json"), "growth": self.growth, "damping": self.damping,
            "settling_time": settling if math.isfinite(settling) else None, "notes": list(self.notes),
            "axes": [
                {"angle": a.angle, "inertia": a.inertia, "damping": a.damping, "stiffness": a.stiffness}
                for a in self.axes
            ],
        }  # fmt: skip


@contextmanager
def _gains_within_limits() -> Iterator[None]:
    """Tell of gains that no document of a controller may hold, as a vehicle asks for that no water would carry."""
    try:
        yield
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        message = f"the gains that suit this vehicle are beyond their limits: {first['loc'][0]} {first['input']:.3g}"
        hint = "check masses, added mass, volumes and areas: some are far too large or too small"
        raise DesignError([Problem("/vehicle", message, hint=hint)]) from error


@_gains_within_limits()
def suggest_loops(
    design: Design | Assembly, trim: Trim | OperatingPoint, *, heading: float = 0.0, sample_time: float = 1.0,
    delay: float = 0.0,
) -> LoopSuggestion:  # fmt: skip
    """Return a cascade that holds a straight glide's heave and pitch, and a heading (rad) where the model is spatial.

    The rule is that of the module. Pitch and moment of the other phase, which a depth band needs, are those of the
    mirrored glide: the opposite ones.

    Raises
    ------
    DesignError
        Where the cells cannot make a pitch moment (or roll moment, with a spatial model) apart from the others, the
        motion turns, or the gains are beyond their limits.

    """
    point = point_of(trim, heading=0.0) if isinstance(trim, Trim) else trim
    assembly = assembly_of(design)
    cells = effectiveness(assembly.design, depth=point.depth)
    spatial = assembly.design.mission.solver.model == "spatial"
    _refuse_unheld(cells, spatial)
    motion = ("theta", "psi", "phi", "u", "v", "w", "p", "q", "r") if spatial else ("theta", "u", "w", "q")
    options = ControllerOptions(sample_time=sample_time, delay=delay)
    problem = feedback_problem(assembly, point, options)
    model = problem.model
    if spatial and "psi" not in model.state_names:
        _refuse_turning(point)
    problem = replace(problem, states=tuple(n for n in motion if n in model.state_names))
    pitch = axis_model(problem, cells, "theta")
    axes = [pitch]
    pitch_loop, growth, damping = _tuned_pitch(problem, pitch)
    moments = cells.matrix @ (np.array([point.extensions[c] for c in cells.cells]) - cells.neutral)
    reach, climbs = authority(cells).alone, bool(moments[0] > 0.0)
    pitch_loop = pitch_loop.model_copy(update={"limit": max(map(abs, reach["pitch"]))})
    lateral = None
    if spatial:
        roll = axis_model(problem, cells, "phi")
        axes.append(roll)
        lateral, of_lateral = _lateral(problem, roll, pitch, pitch_loop, heading, reach["roll"])
        lateral = for_phase(lateral, climbs)
        growth, damping = of_lateral
    cascade = Cascade(
        kind="cascade", sample_time=sample_time, delay=delay, vertical=HoldHeave(heave=float(moments[0])),
        pitch=_pitch(point.pitch, float(moments[1]), climbs, pitch_loop),
        lateral=lateral, unwind_time=max(20.0, 2.0 * sample_time),
    )  # fmt: skip
    return LoopSuggestion(cascade, tuple(axes), growth, damping, tuple(_notes(growth, damping, lateral)))


def _pitch(held: float, moment: float, climbs: bool, loop: Loop) -> Pitch:
    """Return what is done about pitch in both phases, from the pitch (rad) and moment (N m) of one of them."""
    side = -1.0 if climbs else 1.0
    return Pitch(
        dive=side * held, climb=-side * held, dive_moment=side * moment, climb_moment=-side * moment, loop=loop
    )


def for_phase(lateral: Lateral, climbs: bool) -> Lateral:
    """Return lateral loops tuned in one phase as the controller takes them: on climbs it turns the bank's sense."""
    if not climbs:
        return lateral
    gain = lateral.heading_loop.proportional
    heading = lateral.heading_loop.model_copy(update={"proportional": abs(gain)})
    return lateral.model_copy(update={"heading_loop": heading, "climb_bank": "opposite" if gain < 0.0 else "same"})


def axis_model(problem: FeedbackProblem, cells: Effectiveness, angle: str) -> AxisModel:
    """Return pitch (theta) or roll (phi) alone, with the moment shared by least strokes."""
    axis, rate = (1, "q") if angle == "theta" else (2, "p")
    wish = np.zeros(3)
    wish[axis] = 1.0
    scaled = cells.matrix * cells.span / cells.scale[:, None]
    pattern = cells.span * (np.linalg.pinv(scaled) @ (wish / cells.scale))
    names, A = problem.model.state_names, problem.model.A
    row = A[names.index(rate)]
    column = problem.model.B[names.index(rate)].copy()
    for j, cell in enumerate(cells.cells):
        if f"{EXTENSION}{cell}" in names:
            column[j] += row[names.index(f"{EXTENSION}{cell}")]
    inertia = 1.0 / float(column @ pattern)
    damping, stiffness = -row[names.index(rate)] * inertia, -row[names.index(angle)] * inertia
    return AxisModel(angle, rate, inertia, float(damping), float(stiffness), pattern)


def fastest(problem: FeedbackProblem, axis: AxisModel) -> float:
    """Return the largest frequency that strokes, rates, lags, delay and sample allow, rad/s."""
    parts = {part.name: part for _, part in problem.design.vehicle.actuated}
    options, moving = problem.options, [parts[cell] for cell in problem.cells.cells]
    frequency = PHASE_SPENT / (max(part.lag for part in moving) + options.delay + 0.5 * options.sample_time)
    for _ in range(MOST_STEPS):
        moved = STEP * axis.gains(frequency, 0.0).proportional * np.abs(axis.pattern)
        within = moved <= STROKE_SHARE * problem.strokes
        slow = [p.rate_limit is None or m * frequency <= p.rate_limit for m, p in zip(moved, moving, strict=True)]
        if within.all() and all(slow):
            break
        frequency *= 0.95
    return frequency


def closed_cascade(
    model: SampledModel, pitch: AxisModel, pitch_loop: Loop, roll: AxisModel | None = None,
    roll_loop: Loop | None = None, heading_gain: float = 0.0, *, factor: float = 1.0,
) -> Array:  # fmt: skip
    """Return the matrix of one sample of the linear cascade, all gains of pitch and bank times a factor.

    The state is that of `model` and then the loops' integrals of pitch and bank.
    """
    n, at = len(model.states), model.states.index
    errors, gains = np.zeros((2, n)), np.zeros((len(model.cells), n + 2))
    errors[0, at("theta")] = -1.0
    ask = np.zeros((2, n + 2))
    ask[0, :n] = factor * pitch_loop.proportional * errors[0]
    ask[0, at("q")] -= factor * pitch_loop.derivative
    ask[0, n] = factor * pitch_loop.integral
    gains += np.outer(pitch.pattern, ask[0])
    if roll is not None and roll_loop is not None:
        errors[1, at("phi")], errors[1, at("psi")] = -1.0, -heading_gain
        ask[1, :n] = factor * roll_loop.proportional * errors[1]
        ask[1, at("p")] -= factor * roll_loop.derivative
        ask[1, n + 1] = factor * roll_loop.integral
        gains += np.outer(roll.pattern, ask[1])
    whole = np.zeros((n + 2, n + 2))
    whole[:n] = np.hstack([model.F, np.zeros((n, 2))]) + model.G @ gains
    whole[n:, :n] = model.sample_time * errors
    whole[n:, n:] = np.eye(2)
    if roll is None:
        return whole[: n + 1, : n + 1]
    return whole


def quality_of(matrix: Array, sample_time: float) -> tuple[float, float]:
    """Return the largest growth (1/s) and the least damping ratio of oscillations of a sampled loop."""
    z = np.linalg.eigvals(matrix)
    rates = np.log(np.maximum(np.abs(z), 1e-12)) / sample_time + 1j * np.angle(z) / sample_time
    turning = rates[np.abs(rates.imag) > 1e-9]
    damping = float((-turning.real / np.abs(turning)).min(initial=1.0))
    return float(rates.real.max()), damping


def _tuned_pitch(problem: FeedbackProblem, pitch: AxisModel) -> tuple[Loop, float, float]:
    """Return the loop of pitch, and growth and damping of the sampled linear loop in the vertical plane."""
    names = [name for name in problem.model.state_names if name not in ("psi", "phi", "v", "p", "r")]
    model, top = _part(problem, names), fastest(problem, pitch)
    tried = []
    for slower, integral in product(SLOWER, INTEGRALS):
        loop = pitch.gains(slower * top, integral)
        matrices = [closed_cascade(model, pitch, loop, factor=factor) for factor in (1.0, 2.0)]
        tried.append((loop, *_rated(matrices, problem.options.sample_time)))
    return max(tried, key=lambda one: _merit(*one[1:]))


def _rated(matrices: list[Array], sample_time: float) -> tuple[float, float]:
    """Return growth and damping of the first matrix, no decay at all where the second (twice the gains) is unstable."""
    growth, damping = quality_of(matrices[0], sample_time)
    doubled, _ = quality_of(matrices[1], sample_time)
    return (growth, damping) if doubled < 0.0 else (max(growth, 0.0), 0.0)


def _merit(growth: float, damping: float) -> tuple[bool, float, float]:
    """Return what to compare loops by: stable, then damped well enough, then fast."""
    return growth < 0.0, min(damping, LEAST_DAMPING), -growth


def _lateral(
    problem: FeedbackProblem, roll: AxisModel, pitch: AxisModel, pitch_loop: Loop, heading: float,
    reach: tuple[float, float],
) -> tuple[Lateral, tuple[float, float]]:  # fmt: skip
    """Return loops of bank and heading, and growth and damping of the whole loop."""
    model, moment = problem.whole(), max(map(abs, reach))
    turning, top = turn_rate_of_bank(problem, roll), fastest(problem, roll)
    tried = []
    for slower, integral, times in product(SLOWER, INTEGRALS, TIMES_SLOWER):
        gain = min(slower * top / (times * abs(turning)), LARGEST_HEADING_GAIN)
        gain, loop = math.copysign(gain, turning), roll.gains(slower * top, integral)
        matrices = [closed_cascade(model, pitch, pitch_loop, roll, loop, gain, factor=k) for k in (1.0, 2.0)]
        tried.append((loop, gain, _rated(matrices, problem.options.sample_time)))
    loop, gain, quality = max(tried, key=lambda one: _merit(*one[2]))
    bank = min(LARGEST_BANK, 0.6 * moment / max(roll.stiffness, 1e-9))
    lateral = Lateral(
        guidance=HoldHeading(kind="heading", heading=heading),
        roll_loop=loop.model_copy(update={"limit": moment}),
        heading_loop=HeadingLoop(proportional=gain, limit=bank),
    )
    return lateral, quality


def turn_rate_of_bank(problem: FeedbackProblem, roll: AxisModel) -> float:
    """Return the rate of heading per bank in steady flow, 1/s: with v, p, r and a moment that hold bank, v, p and r."""
    names, A = problem.model.state_names, problem.model.A
    rows = [names.index(name) for name in ("phi", "v", "p", "r")]
    B = problem.model.B.copy()
    for j, cell in enumerate(problem.cells.cells):
        if f"{EXTENSION}{cell}" in names:
            B[:, j] += A[:, names.index(f"{EXTENSION}{cell}")]
    system = np.column_stack([A[np.ix_(rows, rows[1:])], B[rows] @ roll.pattern])
    v, p, r, _ = np.linalg.solve(system, -A[rows, rows[0]])
    psi = names.index("psi")
    return float(A[psi, rows] @ np.array([1.0, v, p, r]))


def _part(problem: FeedbackProblem, names: list[str]) -> SampledModel:
    """Return the sampled model of some states alone, the others held."""
    part = replace(problem, model=ordered(problem.model, names), states=tuple(names))
    return part.whole()


def _refuse_unheld(cells: Effectiveness, spatial: bool) -> None:
    holds = authority(cells).holds
    need = ("pitch", "roll") if spatial else ("pitch",)
    missing = [axis for axis in AXES if axis in need and axis not in holds]
    if missing:
        message = f"the cells cannot make {' and '.join(missing)} moments apart from the other axes"
        hint = "design a state feedback, which needs no allocation, or add cells"
        raise DesignError([Problem("/vehicle/components", message, hint=hint)])


def _refuse_turning(point: OperatingPoint) -> NoReturn:
    rate = math.hypot(*point.angular_velocity)
    message = f"the motion turns at {rate:.3g} rad/s, and a heading can only be held on a straight way"
    hint = "give the trim the target turn_rate 0, or make the vehicle symmetric from port to starboard"
    raise DesignError([Problem("/options/trim", message, hint=hint)])


def _notes(growth: float, damping: float, lateral: Lateral | None) -> Iterator[str]:
    if growth >= 0.0:
        yield f"no gains of this rule keep the loop stable with a factor of 2 to spare (growth {growth:.3g} 1/s)"
    elif damping < LEAST_DAMPING:
        yield f"the least damping ratio is {damping:.2g}: that of the glider itself, or of its lags"
    if lateral is not None and lateral.heading_loop.proportional < 0.0:
        yield "a bank turns the glider to the other side on dives here: the heading's gain is negative"
