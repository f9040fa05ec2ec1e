"""All of A, B, C and D against plain differences of the kernel's derivative and outputs, in both models and waters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.attitude import rotation_of
from models.kernel import outputs as planar_outputs
from models.kernel import params, spatial_layout, spatial_outputs
from models.linearize import linearize
from models.operating_point import OperatingPoint
from models.presets import load_preset
from tests.models.linear_support import euler_of, quaternion_of
from tests.models.support import slope_at
from tests.models.test_spatial_truths import changed

Array = NDArray[np.float64]
LAYERS = {"water": {"kind": "density_profile", "depths": [0.0, 6.0, 40.0], "densities": [1015.0, 1021.0, 1027.0]}}
SHEARED = {"current": {"kind": "sheared", "surface_velocity": [0.3, -0.2], "shear": [0.02, -0.01]}}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "three cells, planar": ("three-cell-glider", {}),
    "two bellows, planar": ("canete-dual-bellows", {}),
    "four cells": ("quad-bellows-spiral", {}),
    "Seawing": ("seawing-spiral", {}),
    "moving masses": ("movable-mass-twin", {}),
    "in layers": ("quad-bellows-glide", LAYERS),
    "in sheared water": ("seawing-spiral", SHEARED),
}


class Seen:
    """Rates and output columns of minimal states and extensions, straight from the kernel; velocities over ground.

    `current` (3,) is what the water at the point does, m/s in the world: minimal velocities are seen from it.
    """

    def __init__(self, assembly: Assembly, depth: float) -> None:
        self.assembly, self.p = assembly, assembly.params
        self.spatial = bool(self.p.space[0]["spatial"])
        self.n = 10 if self.spatial else 5
        self.names = spatial_outputs.COLUMNS if self.spatial else planar_outputs.COLUMNS
        self.current = np.zeros(3)
        if self.spatial:
            row = self.columns(np.array([depth, *np.zeros(9 + len(self.p.parts))]))
            self.current[:2] = [row[self.names.index(name)] for name in ("current_x", "current_y")]

    def state(self, minimal: Array) -> Array:
        y, n = np.zeros(len(self.assembly.initial_state)), self.n
        first = int(self.p.space[0]["extensions"])
        y[first : first + len(self.p.parts)] = minimal[n:]
        if not self.spatial:
            y[[params.Z, params.THETA, params.U, params.W, params.Q]] = minimal[:n]
            return y
        q = quaternion_of(minimal[1:4])
        y[spatial_layout.Z], y[spatial_layout.Q0 : spatial_layout.Q3 + 1] = minimal[0], q
        y[spatial_layout.U : spatial_layout.R + 1] = minimal[4:10]
        y[spatial_layout.U : spatial_layout.W + 1] += rotation_of(q).T @ self.current
        return y

    def columns(self, minimal: Array) -> Array:
        out = np.zeros((1, len(self.names)))
        scratch = [np.zeros((1, len(self.p.parts))) for _ in range(2)]
        write = spatial_outputs.spatial_outputs if self.spatial else planar_outputs.outputs
        write(np.zeros(1), self.state(minimal)[None, :], self.p, out, *scratch)
        return np.asarray(out[0])

    def rates(self, minimal: Array) -> Array:
        y = self.state(minimal)
        dy = slope_at(self.p, y)
        if not self.spatial:
            return dy[[params.Z, params.THETA, params.U, params.W, params.Q]]
        q, dq, h = y[3:7], dy[3:7], 1e-2
        near, far = (euler_of(q + k * dq) - euler_of(q - k * dq) for k in (h, 2 * h))
        velocities = dy[spatial_layout.U : spatial_layout.R + 1].copy()
        # seen from water that moves at the constant c: d(R' c)/dt = -omega x R' c
        velocities[:3] += np.cross(minimal[7:10], rotation_of(q).T @ self.current)
        return np.array([dy[spatial_layout.Z], *((8.0 * near - far) / (12.0 * h)), *velocities])


def differences(function: Any, at: Array, steps: Array) -> Array:
    rows = []
    for j, h in enumerate(steps):
        step = np.zeros(len(at))
        step[j] = h
        rows.append((function(at + step) - function(at - step)) / (2.0 * h))
    return np.array(rows).T


def wanted_matrices(seen: Seen, minimal: Array, kept: list[str]) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D by their meaning: a part with a lag is a state, one without is its command."""
    p, n = seen.p, seen.n
    m = len(p.parts)
    steps = np.array([1e-2, *np.full(n - 1, 1e-6), *(1e-4 * (p.parts["stop_high"] - p.parts["stop_low"]))])
    rates, columns = differences(seen.rates, minimal, steps), differences(seen.columns, minimal, steps)
    columns = columns[[seen.names.index(name) for name in kept]]
    per_lag = p.parts["inverse_lag"]
    lagging = np.flatnonzero(per_lag > 0.0)
    follow, command = np.eye(m)[:, lagging], np.diag((per_lag <= 0.0).astype(float))  # e = follow x + command c
    A = np.block([[rates[:, :n], rates[:, n:] @ follow], [np.zeros((len(lagging), n)), -np.diag(per_lag[lagging])]])
    B = np.vstack([rates[:, n:] @ command, per_lag[lagging, None] * np.eye(m)[lagging]])
    own, held = np.eye(n, n + len(lagging)), np.zeros((n, m))
    C = np.vstack([own, np.hstack([columns[:, :n], columns[:, n:] @ follow]), np.hstack([np.zeros((m, n)), follow])])
    return A, B, C, np.vstack([held, columns[:, n:] @ command, command])


@pytest.mark.parametrize("case", CASES)
def test_matrices_are_differences_of_the_kernel(case: str) -> None:
    preset_id, environment = CASES[case]
    design = load_preset(preset_id)
    assembly = assemble(changed(design, environment=environment) if environment else design)
    spatial = design.mission.solver.model == "spatial"
    random = np.random.default_rng(11)
    for _ in range(3):
        u, v, w = random.uniform(0.15, 0.45), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)
        rates = random.uniform(-0.2, 0.2, 3)
        pitch, roll, yaw = random.uniform(-0.9, 0.9), random.uniform(-0.8, 0.8), random.uniform(-3.0, 3.0)
        low, high = assembly.params.parts["stop_low"], assembly.params.parts["stop_high"]
        e = low + random.uniform(0.2, 0.8, len(low)) * (high - low)
        point = OperatingPoint(
            depth=4.4, pitch=pitch, roll=roll * spatial, yaw=yaw * spatial, velocity=(u, v * spatial, w),
            angular_velocity=(rates[0] * spatial, rates[1], rates[2] * spatial),
            extensions=dict(zip(assembly.cells, e.tolist(), strict=True)),
        )  # fmt: skip
        model = linearize(assembly, point)
        seen = Seen(assembly, point.depth)
        motion = [point.depth, roll, pitch, yaw, u, v, w, *rates] if spatial else [point.depth, pitch, u, w, rates[1]]
        kept = list(model.output_names[seen.n : -len(e)])
        assert {"speed", "alpha", "z_dot", "lift", "drag", "net_buoyancy"} <= set(kept)
        wanted = wanted_matrices(seen, np.array([*motion, *e]), kept)
        for name, matrix in zip("ABCD", wanted, strict=True):
            found = getattr(model, name)
            assert found.shape == matrix.shape
            # by row: a large slope beside a small one leaves the rounding of the row's own size
            scale = 1.0 + np.abs(matrix).max(axis=1, keepdims=True)
            assert np.abs((found - matrix) / scale).max() < 1e-6, name
