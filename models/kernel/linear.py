"""Owns slopes of the equations of motion: how rates and outputs change with the states and the extensions.

States in a minimal form, with Euler angles (Z-Y-X) for the quaternion: depth, roll, pitch, yaw, velocities u v w and
p q r (spatial); depth, pitch, u, w, q (planar). Position along and across is left out: nothing depends on it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.kernel import outputs, params, spatial_layout, spatial_outputs
from models.kernel.actuators import STEADY
from models.kernel.jit import compiled, internal
from models.kernel.model import derivative
from models.kernel.search import last_not_above

SPATIAL_STATES = ("z", "phi", "theta", "psi", "u", "v", "w", "p", "q", "r")
PLANAR_STATES = ("z", "theta", "u", "w", "q")


class LinearWork(NamedTuple):
    """Scratch arrays, made outside the kernel."""

    y: NDArray[np.float64]  # (1, states)
    dy: NDArray[np.float64]  # (states,)
    time: NDArray[np.float64]  # (1,)
    drive: NDArray[np.float64]  # (parts + 1, 5)
    v: NDArray[np.float64]  # (variables,)
    rows: NDArray[np.float64]  # (4, rows) at four perturbed places
    out: NDArray[np.float64]  # (1, columns)
    commands: NDArray[np.float64]  # (1, parts)
    volumes: NDArray[np.float64]  # (1, parts)


def make_linear_work(states: int, parts: int, rates: int, columns: int) -> LinearWork:
    """Return scratch arrays for a state of `states` numbers, `rates` of them minimal, and `columns` outputs."""
    return LinearWork(
        np.zeros((1, states)), np.zeros(states), np.zeros(1), np.zeros((parts + 1, 5)), np.zeros(rates + parts),
        np.zeros((4, rates + columns)), np.zeros((1, columns)), np.zeros((1, parts)), np.zeros((1, parts)),
    )  # fmt: skip


@internal
def write_planar_state(v, y):
    """Write the minimal states `v` into the planar state."""
    y[params.Z], y[params.THETA], y[params.U], y[params.W], y[params.Q] = v[0], v[1], v[2], v[3], v[4]


@internal
def write_spatial_state(v, y):
    """Write the minimal states `v` into the spatial state (Fossen, 2011, Eq. 2.72)."""
    sr, cr = math.sin(0.5 * v[1]), math.cos(0.5 * v[1])
    sp, cp = math.sin(0.5 * v[2]), math.cos(0.5 * v[2])
    sy, cy = math.sin(0.5 * v[3]), math.cos(0.5 * v[3])
    y[spatial_layout.Z] = v[0]
    y[spatial_layout.Q0], y[spatial_layout.Q1] = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    y[spatial_layout.Q2], y[spatial_layout.Q3] = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    for j in range(6):
        y[spatial_layout.U + j] = v[4 + j]


@internal
def write_planar_rates(dy, row):
    """Write the rates of the minimal states."""
    row[0], row[1] = dy[params.Z], dy[params.THETA]
    row[2], row[3], row[4] = dy[params.U], dy[params.W], dy[params.Q]


@internal
def write_spatial_rates(v, dy, row):
    """Write the rates of the minimal states; those of the angles by Fossen (2011, Eq. 2.28)."""
    sr, cr, cp, tp = math.sin(v[1]), math.cos(v[1]), math.cos(v[2]), math.tan(v[2])
    across = sr * v[8] + cr * v[9]
    row[0] = dy[spatial_layout.Z]
    row[1], row[2], row[3] = v[7] + tp * across, cr * v[8] - sr * v[9], across / cp
    for j in range(6):
        row[4 + j] = dy[spatial_layout.U + j]


@compiled
def rates_and_outputs(v, t, p, work, row):
    """Write the rates of the minimal states, then every output column, into `row`.

    `v` holds the minimal states and then the extensions. Extensions stand still: how they follow their commands is
    linear, and known without differences.
    """
    y = work.y[0]
    first = p.space[0].extensions
    spatial = p.space[0].spatial != 0
    rates = v.shape[0] - p.parts.shape[0]
    if spatial:
        write_spatial_state(v, y)
    else:
        write_planar_state(v, y)
    for i in range(p.parts.shape[0]):
        y[first + i] = v[rates + i]
        work.drive[i, 0], work.drive[i, 1] = STEADY, 0.0
    work.drive[p.parts.shape[0], 0] = last_not_above(t, p.current_times)
    derivative(t, y, p, work.drive, work.dy)
    work.time[0] = t
    if spatial:
        write_spatial_rates(v, work.dy, row)
        spatial_outputs.spatial_outputs(work.time, work.y, p, work.out, work.commands, work.volumes)
    else:
        write_planar_rates(work.dy, row)
        outputs.outputs(work.time, work.y, p, work.out, work.commands, work.volumes)
    for j in range(work.out.shape[1]):
        row[rates + j] = work.out[0, j]


@compiled
def slopes(v, steps, t, p, work, slope):
    """Fill `slope` (rows, variables) by central differences of `steps` and of twice that, extrapolated (Richardson)."""
    for j in range(v.shape[0]):
        work.v[j] = v[j]
    for j in range(v.shape[0]):
        h = steps[j]
        for m in range(4):
            work.v[j] = v[j] + (1.0 - 2.0 * (m % 2)) * (h if m < 2 else 2.0 * h)
            rates_and_outputs(work.v, t, p, work, work.rows[m])
        work.v[j] = v[j]
        for i in range(slope.shape[0]):
            near = (work.rows[0, i] - work.rows[1, i]) / (2.0 * h)
            far = (work.rows[2, i] - work.rows[3, i]) / (4.0 * h)
            slope[i, j] = near + (near - far) / 3.0
