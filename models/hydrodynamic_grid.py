"""Owns the law over both angles: a table of forces made into bicubic pieces with shape-preserving slopes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from models.hydrodynamics_angles import QUANTITIES, AngleTable

Array = NDArray[np.float64]
_HERMITE = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [-3.0, 3.0, -2.0, -1.0], [2.0, -2.0, 1.0, 1.0]])
"""Takes values and slopes at both ends of [0, 1] to coefficients of powers (0 to 3)."""
_CORNERS = ((slice(0, -1), False), (slice(1, None), False), (slice(0, -1), True), (slice(1, None), True))
"""Of each piece: value at its begin and end, slope at its begin and end."""


@dataclass(frozen=True)
class GridLaw:
    """X, Y, Z, K, M, N per squared speed as bicubic pieces.

    `alpha` (a,), `beta` (b,) breaks, rad; `pieces` ((a - 1) (b - 1), 6, 4, 4) in powers of alpha and beta beyond the
    corner of each cell, alpha by row.
    """

    alpha: Array
    beta: Array
    pieces: Array

    def __call__(self, alpha: float, beta: float) -> Array:
        """Return X, Y, Z, K, M, N per squared speed (6,) at angles in rad.

        Beyond the edges of the table drag, side force and lift are held, which turn with the flow; and the moments.
        """
        a = float(np.clip(alpha, self.alpha[0], self.alpha[-1]))
        b = float(np.clip(beta, self.beta[0], self.beta[-1]))
        i = int(np.clip(np.searchsorted(self.alpha, a, side="right") - 1, 0, len(self.alpha) - 2))
        j = int(np.clip(np.searchsorted(self.beta, b, side="right") - 1, 0, len(self.beta) - 2))
        s, t = (a - self.alpha[i]) ** np.arange(4), (b - self.beta[j]) ** np.arange(4)
        forces = np.asarray(s @ self.pieces[i * (len(self.beta) - 1) + j] @ t, dtype=np.float64)
        if (a, b) != (alpha, beta):
            forces[:3] = flow_to_body(alpha, beta) @ flow_to_body(a, b).T @ forces[:3]
        return forces


def flow_to_body(alpha: float, beta: float) -> Array:
    """Return the rotation that takes (-drag, side force, -lift) to body axes, (3, 3)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    return np.array([[ca * cb, -ca * sb, -sa], [sb, cb, 0.0], [sa * cb, -sa * sb, ca]])


def _whole_table(table: AngleTable) -> tuple[Array, Array, Array]:
    """Return angles (a,), (b,) in rad and values (6, a, b), the mirrored sideslips included."""
    alpha, beta = np.radians(np.array(table.alpha_deg)), np.radians(np.array(table.beta_deg))
    values = np.array([getattr(table, name) for name in QUANTITIES])
    if not table.mirrored:
        return alpha, beta, values
    sign = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])[:, None, None]
    values[[1, 3, 5], :, 0] = 0.0
    return alpha, np.concatenate([-beta[:0:-1], beta]), np.concatenate([sign * values[:, :, :0:-1], values], axis=2)


def _slopes(angles: Array, values: Array, *, axis: int, closed: bool) -> Array:
    """Return shape-preserving slopes along an axis; a closed circle has no ends."""
    if len(angles) == 2:
        return np.broadcast_to(np.diff(values, axis=axis) / np.diff(angles), values.shape).copy()
    if not closed:
        return np.asarray(PchipInterpolator(angles, values, axis=axis).derivative()(angles), dtype=np.float64)
    around = np.concatenate([angles[:-1] - 2 * np.pi, angles, angles[1:] + 2 * np.pi])
    inner = np.take(values, range(len(angles) - 1), axis=axis)
    outer = np.take(values, range(1, len(angles)), axis=axis)
    periodic = PchipInterpolator(around, np.concatenate([inner, values, outer], axis=axis), axis=axis)
    return np.asarray(periodic.derivative()(angles), dtype=np.float64)


@lru_cache(maxsize=16)
def build_grid_law(table: AngleTable) -> GridLaw:
    """Make the law of a table; laws of equal tables are made once, since every edit of a design asks again."""
    alpha, beta, f = _whole_table(table)
    closed = table.alpha_deg[0] == -180.0 and table.alpha_deg[-1] == 180.0
    f_a = _slopes(alpha, f, axis=1, closed=closed)
    f_b = _slopes(beta, f, axis=2, closed=False)
    f_ab = _slopes(alpha, f_b, axis=1, closed=closed)
    da, db = np.diff(alpha)[None, :, None], np.diff(beta)[None, None, :]
    corners = np.empty((6, len(alpha) - 1, len(beta) - 1, 4, 4))
    for i, (row, sloped) in enumerate(_CORNERS):
        for j, (column, tilted) in enumerate(_CORNERS):
            source = (f_ab if tilted else f_a) if sloped else (f_b if tilted else f)
            corners[..., i, j] = source[:, row, column] * (da if sloped else 1.0) * (db if tilted else 1.0)
    unit = np.einsum("ik,qabkl,jl->qabij", _HERMITE, corners, _HERMITE)
    powers = np.arange(4)
    unit /= da[..., None, None] ** powers[:, None] * db[..., None, None] ** powers[None, :]
    pieces = np.ascontiguousarray(np.moveaxis(unit, 0, 2).reshape(-1, 6, 4, 4))
    for shared in (alpha, beta, pieces):
        shared.setflags(write=False)
    return GridLaw(alpha, beta, pieces)
