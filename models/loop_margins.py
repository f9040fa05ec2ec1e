"""Owns how far a sampled closed loop is from instability: gain, phase and delay margins, disk margins.

Loops are broken at the command of one cell, the others staying closed: with L = K (z I - F)^-1 G and S = (I + L)^-1 the
loop of cell i is 1 / S_ii - 1. Gain margins, and the delay margin of all cells together, are those at which an
eigenvalue of the sampled loop reaches the unit circle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from models.feedback_problem import FeedbackProblem
from models.sampled_model import SampledModel, radius_of

Array = NDArray[np.float64]
FREQUENCIES = 2000
SLOWEST = 1e-5
"""Lowest frequency, as a share of that of half the samples."""
GAINS = np.logspace(0.0, 3.0, 61)
"""Factors that are tried on the gains, up and down."""
SAMPLES_LATE = 20
"""Delays beyond so many samples are not tried."""
MARGINAL = 1e-9
LEAST_LOOP = 1e-12
"""Loops weaker than this at every frequency do nothing."""


@dataclass(frozen=True)
class CellMargins:
    """Margins of the loop at the command of one cell, the others closed.

    Factors on its gains (`gain_low` below 1, 0 where none is too small; `gain_high` None where none is too large),
    `phase` (rad) and the frequency of it (rad/s), `delay` (s) by which it alone may be late, None where the loop's gain
    stays below 1; `disk` the balanced disk margin.
    """

    cell: str
    gain_low: float
    gain_high: float | None
    phase: float | None
    frequency: float | None
    delay: float | None
    disk: float

    def __str__(self) -> str:
        high = "any" if self.gain_high is None else f"{self.gain_high:.3g}"
        words = f"'{self.cell}': gain times {self.gain_low:.3g} to {high}"
        if self.phase is not None and self.delay is not None:
            phase = f"{math.degrees(self.phase):.1f} deg at {self.frequency:.3g} rad/s"
            words += f", phase {phase}, delay {self.delay:.3g} s"
        return f"{words}, disk margin {self.disk:.3g}"


@dataclass(frozen=True)
class LoopMargins:
    """Margins of a closed loop: by cell, and of all cells at once.

    `gain_low`, `gain_high` are factors on all gains; `delay` (s) is what may be added to all commands, None where more
    than 20 samples do no harm; `disk` holds against any change of all cells at once, each within its disk (a lower
    bound); `return_difference` is the smallest singular value of I + L, strokes as units, `worst_frequency` where,
    rad/s.
    """

    cells: tuple[CellMargins, ...]
    gain_low: float
    gain_high: float | None
    delay: float | None
    disk: float
    return_difference: float
    worst_frequency: float

    @property
    def disk_gain(self) -> tuple[float, float]:
        """Factors within which every cell's gain may change, all at once: (2 - d) / (2 + d) and its inverse."""
        d = min(self.disk, 2.0)
        low = (2.0 - d) / (2.0 + d)
        return low, 1.0 / low if low > 0.0 else math.inf

    @property
    def disk_phase(self) -> float:
        """Phase by which every cell may lag, all at once, rad: 2 atan(d / 2)."""
        return 2.0 * math.atan(0.5 * min(self.disk, 2.0))

    def __str__(self) -> str:
        high = "any factor" if self.gain_high is None else f"{self.gain_high:.3g}"
        delay = f"more than {SAMPLES_LATE} samples" if self.delay is None else f"{self.delay:.3g} s"
        (low, up), phase = self.disk_gain, math.degrees(self.disk_phase)
        return (
            f"stable with all gains times {self.gain_low:.3g} to {high}, or all commands late by {delay} more; every "
            f"cell at once within gains of {low:.3g} to {up:.3g} or {phase:.1f} deg (disk margin {self.disk:.3g}); "
            f"smallest return difference {self.return_difference:.3g} at {self.worst_frequency:.3g} rad/s"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the margins as a JSON object; what is unlimited is null."""
        low, high = self.disk_gain
        return {
            "cells": [
                {
                    "cell": c.cell, "gain_low": c.gain_low, "gain_high": c.gain_high, "phase": c.phase,
                    "frequency": c.frequency, "delay": c.delay, "disk": c.disk, "words": str(c),
                } for c in self.cells
            ],
            "gain_low": self.gain_low, "gain_high": self.gain_high, "delay": self.delay, "disk": self.disk,
            "disk_gain": [low, high if math.isfinite(high) else None], "disk_phase": self.disk_phase,
            "return_difference": self.return_difference, "worst_frequency": self.worst_frequency, "words": str(self),
        }  # fmt: skip


def loop_margins(problem: FeedbackProblem, gains: Array) -> LoopMargins | None:
    """Return the margins of the loop with gains (cells, states + integrals); None where it is not stable itself.

    Disk margins are those of Seiler, Packard and Gahinet (2020, IEEE Control Systems 40(5), 78) with no skew: the
    inverse of the largest |S - 1/2|; over all cells at once that of the largest singular value, which is a lower bound.
    """
    model, wide = problem.whole(), problem.widened(gains)
    if radius_of(model.closed(wide)) >= 1.0 - MARGINAL:
        return None
    nyquist = math.pi / model.sample_time
    omega = nyquist * np.logspace(math.log10(SLOWEST), 0.0, FREQUENCIES)
    m, strokes = len(model.cells), problem.strokes
    loop = model.loop(wide, omega) * strokes / strokes[:, None]
    difference = np.eye(m) + loop
    sensitivity = np.linalg.inv(difference)
    smallest = np.linalg.svd(difference, compute_uv=False)[:, -1]
    largest = np.linalg.svd(sensitivity - 0.5 * np.eye(m), compute_uv=False)[:, 0]
    worst = int(smallest.argmin())
    low, high = gain_range(model, wide, np.ones(m))
    return LoopMargins(
        tuple(_of_cell(model, wide, omega, sensitivity[:, i, i], i) for i in range(m)), low, high,
        delay_margin(problem, gains), float(1.0 / largest.max()), float(smallest[worst]), float(omega[worst]),
    )  # fmt: skip


def _of_cell(model: SampledModel, wide: Array, omega: Array, sensitivity: NDArray[Any], i: int) -> CellMargins:
    """Return the margins at one cell, from its sensitivity (frequencies,)."""

    def loop_at(frequency: float) -> complex:
        all_loops = np.eye(len(model.cells)) + model.loop(wide, np.array([frequency]))[0]
        return complex(1.0 / np.linalg.inv(all_loops)[i, i] - 1.0)

    gain = np.log(np.maximum(np.abs(1.0 / sensitivity - 1.0), LEAST_LOOP))
    phase = frequency = delay = None
    for k in np.flatnonzero(gain[:-1] * gain[1:] < 0.0):
        crossing = float(brentq(lambda w: math.log(abs(loop_at(w))), omega[k], omega[k + 1]))
        lag = (math.pi + float(np.angle(loop_at(crossing)))) % math.tau
        least = min(lag, math.tau - lag)
        if phase is None or least < phase:
            phase, frequency = least, crossing
        delay = lag / crossing if delay is None else min(delay, lag / crossing)
    alone = np.zeros(len(model.cells))
    alone[i] = 1.0
    low, high = gain_range(model, wide, alone)
    return CellMargins(model.cells[i], low, high, phase, frequency, delay, float(1.0 / np.abs(sensitivity - 0.5).max()))


def gain_range(model: SampledModel, wide: Array, chosen: Array) -> tuple[float, float | None]:
    """Return the factors on the gains of the chosen cells (1 or 0 each) between which the loop is stable."""

    def radius(logarithm: float) -> float:
        factor = 1.0 + chosen * (math.exp(logarithm) - 1.0)
        return radius_of(model.closed(factor[:, None] * wide)) - 1.0

    steps = np.log(GAINS)
    low, high = (_first_crossing(radius, sign * steps) for sign in (-1.0, 1.0))
    return 0.0 if low is None else math.exp(low), None if high is None else math.exp(high)


def delay_margin(problem: FeedbackProblem, gains: Array) -> float | None:
    """Return by how much all commands may be later than they are, s; None beyond 20 samples."""
    wide, delay = problem.widened(gains), problem.options.delay

    def radius(late: float) -> float:
        return radius_of(problem.whole(delay + late).closed(wide)) - 1.0

    steps = problem.options.sample_time * np.linspace(0.0, SAMPLES_LATE, 2 * SAMPLES_LATE + 1)
    return _first_crossing(radius, steps)


def _first_crossing(radius: Callable[[float], float], steps: Array) -> float | None:
    """Return where the loop stops being stable along the steps, the first being stable; None where it does not."""
    for a, b in zip(steps[:-1].tolist(), steps[1:].tolist(), strict=True):
        if radius(b) > MARGINAL:
            return float(brentq(radius, a, b, xtol=1e-9)) if radius(a) < 0.0 else a
    return None
