"""Owns the open-loop schedule of a cell: which extension is asked for, and when."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal, Self

from pydantic import model_validator

from models.components import Extension
from models.fields import Description, Name, quantity, text


class SchedulePoint(Description):
    """One point of a schedule: the command reaches `extension` at `time`, by a step or by a ramp."""

    time: float = quantity("Time since the start of the mission.", unit="s", symbol="t", ge=0.0, le=1e9)
    extension: Extension = quantity("Commanded extension (angle in rad of a rolling mass).", unit="m", symbol="e_cmd")
    shape: Literal["step", "ramp"] = text(
        "How the command comes from the point before: it jumps at this time, or runs linearly up to it.",
        default="step",
    )


class Schedule(Description):
    """What one cell (or movable mass) is asked to do; before the first point it holds its initial extension."""

    cell: Name = text("Name of the component that follows this schedule.")
    points: tuple[SchedulePoint, ...] = text("Points in rising order of time.", min_length=1)

    @model_validator(mode="after")
    def _times_rise(self) -> Self:
        for k, (a, b) in enumerate(pairwise(self.points)):
            if not a.time < b.time:
                raise ValueError(
                    f"times must rise: point {k + 2} of '{self.cell}' is at {b.time} s, not after {a.time} s"
                )
        return self
