"""Train a small policy to turn to headings by the cross-entropy method: `python examples/train_policy.py`.

Every generation tries 48 linear policies on six gliders each, all in one environment; the best eight say where to look
next (Rubinstein, Kroese, 2004, The Cross-Entropy Method).
"""

from __future__ import annotations

import time

import gymnasium
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
POLICIES, TRIALS, BEST, GENERATIONS = 48, 6, 8, 10
DURATION, STEP_TIME = 150.0, 0.5  # s

envs = gymnasium.make_vec(
    "models.gym_environment:GliderStudio/Glide-v0", num_envs=POLICIES * TRIALS, task="heading",
    initial={"depth": (5.0, 30.0)}, duration=DURATION, step_time=STEP_TIME,
)  # fmt: skip
entries = envs.unwrapped.entries
USED = [entries.index(name) for name in ("roll, rad", "roll rate, rad/s", "yaw rate, rad/s", "heading error, rad")]
SCALE = np.array([1.0, 10.0, 10.0, 1.0, 1.0])  # the last is a constant
SHAPE = (*envs.unwrapped.single_action_space.shape, len(SCALE))  # of the cells' commands by what is used


def returns(policies: Array, seed: int) -> Array:
    """Return what each policy (n, cells, used) earns in an episode, the mean of its gliders."""
    observed, _ = envs.reset(seed=seed)
    weights = np.repeat(policies, TRIALS, axis=0)
    earned, flying = np.zeros(len(weights)), np.ones(len(weights), dtype=bool)
    for _ in range(round(DURATION / STEP_TIME)):
        used = np.column_stack([observed[:, USED], np.ones(len(observed))]) * SCALE
        observed, rewards, terminated, _, _ = envs.step(np.tanh(np.einsum("nij,nj->ni", weights, used)))
        earned += rewards * flying
        flying &= ~terminated
    return earned.reshape(len(policies), TRIALS).mean(axis=1)


random = np.random.default_rng(0)
mean, deviation = np.zeros(SHAPE), np.ones(SHAPE)
began = time.perf_counter()
for generation in range(GENERATIONS):
    policies = mean + deviation * random.standard_normal((POLICIES, *SHAPE))
    policies[0] = mean
    earned = returns(policies, seed=1000 * generation)
    best = policies[np.argsort(earned)[-BEST:]]
    print(f"generation {generation + 1:2}: {earned[0]:6.1f} by their mean, {earned.max():6.1f} by the best")
    mean, deviation = best.mean(axis=0), best.std(axis=0) + 0.05
elapsed = time.perf_counter() - began
steps = GENERATIONS * POLICIES * TRIALS * round(DURATION / STEP_TIME)
final = returns(np.repeat(mean[None], POLICIES, axis=0), seed=10**6).mean()
print(f"{steps / 1e6:.1f} million steps in {elapsed:.1f} s")
print(f"on new headings the mean earns {final:.1f} of {DURATION:.0f}")
