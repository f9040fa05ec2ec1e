"""Owns gains of state feedback on a sampled model: by least quadratic cost, and by poles where they are asked for."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from models.problems import DesignError, Problem
from models.sampled_model import SampledModel

Array = NDArray[np.float64]
LEAST_DIRECTION = 1e-8
"""Inputs whose effect is below this share of the largest do nothing that others do not."""
MET = 1e-6
"""Poles of the sampled loop are where they were asked for within this, as far as rounding allows."""


def cost_over(A: Array, B: Array, Q: Array, R: Array, *, time: float) -> Array:
    """Return the weight on [x, u] (states + cells, square) that costs what x'Q x + u'R u does over a time (s), u held.

    Weights then mean the same at any sample time. Of a short time by one matrix exponential (Van Loan, 1978, IEEE TAC
    23, 395), and twice that time costs W + M'W M, M being the motion over it.
    """
    n, m = B.shape
    size = n + m
    motion, weight = np.zeros((size, size)), np.zeros((size, size))
    motion[:n, :n], motion[:n, n:] = A, B
    weight[:n, :n], weight[n:, n:] = Q, R
    doublings = max(0, math.ceil(math.log2(max(float(np.abs(A).sum(axis=1).max()) * time, 1.0))) + 1)
    whole = np.zeros((2 * size, 2 * size))
    whole[:size, :size], whole[:size, size:], whole[size:, size:] = -motion.T, weight, motion
    moved = expm(whole * (time / 2.0**doublings))
    over = moved[size:, size:]
    cost = over.T @ moved[:size, size:]
    for _ in range(doublings):
        cost = cost + over.T @ cost @ over
        over = over @ over
    return np.asarray(0.5 * (cost + cost.T), dtype=np.float64)


def lqr_weights(
    A: Array, B: Array, *, deviations: Array, commands: Array, sums: Array, sample_time: float
) -> tuple[Array, Array, Array]:
    """Return Q, R, N of a sampled model with integrals by Bryson's rule, from largest acceptable departures.

    `deviations` (states,), `commands` (cells,) and `sums` (integrals,) are those of states, commands and integrals.
    """
    n, k = len(deviations), len(sums)
    cost = cost_over(A, B, np.diag(deviations**-2.0), np.diag(commands**-2.0), time=sample_time)
    Q, R, N = cost[:n, :n], cost[n:, n:], cost[:n, n:]
    whole = np.zeros((n + k, n + k))
    whole[:n, :n], whole[n:, n:] = Q, np.diag(sample_time * sums**-2.0)
    return whole, R, np.vstack([N, np.zeros((k, len(commands)))])


def lqr_gains(model: SampledModel, Q: Array, R: Array, N: Array) -> Array:
    """Return the gains (cells, states) of least cost, the sum of x'Q x + u'R u + 2 x'N u over all samples.

    States and commands are scaled by their weights first, as the Riccati equation is solved better so.

    Raises
    ------
    DesignError
        Where the Riccati equation has no stabilising solution.

    """
    import control

    x, u = 1.0 / np.sqrt(np.diag(Q)), 1.0 / np.sqrt(np.diag(R))
    F, G = model.F * x / x[:, None], model.G * u / x[:, None]
    try:
        gains, _, _ = control.dlqr(F, G, Q * np.outer(x, x), R * np.outer(u, u), N * np.outer(x, u))
    except (np.linalg.LinAlgError, control.ControlDimension, ValueError) as error:
        hint = "leave out states that the cells hardly move, or give them more room (deviations)"
        message = f"no gains of least cost exist: {error}"
        raise DesignError([Problem("/options/states", message, hint=hint)]) from error
    return np.asarray(u[:, None] * gains / x, dtype=np.float64)


def placed_gains(model: SampledModel, poles: Sequence[complex], *, states: Array, commands: Array) -> Array:
    """Return gains (cells, states) that place the poles (1/s) of the sampled loop at exp(s T).

    What freedom several cells leave makes the eigenvectors as independent as can be (Tits and Yang, 1996), in states
    and commands scaled by `states` (states,) and `commands` (cells,).

    Raises
    ------
    DesignError
        Where the number of poles is not that of the states, or one is repeated more often than the cells can do.

    """
    n = len(model.states)
    if len(poles) != n:
        known = ", ".join(model.states)
        message = f"{len(poles)} poles are given, {n} are needed: one for each of {known}"
        raise DesignError([Problem("/options/poles", message, limit=n)])
    F, G = model.F * states / states[:, None], model.G * commands / states[:, None]
    _, sizes, directions = np.linalg.svd(G, full_matrices=False)
    rank = int(np.sum(sizes > LEAST_DIRECTION * sizes.max(initial=0.0)))
    pole, times = Counter(poles).most_common(1)[0]
    if times > rank:
        message = f"pole {pole.real:g} {pole.imag:+g}j 1/s is asked for {times} times; the cells allow {rank}"
        raise DesignError([Problem("/options/poles", message, limit=rank, hint="set them slightly apart")])
    # cells that do the same make one input: what is asked of it is shared by least squares
    shared = directions[:rank].T
    wanted = np.exp(np.array(poles) * model.sample_time)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that the last digits of robustness were not reached
            import control  # loading it takes most of a second

            gains = shared @ control.place(F, G @ shared, wanted)
    except (ValueError, np.linalg.LinAlgError) as error:
        hint = "ask for poles nearer to those of the glider, or further apart"
        raise DesignError([Problem("/options/poles", f"these poles cannot be placed: {error}", hint=hint)]) from error
    return np.asarray(commands[:, None] * gains / states, dtype=np.float64)


def missed_by(model: SampledModel, gains: Array, poles: Sequence[complex]) -> float:
    """Return by how much the eigenvalues of the sampled loop miss exp(s T), the largest of nearest pairs."""
    left = list(np.linalg.eigvals(model.closed(gains)))
    worst = 0.0
    for wanted in np.exp(np.array(poles) * model.sample_time):
        nearest = min(range(len(left)), key=lambda k: abs(left[k] - wanted))
        worst = max(worst, abs(left.pop(nearest) - wanted))
    return worst
