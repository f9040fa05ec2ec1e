"""Owns responses of a designed loop: what the linear model predicts, and the flight of the non-linear one beside it.

A response goes from a start to a goal, both given by the values of all states, in SI units: a step of the set point
starts in the old trim, a departure from the trim elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from models.assemble import Assembly, assemble
from models.controller_options import StepOptions
from models.controllers import MEASURED, GainPoint, SetPoint, StateFeedback
from models.design import Design, parse_design
from models.feedback_problem import FeedbackProblem
from models.limits import DEFAULT_LIMITS, Limits
from models.mission import Control, Initial
from models.modes import EXTENSION
from models.operating_point import OperatingPoint, down_in_body, point_of
from models.problems import DesignError, Problem, pointer_to, problems_from_validation
from models.response_figures import Figures, figures_of
from models.run import Run, Status
from models.simulate import Control as RunControl
from models.simulate import run_assembly
from models.targeted_trim import trim_for
from models.trim import STRAIGHT, Trim

Array = NDArray[np.float64]
TARGETS = {"theta": "pitch", "phi": "roll", "u": "speed"}
FINEST_OUTPUT = 0.5
"""Longest time between samples of a flight, s."""
MOST_SAMPLES = 100_000
DIFFERENT = 0.1
"""Flights that differ from the linear prediction by more than this share of the step are told."""


class Flight(NamedTuple):
    """Within which limits a response is flown, and by what handle it can be stopped."""

    limits: Limits
    control: RunControl | None


@dataclass(frozen=True)
class LoopResponse:
    """A response of one state from `start` to `goal` (rad, m/s), linear and flown.

    `times` (samples,) s are those of the controller; `linear` (samples, states) and `commands` (samples, cells) what
    the linear model predicts, whole values by `states` and `cells`; `goal_states` (states,) and `goal_extensions`
    (cells,) where it goes. `design` is the mission that was flown.
    """

    state: str
    start: float
    goal: float
    times: Array
    states: tuple[str, ...]
    cells: tuple[str, ...]
    linear: Array
    commands: Array
    goal_states: Array
    goal_extensions: Array
    predicted: Figures
    design: Design
    run: Run | None
    flown: Figures | None
    difference: float | None
    warnings: tuple[str, ...]

    @property
    def predicted_state(self) -> Array:
        """The stepped state by the linear model, (samples,)."""
        return self.linear[:, self.states.index(self.state)]

    @property
    def flown_state(self) -> Array:
        """The stepped state of the flight at the controller's samples, (samples,)."""
        return self.of_flight(self.state)

    def of_flight(self, name: str) -> Array:
        """Return a state or a cell's extension of the flight at the controller's samples, (samples,)."""
        if self.run is None:
            raise DesignError([Problem("/run", "the response was not flown")])
        if name.startswith(EXTENSION):
            column = self.run.cell_values["extension"][:, self.run.cells.index(name.removeprefix(EXTENSION))]
        else:
            column = np.unwrap(self.run.values[name]) if name in ("phi", "psi") else self.run.values[name]
        reached = self.times[self.times <= self.run.times[-1]]
        return np.asarray(np.interp(reached, self.run.times, column), dtype=np.float64)

    def as_dict(self) -> dict[str, Any]:
        """Return the response as a JSON object; the flight only by its figures and the stepped state."""
        flown = None if self.run is None else self.flown_state.tolist()
        return {
            "state": self.state, "start": self.start, "goal": self.goal, "times": self.times.tolist(),
            "linear": self.predicted_state.tolist(), "flown": flown, "cells": list(self.cells),
            "commands": self.commands.tolist(), "predicted": self.predicted.as_dict(),
            "flight": None if self.flown is None else self.flown.as_dict(), "difference": self.difference,
            "status": None if self.run is None else self.run.status.name, "warnings": list(self.warnings),
        }  # fmt: skip


def values_at(problem: FeedbackProblem, point: OperatingPoint) -> dict[str, float]:
    """Return the values of every state (by the linear model's names) at a point."""
    (u, v, w), (p, q, r) = point.velocity, point.angular_velocity
    known = {
        "z": point.depth, "phi": point.roll, "theta": point.pitch, "psi": point.yaw, "u": u, "v": v, "w": w, "p": p,
        "q": q, "r": r,
    } | {f"{EXTENSION}{name}": value for name, value in point.extensions.items()}  # fmt: skip
    return {name: known[name] for name in problem.model.state_names}


