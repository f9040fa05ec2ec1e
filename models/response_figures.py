"""Owns the figures of a response to a step: rise, overshoot, settling, and what it asks of the cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SETTLED = 0.02
"""A response has settled when it stays within this share of the step."""


@dataclass(frozen=True)
class Figures:
    """Figures of one response: times in s, None where it does not come to that; the overshoot as a share of the step.

    `command` and `rate` by cell: largest departure of the command from the start (m or rad), largest rate of the
    extension that it asks for, m/s or rad/s.
    """

    rise_time: float | None
    overshoot: float
    settling_time: float | None
    error: float
    command: Mapping[str, float]
    rate: Mapping[str, float]

    def __str__(self) -> str:
        rise = "does not rise" if self.rise_time is None else f"rises in {self.rise_time:.3g} s"
        settles = "does not settle" if self.settling_time is None else f"settles in {self.settling_time:.3g} s"
        return f"{rise}, overshoots by {100.0 * self.overshoot:.3g} %, {settles}"

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as a JSON object."""
        return {
            "rise_time": self.rise_time, "overshoot": self.overshoot, "settling_time": self.settling_time,
            "error": self.error, "command": dict(self.command), "rate": dict(self.rate), "words": str(self),
        }  # fmt: skip


def figures_of(share: Array, times: Array, departures: Array, rates: Mapping[str, float]) -> Figures:
    """Return the figures of a response: of the state as a share of the step (samples,) over times (samples,) s.

    `departures` (samples or more, cells) are those of the commands from the start, `rates` the largest ones by cell.
    """
    low, high = (_first_time(share, times, level) for level in (0.1, 0.9))
    outside = np.flatnonzero(np.abs(share - 1.0) > SETTLED)
    settling = 0.0 if not len(outside) else (float(times[outside[-1] + 1]) if outside[-1] + 1 < len(times) else None)
    largest = np.abs(departures).max(axis=0, initial=0.0)
    return Figures(
        None if low is None or high is None else high - low, max(float(share.max()) - 1.0, 0.0), settling,
        float(share[-1] - 1.0), dict(zip(rates, largest.tolist(), strict=True)), dict(rates),
    )  # fmt: skip


def _first_time(share: Array, times: Array, level: float) -> float | None:
    above = np.flatnonzero(share >= level)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(times[0])
    return float(times[k - 1] + (level - share[k - 1]) / (share[k] - share[k - 1]) * (times[k] - times[k - 1]))
