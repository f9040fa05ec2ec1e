"""Owns the rows of the schedule that a component follows: its points, in order of time."""

from __future__ import annotations

from typing import Any

from models.components import Rigid, RollingMass
from models.design import Design
from models.mass_properties import initial_extensions
from models.problems import pointer_to
from models.schedule import Schedule, SchedulePoint
from studio.changes import Patch
from studio.panel.component_rows import unit_of
from studio.panel.rows import SECOND, Row, actions, field_row, note

MAX_POINTS_SHOWN = 12


def _schedule_of(design: Design, name: str) -> tuple[int, Schedule] | None:
    return next(((i, s) for i, s in enumerate(design.mission.control.schedules) if s.cell == name), None)


def schedule_rows(design: Design, index: int) -> list[Row]:
    """Return the rows of the schedule that component `index` follows; none where it cannot move."""
    component = design.vehicle.components[index]
    if isinstance(component, Rigid):
        return []
    found = _schedule_of(design, component.name)
    points = found[1].points if found else ()
    what = "Angle" if isinstance(component, RollingMass) else "Extension"
    rows: list[Row] = []
    for k in range(min(len(points), MAX_POINTS_SHOWN)):
        path = ("mission", "control", "schedules", found[0] if found else 0, "points", k)
        shapes = (("step", "step"), ("ramp", "ramp"))
        rows += [
            field_row(f"Time {k + 1}", (*path, "time"), SchedulePoint, unit=SECOND),
            field_row(f"{what} {k + 1}", (*path, "extension"), SchedulePoint, unit=unit_of(component), step=0.1),
            field_row(f"Shape {k + 1}", (*path, "shape"), SchedulePoint, widget="choice", choices=shapes),
        ]
    if not points:
        rows.append(note(lambda _: f"Holds its {what.lower()} at start."))
    if len(points) > MAX_POINTS_SHOWN:
        rows.append(note(lambda _: f"{len(points) - MAX_POINTS_SHOWN} more points are in the timeline below."))
    options = (("+ Add", -1), *((f"− {k + 1}", k) for k in range(min(len(points), MAX_POINTS_SHOWN))))
    rows.append(actions("Points", options, lambda d, k: _points_patch(d, component.name, k)))
    return rows


def _points_patch(design: Design, name: str, k: int) -> Patch:
    """Return the patch that removes point k, or for k = -1 adds one after the last."""
    found = _schedule_of(design, name)
    schedules: tuple[str | int, ...] = ("mission", "control", "schedules")
    if found is None:
        point: dict[str, Any] = {"time": 0.0, "extension": initial_extensions(design)[name]}
        return [{"op": "add", "path": pointer_to(*schedules, "-"), "value": {"cell": name, "points": [point]}}]
    i, schedule = found
    if k < 0:
        last, end = schedule.points[-1], design.mission.duration
        time = round((last.time + end) / 2.0, 2) if last.time < 0.99 * end else last.time + 1.0
        point = {"time": time, "extension": last.extension}
        return [{"op": "add", "path": pointer_to(*schedules, i, "points", "-"), "value": point}]
    whole = len(schedule.points) == 1
    return [{"op": "remove", "path": pointer_to(*schedules, i, *(() if whole else ("points", k)))}]
