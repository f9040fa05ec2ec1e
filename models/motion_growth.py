"""Owns how fast a small disturbance of a steady motion grows: the largest real part of its eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from models.attitude import quaternion_from_rpy_radians
from models.kernel import params, steady
from models.kernel.actuators import STEADY
from models.kernel.model import derivative
from models.kernel.params import make_work
from models.kernel.spatial_layout import Q0, P, U
from models.kernel.steady import PITCH
from models.linearize import motion_matrix
from models.steady_problem import SteadyProblem, down_in_body

Array = NDArray[np.float64]
NEARLY_VERTICAL = 4e-3
"""Cosine of the pitch below which Euler angles are left: the vector down in body axes takes their place in space."""
STEP = 1e-5


def growth_of(problem: SteadyProblem, motion: Array) -> float:
    """Return the growth of a disturbance, 1/s: negative where every one dies out; depth, heading, extensions held."""
    y = np.zeros(len(problem.assembly.initial_state))
    steady.write_steady(motion, problem.depth, y, problem.params)
    if math.cos(motion[PITCH]) > NEARLY_VERTICAL:
        _names, A = motion_matrix(problem.assembly, problem.params, y)
    elif problem.spatial:
        A = matrix_by_down(problem, motion, y)
    else:
        A = matrix_in_plane(problem, y)
    return float(np.linalg.eigvals(A).real.max())


def _slopes(rates: Callable[[Array], Array], size: int) -> Array:
    """Return the slopes of rates (size,) about no disturbance, (size, size)."""
    return np.column_stack([(rates(d) - rates(-d)) / (2.0 * STEP) for d in STEP * np.eye(size)])


def _derivative_at(problem: SteadyProblem, y: Array) -> Array:
    """Return dy/dt with the extensions held."""
    dy, work = np.zeros(len(y)), make_work(len(y), len(problem.params.parts))
    work.drive[:-1, 0] = STEADY
    derivative(0.0, y, problem.params, work.drive, dy)
    return dy


def matrix_in_plane(problem: SteadyProblem, y: Array) -> Array:
    """Return the matrix of theta, u, w, q, for any pitch."""
    kept = slice(params.THETA, params.Q + 1)

    def rates(x: Array) -> Array:
        state = y.copy()
        state[kept] += x
        return _derivative_at(problem, state)[kept]

    return _slopes(rates, 4)


def matrix_by_down(problem: SteadyProblem, motion: Array, y: Array) -> Array:
    """Return the matrix of [k along two directions across it, u v w, p q r], for any attitude; k' = k x omega."""
    k = down_in_body(motion)
    across = np.linalg.svd(k[None, :])[2][1:]

    def rates(x: Array) -> Array:
        state = y.copy()
        down = k + x[:2] @ across
        roll, pitch = math.atan2(down[1], down[2]), math.atan2(-down[0], math.hypot(down[1], down[2]))
        state[Q0 : Q0 + 4] = quaternion_from_rpy_radians(roll, pitch, 0.0)
        state[U : U + 6] += x[2:]
        turning = np.cross(down / np.linalg.norm(down), state[P : P + 3])
        return np.concatenate([across @ turning, _derivative_at(problem, state)[U : U + 6]])

    return _slopes(rates, 8)
