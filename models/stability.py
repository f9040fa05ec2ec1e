"""Owns stability over a run: static margins at every sample, growth of small motions, and where either is lost.

Margins as in `models.margins`. Growth is the largest real part of the eigenvalues of the motion with depth, heading and
extensions held, frozen in time at each instant: of a glider that is settled it says whether the glide is stable, of one
that is turning over only which way things go. SI units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.limits import DEFAULT_LIMITS, Limits
from models.margins import hydrodynamics, hydrostatics
from models.modes import NEUTRAL
from models.motion_growth import growth_at_state
from models.problems import DesignError, Problem
from models.run import Run
from models.simulate import STATES

Array = NDArray[np.float64]
SAMPLES = 200


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
    Quantity("growth", "the growth of small motions", "1/s", "/mission/control", NEUTRAL, good=-1.0),
)  # fmt: skip


@dataclass(frozen=True)
class Extreme:
    """The worst value of a quantity over a run, and when."""

    name: str
    unit: str
    value: float
    time: float


@dataclass(frozen=True)
class SignChange:
    """A quantity turns bad (`lost`) or good again: when (s), and its values at the samples before and after."""

    name: str
    time: float
    before: float
    after: float
    lost: bool


@dataclass(frozen=True)
class StabilityHistory:
    """Stability over a run.

    `times` (samples,) s; `offset` (samples, 3) m from the centre of buoyancy to that of mass, body axes; margins and
    stiffnesses (samples,), not numbers where there is no flow or no neutral point; `growth` (k,) 1/s at `growth_times`.
    `length` (m) is that of the vehicle. `extremes` are the worst values, `changes` every change of sign by quantity;
    `warnings` sum up in one message each what is lost, when and for how long.
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
    changes: tuple[SignChange, ...] = ()

    def extreme(self, name: str) -> Extreme | None:
        """Return the worst value of a quantity; None where it has no value at any time."""
        return next((extreme for extreme in self.extremes if extreme.name == name), None)

    def as_dict(self) -> dict[str, Any]:
        """Return the history as a JSON object, without `changes`; values that are not numbers are null."""
        series = {quantity.name: _or_null(getattr(self, quantity.name)) for quantity in QUANTITIES}
        return {
            "times": self.times.tolist(), "offset": self.offset.tolist(), **series,
            "growth_times": self.growth_times.tolist(), "length": self.length,
            "extremes": [{"name": e.name, "unit": e.unit, "value": e.value, "time": e.time} for e in self.extremes],
            "warnings": [warning.as_dict() for warning in self.warnings],
        }  # fmt: skip


def _or_null(values: Array) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]


def stability_over(
    run: Run, samples: int = SAMPLES, *, assembly: Assembly | None = None, limits: Limits = DEFAULT_LIMITS
) -> StabilityHistory:
    """Return the stability along a run, small motions at up to `samples` instants evenly spread.

    The run's design is assembled within `limits`, unless its assembly is given.

    Raises
    ------
    DesignError
        Where `samples` is not positive, or the run's design cannot be assembled.

    """
    if samples < 1:
        raise DesignError([Problem("/samples", f"{samples} samples: give at least 1", limit=1)])
    made = assembly or assemble(run.design, limits)
    still, flow = hydrostatics(run), hydrodynamics(run, made)
    chosen = np.unique(np.linspace(0, len(run.times) - 1, min(samples, len(run.times))).round().astype(np.intp))
    series = {
        "hydrostatic_margin": still.margin, "pitch_stiffness": still.pitch, "roll_stiffness": still.roll,
        "pitch_margin": flow.pitch, "yaw_margin": flow.yaw, "growth": growth_at(run, made, chosen),
    }  # fmt: skip
    times = {name: run.times[chosen] if name == "growth" else run.times for name in series}
    told = [(quantity, times[quantity.name], series[quantity.name]) for quantity in QUANTITIES]
    growth = (times["growth"], series["growth"])
    return StabilityHistory(
        times=run.times, offset=still.offset, growth_times=times["growth"], length=flow.length, **series,
        extremes=tuple(extreme for each in told if (extreme := worst_of(*each)) is not None),
        warnings=tuple(warning for each in told if (warning := warning_of(*each, growth)) is not None),
        changes=tuple(change for each in told for change in changes_of(*each)),
    )  # fmt: skip


def growth_at(run: Run, assembly: Assembly, samples: NDArray[np.intp]) -> Array:
    """Return the largest real part of the eigenvalues at some samples, by index, (k,) 1/s."""
    states = np.zeros((len(samples), len(assembly.initial_state)))
    names = STATES[run.model]
    for j, name in enumerate(names):
        states[:, j] = run.values[name][samples]
    states[:, len(names) : len(names) + len(run.cells)] = run.cell_values["extension"][samples]
    told = zip(states, run.times[samples].tolist(), strict=True)
    return np.array([growth_at_state(assembly, assembly.params, state, time=time) for state, time in told])


