"""Owns allocation outside the kernel: what each cell does to heave, pitch and roll, and what all of them can together.

Forces and moments are changes from those with every cell at neutral, at level attitude, about the body origin: heave
(N, up), pitch (N m, nose up), roll (N m, starboard down).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from models.components import Actuated, MovableMass, RollingMass, extension_unit
from models.design import DeclaredMass, Design
from models.kernel import allocate as kernel
from models.mass_properties import component_center_of_mass, component_volume_moment
from models.problems import DesignError, Problem
from models.volumes import volume
from models.water import density_at, gravity_of

Array = NDArray[np.float64]
AXES = ("heave", "pitch", "roll")
UNITS = ("N", "N m", "N m")
LEAST_EFFORT = 1e-6
"""Weight of a cell's departure from neutral (in strokes) beside the misfit (in authorities): small, so that it decides
only what the wish leaves open."""
REACHED = 1e-4
"""A wish counts as reached within this share of the axis' authority."""
SMALLEST_SINGULAR = 1e-6
"""Singular values below this share of the largest count as none."""


@dataclass(frozen=True)
class Effectiveness:
    """What the cells do: `matrix` (3, cells) in N and N m per m (or rad), for `AXES`; stops and `neutral` (cells,).

    `scale` (3,) is the authority of each axis: the sum over the cells of what half a stroke does, or 1 where none does
    anything.
    """

    cells: tuple[str, ...]
    units: tuple[str, ...]
    parts: tuple[int, ...]
    matrix: Array
    low: Array
    high: Array
    neutral: Array

    @property
    def span(self) -> Array:
        """Strokes, (cells,) m or rad."""
        return self.high - self.low

    @property
    def scale(self) -> Array:
        """Authority of each axis, (3,) N, N m, N m; 1 where there is none."""
        total = 0.5 * np.abs(self.matrix) @ self.span
        return np.where(total > 1e-12 * max(float(total.max(initial=0.0)), 1e-300), total, 1.0)

    def rows(
        self, weights: Sequence[float] = (1.0, 1.0, 1.0), *, effort: Mapping[str, float] | None = None
    ) -> tuple[Array, Array]:
        """Return the kernel's rows of cells (cells, 10), and by what a wish is multiplied to scale it, (3,)."""
        per_axis = np.asarray(weights, dtype=np.float64) / self.scale
        rows = np.zeros((len(self.cells), kernel.COLUMNS))
        rows[:, : kernel.AXES] = (per_axis[:, None] * self.matrix * self.span).T
        rows[:, kernel.LOW], rows[:, kernel.HIGH] = (
            (self.low - self.neutral) / self.span,
            (self.high - self.neutral) / self.span,
        )
        rows[:, kernel.EFFORT] = [LEAST_EFFORT * (effort or {}).get(name, 1.0) for name in self.cells]
        rows[:, kernel.SPAN], rows[:, kernel.BASE] = self.span, self.neutral
        rows[:, kernel.PART] = self.parts
        return rows, per_axis


@dataclass(frozen=True)
class Allocation:
    """Extensions by name (m or rad), what they make of the wish, and what is missing, (3,) for `AXES`."""

    extensions: dict[str, float]
    wanted: Array
    reached: Array
    at_stop: tuple[str, ...]
    short: tuple[str, ...]

    @property
    def missing(self) -> Array:
        """What is wanted and not reached, (3,) N, N m, N m."""
        return self.wanted - self.reached

    def __str__(self) -> str:
        if not self.short:
            return "all that is wanted is reached"
        parts = [
            f"{axis} is short by {self.missing[AXES.index(axis)]:+.3g} of {self.wanted[AXES.index(axis)]:+.3g} "
            f"{UNITS[AXES.index(axis)]}"
            for axis in self.short
        ]
        held = f"; at a stop: {', '.join(self.at_stop)}" if self.at_stop else "; no cell acts on it"
        return "; ".join(parts) + held


@dataclass(frozen=True)
class Authority:
    """What the cells of a layout can do together.

    `singular_values` (k,) of the matrix scaled by strokes and authorities, `directions` (3, k) the combinations of axes
    they belong to; `alone` what each axis reaches with the two others at zero, (low, high); `holds` the axes that can
    be held apart from the others.
    """

    rank: int
    singular_values: Array
    directions: Array
    alone: dict[str, tuple[float, float]]
    holds: tuple[str, ...]


def effectiveness(
    design: Design, cells: Sequence[str] | None = None, *, depth: float = 0.0, pointer: str = "/options/cells"
) -> Effectiveness:
    """Return what each of the named cells (all that move, if none are) does at neutral, by the density at a depth (m).

    `pointer` is where the names stand, for errors.

    Raises
    ------
    DesignError
        Where a name is unknown or named twice.

    """
    chosen = _chosen(design, cells, pointer)
    environment = design.mission.environment
    density = float(np.asarray(density_at(environment.water, np.array([depth])))[0])
    gravity = gravity_of(environment)
    frozen = isinstance(design.vehicle.mass_properties, DeclaredMass)
    columns = [_column(part, density, gravity, frozen) for _, part in chosen]
    strokes = np.array([part.stroke for _, part in chosen]).reshape(-1, 2)
    return Effectiveness(
        cells=tuple(part.name for _, part in chosen),
        units=tuple(extension_unit(part) for _, part in chosen),
        parts=tuple(index for index, _ in chosen),
        matrix=np.array(columns).reshape(-1, 3).T + 0.0,
        low=strokes[:, 0], high=strokes[:, 1],
        neutral=np.array([part.neutral for _, part in chosen], dtype=np.float64),
    )  # fmt: skip