def set_point_step(
    problem: FeedbackProblem, gains: Array, step: StepOptions, *, fly: bool = True, limits: Limits = DEFAULT_LIMITS,
    control: RunControl | None = None,
) -> LoopResponse:  # fmt: skip
    """Return the response to a step of a set point at time zero, from the trim to the one with the state changed.

    The new trim is the steady motion nearest in extensions with that pitch or speed (`u`) and the old rate of turn, or
    with that roll; of a heading, the same one turned. Its states and extensions are the controller's new ones.

    Raises
    ------
    DesignError
        Where the state is not fed back, no such steady motion is within the stops, or the flight exceeds the limits.

    """
    goal = stepped_point(problem, step)
    flight = Flight(limits, control) if fly else None
    return _response(problem, gains, step.state, problem.point, goal, step.duration, flight)


def departure(
    problem: FeedbackProblem, gains: Array, departures: Mapping[str, float], *, duration: float = 120.0,
    fly: bool = True, limits: Limits = DEFAULT_LIMITS, control: RunControl | None = None,
) -> LoopResponse:  # fmt: skip
    """Return the way back to the trim from a start off it, by states of the motion (rad, m/s, rad/s).

    The first state is watched; `duration` in s.

    Raises
    ------
    DesignError
        Where none is given, one is no state of the motion, 0 or no number, or the start no attitude.

    """
    _refuse_departures(problem, departures)
    at, point = departures.get, problem.point
    start = replace(
        point, roll=point.roll + at("phi", 0.0), pitch=point.pitch + at("theta", 0.0), yaw=point.yaw + at("psi", 0.0),
        velocity=(point.velocity[0] + at("u", 0.0), point.velocity[1] + at("v", 0.0), point.velocity[2] + at("w", 0.0)),
        angular_velocity=(
            point.angular_velocity[0] + at("p", 0.0), point.angular_velocity[1] + at("q", 0.0),
            point.angular_velocity[2] + at("r", 0.0),
        ),
    )  # fmt: skip
    flight = Flight(limits, control) if fly else None
    try:
        return _response(problem, gains, next(iter(departures)), start, point, duration, flight)
    except DesignError as error:
        raise DesignError(
            replace(p, pointer="/options/departures") if p.pointer.startswith("/mission/initial") else p
            for p in error.problems
        ) from None


def _refuse_departures(problem: FeedbackProblem, departures: Mapping[str, float]) -> None:
    """Raise `DesignError` where departures name no states of the motion, or are no numbers to depart by."""
    known = [name for name in MEASURED[1:] if name in problem.model.state_names]
    hint = f"those are: {', '.join(known)}"
    if not departures:
        raise DesignError([Problem("/options/departures", "no departure is given", hint=hint)])
    problems = []
    for name, value in departures.items():
        at = pointer_to("options", "departures", name)
        if name not in known:
            problems.append(Problem(at, f"'{name}' is no state of the motion", hint=hint))
        elif not math.isfinite(value) or value == 0.0:
            problems.append(Problem(at, f"{value:g} is no departure", hint="give a finite number that is not 0"))
    if problems:
        raise DesignError(problems)


def stepped_point(problem: FeedbackProblem, step: StepOptions) -> OperatingPoint:
    """Return the trim that a step asks for."""
    point = problem.point
    if step.state not in problem.states:
        message, hint = f"{step.state} is not fed back: it has no set point", f"step {', '.join(problem.states)}"
        raise DesignError([Problem("/options/step/state", message, hint=hint)])
    if step.state == "psi":
        return replace(point, yaw=point.yaw + step.amount)
    if step.state == "phi" and "psi" in problem.states:
        message = "a bank turns the glider, and its heading is held"
        raise DesignError([Problem("/options/step/state", message, hint="leave psi out of the states, or step psi")])
    now = {"theta": point.pitch, "phi": point.roll, "u": point.speed}[step.state]
    free = [cell for cell in problem.cells.cells if cell in point.extensions]
    targets = {TARGETS[step.state]: now + step.amount}
    turn = turn_rate_of(point)
    if step.state != "phi" and abs(turn) > STRAIGHT:
        targets["turn_rate"] = turn
    found = trim_for(problem.assembly, targets, free, extensions=point.extensions, depth=point.depth)
    if not isinstance(found, Trim):
        hint = "ask for less, give more cells, or step another state"
        raise DesignError([Problem("/options/step/amount", f"no trim to step to: {found}", hint=hint)])
    return point_of(found, heading=point.yaw)


