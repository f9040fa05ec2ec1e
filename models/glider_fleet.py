"""Owns many gliders of one design that are told their commands from outside, advanced together by the kernel.

The rows of every array are the gliders; they share nothing but the design, so each moves as it would alone. The kernel
takes fixed RK4 steps, ended early only where an actuator reaches its command or its rate limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from models.allocation import AXES, authority, effectiveness
from models.assemble import assemble
from models.attitude import quaternion_from_rpy_radians
from models.design import Design
from models.kernel import params
from models.kernel import spatial_layout as spatial
from models.kernel.control import see
from models.kernel.control_layout import MEASURED, PITCH, ROLL_RATE, SURGE, YAW_RATE
from models.kernel.environments import advance_many, allocate_many
from models.kernel.integrate import COMPLETED
from models.mission import Control

Array = NDArray[np.float64]
Range = float | tuple[float, float]
"""One value, or a lowest and a highest between which it is drawn uniformly."""
ACCURACY = 1e-3
"""Within which a step and its half must agree in velocity (m/s), roll and pitch (rad) and rates (rad/s)."""
TRIAL_TIME = 30.0
"""Over which they are compared, s."""
MOST_HALVINGS = 8
MOST_STEPS = 1_000_000
"""Of RK4 within one step of an environment."""


class Fleet:
    """Gliders of one design: `states` (m, n), `seen` (m, MEASURED), `told` (m, cells) and `codes` (m,) of the kernel.

    `told` are the commands (m or rad), which `command` writes. `step_time` (s) is what `advance` advances by, `step`
    (s) the RK4 step. With `threads` the rows are split among as many, which changes no number.
    """

    def __init__(self, design: Design, count: int, *, step_time: float, step: float, threads: int = 1) -> None:
        # everything is told, so neither the schedules nor a controller count
        mission = design.mission.model_copy(update={"control": Control()})
        self.design = design.model_copy(update={"mission": mission})
        assembly = assemble(self.design)
        self.cells, self.start = assembly.cells, assembly.initial_state
        self.params = assembly.params
        self.first = int(self.params.space["extensions"][0])
        self.low, self.high = (np.array(self.params.parts[name]) for name in ("stop_low", "stop_high"))
        self.states, self.times = np.tile(self.start, (count, 1)), np.zeros(count)
        self.told, self.codes = np.tile(self._extensions_of(self.states)[:1], (count, 1)), np.zeros(count, np.int64)
        self.seen = np.zeros((count, MEASURED))
        self.extensions = self._extensions_of(self.states)
        self.step_time, self.step = step_time, step
        n, parts = len(self.start), len(self.cells)
        chunks = [c for c in np.array_split(np.arange(count), max(threads, 1)) if len(c)]
        self._calls = [
            (
                False, self.times[rows], step_time, step, MOST_STEPS, self.states[rows], self.told[rows],
                self.codes[rows], self.seen[rows], self.params, params.make_work(n, parts),
                params.make_record(0, n, 1, np.zeros(2)),
            )
            for rows in (slice(int(c[0]), int(c[-1]) + 1) for c in chunks)
        ]  # fmt: skip
        self._pool = ThreadPoolExecutor(len(chunks)) if len(chunks) > 1 else None

    def _extensions_of(self, states: Array) -> Array:
        return states[:, self.first : self.first + len(self.cells)]

    def advance(self) -> None:
        """Advance every glider whose code is that of a completed run by `step_time`, and measure it."""
        if self._pool is None:
            advance_many(*self._calls[0])
        else:
            list(self._pool.map(lambda arguments: advance_many(*arguments), self._calls))

    def place(self, row: int, *, depth: float, roll: float, pitch: float, heading: float) -> None:
        """Put one glider back to the mission's start, at another depth (m) and attitude (rad)."""
        y, seen = self.states[row], self.seen[row]
        y[:] = self.start
        y[int(self.params.space["depth"][0])] = depth
        if self.params.space["spatial"][0]:
            y[spatial.Q0 : spatial.Q3 + 1] = quaternion_from_rpy_radians(roll, pitch, heading)
            velocity = np.array(self.design.mission.initial.velocity)
            y[spatial.U : spatial.W + 1] = velocity
            see(0.0, y, self.params, seen)
            # seen is the velocity less the current: add that, so that the mission's velocity is through the water
            y[spatial.U : spatial.W + 1] += velocity - seen[SURGE : SURGE + 3]
        else:
            y[params.THETA] = pitch
        see(0.0, y, self.params, seen)
        self.told[row] = self.extensions[row]
        self.times[row], self.codes[row] = 0.0, COMPLETED

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()


class CellActions:
    """Actions are commanded extensions: -1 and 1 the stops of each cell."""

    def __init__(self, fleet: Fleet) -> None:
        if not fleet.cells:
            raise ValueError("the design has no part that moves: there is nothing to command")
        self.names, self.told = fleet.cells, fleet.told
        count = len(fleet.told)
        self.middle = np.tile(0.5 * (fleet.low + fleet.high), (count, 1))
        self.half = np.tile(0.5 * (fleet.high - fleet.low), (count, 1))

    def command(self, actions: Array) -> None:
        """Write the commands for actions (m, cells) within -1 to 1."""
        np.multiply(actions, self.half, out=self.told)
        np.add(self.told, self.middle, out=self.told)