def worst_of(quantity: Quantity, times: Array, values: Array) -> Extreme | None:
    """Return the worst value of a quantity and when; None where it has none."""
    if not np.isfinite(values).any():
        return None
    k = int(np.nanargmin(quantity.good * values))
    return Extreme(quantity.name, quantity.unit, float(values[k]), float(times[k]))


def changes_of(quantity: Quantity, times: Array, values: Array) -> tuple[SignChange, ...]:
    """Return when a quantity turns bad or good again, by linear interpolation between samples that have a value."""
    known = np.flatnonzero(np.isfinite(values))
    t, x = times[known], values[known]
    bad = quantity.good * x < -quantity.dead_band
    changes = []
    for i in np.flatnonzero(bad[:-1] != bad[1:]):
        share = min(max(x[i] / (x[i] - x[i + 1]), 0.0), 1.0)
        crossing = float(t[i] + (t[i + 1] - t[i]) * share)
        changes.append(SignChange(quantity.name, crossing, float(x[i]), float(x[i + 1]), bool(bad[i + 1])))
    return tuple(changes)


def stretches_lost(quantity: Quantity, times: Array, values: Array) -> list[tuple[float, float]]:
    """Return from when until when (s) a quantity has the sign that neither rights nor damps."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return []
    changes = changes_of(quantity, times, values)
    starts = [change.time for change in changes if change.lost]
    ends = [change.time for change in changes if not change.lost]
    if quantity.good * values[known[0]] < -quantity.dead_band:
        starts = [float(times[known[0]]), *starts]
    if len(ends) < len(starts):
        ends = [*ends, float(times[known[-1]])]
    return list(zip(starts, ends, strict=True))


def warning_of(quantity: Quantity, times: Array, values: Array, growth: tuple[Array, Array]) -> Problem | None:
    """Return one warning of a quantity that is lost at any time, None of one that never is.

    It tells how often the sign changes, when it is first lost, and the longest stretch: from when until when, the worst
    value there, and whether small motions are stable meanwhile by `growth`, its times (s) and values (1/s).
    """
    lost = stretches_lost(quantity, times, values)
    if not lost:
        return None
    changes = changes_of(quantity, times, values)
    start, end = max(lost, key=lambda stretch: stretch[1] - stretch[0])
    worst = worst_of(quantity, *_within(start, end, times, values))
    assert worst is not None  # the ends of a stretch have values
    side = "below" if quantity.good > 0.0 else "above"
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    depth = f"{worst.value:.3g}{unit} at {worst.time:.2f} s"
    if changes:
        often = "once" if len(changes) == 1 else f"{len(changes)} times"
        words = (
            f"{quantity.words} changes sign {often}: first lost {_first(changes, lost[0][0], unit)}, "
            f"longest {side} 0 from {start:.2f} to {end:.2f} s, at worst {depth}"
        )
    else:
        words = f"{quantity.words} is {side} 0 all the time, at worst {depth}"
    told = "" if quantity.name == "growth" else _meanwhile(start, end, *growth)
    return Problem(quantity.pointer, words + told, limit=0.0)


def _first(changes: tuple[SignChange, ...], start: float, unit: str) -> str:
    """Return when a quantity is first lost, in words; before its first change where it begins so."""
    if not changes[0].lost:
        return f"at the start, {start:.2f} s (until {changes[0].time:.2f} s)"
    return f"at {changes[0].time:.2f} s (from {changes[0].before:.3g} to {changes[0].after:.3g}{unit})"


def _within(start: float, end: float, times: Array, values: Array) -> tuple[Array, Array]:
    """Return the samples from `start` to `end` (s), with values between samples at these two, by interpolation."""
    known = np.isfinite(values)
    inside = known & (times > start) & (times < end)
    ends = np.interp([start, end], times[known], values[known])
    return np.array([start, *times[inside], end]), np.array([ends[0], *values[inside], ends[1]])


def _meanwhile(start: float, end: float, times: Array, growth: Array) -> str:
    """Return whether small motions are stable from `start` to `end` (s), in words; none where growth has no value."""
    if not np.isfinite(growth).any():
        return ""
    most = float(_within(start, end, times, growth)[1].max())
    if most < -NEUTRAL:
        return f"; small motions are stable all the while (growth at most {most:.3g} 1/s)"
    return f"; small motions are not stable all the while (growth up to {most:.3g} 1/s)"
