"""Owns what is marked along a run's time: stretches that its warnings cover, and the phases of its controller."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.controllers import Cascade, DepthBand, Station, Waypoints
from models.problems import Problem
from models.run import Run
from models.run_warnings import Doubt, Spans, outside_data

Array = NDArray[np.float64]

MOST_SPANS = 200
"""Stretches told of one thing; more could not be told apart on a screen."""
DIGITS = 4
"""Of a time in s."""


def warning_times(warning: Problem) -> list[list[float]]:
    """Return the stretches of time (s) that a warning is about; none where it is about the design or the whole run."""
    return _written(warning.times) if isinstance(warning, Doubt) else []


def outside_spans(run: Run) -> list[dict[str, Any]]:
    """Return in what way and when samples lie outside the data that forces and water come from."""
    return [
        {"what": warning.message, "pointer": warning.pointer, "spans": warning_times(warning)}
        for warning in outside_data(run)
    ]


def phases_of(run: Run) -> list[dict[str, Any]]:
    """Return the phases that a controller's guidance went through: `track` vertical or lateral, `tone` by its kind."""
    controller = run.design.mission.control.controller
    if not isinstance(controller, Cascade):
        return []
    bands = []
    if isinstance(controller.vertical, DepthBand):
        bands += _bands(run, "vertical", run.values["phase"], lambda value: ("Climb" if value else "Dive", int(value)))
    guidance = None if controller.lateral is None else controller.lateral.guidance
    if isinstance(guidance, Waypoints):
        count = len(guidance.points)
        bands += _bands(run, "lateral", run.values["leg"], lambda value: _leg(int(value), count))
    elif isinstance(guidance, Station):
        away = np.isfinite(run.values["heading_target"]).astype(np.float64)
        bands += _bands(run, "lateral", away, lambda value: ("Heads back" if value else "Spirals", int(value)))
    return bands


def _leg(leg: int, count: int) -> tuple[str, int]:
    return (f"Leg {leg + 1} of {count}", leg % 2) if leg < count else ("Past the last waypoint", 2)


def _bands(run: Run, track: str, values: Array, name: Callable[[float], tuple[str, int]]) -> list[dict[str, Any]]:
    """Return a band for each stretch of equal values; not a number is none."""
    known = np.nan_to_num(values, nan=-1.0)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(known)) + 1])
    ends = np.concatenate([starts[1:], [len(known) - 1]])
    bands = []
    for a, b in zip(starts.tolist()[:MOST_SPANS], ends.tolist(), strict=False):
        if known[a] >= 0.0 and b > a:
            label, tone = name(float(known[a]))
            (span,) = _written([(run.times[a], run.times[b])])
            bands.append({"track": track, "name": label, "tone": tone, "from": span[0], "to": span[1]})
    return bands


def _written(spans: Spans | Iterable[tuple[float, float]]) -> list[list[float]]:
    return [[round(float(a), DIGITS), round(float(b), DIGITS)] for a, b in list(spans)[:MOST_SPANS]]
