"""Owns how fast a small disturbance of a motion grows: the largest real part of its eigenvalues, at any attitude."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.attitude import rotation_of
from models.kernel import params, spatial_layout, steady
from models.kernel.actuators import STEADY
from models.kernel.model import derivative
from models.kernel.params import Params, make_work
from models.kernel.spatial_layout import Q0, P, U
from models.linearize import carried, motion_matrix
from models.steady_problem import SteadyProblem

Array = NDArray[np.float64]
NEARLY_VERTICAL = 4e-3
"""Cosine of the pitch below which Euler angles are left: the vector down in body axes takes their place in space."""
STEP = 1e-5


def growth_of(problem: SteadyProblem, motion: Array) -> float:
    """Return the growth of a disturbance, 1/s: negative where every one dies out; depth, heading, extensions held."""
    y = np.zeros(len(problem.assembly.initial_state))
    steady.write_steady(motion, problem.depth, y, problem.params)
    return growth_at_state(problem.assembly, problem.params, y)


def growth_at_state(assembly: Assembly, p: Params, state: Array, *, time: float = 0.0) -> float:
    """Return the growth of a disturbance of a state of the kernel, 1/s, the motion frozen as it is at a time (s).

    Depth, heading and extensions are held; velocities in `state` are over ground.
    """
    y = np.asarray(state, dtype=np.float64)
    if abs(_cosine_of_pitch(p, y)) > NEARLY_VERTICAL:
        A = motion_matrix(assembly, p, y, time=time)[1]
    elif p.space[0]["spatial"]:
        A = matrix_by_down(p, y, time=time)
    else:
        A = matrix_in_plane(p, y, time=time)
    return float(np.linalg.eigvals(A).real.max())


def _cosine_of_pitch(p: Params, y: Array) -> float:
    """Return the cosine of the pitch of a state, 1; negative where a planar glider is beyond the vertical."""
    if not p.space[0]["spatial"]:
        return math.cos(y[params.THETA])
    down = rotation_of(y[Q0 : Q0 + 4] / np.linalg.norm(y[Q0 : Q0 + 4]))[2]
    return math.hypot(down[1], down[2])


def _slopes(rates: Callable[[Array], Array], size: int) -> Array:
    """Return the slopes of rates (size,) about no disturbance, (size, size)."""
    return np.column_stack([(rates(d) - rates(-d)) / (2.0 * STEP) for d in STEP * np.eye(size)])


def _derivative_at(p: Params, y: Array, time: float) -> Array:
    """Return dy/dt with the extensions held."""
    dy, work = np.zeros(len(y)), make_work(len(y), len(p.parts))
    work.drive[:-1, 0] = STEADY
    work.drive[-1, 0] = max(int(np.searchsorted(p.current_times, time, side="right")) - 1, 0)
    derivative(time, y, p, work.drive, dy)
    return dy


def matrix_in_plane(p: Params, y: Array, *, time: float = 0.0) -> Array:
    """Return the matrix of theta, u, w, q of a planar state, for any pitch; in the plane there is no current."""
    kept = slice(params.THETA, params.Q + 1)

    def rates(x: Array) -> Array:
        state = y.copy()
        state[kept] += x
        return _derivative_at(p, state, time)[kept]

    return _slopes(rates, 4)


def matrix_by_down(p: Params, y: Array, *, time: float = 0.0) -> Array:
    """Return the matrix of [k along two directions across it, u v w, p q r] of a spatial state, for any attitude.

    k is the unit vector down in body axes, k' = k x omega. A change d of it is a turn by d x k about the body's own
    axes, without a turn about the vertical. Velocities are as seen from the water.
    """
    seen, current = carried(p, float(y[spatial_layout.Z]), time)
    base = y.copy()
    q = base[Q0 : Q0 + 4] / np.linalg.norm(base[Q0 : Q0 + 4])
    turned = rotation_of(q)
    base[U : U + 3] -= turned.T @ np.array([*current, 0.0])
    k = turned[2]
    across = np.linalg.svd(k[None, :])[2][1:]

    def rates(x: Array) -> Array:
        state = base.copy()
        change = x[:2] @ across
        state[Q0 : Q0 + 4] = _turned(q, np.cross(change, k))
        state[U : U + 6] += x[2:]
        turning = np.cross(k + change, state[P : P + 3])
        return np.concatenate([across @ turning, _derivative_at(seen, state, time)[U : U + 6]])

    return _slopes(rates, 8)


def _turned(q: Array, by: Array) -> Array:
    """Return a quaternion turned about the body's own axes by a small rotation vector, rad."""
    angle = float(np.linalg.norm(by))
    w, v = math.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / math.pi) * by
    return np.array([q[0] * w - q[1:] @ v, *(q[0] * v + w * q[1:] + np.cross(q[1:], v))])
