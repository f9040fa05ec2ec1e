"""Owns the design of controllers: gains of state feedback about a trim, with what they promise and what speaks against.

The kernel's law is sampled and holds its commands, so gains are found on the model sampled at that time. Those of least
cost know the delay, lags and states that are not fed back; poles are placed without them. Eigenvalues, margins and
responses are those of all states with the delay. SI units and radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.controller_options import ControllerOptions, StepOptions, TrimOptions
from models.controllers import StateFeedback
from models.design import Design
from models.feedback_gains import MET, lqr_gains, lqr_weights, missed_by, placed_gains
from models.feedback_problem import FeedbackProblem, feedback_problem
from models.limited_gains import LARGEST, limited_gains
from models.limits import DEFAULT_LIMITS, Limits
from models.loop_margins import LoopMargins, loop_margins
from models.loop_response import (
    LoopResponse,
    departure,
    feedback_of,
    gain_point,
    mission_from,
    set_point_step,
)
from models.modes import NEUTRAL, Modes, modes_of
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem
from models.simulate import Control
from models.steady_problem import assembly_of
from models.targeted_trim import trim_for
from models.trim import Trim, find_trims

Array = NDArray[np.float64]
SMALL_DISK = 0.5
"""Disk margins below this (a phase of 28 deg) are told as small."""
RATES = "gains, modes and margins do not know the cells' rate limits: fly a step to see what they do"
SLOW_ENOUGH, DAMPED = 0.5, 0.5
"""Modes that turn by more than the first in a sample (rad), damped by less than the second, are told."""


@dataclass(frozen=True, eq=False)
class ControllerDesign:
    """A state feedback about one trim.

    `gains` (cells, states + integrals), m (or rad) by the state's unit; `open_loop` and `closed_loop` modes (1/s), the
    latter those of the sampled loop as if continuous, s = log(z) / T; `margins` None where it is not stable. `response`
    is that to a step and `recovery` the way back from departures, None where the options ask for none.
    """

    problem: FeedbackProblem
    gains: Array
    controller: StateFeedback
    open_loop: Modes
    closed_loop: Modes
    margins: LoopMargins | None
    response: LoopResponse | None
    recovery: LoopResponse | None
    warnings: tuple[str, ...]

    @property
    def stable(self) -> bool:
        """Whether every small departure of the fed-back model dies out."""
        return all(mode.growth < -NEUTRAL for mode in self.closed_loop.modes)

    def step(self, options: StepOptions, *, fly: bool = True) -> LoopResponse:
        """Return the response to a step of a set point, linear and flown."""
        return set_point_step(self.problem, self.gains, options, fly=fly)

    def departure(self, by: Mapping[str, float], *, duration: float = 120.0, fly: bool = True) -> LoopResponse:
        """Return the way back to the trim from departures of states (rad, m/s, rad/s) over a duration, s."""
        return departure(self.problem, self.gains, by, duration=duration, fly=fly)

    def mission(self, *, duration: float, interval: float = 0.5) -> Design:
        """Return the design with a mission that starts in the trim under this controller; times in s."""
        return mission_from(
            self.problem.design, self.problem.point, self.controller, duration=duration, interval=interval
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the design as a JSON object."""
        return {
            "controller": self.controller.model_dump(mode="json"), "trim": self.problem.point.as_dict(),
            "cells": list(self.problem.cells.cells), "states": list(self.problem.states),
            "gains": self.gains.tolist(), "stable": self.stable, "open_loop": self.open_loop.as_dict(),
            "closed_loop": self.closed_loop.as_dict(),
            "margins": None if self.margins is None else self.margins.as_dict(),
            "response": None if self.response is None else self.response.as_dict(),
            "recovery": None if self.recovery is None else self.recovery.as_dict(), "warnings": list(self.warnings),
        }  # fmt: skip


def design_controller(
    design: Design | Assembly, options: ControllerOptions | None = None, *, limits: Limits = DEFAULT_LIMITS,
    control: Control | None = None,
) -> ControllerDesign:  # fmt: skip
    """Return a state feedback of a design about the trim that the options ask for, and its responses if asked.

    Flights keep within the limits; `control` stops them.

    Raises
    ------
    DesignError
        Where there is no such trim, a name is unknown, or the cells cannot move what is to be fed back.

    """
    chosen = options or ControllerOptions()
    if chosen.table is not None:
        hint = "use models.gain_table.design_table, or leave the table out"
        raise DesignError([Problem("/options/table", "this designs for one trim", hint=hint)])
    assembly = assembly_of(design)
    point = point_of(trim_of_options(assembly, chosen), heading=chosen.trim.heading)
    return design_about(assembly, point, chosen, limits=limits, control=control)


