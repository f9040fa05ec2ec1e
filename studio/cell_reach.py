"""Owns how near each cell comes to its stops in a run: what counts as near, what as at the stop, and when it is so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.run import Run
from studio.holds import Span

Array = NDArray[np.float64]

AT_STOP = 1e-6
"""A cell within this share of its stroke from a stop is at it."""
NEAR_STOP = 0.05
"""A cell within this share of its stroke from a stop is near it: in warnings, in the lanes and in the readouts."""


@dataclass(frozen=True)
class StopReach:
    """How near a cell comes to one of its stops (m or rad), and when it is near it and at it, s.

    `least` is the distance as a share of the stroke, at `time` (s). Near begins at the extension `near_limit`; what is
    at the stop is near it too.
    """

    side: str
    stop: float
    near_limit: float
    least: float
    time: float
    near: tuple[Span, ...]
    at: tuple[Span, ...]


@dataclass(frozen=True)
class CellReach:
    """How near a cell comes to its stops in a run."""

    name: str
    low: StopReach
    high: StopReach

    @property
    def nearest(self) -> StopReach:
        """The stop that it comes nearer to."""
        return min(self.low, self.high, key=lambda reach: reach.least)


def cell_reach(assembly: Assembly, run: Run, k: int) -> CellReach:
    """Return how near the k-th cell of a run comes to its stops."""
    part, extension = assembly.params.parts[k], run.cell_values["extension"][:, k]
    low, high = float(part["stop_low"]), float(part["stop_high"])
    stroke = high - low
    share = (extension - low) / stroke
    return CellReach(
        run.cells[k],
        _stop_reach("lower", low, low + NEAR_STOP * stroke, run.times, share),
        _stop_reach("upper", high, high - NEAR_STOP * stroke, run.times, 1.0 - share),
    )


def _stop_reach(side: str, stop: float, near_limit: float, times: Array, share: Array) -> StopReach:
    nearest = int(share.argmin())
    return StopReach(
        side, stop, near_limit, max(float(share[nearest]), 0.0), float(times[nearest]),
        spans_where(times, share <= NEAR_STOP), spans_where(times, share <= AT_STOP),
    )  # fmt: skip


def spans_where(times: Array, flags: NDArray[np.bool_]) -> tuple[Span, ...]:
    """Return from when until when flags (n,) hold without a break, s."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return tuple(zip(times[starts].tolist(), times[ends].tolist(), strict=True))


def reach_document(cell: CellReach) -> dict[str, Any]:
    """Return a cell's nearest stop as the page shows it."""
    nearest = cell.nearest
    return {
        "name": cell.name, "side": nearest.side, "nearest": nearest.least, "time": nearest.time,
        "near": bool(nearest.near), "at": bool(nearest.at),
    }  # fmt: skip