def turn_rate_of(point: OperatingPoint) -> float:
    """Return the rate of turn about the vertical of a steady motion, rad/s."""
    return float(down_in_body(point.roll, point.pitch) @ np.array(point.angular_velocity))


def gain_point(problem: FeedbackProblem, gains: Array, point: OperatingPoint, value: float) -> GainPoint:
    """Return a row of the controller's table: gains about a point at a value of the set point."""
    at = values_at(problem, point)
    return GainPoint(
        value=value, extensions=tuple(float(point.extensions[cell]) for cell in problem.cells.cells),
        state=tuple(at[name] for name in problem.model.state_names[: len(problem.states)]),
        gains=tuple(tuple(row) for row in gains.tolist()),
    )  # fmt: skip


def feedback_of(
    problem: FeedbackProblem, points: tuple[GainPoint, ...], *, set_points: tuple[SetPoint, ...] = (), by: str = ""
) -> StateFeedback:
    """Return the controller with a table of gains."""
    return StateFeedback(
        kind="state_feedback", cells=problem.cells.cells, states=problem.states, integrals=problem.options.integrals,
        sample_time=problem.options.sample_time, delay=problem.options.delay, points=points, set_points=set_points,
        scheduled_by=by,
    )  # fmt: skip


def mission_from(
    design: Design, point: OperatingPoint, controller: StateFeedback, *, duration: float, interval: float
) -> Design:
    """Return the design with a mission that starts at a point under a controller; times in s.

    Raises
    ------
    DesignError
        Where a mission cannot start at the point.

    """
    start = {
        "position": (0.0, 0.0, point.depth), "roll": point.roll, "pitch": point.pitch, "yaw": point.yaw,
        "velocity": point.velocity, "angular_velocity": point.angular_velocity, "extensions": dict(point.extensions),
    }  # fmt: skip
    try:
        initial = Initial.model_validate(start)
    except ValidationError as error:
        told = problems_from_validation(error, start)
        raise DesignError(replace(p, pointer=f"/mission/initial{p.pointer}") for p in told) from None
    solver = design.mission.solver.model_copy(update={"output_interval": interval})
    changed: dict[str, Any] = {
        "initial": initial, "control": Control(controller=controller), "duration": duration, "solver": solver,
    }  # fmt: skip
    mission = design.mission.model_copy(update=changed)
    return parse_design(design.model_copy(update={"mission": mission}).model_dump(mode="json"))


def _response(
    problem: FeedbackProblem, gains: Array, state: str, start: OperatingPoint, goal: OperatingPoint, duration: float,
    flight: Flight | None,
) -> LoopResponse:  # fmt: skip
    from_values, to_values = values_at(problem, start), values_at(problem, goal)
    sample_time = problem.options.sample_time
    count = max(2, math.ceil(duration / sample_time))
    if count > MOST_SAMPLES:
        message, hint = f"{duration:g} s are {count} samples of {sample_time:g} s", "watch for less long"
        raise DesignError([Problem("/options/step/duration", message, limit=MOST_SAMPLES, hint=hint)])
    design = mission_from(
        problem.design, start, _stepping(problem, gains, goal, state), duration=count * sample_time,
        interval=sample_time / math.ceil(sample_time / FINEST_OUTPUT),
    )  # fmt: skip
    flyable = None if flight is None else _flyable(design, flight.limits)
    times = np.arange(count + 1, dtype=np.float64) * sample_time
    linear, commands = predicted(problem, gains, start, goal, count)
    names, cells = problem.model.state_names, problem.cells.cells
    a, b = from_values[state], to_values[state]
    departures = commands - np.array([start.extensions[cell] for cell in cells])
    share = (linear[:, names.index(state)] - a) / (b - a)
    forward = figures_of(share, times, departures, _rates(problem, linear, commands))
    response = LoopResponse(
        state, a, b, times, names, cells, linear, commands, np.array([to_values[name] for name in names]),
        np.array([goal.extensions[cell] for cell in cells]), forward, design, None, None, None,
        tuple(_demands(problem, forward, commands)),
    )  # fmt: skip
    if flight is None or flyable is None:
        return response
    return flown(response, run_assembly(flyable, limits=flight.limits, control=flight.control))


def _flyable(design: Design, limits: Limits) -> Assembly:
    """Return the assembly of the mission of a response; raises `DesignError` where it is too long for the limits."""
    try:
        return assemble(design, limits)
    except DesignError as error:
        at, of_time = "/options/step/duration", ("/mission/duration", "/mission/solver")
        raise DesignError(
            replace(p, pointer=at, hint="watch for less long") if p.pointer.startswith(of_time) else p
            for p in error.problems
        ) from None


