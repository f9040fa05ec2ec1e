"""Owns episodes of many gliders at a task: how they begin, what is observed, what is earned, and when they end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.design import Design
from models.glide_tasks import TASKS, Motion, Reward, Task
from models.glider_fleet import Action, Fleet, Range, Start, accurate_step, actions_of
from models.kernel.control_layout import DEPTH, YAW_RATE
from models.kernel.integrate import CANCELLED, COMPLETED
from models.presets import load_preset, preset_ids
from models.simulate import STATUS_BY_CODE

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
SEEN = YAW_RATE + 1
"""Of what is measured, an observation begins with as many: the place is left out."""
TOLD = (
    ("depth, m", -10.0, 1.2e4), ("roll, rad", -math.pi, math.pi), ("pitch, rad", -math.pi / 2.0, math.pi / 2.0),
    ("yaw, rad", -math.pi, math.pi),
    ("surge through the water, m/s", -10.0, 10.0), ("sway, m/s", -10.0, 10.0), ("heave, m/s", -10.0, 10.0),
    ("roll rate, rad/s", -10.0, 10.0), ("pitch rate, rad/s", -10.0, 10.0), ("yaw rate, rad/s", -10.0, 10.0),
)  # fmt: skip
"""Names with units and bounds of those; what lies beyond its bounds is told as the bound."""


class Episodes:
    """Gliders of one design at one task, each with an episode of its own."""

    def __init__(
        self, design: Design | str, count: int, *, task: str | Task, reward: Reward | None, action: Action,
        initial: Mapping[str, Range] | None, step_time: float, step: float | None, duration: float | None, threads: int,
    ) -> None:  # fmt: skip
        if isinstance(design, str) and design not in preset_ids():
            raise ValueError(f"there is no preset '{design}': those are {', '.join(preset_ids())}; or give a Design")
        described = load_preset(design) if isinstance(design, str) else design
        duration = described.mission.duration if duration is None else duration
        if not 0.0 < step_time <= duration < math.inf:
            raise ValueError(f"step_time {step_time:g} s is not between 0 and the duration, {duration:g} s")
        if step is not None and not 0.0 < step < math.inf:
            raise ValueError(f"step {step:g} s is not a time above 0 s")
        if isinstance(task, str) and task not in TASKS:
            raise ValueError(f"there is no task '{task}': those are {', '.join(TASKS)}; or give one of your own")
        self.task = TASKS[task]() if isinstance(task, str) else task
        self.reward_of = self.task.reward if reward is None else reward
        if step is None:
            step = accurate_step(described, step_time)
        self.fleet = Fleet(described, count, step_time=step_time, step=step, threads=threads)
        self.actions = actions_of(self.fleet, action)
        self.start = Start(described, initial)
        self.most_steps = math.ceil(duration / step_time - 1e-9)
        self.steps = np.zeros(count, dtype=np.int64)
        goals = len(self.task.draw(self.fleet.seen[0], np.random.default_rng(0)))
        self.before, self.goals = np.zeros_like(self.fleet.seen), np.zeros((count, goals))
        self._prepare_observations(count)
        self.motion = Motion(
            self.fleet.seen, self.before, self.fleet.extensions, self.fleet.told, self.goals, self._of_task, step_time
        )

    def _prepare_observations(self, count: int) -> None:
        of_cells = tuple((f"extension of {name}, 1", -1.0, 1.0) for name in self.fleet.cells)
        self.told = (*TOLD, *of_cells, *self.task.told)
        # of single precision, as they will be told
        self.low, self.high = (np.array([told[k] for told in self.told], dtype=np.float32) for k in (1, 2))
        self._observed = np.zeros((count, len(self.told)))
        # a row for each glider: NumPy takes twice as long over arrays of unlike shapes
        self._lowest, self._highest = (np.tile(bound.astype(np.float64), (count, 1)) for bound in (self.low, self.high))
        end = SEEN + len(of_cells)
        self._of_glider, self._of_cells = self._observed[:, :SEEN], self._observed[:, SEEN:end]
        self._of_task = self._observed[:, end:]
        self._measured = self.fleet.seen[:, DEPTH:SEEN]
        self._middle = np.tile(0.5 * (self.fleet.low + self.fleet.high), (count, 1))
        self._per_half = np.tile(2.0 / (self.fleet.high - self.fleet.low), (count, 1))
        self._within = np.zeros((count, len(self.actions.names)))
        self._most, self._least = np.ones_like(self._within), -np.ones_like(self._within)

    def begin(self, row: int, random: np.random.Generator, start: Start) -> None:
        """Begin an episode of one glider, with a start and a goal of its own."""
        self.fleet.place(row, **start.draw(random))
        self.before[row] = self.fleet.seen[row]
        self.goals[row] = self.task.draw(self.fleet.seen[row], random)
        self.steps[row] = 0

    def start_for(self, options: Mapping[str, Any] | None) -> Start:
        """Return the start with the ranges of a reset's options in place of its own."""
        return Start(self.fleet.design, {**self.start.ranges, **options}) if options else self.start

    def command(self, actions: NDArray[Any]) -> None:
        """Take actions (m, ...); they are held within -1 to 1.

        Raises
        ------
        ValueError
            Where their shape is another, or one is not a number.

        """
        if actions.shape != self._within.shape:
            raise ValueError(f"actions have shape {actions.shape}, not {self._within.shape}")
        np.copyto(self._within, actions)
        np.minimum(self._within, self._most, out=self._within)
        np.maximum(self._within, self._least, out=self._within)
        if math.isnan(np.vdot(self._within, self._within)):
            row, k = np.argwhere(np.isnan(self._within))[0]
            raise ValueError(
                f"the action for '{self.actions.names[k]}' of glider {row} is not a number, "
                f"at {self.fleet.times[row]:g} s: give one within -1 to 1"
            )
        self.actions.command(self._within)

    def advance(self) -> None:
        """Advance every glider by a step."""
        np.copyto(self.before, self.fleet.seen)
        self.fleet.advance()
        self.steps += 1

    def skip(self, rows: Flags) -> None:
        """Leave these gliders where they are until their episodes begin anew."""
        self.fleet.codes[rows] = CANCELLED

    def observe(self) -> NDArray[np.float32]:
        """Return the observations, (m, ...)."""
        np.copyto(self._of_glider, self._measured)
        np.subtract(self.fleet.extensions, self._middle, out=self._of_cells)
        np.multiply(self._of_cells, self._per_half, out=self._of_cells)
        self.task.tell(self.motion, self._of_task)
        np.maximum(self._observed, self._lowest, out=self._observed)
        np.minimum(self._observed, self._highest, out=self._observed)
        return self._observed.astype(np.float32)

    def ended(self) -> tuple[Flags, Flags]:
        """Return which episodes the glider ended (surface, bed, divergence, task done), and which the time, (m,)."""
        ended, reached = self.fleet.codes != COMPLETED, self.task.reached(self.motion)
        return ended if reached is None else ended | reached, self.steps >= self.most_steps

    def status(self, row: int) -> str:
        """Return how an episode that has ended did: the name of a run's status, or 'reached'."""
        code = int(self.fleet.codes[row])
        if code == COMPLETED and self.steps[row] < self.most_steps:
            return "reached"
        return STATUS_BY_CODE[code].name