def _chosen(design: Design, cells: Sequence[str] | None, pointer: str) -> list[tuple[int, Actuated]]:
    """Return the named parts, each with its index among those that move."""
    moving = {part.name: (index, part) for index, (_, part) in enumerate(design.vehicle.actuated)}
    if cells is None:
        return list(moving.values())
    for i, name in enumerate(cells):
        at = f"{pointer}/{i}"
        if name not in moving:
            known = ", ".join(f"'{other}'" for other in moving) or "none"
            raise DesignError([Problem(at, f"no component that moves is named '{name}'", hint=f"those are: {known}")])
        if name in cells[:i]:
            raise DesignError([Problem(at, f"'{name}' is named twice", limit=1, hint="name it once")])
    return [moving[name] for name in cells]


def _column(part: Actuated, density: float, gravity: float, frozen: bool) -> Array:
    """Return d[heave, pitch, roll]/de of one part at neutral."""
    h = 1e-6 * (part.stroke[1] - part.stroke[0])
    a, b = part.neutral - h, part.neutral + h
    swell = (volume(part, b) - volume(part, a)) / (2.0 * h)
    moment = (component_volume_moment(part, b) - component_volume_moment(part, a)) / (2.0 * h)
    column = density * gravity * np.array([swell, moment[0], -moment[1]])
    if isinstance(part, MovableMass | RollingMass) and not frozen:
        shift = (component_center_of_mass(part, b) - component_center_of_mass(part, a)) / (2.0 * h)
        column += part.mass * gravity * np.array([0.0, -shift[0], shift[1]])
    return column


def allocate(
    cells: Effectiveness, wanted: Sequence[float], weights: Sequence[float] = (1.0, 1.0, 1.0), *,
    effort: Mapping[str, float] | None = None,
) -> Allocation:  # fmt: skip
    """Return the extensions that make a wanted [heave, pitch, roll] (N, N m, N m), as far as the stops allow."""
    rows, per_axis = cells.rows(weights, effort=effort)
    wish = np.asarray(wanted, dtype=np.float64)
    x = np.zeros(len(rows))
    kernel.allocate(rows, *(per_axis * wish).tolist(), x)
    extensions = cells.neutral + x * cells.span
    reached = cells.matrix @ (extensions - cells.neutral)
    stopped = [
        name for name, row, value in zip(cells.cells, rows, x, strict=True)
        if value <= row[kernel.LOW] or value >= row[kernel.HIGH]
    ]  # fmt: skip
    short = np.abs(wish - reached) > REACHED * np.maximum(cells.scale, np.abs(wish))
    return Allocation(
        dict(zip(cells.cells, extensions.tolist(), strict=True)), wish, reached, tuple(stopped),
        tuple(axis for axis, is_short in zip(AXES, short, strict=True) if is_short),
    )  # fmt: skip


def authority(cells: Effectiveness) -> Authority:
    """Return rank, singular values, what each axis reaches alone, and which axes can be held apart."""
    scaled = cells.matrix * (0.5 * cells.span) / cells.scale[:, None]
    directions, values, _ = np.linalg.svd(scaled, full_matrices=False) if scaled.size else (np.eye(3), np.zeros(0), 0)
    rank = int(np.sum(values > SMALLEST_SINGULAR * values.max(initial=0.0)))
    alone = {axis: _alone(cells, k) for k, axis in enumerate(AXES)}
    least = [1e-6 * scale for scale in cells.scale]
    holds = tuple(axis for k, axis in enumerate(AXES) if alone[axis][1] - alone[axis][0] > least[k])
    return Authority(rank, values, directions, alone, holds)


def _alone(cells: Effectiveness, axis: int) -> tuple[float, float]:
    """Return the least and the most of one axis that the strokes allow while the other two stay at zero."""
    if not cells.cells:
        return 0.0, 0.0
    others = [k for k in range(3) if k != axis]
    per = cells.matrix / cells.scale[:, None]
    bounds = list(zip(cells.low - cells.neutral, cells.high - cells.neutral, strict=True))
    ends = []
    for sign in (1.0, -1.0):
        found: Any = linprog(sign * per[axis], A_eq=per[others], b_eq=np.zeros(2), bounds=bounds, method="highs")
        ends.append(sign * float(found.fun) * float(cells.scale[axis]) if found.status == 0 else 0.0)
    return (ends[0] + 0.0, ends[1] + 0.0) if all(map(math.isfinite, ends)) else (0.0, 0.0)
