"""Owns what a glider in an environment is to do: the goal of an episode, how it is told, and what is rewarded.

Everything works on all gliders at once, with one row each, and by operations on single numbers only, so that a glider
among many earns what it earns alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from models.kernel.control_layout import DEPTH, EAST, NORTH, SURGE, YAW

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Motion:
    """What a reward is given after a step; every array has one row for each glider. Read only.

    `seen` and `before` (m, 12) are what ideal instruments measure after and before the step, by the indices of
    `models.kernel.control_layout` (DEPTH m; ROLL, PITCH, YAW rad; SURGE, SWAY, HEAVE m/s through the water; ROLL_RATE,
    PITCH_RATE, YAW_RATE rad/s; NORTH, EAST m). `extensions` and `told` (m, cells) are extensions and commands (m or
    rad), `goal` (m, ...) what the task drew for the episode and `entries` (m, ...) what it told of it after the step,
    `step_time` s.
    """

    seen: Array
    before: Array
    extensions: Array
    told: Array
    goal: Array
    entries: Array
    step_time: float


Reward = Callable[[Motion], Array]
"""Returns the rewards of one step, (m,)."""
Told = tuple[str, float, float]
"""An entry of an observation: its name with the unit, its lowest and its highest value."""


class Task(Protocol):
    """What an environment asks of a task; any object with these will do."""

    @property
    def told(self) -> tuple[Told, ...]:
        """Entries that the task adds to an observation."""

    def draw(self, seen: Array, random: np.random.Generator) -> tuple[float, ...]:
        """Return the goal of an episode that begins with what is seen (12,): a row of `Motion.goal`."""

    def tell(self, motion: Motion, out: Array) -> None:
        """Write the task's entries of the observations into `out` (m, entries)."""

    def reward(self, motion: Motion) -> Array:
        """Return the rewards of one step, (m,)."""

    def reached(self, motion: Motion) -> NDArray[np.bool_] | None:
        """Return which gliders have done their task, (m,), which ends their episodes; None for a task without end."""


def wrapped(angle: Array) -> Array:
    """Return angles within -pi to pi, rad."""
    turns = angle * (0.5 / math.pi)
    np.rint(turns, out=turns)
    turns *= 2.0 * math.pi
    return np.asarray(angle - turns)


@dataclass(frozen=True)
class HoldHeading:
    """Turn to a heading and hold it: rewarded by 1 - 2 |error| / pi each second (1 on it, 0 across, -1 against it).

    `heading` rad; where it is None every episode draws its own, within `turn` rad of the initial one.
    """

    heading: float | None = None
    turn: float = math.pi
    told: tuple[Told, ...] = (("heading error, rad", -math.pi, math.pi),)

    def draw(self, seen: Array, random: np.random.Generator) -> tuple[float, ...]:
        """Return the heading, rad."""
        if self.heading is not None:
            return (self.heading,)
        return (float(seen[YAW]) + random.uniform(-self.turn, self.turn),)

    def tell(self, motion: Motion, out: Array) -> None:
        """Write heading less yaw."""
        out[:, 0] = wrapped(motion.goal[:, 0] - motion.seen[:, YAW])

    def reward(self, motion: Motion) -> Array:
        """Return 1 - 2 |error| / pi, times the time."""
        error = np.abs(motion.entries[:, 0])
        return np.asarray(motion.step_time - (2.0 / math.pi * motion.step_time) * error)

    def reached(self, motion: Motion) -> None:
        """Return nothing: there is always more to hold."""


@dataclass(frozen=True)
class StayInBand:
    """Glide ahead between two depths: rewarded by the way made forward through the water (m), less a price.

    The price is `price` for each second and metre above `top` or below `bottom` (m).
    """

    top: float = 10.0
    bottom: float = 40.0
    price: float = 0.2
    told: tuple[Told, ...] = (("depth below the top, m", -1.2e4, 1.2e4), ("depth above the bottom, m", -1.2e4, 1.2e4))

    def __post_init__(self) -> None:
        if not 0.0 <= self.top < self.bottom:
            raise ValueError(f"top {self.top:g} m is not above bottom {self.bottom:g} m, both below the surface")

    def draw(self, seen: Array, random: np.random.Generator) -> tuple[float, ...]:
        """Return the band."""
        return self.top, self.bottom

    def tell(self, motion: Motion, out: Array) -> None:
        """Write how far the edges are."""
        np.subtract(motion.seen[:, DEPTH], motion.goal[:, 0], out=out[:, 0])
        np.subtract(motion.goal[:, 1], motion.seen[:, DEPTH], out=out[:, 1])

    def reward(self, motion: Motion) -> Array:
        """Return the way made, less the price."""
        outside = np.maximum(-motion.entries.min(axis=1), 0.0)
        return np.asarray(motion.step_time * (motion.seen[:, SURGE] - self.price * outside))

    def reached(self, motion: Motion) -> None:
        """Return nothing: there is always further to go."""


@dataclass(frozen=True)
class ReachWaypoint:
    """Glide to a place drawn for each episode: rewarded by the metres that it comes nearer, and ended within `radius`.

    It lies `distance` (lowest, highest; m) away, within `turn` (rad) of the initial heading.
    """

    distance: tuple[float, float] = (40.0, 80.0)
    turn: float = math.pi / 3.0
    radius: float = 5.0
    told: tuple[Told, ...] = (("bearing of the place from the bow, rad", -math.pi, math.pi), ("distance, m", 0.0, 1e6))

    def draw(self, seen: Array, random: np.random.Generator) -> tuple[float, ...]:
        """Return the place, north and east."""
        distance = random.uniform(*self.distance)
        bearing = float(seen[YAW]) + random.uniform(-self.turn, self.turn)
        return float(seen[NORTH]) + distance * math.cos(bearing), float(seen[EAST]) + distance * math.sin(bearing)

    def _distances(self, motion: Motion, seen: Array) -> Array:
        """Return how far the place is, (m,) m."""
        north, east = motion.goal[:, 0] - seen[:, NORTH], motion.goal[:, 1] - seen[:, EAST]
        return np.asarray(np.sqrt(north * north + east * east))

    def tell(self, motion: Motion, out: Array) -> None:
        """Write bearing and distance."""
        north, east = motion.goal[:, 0] - motion.seen[:, NORTH], motion.goal[:, 1] - motion.seen[:, EAST]
        out[:, 0] = wrapped(np.arctan2(east, north) - motion.seen[:, YAW])
        out[:, 1] = self._distances(motion, motion.seen)

    def reward(self, motion: Motion) -> Array:
        """Return by how much the place came nearer, m."""
        return np.asarray(self._distances(motion, motion.before) - motion.entries[:, 1])

    def reached(self, motion: Motion) -> NDArray[np.bool_]:
        """Return which gliders are within the radius."""
        return np.asarray(motion.entries[:, 1] <= self.radius)


TASKS: dict[str, Callable[[], Task]] = {
    "heading": HoldHeading, "depth_band": StayInBand, "waypoint": ReachWaypoint,
}  # fmt: skip
"""Tasks by the name that an environment takes."""
