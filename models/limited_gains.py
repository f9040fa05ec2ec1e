"""Owns gains of least cost among those that the controller can have: on the states fed back, with delay and lags.

Commands under way, and states or lags that are not fed back, are part of the motion but not of the law; the Riccati
equation then gives no answer, and the cost is lowered step by step (Levine and Athans, 1970, IEEE TAC 15, 44; in
discrete time and with these steps: Moerder and Calise, 1985, J. Guidance 8, 529).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_lyapunov

from models.feedback_gains import cost_over
from models.feedback_problem import FeedbackProblem
from models.modes import EXTENSION
from models.sampled_model import SampledModel, held_over, radius_of, split_delay

Array = NDArray[np.float64]
MOST_STEPS = 100
LARGEST = 64
"""States beyond which the steps would take minutes."""
SETTLED = 1e-9
"""The search ends where a step lowers the cost by less than this share."""
USUAL = 0.1
"""Departure of a state that is not fed back, with which responses begin, rad, m/s, rad/s."""
STABLE = 1.0 - 1e-7
FACTORS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
"""Factors on the first gains, of which the first that is stable is the start."""


class Cost(NamedTuple):
    """x'Q x + 2 x'N u + u'R u of one sample over the states of a sampled model, and the spread of starts (states,)."""

    Q: Array
    N: Array
    R: Array
    start: Array


class Step(NamedTuple):
    """Cost of some gains, and the gains towards which it falls."""

    cost: float
    toward: Array


def limited_gains(problem: FeedbackProblem, gains: Array, sums: Array) -> Array | None:
    """Return gains (cells, states + integrals) of least cost with delay, lags and all states, or None.

    `gains` are a first guess, `sums` (integrals,) the largest acceptable integrals. None where no multiple of the guess
    is stable, or delays make the model too large.
    """
    model = problem.whole()
    if len(model.states) > LARGEST:
        return None
    fed, n = len(problem.states), model.motion
    columns = np.array([*range(fed), *range(n, n + model.sums)])
    cost = cost_of(problem, model, sums)
    tried = (factor * model.feedback(problem.widened(gains)) for factor in FACTORS)
    wide = next((each for each in tried if radius_of(model.F - model.G @ each) < STABLE), None)
    if wide is None:
        return None
    here = step_from(model, cost, wide, columns)
    for _ in range(MOST_STEPS):
        share, better = 1.0, None
        while share > 1e-4 and better is None:
            there = wide + share * (here.toward - wide)
            if radius_of(model.F - model.G @ there) < STABLE:
                step = step_from(model, cost, there, columns)
                better = step if step.cost < here.cost else None
            share *= 0.5
        if better is None:
            break
        gained, wide, here = here.cost - better.cost, there, better
        if gained < SETTLED * here.cost:
            break
    return wide[:, columns]


def cost_of(problem: FeedbackProblem, model: SampledModel, sums: Array) -> Cost:
    """Return the cost of one sample, the old command acting until the delay's rest and the new one from then on."""
    n, m = model.motion, len(model.cells)
    A, B, T = problem.model.A, problem.model.B, model.sample_time
    weights = np.zeros(n)
    weights[: len(problem.states)] = problem.deviations**-2.0
    Q, R = np.diag(weights), np.diag(problem.commands**-2.0)
    whole, rest = split_delay(model.delay, T)
    size = len(model.states)
    early, late = np.zeros((n + m, size + m)), np.zeros((n + m, size + m))
    after, through = held_over(A, B, rest)
    for to, age in ((early, whole + 1), (late, whole)):
        first = size if age == 0 else n + model.sums + (age - 1) * m
        if first + m <= size + m and (age > 0 or to is late) and (rest > 0.0 or to is late):
            to[n:, first : first + m] = np.eye(m)
    early[:n, :n] = np.eye(n)
    late[:n] = after @ early[:n] + through @ early[n:]
    parts = [(late, T - rest)] + ([(early, rest)] if rest > 0.0 else [])
    total = sum(to.T @ cost_over(A, B, Q, R, time=time) @ to for to, time in parts)
    total = np.asarray(total, dtype=np.float64)
    total[range(n, n + model.sums), range(n, n + model.sums)] += T * sums**-2.0
    start = np.zeros(size)
    usual = [0.0 if name.startswith(EXTENSION) else USUAL for name in model.states[len(problem.states) : n]]
    start[:n] = np.concatenate([problem.deviations, usual])
    return Cost(total[:size, :size], total[:size, size:], total[size:, size:], start)


def step_from(model: SampledModel, cost: Cost, wide: Array, columns: NDArray[np.int64]) -> Step:
    """Return the cost of gains (cells, states), and where its gradient over the free columns would vanish.

    With P the cost of a start and S the sum of x x' over all samples that is (R + G'P G) K = (N' + G'P F) S C' (C S
    C')^-1.
    """
    closed = model.F - model.G @ wide
    stage = cost.Q - cost.N @ wide - wide.T @ cost.N.T + wide.T @ cost.R @ wide
    spread = np.diag(cost.start**2)
    P, S = solve_discrete_lyapunov(closed.T, stage), solve_discrete_lyapunov(closed, spread)
    wanted = np.linalg.solve(cost.R + model.G.T @ P @ model.G, cost.N.T + model.G.T @ P @ model.F)
    toward = np.zeros_like(wide)
    scale = np.sqrt(np.diag(S)[columns])
    inner = S[np.ix_(columns, columns)] / scale[:, None] / scale
    outer = wanted @ S[:, columns] / scale
    toward[:, columns] = np.linalg.lstsq(inner, outer.T, rcond=1e-12)[0].T / scale
    return Step(float(np.sum(P * spread)), toward)