class ForceActions:
    """Actions are heave (up), pitch moment (nose up) and roll moment (starboard down) from neutral, by allocation.

    1 is the authority of the axis: the sum over the cells of what half a stroke does. Only axes that the cells can hold
    apart from the others count.
    """

    def __init__(self, fleet: Fleet) -> None:
        cells = effectiveness(fleet.design)
        self.names = authority(cells).holds
        if not self.names:
            raise ValueError("the cells can hold neither heave nor pitch nor roll apart from the others: use 'cells'")
        self.axes = [AXES.index(name) for name in self.names]
        self.rows, _ = cells.rows()
        self.wishes, self.share = np.zeros((len(fleet.told), len(AXES))), np.zeros(len(fleet.cells))
        self.told = fleet.told

    def command(self, actions: Array) -> None:
        """Write the commands for actions (m, axes) within -1 to 1."""
        self.wishes[:, self.axes] = actions  # scaled by the authorities, as the rows are
        allocate_many(self.wishes, self.rows, self.share, self.told)


Action = Literal["cells", "forces"]
"""What an environment's actions are."""


def actions_of(fleet: Fleet, action: Action) -> CellActions | ForceActions:
    """Return what turns actions into commands; raises `ValueError` where there is no such thing, or nothing to move."""
    if action not in get_args(Action):
        raise ValueError(f"there are no actions '{action}': those are {', '.join(get_args(Action))}")
    return CellActions(fleet) if action == "cells" else ForceActions(fleet)


class Start:
    """Draws where and how a glider begins: ranges of depth (m), roll, pitch and heading (rad), else the mission's."""

    NAMES = ("depth", "roll", "pitch", "heading")

    def __init__(self, design: Design, ranges: Mapping[str, Range] | None = None) -> None:
        initial = design.mission.initial
        self.design = design
        self.ranges: dict[str, Range] = {
            "depth": initial.position[2], "roll": initial.roll, "pitch": initial.pitch, "heading": initial.yaw,
        }  # fmt: skip
        for name, value in (ranges or {}).items():
            self._check(name, value)
            self.ranges[name] = value

    def _check(self, name: str, value: Range) -> None:
        if name not in self.NAMES:
            raise ValueError(f"there is no initial '{name}': those are {', '.join(self.NAMES)}")
        low, high = value if isinstance(value, tuple | list) else (value, value)
        bed = self.design.mission.environment.bed_depth
        least, most = {
            "depth": (0.0, math.inf if bed is None else bed), "pitch": (-math.pi / 2.0, math.pi / 2.0),
        }.get(name, (-math.pi, math.pi))  # fmt: skip
        if not (least <= low <= high <= most and math.isfinite(high)):
            raise ValueError(f"initial {name} {value} is not a rising range within {least:.6g} to {most:.6g}")
        if self.design.mission.solver.model == "planar" and name in ("roll", "heading") and (low, high) != (0.0, 0.0):
            raise ValueError(f"initial {name} {value}: the planar model has no bank and no heading; leave it out")

    def draw(self, random: np.random.Generator) -> dict[str, float]:
        """Return one start; only ranges draw."""
        return {
            name: float(random.uniform(*value) if isinstance(value, tuple | list) else value)
            for name, value in self.ranges.items()
        }


def accurate_step(design: Design, step_time: float) -> float:
    """Return the longest of `step_time`, its half, quarter ... (s) that is accurate enough for a glider.

    Eight gliders are told random extensions over `TRIAL_TIME`; a step is taken once it and its half agree within
    `ACCURACY`.

    Raises
    ------
    ValueError
        Where none down to a 256th does.

    """
    coarse = _trial(design, step_time, step_time)
    for halvings in range(MOST_HALVINGS + 1):
        step = step_time * 0.5**halvings
        fine = _trial(design, step_time, 0.5 * step)
        with np.errstate(invalid="ignore", over="ignore"):
            if np.abs(fine - coarse).max() <= ACCURACY:
                return step
        coarse = fine
    raise ValueError(
        f"no RK4 step from {step_time:g} s down to {step_time * 0.5**MOST_HALVINGS:g} s keeps this glider's motion "
        f"within {ACCURACY:g} of that with half of it: choose a shorter step_time, or give `step`"
    )


def _trial(design: Design, step_time: float, step: float) -> Array:
    """Return velocities, roll, pitch and rates of the trial with one step, over its samples and gliders."""
    fleet = Fleet(design, 8, step_time=step_time, step=step)
    random = np.random.default_rng(0)
    samples = max(math.ceil(TRIAL_TIME / step_time), 2)
    changes = max(samples // 5, 1)
    seen = np.zeros((samples, *fleet.seen.shape))
    for k in range(samples):
        if k % changes == 0:
            fleet.told[:] = random.uniform(fleet.low, fleet.high, fleet.told.shape)
        fleet.advance()
        seen[k] = fleet.seen
    angles, rates = seen[..., PITCH - 1 : PITCH + 1], seen[..., ROLL_RATE : YAW_RATE + 1]
    return np.concatenate([angles, seen[..., SURGE : SURGE + 3], rates], axis=-1)
