"""Owns what a layout of cells can hold and move: heave, pitch and roll at rest, and the modes about a steady motion.

At rest, from the forces of the cells (`models.allocation`). In motion: what can be reached is spanned by B, A B, A A B
and so on, and a mode can be moved where its eigenvector lies therein. How nearly it cannot, by the test of Popov,
Belevitch and Hautus, the smallest singular value of [l I - A, B] (Kailath, 1980, 2.4.3); how well each cell does, by
the cosine between the left eigenvector and the cell's column (Hamdan and Nayfeh, 1989). States and inputs are scaled
first, or metres and radians would be weighed against each other as numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.allocation import AXES, Authority, authority, effectiveness
from models.design import Design
from models.linear_model import LinearModel
from models.modes import EXTENSION, Mode, modes_of

Array = NDArray[np.float64]
SCALE = {"z": 1.0}
USUAL_SCALE = 0.1
"""Scale of an angle (rad), a velocity (m/s) and a rate (rad/s); of depth it is 1 m, of an extension half a stroke."""
UNMOVED = 1e-7
"""Singular values and cosines below this are none: rounding of the differences leaves 1e-9."""
OUTSIDE = 1e-3
"""An eigenvector of which more than this lies outside what is reached belongs to a mode that cannot be moved."""


@dataclass(frozen=True)
class ModeControl:
    """How the inputs move one mode.

    `distance` is the smallest singular value of the scaled [l I - A, B] (1/s): how far the model is from one in which
    some mode of this eigenvalue cannot be moved. `cosines` (inputs,) say how well each input alone moves this one.
    """

    mode: Mode
    distance: float
    cosines: Array
    movable: bool

    def as_dict(self) -> dict[str, Any]:
        """Return it as a JSON object."""
        return {
            "name": self.mode.name, "real": self.mode.eigenvalue.real, "imag": self.mode.eigenvalue.imag,
            "distance": self.distance, "cosines": self.cosines.tolist(), "movable": self.movable,
        }  # fmt: skip


@dataclass(frozen=True)
class Controllability:
    """What the inputs of a linear model can move; `rank` of its `states` states."""

    inputs: tuple[str, ...]
    states: int
    rank: int
    modes: tuple[ModeControl, ...]

    @property
    def unmoved(self) -> tuple[str, ...]:
        """Names of the modes that no input moves."""
        return tuple(each.mode.name for each in self.modes if not each.movable)

    def __str__(self) -> str:
        if not self.unmoved:
            return f"the cells can move every mode ({self.rank} of {self.states} states)"
        what = ", ".join(self.unmoved)
        return f"no cell moves {what}: {self.rank} of {self.states} states can be reached"

    def as_dict(self) -> dict[str, Any]:
        """Return it as a JSON object."""
        return {
            "inputs": list(self.inputs), "states": self.states, "rank": self.rank,
            "modes": [each.as_dict() for each in self.modes], "unmoved": list(self.unmoved), "words": str(self),
        }  # fmt: skip


@dataclass(frozen=True)
class HoldingPower:
    """What a layout can hold at rest: of heave, pitch and roll, which apart from the others, and how strongly."""

    cells: tuple[str, ...]
    authority: Authority

    def __str__(self) -> str:
        holds = self.authority.holds
        missing = [axis for axis in AXES if axis not in holds]
        if not missing:
            return "heave, pitch and roll can each be held apart from the others"
        first = f"{' and '.join(holds)} can be held apart; " if holds else ""
        return f"{first}{' and '.join(missing)} cannot be held apart from the others"

    def as_dict(self) -> dict[str, Any]:
        """Return it as a JSON object."""
        of = self.authority
        return {
            "cells": list(self.cells), "rank": of.rank, "singular_values": of.singular_values.tolist(),
            "directions": of.directions.tolist(), "alone": {axis: list(ends) for axis, ends in of.alone.items()},
            "holds": list(of.holds), "words": str(self),
        }  # fmt: skip


def holding_power(design: Design, cells: Sequence[str] | None = None, *, depth: float = 0.0) -> HoldingPower:
    """Return what the named cells (all that move, if none are) can hold at rest, by the density at a depth (m).

    Raises
    ------
    DesignError
        Where a name is unknown or named twice.

    """
    columns = effectiveness(design, cells, depth=depth)
    return HoldingPower(columns.cells, authority(columns))


def controllability(model: LinearModel, strokes: Sequence[float] | Array | None = None) -> Controllability:
    """Return which modes of a model its inputs can move; `strokes` (inputs,) scale them, 0.1 where none are given."""
    half = np.full(len(model.inputs), USUAL_SCALE) if strokes is None else 0.5 * np.asarray(strokes, dtype=np.float64)
    of_cell = dict(zip((name.removeprefix("command of ") for name in model.input_names), half.tolist(), strict=True))
    scale = np.array([_scale_of(name, of_cell) for name in model.state_names])
    A, B = model.A * scale / scale[:, None], model.B * half / scale[:, None]
    modes = modes_of(model.A, model.state_names)
    span = reached(A, B)
    told = tuple(_control_of(mode, A, B, scale, span) for mode in modes.modes)
    return Controllability(model.input_names, len(scale), span.shape[1], told)


def reached(A: Array, B: Array) -> Array:
    """Return orthonormal columns (states, rank) that span B, A B, A A B ..., built up block by block (Arnoldi)."""
    size = max(float(np.linalg.norm(A, 2)), 1e-300) if len(A) else 1.0
    span, block = np.zeros((len(A), 0)), B / max(float(np.abs(B).max(initial=0.0)), 1e-300)
    while block.shape[1]:
        for _ in range(2):  # once more, against rounding
            block = block - span @ (span.T @ block)
        left, values, _ = np.linalg.svd(block, full_matrices=False)
        fresh = left[:, values > UNMOVED]
        span, block = np.hstack([span, fresh]), A @ fresh / size
    return span


def _scale_of(name: str, of_cell: dict[str, float]) -> float:
    if name.startswith(EXTENSION):
        return of_cell[name.removeprefix(EXTENSION)]
    return SCALE.get(name, USUAL_SCALE)


def _control_of(mode: Mode, A: Array, B: Array, scale: Array, span: Array) -> ModeControl:
    """Tell how the inputs move one mode; A, B scaled, `span` what they reach."""
    shifted = mode.eigenvalue * np.eye(len(A)) - A
    distance = float(np.linalg.svd(np.hstack([shifted, B]), compute_uv=False)[-1])
    right = mode.eigenvector / scale
    right /= np.linalg.norm(right)
    movable = float(np.linalg.norm(right - span @ (span.T @ right))) < OUTSIDE
    # of an eigenvalue met more than once, the left eigenvector that belongs to this mode
    vectors, sizes, _ = np.linalg.svd(shifted)
    null = vectors[:, sizes <= max(UNMOVED, 1.001 * float(sizes[-1]))]
    w = null @ (null.conj().T @ right)
    lengths = float(np.linalg.norm(w)) * np.linalg.norm(B, axis=0)
    cosines = np.divide(np.abs(w.conj() @ B), lengths, out=np.zeros(B.shape[1]), where=lengths > 0.0)
    cosines[(cosines < UNMOVED) | (not movable)] = 0.0
    return ModeControl(mode, distance, cosines, movable)
