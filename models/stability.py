"""Owns stability over a run: static margins at every sample, growth of small motions, and where either changes sign.

Margins as in `models.margins`. Growth is the largest real part of the eigenvalues of the motion with depth, heading and
extensions held, frozen in time at each instant: of a glider that is settled it says whether the glide is stable, of one
that is turning over only which way things go. SI units.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.linearize import motion_matrix
from models.margins import hydrodynamics, hydrostatics
from models.problems import DesignError, Problem
from models.run import Run
from models.simulate import STATES

Array = NDArray[np.float64]
SAMPLES = 200
MOST_WARNINGS = 5
"""Sign changes of one quantity that are told one by one."""


@dataclass(frozen=True)
class Quantity:
    """One thing that should keep its sign: its name, what it is in words, its unit, the part of a design it belongs to.

    `good` is the sign that rights or damps; within `dead_band` of zero the other one counts as none.
    """

    name: str
    words: str
    unit: str
    pointer: str
    dead_band: float
    good: float = 1.0


QUANTITIES = (
    Quantity("hydrostatic_margin", "the centre of buoyancy above that of mass", "m", "/vehicle/components", 1e-9),
    Quantity("pitch_stiffness", "the hydrostatic stiffness in pitch over the weight", "m", "/vehicle/components", 1e-9),
    Quantity("roll_stiffness", "the hydrostatic stiffness in roll over the weight", "m", "/vehicle/components", 1e-9),
    Quantity("pitch_margin", "the hydrodynamic margin in pitch", "1", "/vehicle/hydrodynamics", 1e-6),
    Quantity("yaw_margin", "the hydrodynamic margin in yaw", "1", "/vehicle/hydrodynamics", 1e-6),
    Quantity("growth", "the growth of small motions", "1/s", "/mission/control", 1e-6, good=-1.0),
)  # fmt: skip


@dataclass(frozen=True)
class Extreme:
    """The worst value of a quantity over a run, and when."""

    name: str
    unit: str
    value: float
    time: float


@dataclass(frozen=True)
class StabilityHistory:
    """Stability over a run.

    `times` (samples,) s; `offset` (samples, 3) m from the centre of buoyancy to that of mass, body axes; margins and
    stiffnesses (samples,), not numbers where there is no flow or no neutral point; `growth` (k,) 1/s at `growth_times`.
    `length` (m) is that of the vehicle. `extremes` are the worst values; `warnings` tell every change of sign.
    """

    times: Array
    offset: Array
    hydrostatic_margin: Array
    pitch_stiffness: Array
    roll_stiffness: Array
    pitch_margin: Array
    yaw_margin: Array
    growth_times: Array
    growth: Array
    length: float
    extremes: tuple[Extreme, ...]
    warnings: tuple[Problem, ...]

    def extreme(self, name: str) -> Extreme | None:
        """Return the worst value of a quantity; None where it has no value at any time."""
        return next((extreme for extreme in self.extremes if extreme.name == name), None)

    def as_dict(self) -> dict[str, Any]:
        """Return the history as a JSON object; values that are not numbers are null."""
        series = {quantity.name: _or_null(getattr(self, quantity.name)) for quantity in QUANTITIES}
        return {
            "times": self.times.tolist(), "offset": self.offset.tolist(), **series,
            "growth_times": self.growth_times.tolist(), "length": self.length,
            "extremes": [{"name": e.name, "unit": e.unit, "value": e.value, "time": e.time} for e in self.extremes],
            "warnings": [warning.as_dict() for warning in self.warnings],
        }  # fmt: skip


def _or_null(values: Array) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]


def stability_over(run: Run, samples: int = SAMPLES, *, assembly: Assembly | None = None) -> StabilityHistory:
    """Return the stability along a run, small motions at up to `samples` instants evenly spread.

    Raises
    ------
    DesignError
        Where `samples` is not positive, or the run's design cannot be assembled.

    """
    if samples < 1:
        raise DesignError([Problem("/samples", f"{samples} samples: give at least 1", limit=1)])
    made = assembly or assemble(run.design)
    still, flow = hydrostatics(run), hydrodynamics(run, made)
    chosen = np.unique(np.linspace(0, len(run.times) - 1, min(samples, len(run.times))).round().astype(np.intp))
    series = {
        "hydrostatic_margin": still.margin, "pitch_stiffness": still.pitch, "roll_stiffness": still.roll,
        "pitch_margin": flow.pitch, "yaw_margin": flow.yaw, "growth": growth_at(run, made, chosen),
    }  # fmt: skip
    times = {name: run.times[chosen] if name == "growth" else run.times for name in series}
    told = [(quantity, times[quantity.name], series[quantity.name]) for quantity in QUANTITIES]
    return StabilityHistory(
        times=run.times, offset=still.offset, growth_times=times["growth"], length=flow.length, **series,
        extremes=tuple(extreme for each in told if (extreme := worst_of(*each)) is not None),
        warnings=tuple(warning for each in told for warning in changes_of(*each)),
    )  # fmt: skip


def growth_at(run: Run, assembly: Assembly, samples: NDArray[np.intp]) -> Array:
    """Return the largest real part of the eigenvalues at some samples, by index, (k,) 1/s.

    It is not a number where pitch is within 0.1 deg of straight up or down.
    """
    states = np.zeros((len(samples), len(assembly.initial_state)))
    names = STATES[run.model]
    for j, name in enumerate(names):
        states[:, j] = run.values[name][samples]
    states[:, len(names) : len(names) + len(run.cells)] = run.cell_values["extension"][samples]
    growth = np.full(len(samples), np.nan)
    for k, (state, time) in enumerate(zip(states, run.times[samples].tolist(), strict=True)):
        try:
            _names, A = motion_matrix(assembly, assembly.params, state, time=time)
        except DesignError:
            continue
        growth[k] = float(np.linalg.eigvals(A).real.max())
    return growth


def worst_of(quantity: Quantity, times: Array, values: Array) -> Extreme | None:
    """Return the worst value of a quantity and when; None where it has none."""
    if not np.isfinite(values).any():
        return None
    k = int(np.nanargmin(quantity.good * values))
    return Extreme(quantity.name, quantity.unit, float(values[k]), float(times[k]))


def changes_of(quantity: Quantity, times: Array, values: Array) -> Iterator[Problem]:
    """Yield a warning whenever a quantity turns bad or good again, its time by linear interpolation.

    Past the fifth only their number is told.
    """
    known = np.flatnonzero(np.isfinite(values))
    t, x = times[known], values[known]
    bad = quantity.good * x < -quantity.dead_band
    at = np.flatnonzero(bad[:-1] != bad[1:])
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    for i in islice(at, MOST_WARNINGS):
        share = min(max(x[i] / (x[i] - x[i + 1]), 0.0), 1.0)
        crossing = t[i] + (t[i + 1] - t[i]) * share
        side = "falls below" if x[i + 1] < x[i] else "rises above"
        yield Problem(
            quantity.pointer,
            f"{quantity.words} {side} 0 at {crossing:.2f} s (from {x[i]:.3g} to {x[i + 1]:.3g}{unit}): "
            f"stability is {'lost' if bad[i + 1] else 'regained'}",
            limit=0.0,
        )
    if len(at) > MOST_WARNINGS:
        more = len(at) - MOST_WARNINGS
        yield Problem(quantity.pointer, f"{quantity.words} changes sign {more} more times", limit=0.0)
