"""Owns gliders as Gymnasium environments: one glider, or many that one call of the kernel advances.

`gymnasium.make("models.gym_environment:GliderStudio/Glide-v0", design=...)` imports this module, which registers them.

An observation is a row of single-precision numbers: depth (m), roll, pitch and yaw (rad), velocity through the water in
body axes (m/s), angular velocity (rad/s), the extension of each cell as a share of its stroke (-1 to 1), and what the
task tells; `entries` names them with their units. Actions within -1 to 1 are commands to the cells, or heave, pitch and
roll; they are held for `step_time`. An episode is terminated where the mission's surface or bed ends a run, where the
motion diverges or the task is done, and truncated at the mission's duration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from models.design import Design
from models.glide_episodes import Episodes
from models.glide_tasks import Reward, Task
from models.glider_fleet import Action, Range

Array = NDArray[np.float64]
Observation = NDArray[np.float32]
Flags = NDArray[np.bool_]
ID = "GliderStudio/Glide-v0"
STEP_TIME = 0.25
"""Between two actions, s."""


def spaces_of(episodes: Episodes) -> tuple[gymnasium.Space[Observation], gymnasium.Space[NDArray[Any]]]:
    """Return the spaces of observations and actions of one glider."""
    return (
        Box(episodes.low, episodes.high, dtype=np.float32),
        Box(-1.0, 1.0, (len(episodes.actions.names),), dtype=np.float32),
    )


class GliderEnv(gymnasium.Env[Observation, NDArray[Any]]):
    """One glider.

    Parameters
    ----------
    design
        A design, or the name of a preset; its schedules and its controller play no part.
    task
        "heading", "depth_band", "waypoint", or a task of one's own (`models.glide_tasks`).
    reward
        A function of `Motion` in place of the task's.
    action
        "cells": commanded extensions, -1 and 1 the stops; "forces": heave (up), pitch (nose up) and roll (starboard
        down), as far as the cells can hold them apart, 1 the authority of all cells together.
    initial
        Ranges from which depth (m), roll, pitch and heading (rad) are drawn at a reset, as name: (low, high), or one
        value; else the mission's. A reset's `options` take the same and go before.
    step_time
        Between two actions, s.
    step
        Of RK4, s; where None the longest that is accurate enough (`accurate_step`).
    duration
        Of an episode, s; the mission's where None.

    Raises
    ------
    DesignError
        Where the design cannot be simulated.
    ValueError
        Where an argument, an option or an action makes no sense.

    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self, design: Design | str = "quad-bellows-glide", *, task: str | Task = "heading",
        reward: Reward | None = None, action: Action = "cells", initial: Mapping[str, Range] | None = None,
        step_time: float = STEP_TIME, step: float | None = None, duration: float | None = None,
    ) -> None:  # fmt: skip
        self.episodes = Episodes(
            design, 1, task=task, reward=reward, action=action, initial=initial, step_time=step_time, step=step,
            duration=duration, threads=1,
        )  # fmt: skip
        self.observation_space, self.action_space = spaces_of(self.episodes)
        self.entries = tuple(name for name, _low, _high in self.episodes.told)
        self.step_size = self.episodes.fleet.step

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; `options` take initial values or ranges."""
        super().reset(seed=seed)
        self.episodes.begin(0, self.np_random, self.episodes.start_for(options))
        return self.episodes.observe()[0], {}

    def step(self, action: NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for `step_time`; at the end of an episode the info's `status` says how it ended."""
        episodes = self.episodes
        episodes.command(np.asarray(action)[None])
        episodes.advance()
        observed = episodes.observe()[0]
        reward = float(episodes.reward_of(episodes.motion)[0])
        ended, out_of_time = episodes.ended()
        terminated, truncated = bool(ended[0]), bool(out_of_time[0])
        info = {"status": episodes.status(0)} if terminated or truncated else {}
        return observed, reward, terminated, truncated, info


class GliderVectorEnv(VectorEnv[Observation, NDArray[Any], NDArray[Any]]):
    """Many gliders of one design, each as it would be in a `GliderEnv` with its seed; parameters as there.

    `reset(seed=s)` seeds glider k with s + k. An episode that has ended begins anew with the next step, whose action is
    ignored and whose reward is 0. With `threads` the gliders are split among as many.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self, num_envs: int = 1, design: Design | str = "quad-bellows-glide", *, task: str | Task = "heading",
        reward: Reward | None = None, action: Action = "cells", initial: Mapping[str, Range] | None = None,
        step_time: float = STEP_TIME, step: float | None = None, duration: float | None = None, threads: int = 1,
    ) -> None:  # fmt: skip
        if num_envs < 1:
            raise ValueError(f"num_envs {num_envs} is not 1 or more")
        self.num_envs = num_envs
        self.episodes = Episodes(
            design, num_envs, task=task, reward=reward, action=action, initial=initial, step_time=step_time, step=step,
            duration=duration, threads=threads,
        )  # fmt: skip
        self.single_observation_space, self.single_action_space = spaces_of(self.episodes)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.entries = tuple(name for name, _low, _high in self.episodes.told)
        self.step_size = self.episodes.fleet.step
        self._randoms: list[np.random.Generator] = []
        self._ended = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin all episodes; `seed` is one for the first glider, or one for each."""
        self._seed(seed)
        start = self.episodes.start_for(options)
        for row, random in enumerate(self._randoms):
            self.episodes.begin(row, random, start)
        self._ended[:] = False
        return self.episodes.observe(), {}

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        if isinstance(seed, int | np.integer):
            super().reset(seed=int(seed))
            seed = [int(seed) + k for k in range(self.num_envs)]
        if seed is None:
            seed = [None] * self.num_envs
        if len(seed) != self.num_envs:
            raise ValueError(f"{len(seed)} seeds for {self.num_envs} environments: give one for each, or one number")
        if not self._randoms:
            self._randoms = [seeding.np_random(one)[0] for one in seed]
        else:
            self._randoms = [
                old if one is None else seeding.np_random(one)[0] for old, one in zip(self._randoms, seed, strict=True)
            ]

    def step(self, actions: NDArray[Any]) -> tuple[Observation, Array, Flags, Flags, dict[str, Any]]:
        """Hold an action of each glider for `step_time`; the info's `status` says how an episode ended."""
        if not self._randoms:
            raise gymnasium.error.ResetNeeded("call reset before step")
        episodes, fresh = self.episodes, self._ended
        begins = bool(fresh.any())
        episodes.command(np.asarray(actions))
        if begins:
            episodes.skip(fresh)
        episodes.advance()
        if begins:
            for row in np.flatnonzero(fresh).tolist():
                episodes.begin(row, self._randoms[row], episodes.start)
        observed = episodes.observe()
        rewards = episodes.reward_of(episodes.motion)
        terminated, truncated = episodes.ended()
        if begins:
            rewards = np.where(fresh, 0.0, rewards)
            terminated &= ~fresh
        self._ended = terminated | truncated
        return observed, rewards, terminated, truncated, self._infos()

    def _infos(self) -> dict[str, Any]:
        if not self._ended.any():
            return {}
        status = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(self._ended).tolist():
            status[row] = self.episodes.status(row)
        return {"status": status, "_status": self._ended.copy()}

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self.episodes.fleet.close()


if ID not in gymnasium.registry:
    gymnasium.register(
        ID, entry_point="models.gym_environment:GliderEnv",
        vector_entry_point="models.gym_environment:GliderVectorEnv",
    )  # fmt: skip
