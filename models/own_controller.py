"""Owns runs under a controller written in Python: any function from what is measured to commands, called every sample.

Between its calls the kernel integrates as ever, so a run keeps its events, its error control and its energy balance.
Frames: the body's axes point forward, to starboard and down; the world's north, east and down. SI and radians.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.controllers import Noise
from models.design import Design
from models.kernel.actuators import SAME_TIME
from models.kernel.control import IN_PLANE, see
from models.kernel.control_layout import (
    DEPTH,
    EAST,
    MEASURED,
    NORTH,
    PITCH,
    ROLL,
    ROLL_RATE,
    SURGE,
    YAW,
)
from models.kernel.integrate import COMPLETED, PROGRESS, finish, integrate
from models.kernel.noise import normal
from models.limits import DEFAULT_LIMITS, Limits
from models.problems import DesignError, Problem
from models.run import Run
from models.simulate import STATES, Control, make_record, make_run, make_work

Array = NDArray[np.float64]
SHORTEST_SAMPLE_TIME = 1e-3
"""Between two calls of a controller, s."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """What the instruments say at a sample.

    `time` s; `depth` m; `roll`, `pitch`, `yaw` rad (yaw is the heading, -pi to pi); `velocity` (3,) m/s of the body
    origin through the water and `angular_velocity` (3,) rad/s, both in body axes; `north`, `east` m from the world's
    origin; `extensions` m (rad of a rolling mass) by the name of each part that moves. A planar glider's roll, yaw,
    sway, roll and yaw rate, and east are 0.
    """

    time: float
    depth: float
    roll: float
    pitch: float
    yaw: float
    velocity: Array
    angular_velocity: Array
    north: float
    east: float
    extensions: Mapping[str, float]


OwnController = Callable[[Measurement], Mapping[str, float]]
"""Returns commanded extensions, m or rad, by name; a part that it leaves out keeps its last command."""


def simulate_with(
    design: Design, controller: OwnController, *, sample_time: float, delay: float = 0.0, noise: Noise | None = None,
    limits: Limits = DEFAULT_LIMITS, control: Control | None = None,
) -> Run:  # fmt: skip
    """Simulate a design's mission under a controller of one's own.

    It is called at 0, `sample_time`, 2 `sample_time` ... (s). What it returns reaches the actuators `delay` (s) later
    and is held; a command beyond a stop is held at the stop. A part that it has never named follows its schedule. The
    instruments err by `noise`, drawn anew at every sample. `control` tells the progress and can cancel, as with
    `simulate`.

    Raises
    ------
    DesignError
        Where the design cannot be simulated, or has a controller already.
    ValueError
        Where the sample time or the delay is no such time, or a command names no part that moves or is no finite
        number.
    TypeError
        Where the controller returns no mapping of names to numbers.

    """
    _check_times(sample_time, delay)
    if design.mission.control.controller is not None:
        hint = "remove it (null), or use `simulate`"
        raise DesignError([Problem("/mission/control/controller", "the design has a controller already", hint=hint)])
    assembly = assemble(design, limits)
    loop = _Loop(assembly, controller, sample_time=sample_time, delay=delay, noise=noise or Noise())
    mission, solver = design.mission, design.mission.solver
    y, work, record = assembly.initial_state.copy(), loop.work, make_record(assembly, control, keeps_commands=True)
    began = time.perf_counter()
    t, code = 0.0, COMPLETED
    while code == COMPLETED and t < mission.duration:
        due = loop.run(t, y)
        code = integrate(
            solver.method == "adaptive", t, min(due, mission.duration), solver.step, solver.output_interval,
            limits.steps, y, assembly.params, work, record,
        )  # fmt: skip
        t = float(record.control[PROGRESS])
    finish(t, y, work, record)
    return make_run(assembly, record, int(code), time.perf_counter() - began)


def _check_times(sample_time: float, delay: float) -> None:
    if not SHORTEST_SAMPLE_TIME <= sample_time < math.inf:
        raise ValueError(f"sample_time {sample_time:g} s is not a finite time of {SHORTEST_SAMPLE_TIME:g} s or more")
    if not 0.0 <= delay < math.inf:
        raise ValueError(f"delay {delay:g} s is not a finite time of 0 s or more")


class _Loop:
    """Takes the samples, keeps the commands that wait for their delay, and hands them to the actuators."""

    def __init__(
        self, assembly: Assembly, controller: OwnController, *, sample_time: float, delay: float, noise: Noise
    ) -> None:
        self.assembly, self.controller = assembly, controller
        self.sample_time, self.delay = sample_time, delay
        self.work = make_work(assembly)
        self.sampled = self.applied = 0
        self.waiting: list[dict[int, float]] = []
        self.spread = np.array(
            [noise.depth, *[noise.attitude] * 3, *[noise.velocity] * 3, *[noise.rate] * 3, *[noise.place] * 2]
        )
        self.seed, self.planar = noise.seed, assembly.design.mission.solver.model == "planar"
        self.parts = {name: k for k, name in enumerate(assembly.cells)}
        self.first = len(STATES[assembly.design.mission.solver.model])

    def run(self, t: float, y: Array) -> float:
        """Take the samples and hand over the commands that are due at a time; return when something is due next."""
        now = t + SAME_TIME * max(1.0, abs(t))
        while self.sampled * self.sample_time <= now:
            at = self.sampled * self.sample_time
            self.waiting.append(self._commands(at, self.controller(self._measure(at, y))))
            self.sampled += 1
        while self.waiting and self.applied * self.sample_time + self.delay <= now:
            for part, extension in self.waiting.pop(0).items():
                self.work.told[part] = extension
            self.applied += 1
        due = self.sampled * self.sample_time
        return min(due, self.applied * self.sample_time + self.delay) if self.waiting else due

    def _measure(self, t: float, y: Array) -> Measurement:
        seen = np.zeros(MEASURED)
        see(t, y, self.assembly.params, seen)
        for channel in np.flatnonzero(self.spread):
            if not self.planar or int(channel) in IN_PLANE:
                seen[channel] += self.spread[channel] * normal(self.seed, self.sampled, int(channel))
        extensions = y[self.first : self.first + len(self.parts)].tolist()
        return Measurement(
            time=t, depth=float(seen[DEPTH]), roll=float(seen[ROLL]), pitch=float(seen[PITCH]), yaw=float(seen[YAW]),
            velocity=seen[SURGE : SURGE + 3], angular_velocity=seen[ROLL_RATE : ROLL_RATE + 3],
            north=float(seen[NORTH]), east=float(seen[EAST]),
            extensions=dict(zip(self.parts, extensions, strict=True)),
        )  # fmt: skip

    def _commands(self, t: float, told: Mapping[str, float]) -> dict[int, float]:
        """Return commands by the index of the part, within the stops; raises where one makes no sense."""
        if not isinstance(told, Mapping):
            raise TypeError(
                f"at {t:g} s the controller returned {told!r}: return a mapping of names to extensions, empty to tell "
                "nothing"
            )
        commands: dict[int, float] = {}
        for name, value in told.items():
            part = self.parts.get(name)
            if part is None:
                known = ", ".join(f"'{other}'" for other in self.parts) or "none"
                raise ValueError(
                    f"at {t:g} s the controller told '{name}' {value!r}: no part of this name moves; those are: {known}"
                )
            commands[part] = self._within_stops(t, name, part, value)
        return commands

    def _within_stops(self, t: float, name: str, part: int, value: object) -> float:
        if not isinstance(value, int | float | np.number | np.ndarray) or np.size(value) != 1:
            raise TypeError(f"at {t:g} s the controller told '{name}' {value!r}: return one number, in m or rad")
        extension = float(np.asarray(value).reshape(()))
        row = self.assembly.params.parts[part]
        if not math.isfinite(extension):
            raise ValueError(
                f"at {t:g} s the controller told '{name}' {extension}: return a finite number from "
                f"{row['stop_low']:g} to {row['stop_high']:g}, or leave the part out"
            )
        return min(max(extension, float(row["stop_low"])), float(row["stop_high"]))
