"""Owns the holds of a mission: the stretches in which the cells stay where they are, each told by its times.

An open-loop schedule says exactly when nothing is asked to move. Under control the cells move at every sample, so there
the phases of the run stand in: its dives, climbs and legs, each with the extensions of its second half.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.components import Actuated
from models.design import Design
from models.mass_properties import initial_extensions
from models.run import Run
from models.schedule import Schedule

Array = NDArray[np.float64]
Span = tuple[float, float]

MOST_HOLDS = 4
"""Of more, those that last longest are told: a spatial trim takes 3 to 5 ms, and an edit waits for them all."""
SAME = 1e-6
"""Extensions that differ by less than this share of a stroke are one hold."""
ALIKE = 0.03
"""Under control extensions scatter: phases within this share of a stroke of each other are one hold."""
JUST = 1e-6
"""By less than this, s, a run that ends before a hold does ends with it."""
SHORTEST = 0.02
"""Phases of a controlled run below this share of it are none."""
TURNS = ("dive", "climb", "waypoint")


@dataclass(frozen=True)
class Hold:
    """Extensions (m or rad, by name) and when they are held (s); `about` where they are typical, not exact.

    `reached` is False where the run ended before: its times are then those of the mission.
    """

    spans: tuple[Span, ...]
    extensions: Mapping[str, float]
    about: bool = False
    reached: bool = True

    @property
    def lasts(self) -> float:
        """How long it is held in all, s."""
        return sum(end - start for start, end in self.spans)


def holds_of(assembly: Assembly, run: Run | None) -> tuple[list[Hold], list[Hold]]:
    """Return the distinct holds by their first times, and the shorter ones that are left out."""
    design = assembly.design
    if design.mission.control.controller is None:
        found, tolerance = scheduled_holds(design), SAME
    else:
        found, tolerance = phases_of(run) if run is not None else [], ALIKE
    distinct = _distinct(found, {part.name: part for _, part in design.vehicle.actuated}, tolerance)
    if run is not None:
        distinct = [_as_flown(hold, float(run.times[-1])) for hold in distinct]
    ranked = sorted(distinct, key=lambda hold: (not hold.reached, -hold.lasts))
    return sorted(ranked[:MOST_HOLDS], key=lambda hold: hold.spans[0]), ranked[MOST_HOLDS:]


def spans_of(holds: Iterable[Hold]) -> tuple[Span, ...]:
    """Return when a run is in one of these holds, in the order of time."""
    return _joined(sorted(span for hold in holds if hold.reached for span in hold.spans))


def _as_flown(hold: Hold, end: float) -> Hold:
    """Return a hold with the times before a run's end (s), or as not reached where it has none."""
    flown = tuple((start, min(stop, end) if stop > end + JUST else stop) for start, stop in hold.spans if start < end)
    return replace(hold, spans=flown) if flown else replace(hold, reached=False)


def scheduled_holds(design: Design) -> list[Hold]:
    """Return the stretches of a mission in which no command moves, in the order of time."""
    duration = design.mission.duration
    schedules = {schedule.cell: schedule for schedule in design.mission.control.schedules}
    times = {point.time for schedule in schedules.values() for point in schedule.points if point.time < duration}
    start = initial_extensions(design)
    holds = []
    for begin, end in pairwise(sorted({0.0, *times, duration})):
        commands = {name: _held(schedules.get(name), initial, begin, end) for name, initial in start.items()}
        still = {name: value for name, value in commands.items() if value is not None}
        if len(still) == len(commands):
            holds.append(Hold(((begin, end),), still))
    return holds


def _held(schedule: Schedule | None, initial: float, begin: float, end: float) -> float | None:
    """Return the command between two neighbouring times of a mission's points, or None where it ramps."""
    value = initial
    for point in schedule.points if schedule else ():
        if point.time <= begin:
            value = point.extension
        else:
            ramps = point.shape == "ramp" and point.extension != value
            return None if ramps else value
    return value


def phases_of(run: Run) -> list[Hold]:
    """Return the phases of a controlled run, each with the median extensions of its second half."""
    last = float(run.times[-1])
    marks = sorted({0.0, *(event.time for event in run.events if event.kind in TURNS), last})
    holds = []
    for begin, end in pairwise(marks):
        settled = (run.times >= 0.5 * (begin + end)) & (run.times <= end)
        if end - begin < SHORTEST * last or not settled.any():
            continue
        middle = np.median(run.cell_values["extension"][settled], axis=0).tolist()
        holds.append(Hold(((begin, end),), dict(zip(run.cells, middle, strict=True)), about=True))
    return holds


def _distinct(holds: Iterable[Hold], parts: Mapping[str, Actuated], tolerance: float) -> list[Hold]:
    """Return the holds, those of (nearly) the same extensions as one with all their times."""
    distinct: list[Hold] = []
    for hold in holds:
        for k, known in enumerate(distinct):
            if all(
                abs(e - known.extensions[name]) <= tolerance * (parts[name].stroke[1] - parts[name].stroke[0])
                for name, e in hold.extensions.items()
            ):
                distinct[k] = replace(known, spans=_joined([*known.spans, *hold.spans]))
                break
        else:
            distinct.append(hold)
    return distinct


def _joined(spans: Sequence[Span]) -> tuple[Span, ...]:
    """Return rising spans, those that touch as one."""
    joined: list[Span] = []
    for start, end in spans:
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    return tuple(joined)
