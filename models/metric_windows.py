"""Owns stretches of a run: its outputs between two times, and which stretches a phase consists of."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from models.energy import dive_marks
from models.metric_phases import (
    BetweenEvents,
    Both,
    Dive,
    DivePart,
    EventAt,
    LastSeconds,
    Limited,
    Phase,
    TimeSpan,
    While,
    WholeRun,
)  # fmt: skip
from models.metric_statistics import Interval, Piece, beyond, changes, pieces_of
from models.run import Event, Run

Array = NDArray[np.float64]
T = TypeVar("T")
UNWOUND = ("psi",)
"""Angles that go on past half a turn rather than jump by a whole one."""


class MissingOutputError(LookupError):
    """A run does not keep an output: it is of the other model, of other cells, or without a controller."""


class Stretch:
    """A run between two times (s): its outputs, with the values at the ends interpolated between samples."""

    def __init__(self, glide: Glide, begin: float, end: float) -> None:
        times = glide.run.times
        self.glide, self.begin, self.end = glide, begin, end
        self.from_start, self.to_end = begin <= times[0], end >= times[-1]
        self._kept: dict[tuple[str, str | None], Array] = {}

    @property
    def run(self) -> Run:
        """The run it is of."""
        return self.glide.run

    @property
    def duration(self) -> float:
        """Its length, s."""
        return self.end - self.begin

    @cached_property
    def times(self) -> Array:
        """Times of its samples and of its ends, s."""
        return self._between(self.run.times)

    def __getitem__(self, name: str) -> Array:
        return self.output(name)

    def __contains__(self, name: str) -> bool:
        return name in self.run.values

    def output(self, name: str, cell: str | None = None) -> Array:
        """Return an output at `times`; raises `MissingOutputError` where the run keeps none of this name."""
        key = name, cell
        if key not in self._kept:
            self._kept[key] = self._between(self.glide.output(name, cell))
        return self._kept[key]

    def pieces(self, name: str, cell: str | None = None, *, absolute: bool = False) -> list[Piece]:
        """Return an output as the pieces in which it is a number."""
        return pieces_of(self.times, self.output(name, cell), absolute=absolute)

    @cached_property
    def steps(self) -> Array:
        """Horizontal way over ground from sample to sample, m."""
        dx = changes(self["x"])
        return np.hypot(dx, changes(self["y"])) if "y" in self else np.abs(dx)

    @cached_property
    def way(self) -> float:
        """Horizontal way over ground, m."""
        return float(self.steps.sum())

    @cached_property
    def vertical_travel(self) -> float:
        """Way down and up, m."""
        return float(np.abs(changes(self["z"])).sum())

    def gain(self, name: str) -> float:
        """Return by how much an account grew that begins with zero before the run does."""
        account = self[name]
        return float(account[-1] - (0.0 if self.from_start else account[0]))

    def holds(self, time: float) -> bool:
        """Return whether a time is within; the end belongs to what follows, if anything does."""
        return self.begin <= time and (self.to_end or time < self.end)

    def events(self, kind: str, cell: str | None = None) -> list[Event]:
        """Return its events of a kind, in order."""
        return [
            event for event in self.run.events
            if event.kind == kind and (cell is None or event.cell == cell) and self.holds(event.time)
        ]  # fmt: skip

    def _between(self, samples: Array) -> Array:
        """Return samples (n,) cut at both ends."""
        if self.from_start and self.to_end:
            return samples
        first, last = self._inside
        ends = [self._at(samples, time, k) for time, k in ((self.begin, first), (self.end, last))]
        return np.concatenate([ends[:1], samples[first:last], ends[1:]])

    @cached_property
    def _inside(self) -> tuple[int, int]:
        """The samples strictly within."""
        times = self.run.times
        return int(np.searchsorted(times, self.begin, "right")), int(np.searchsorted(times, self.end, "left"))

    def _at(self, samples: Array, time: float, near: int) -> float:
        """Return what goes straight between samples, at a time; `near` is a sample beside it."""
        times = self.run.times
        k = min(max(near - 1, 0), len(times) - 2)
        for sample in (k, k + 1):
            if times[sample] == time:
                return float(samples[sample])
        share = (time - times[k]) / (times[k + 1] - times[k])
        return float(samples[k] + share * (samples[k + 1] - samples[k]))


class Glide:
    """A run as metrics look at it; what several of them need is computed once."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.whole = Stretch(self, float(run.times[0]), float(run.times[-1]))
        self._stretches: dict[Phase, tuple[Stretch, ...]] = {}

    def output(self, name: str, cell: str | None) -> Array:
        """Return an output (samples,); raises `MissingOutputError` where the run keeps none of this name."""
        if cell is None and name in self.run.values:
            values = self.run.values[name]
            return np.unwrap(values) if name in UNWOUND else values
        if name in self.run.cell_values and cell in self.run.cells:
            return self.run.cell_values[name][:, self.run.cells.index(cell)]
        raise MissingOutputError(name)

    @cached_property
    def dives(self) -> tuple[tuple[int, int, int], ...]:
        """First, deepest and last sample of each dive of the energy bill."""
        z = self.run.values["z"]
        if not np.isfinite(z).all():
            return ()
        return tuple((a, a + int(z[a : b + 1].argmax()), b) for a, b in pairwise(dive_marks(z)) if b > a)

    def stretches(self, phase: Phase) -> tuple[Stretch, ...]:
        """Return the stretches that a phase consists of, in order."""
        if isinstance(phase, WholeRun):
            return (self.whole,)
        if phase not in self._stretches:
            self._stretches[phase] = tuple(Stretch(self, *interval) for interval in self._intervals(phase))
        return self._stretches[phase]

    def _intervals(self, phase: Phase) -> list[Interval]:
        begin, end = self.whole.begin, self.whole.end
        match phase:
            case WholeRun():
                found = [(begin, end)]
            case TimeSpan():
                found = [(max(begin, phase.begin), end if phase.end is None else min(end, phase.end))]
            case LastSeconds():
                found = [(max(begin, end - phase.seconds), end)]
            case Dive() | DivePart():
                found = self._of_dives(phase)
            case While():
                found = limited(self.whole, phase)
            case BetweenEvents():
                found = [(a, b) for a in self._mark(phase.begin, begin) for b in self._mark(phase.end, end)]
            case Both():
                found = self._intervals(phase.of[0])
                for other in phase.of[1:]:
                    found = overlaps(found, self._intervals(other))
        return [(a, b) for a, b in found if b > a]

    def _of_dives(self, phase: Dive | DivePart) -> list[Interval]:
        dives = self.dives if phase.number is None else picked(self.dives, phase.number)
        parts = {"dive": (0, 2), "descent": (0, 1), "climb": (1, 2)}
        first, last = parts[phase.kind]
        times = self.run.times
        return [(float(times[dive[first]]), float(times[dive[last]])) for dive in dives]

    def _mark(self, event: EventAt | None, otherwise: float) -> list[float]:
        """Return the time of an event, as a list that is empty where there was none."""
        if event is None:
            return [otherwise]
        return [found.time for found in picked(self.whole.events(event.event, event.cell), event.number)]


def picked(items: Sequence[T], number: int) -> Sequence[T]:
    """Return the item of a number, counted from 1, or from the last with -1; none where there is none."""
    k = number - 1 if number > 0 else len(items) + number
    return items[k : k + 1] if k >= 0 else ()


def limited(stretch: Stretch, limit: Limited) -> list[Interval]:
    """Return the times within a stretch at which an output is beyond a limit."""
    pieces = stretch.pieces(limit.of, limit.cell, absolute=limit.absolute)
    return beyond(pieces, limit.bound, below=limit.above is None)


def overlaps(some: Sequence[Interval], others: Sequence[Interval]) -> list[Interval]:
    """Return where two rising sequences of intervals overlap."""
    found, k = [], 0
    for a, b in some:
        while k < len(others) and others[k][1] <= a:
            k += 1
        for c, d in others[k:]:
            if c >= b:
                break
            found.append((max(a, c), min(b, d)))
    return found