def design_about(
    design: Design | Assembly, point: OperatingPoint, options: ControllerOptions, *, limits: Limits = DEFAULT_LIMITS,
    control: Control | None = None,
) -> ControllerDesign:  # fmt: skip
    """Return a state feedback about an operating point, which should be a trim.

    Raises
    ------
    DesignError
        As of `design_controller`.

    """
    problem = feedback_problem(design, point, options)
    gains, said = gains_for(problem)
    model = problem.whole()
    closed = model.modes(model.closed(problem.widened(gains)))
    margins = loop_margins(problem, gains)
    response = recovery = None
    if options.step is not None:
        response = set_point_step(problem, gains, options.step, limits=limits, control=control)
    if options.departures:
        duration = options.recovery_duration
        recovery = departure(problem, gains, options.departures, duration=duration, limits=limits, control=control)
    warnings = (*_warnings(problem, closed, margins), *said)
    for each in (response, recovery):
        warnings += () if each is None else each.warnings
    controller = feedback_of(problem, (gain_point(problem, gains, point, 0.0),))
    opened = modes_of(problem.model.A, problem.model.state_names)
    return ControllerDesign(problem, gains, controller, opened, closed, margins, response, recovery, warnings)


def gains_for(problem: FeedbackProblem) -> tuple[Array, tuple[str, ...]]:
    """Return the gains (cells, states + integrals) by the method of the options, and in words what they do not know."""
    options, simple = problem.options, problem.simple
    sums = problem.deviations[: options.integrals] * options.integral_time
    if options.method == "poles":
        scale = np.concatenate([problem.deviations, sums])
        poles = [complex(*pole) for pole in options.poles]
        gains = placed_gains(simple, poles, states=scale, commands=problem.commands)
        missed = missed_by(simple, gains, poles)
        words = f"the poles are met within {missed:.2g} of the unit circle's radius only"
        return gains, (*_not_known(problem), *([words] if missed > MET else []))
    weights = lqr_weights(
        problem.A, problem.B, deviations=problem.deviations, commands=problem.commands, sums=sums,
        sample_time=options.sample_time,
    )  # fmt: skip
    gains = lqr_gains(simple, *weights)
    if not _not_known(problem):
        return gains, ()
    limited = limited_gains(problem, gains, sums)
    if limited is not None:
        return limited, ()
    size = len(problem.whole().states)
    long = f"{size} states with the commands under way are more than {LARGEST}: sample less often to have it known"
    return gains, (*_not_known(problem), *([long] if size > LARGEST else []))


def _not_known(problem: FeedbackProblem) -> tuple[str, ...]:
    """Return what gains on the states fed back alone do not know, in words."""
    left = [name for name in problem.model.state_names[len(problem.states) :]]
    words = []
    if problem.options.delay > 0.0:
        words.append(f"the gains are found without the delay of {problem.options.delay:g} s; all figures are with it")
    if left:
        words.append(f"the gains are found with {', '.join(left)} left out; all figures are with them")
    return tuple(words)


def trim_of_options(design: Design | Assembly, options: ControllerOptions) -> Trim:
    """Return the steady motion that the options ask for.

    Raises
    ------
    DesignError
        Where there is none.

    """
    try:
        return _trim_of(assembly_of(design), options.trim)
    except DesignError as error:
        raise DesignError(
            replace(p, pointer=p.pointer.replace("/options/", "/options/trim/", 1))
            if p.pointer.startswith("/options/") and not p.pointer.startswith("/options/trim/") else p
            for p in error.problems
        ) from None  # fmt: skip


def _trim_of(assembly: Assembly, wanted: TrimOptions) -> Trim:
    if wanted.targets:
        free = wanted.free or assembly.cells
        found = trim_for(assembly, wanted.targets, free, extensions=wanted.extensions, depth=wanted.depth)
        if isinstance(found, Trim):
            return found
        raise DesignError([Problem("/options/trim/targets", f"no trim meets them: {found}")])
    search = find_trims(assembly, extensions=wanted.extensions, depth=wanted.depth)
    if not search.solutions:
        message = f"no steady motion: {search.searched}"
        hint = "say which motion by options.trim.targets (--target speed=0.3), or give extensions that drive one"
        raise DesignError([Problem("/options/trim/extensions", message, hint=hint)])
    return search.solutions[0]


def _warnings(problem: FeedbackProblem, closed: Modes, margins: LoopMargins | None) -> Iterator[str]:
    """Yield what speaks against a design, the worst first."""
    options = problem.options
    growing = [mode for mode in closed.modes if mode.growth >= -NEUTRAL]
    for mode in growing:
        cause = "the delay, the states that are not fed back, or lags"
        grows = f"{mode.name} grows by {mode.growth:.3g} 1/s"
        yield f"the loop is not stable with all states and the delay: {grows}; the cause is {cause}"
    if not problem.model.is_equilibrium:
        yield f"this is no trim: rates of up to {problem.model.residual:.3g} a second are left"
    if margins is not None and margins.disk < SMALL_DISK:
        yield f"the margins are small: {margins}"
    for mode in closed.modes:
        turns, damping = mode.eigenvalue.imag * options.sample_time, mode.damping_ratio
        if turns > SLOW_ENOUGH and damping is not None and damping < DAMPED:
            yield f"{mode.name} turns by {turns:.2g} rad in a sample, damped by {damping:.2g}: sample faster"
    drift = dict(zip(problem.model.state_names, problem.model.drift, strict=True))
    if "psi" in drift and abs(drift["psi"]) > NEUTRAL:
        yield f"heading drifts by {drift['psi']:.3g} rad/s in this trim"
    yield from problem.notes
    yield from (note for note in problem.model.notes if "at its stop" in note or "at its rate limit" in note)
    if any(part.rate_limit is not None for _, part in problem.design.vehicle.actuated):
        yield RATES