def predicted(
    problem: FeedbackProblem, gains: Array, start: OperatingPoint, goal: OperatingPoint, count: int
) -> tuple[Array, Array]:
    """Return states (count + 1, states) and commands (count + 1, cells) of the linear loop, whole values, by sample."""
    model, wide = problem.whole(), problem.widened(gains)
    names, cells, n = problem.model.state_names, problem.cells.cells, model.motion
    to_values, from_values = values_at(problem, goal), values_at(problem, start)
    at_goal = np.array([to_values[name] for name in names])
    e_goal, e_start = (np.array([p.extensions[cell] for cell in cells]) for p in (goal, start))
    X = np.zeros(len(model.states))
    X[:n] = np.array([from_values[name] for name in names]) - at_goal
    held = X[n + model.sums :].reshape(-1, len(cells))
    held[:] = e_start - e_goal
    closed, feedback = model.closed(wide), model.feedback(wide)
    states, commands = np.zeros((count + 1, n)), np.zeros((count + 1, len(cells)))
    for k in range(count + 1):
        states[k], commands[k] = at_goal + X[:n], e_goal - feedback @ X
        X = closed @ X
    return states, commands


def _stepping(problem: FeedbackProblem, gains: Array, goal: OperatingPoint, state: str) -> StateFeedback:
    """Return the controller of a step at time zero: its table holds the old trim and the new one, if they differ."""
    old, new = (values_at(problem, point)[state] for point in (problem.point, goal))
    rows = {value: gain_point(problem, gains, point, value) for value, point in ((old, problem.point), (new, goal))}
    points = tuple(rows[value] for value in sorted(rows))
    return feedback_of(problem, points, set_points=(SetPoint(time=0.0, value=new),), by=f"{state}")


def flown(response: LoopResponse, run: Run) -> LoopResponse:
    """Return the response with its flight."""
    response = replace(response, run=run)
    kept = [run.cells.index(cell) for cell in response.cells]
    step, extension = response.goal - response.start, run.cell_values["extension"][:, kept]
    rates = np.abs(np.diff(extension, axis=0)).max(axis=0, initial=0.0) / max(float(np.diff(run.times).max()), 1e-12)
    y, times = response.flown_state, response.times[: len(response.flown_state)]
    asked = run.cell_values["command"][:, kept] - extension[0]
    rate = dict(zip(response.cells, rates.tolist(), strict=True))
    figures = figures_of((y - response.start) / step, times, asked, rate)
    off = float(np.abs(y - response.predicted_state[: len(y)]).max() / abs(step))
    warnings = list(response.warnings)
    if run.status is not Status.completed:
        warnings.append(f"the flight ended at {run.times[-1]:.4g} s: {run.message}")
    if off > DIFFERENT:
        warnings.append(f"the flight differs from the linear prediction by up to {100.0 * off:.3g} % of the step")
    return replace(response, flown=figures, difference=off, warnings=tuple(warnings))


def _rates(problem: FeedbackProblem, linear: Array, commands: Array) -> dict[str, float]:
    """Return the largest rate that the linear commands ask of each cell: over its lag, or over a sample without one."""
    names, rates = problem.model.state_names, {}
    for j, cell in enumerate(problem.cells.cells):
        at = f"{EXTENSION}{cell}"
        if at in names:
            per_lag = -float(problem.model.A[names.index(at), names.index(at)])
            rates[cell] = float(np.abs(commands[:, j] - linear[:, names.index(at)]).max() * per_lag)
        else:
            changes = np.diff(commands[:, j], prepend=problem.extensions[j])
            rates[cell] = float(np.abs(changes).max() / problem.options.sample_time)
    return rates


def _demands(problem: FeedbackProblem, figures: Figures, commands: Array) -> Iterator[str]:
    """Yield what a linear response asks of the cells beyond their rates and strokes."""
    parts = {part.name: part for _, part in problem.design.vehicle.actuated}
    for j, cell in enumerate(problem.cells.cells):
        limit, rate = parts[cell].rate_limit, figures.rate[cell]
        if limit is not None and rate > limit:
            yield f"'{cell}' is asked for {rate:.3g} a second, its limit is {limit:g}: the flight will be slower"
        low, high = float(problem.cells.low[j]), float(problem.cells.high[j])
        least, most = float(commands[:, j].min()), float(commands[:, j].max())
        if least < low or most > high:
            yield f"'{cell}' is asked for {least:.4g} to {most:.4g}, its stops are {low:g} and {high:g}"
