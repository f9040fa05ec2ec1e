"""Owns the rows of one component: place, mass, the laws of its cell, and its schedule."""

from __future__ import annotations

from typing import Any

from models.components import Bellows, Bladder, Component, MovableMass, Piston, Rigid
from models.design import Design
from models.mass_properties import initial_extensions
from models.mission import Initial
from models.problems import pointer_to
from models.schedule import Schedule, SchedulePoint
from models.volumes import volume
from studio.changes import Patch, renamed, table_patch
from studio.panel.rows import (
    CM2,
    CM3,
    COUNT,
    GRAM,
    KG_CM2,
    MM,
    MM_PER_S,
    SECOND,
    Row,
    actions,
    at,
    field_row,
    hint_for,
    note,
    readout,
)
from studio.scene import vehicle_length

MAX_POINTS_SHOWN = 12
AXES = (
    ("forward", (1.0, 0.0, 0.0)),
    ("aft", (-1.0, 0.0, 0.0)),
    ("down", (0.0, 0.0, 1.0)),
    ("up", (0.0, 0.0, -1.0)),
)


def component_rows(design: Design, index: int) -> list[Row]:
    """Return the rows of component `index`."""
    component = design.vehicle.components[index]
    rows = _common_rows(component, index)
    match component:
        case Rigid():
            rows += _rigid_rows(index)
        case Bellows():
            rows += _bellows_rows(component, index)
        case Piston():
            rows += _piston_rows(index)
        case Bladder():
            rows += _bladder_rows(component, index)
        case MovableMass():
            rows += _stroke_rows(MovableMass, index)
    if not isinstance(component, Rigid):
        rows[3:3] = _extension_rows(component)
        rows += _actuator_rows(component, index)
    return rows


def _path(index: int, *fields: str | int) -> tuple[str | int, ...]:
    return "vehicle", "components", index, *fields


def _common_rows(component: Component, index: int) -> list[Row]:
    kind = type(component)

    def reach(design: Design) -> tuple[float, float]:
        half = round(0.6 * vehicle_length(design), 2)
        return -half, half

    def height(design: Design) -> tuple[float, float]:
        half = max(round(0.1 * vehicle_length(design), 2), 0.02)
        return -half, half

    name = Row(
        "Name", "text", lambda design: at(design, *_path(index, "name")),
        lambda design, value: renamed(design, index, value), hint=hint_for(kind, "name"),
    )  # fmt: skip
    forward, down = "Here x: forward.", "Here z: down."
    return [
        field_row(
            "Position x", _path(index, "position", 0), kind, widget="slider", unit=MM, span=reach, remark=forward
        ),
        field_row("Position z", _path(index, "position", 2), kind, widget="slider", unit=MM, span=height, remark=down),
        field_row("Mass", _path(index, "mass"), kind, unit=GRAM),
        name,
    ]


def _rigid_rows(index: int) -> list[Row]:
    def center(design: Design, axis: int, value: float) -> Patch:
        component = design.vehicle.components[index]
        point = list(component.center_of_mass or component.position)
        point[axis] = value
        return [{"op": "replace", "path": pointer_to(*_path(index, "center_of_mass")), "value": point}]

    def center_row(label: str, axis: int) -> Row:
        def read(design: Design) -> float:
            component = design.vehicle.components[index]
            return (component.center_of_mass or component.position)[axis]

        return Row(
            label, "number", read, lambda design, value: center(design, axis, value),
            hint=hint_for(Rigid, "center_of_mass"), unit=MM,
        )  # fmt: skip

    inertia = _path(index, "inertia", "yy")
    return [
        field_row("Volume", _path(index, "volume"), Rigid, unit=CM3),
        center_row("Centre of mass x", 0),
        center_row("Centre of mass z", 2),
        Row(
            "Pitch inertia", "number", lambda design: at(design, *inertia),
            lambda _, value: [{"op": "replace", "path": pointer_to(*inertia), "value": value}],
            hint="Moment of inertia in pitch about its own centre of mass (I_yy).", unit=KG_CM2,
        ),
    ]  # fmt: skip


def _extension_rows(component: Component) -> list[Row]:
    name = component.name

    def write(_: Design, value: float) -> Patch:
        return [{"op": "add", "path": pointer_to("mission", "initial", "extensions", name), "value": value}]

    def stops(design: Design) -> tuple[float, float]:
        return next(c.stroke for _, c in design.vehicle.actuated if c.name == name)

    rows = [
        Row(
            "Extension at start", "slider", lambda design: initial_extensions(design)[name], write,
            hint=hint_for(Initial, "extensions"), unit=MM, span=stops, step=0.1,
        )
    ]  # fmt: skip
    if not isinstance(component, MovableMass):

        def start_volume(design: Design) -> float:
            part = next(c for c in design.vehicle.components if c.name == name)
            return volume(part, initial_extensions(design)[name])

        rows.append(readout("Volume at start", start_volume, CM3, hint="Displaced volume at the extension at start."))
    return rows


def _stroke_rows(kind: type[Bellows] | type[MovableMass], index: int) -> list[Row]:
    return [
        field_row("Stroke from", _path(index, "extension_range", 0), kind, unit=MM),
        field_row("Stroke to", _path(index, "extension_range", 1), kind, unit=MM),
        field_row("Neutral", _path(index, "neutral_extension"), kind, unit=MM),
    ]


def _bellows_rows(component: Bellows, index: int) -> list[Row]:
    def neutral_volume(design: Design) -> float:
        part = design.vehicle.components[index]
        return volume(part, part.neutral) if isinstance(part, Bellows) else 0.0

    return [
        field_row("Pleats", _path(index, "pleats"), Bellows, widget="integer", unit=COUNT),
        field_row("Inner radius", _path(index, "inner_radius"), Bellows, unit=MM),
        field_row("Outer radius", _path(index, "outer_radius"), Bellows, unit=MM),
        field_row("Fixed volume", _path(index, "fixed_volume"), Bellows, unit=CM3),
        readout("Neutral volume", neutral_volume, CM3, hint="Displaced volume at neutral extension."),
        *_stroke_rows(Bellows, index),
    ]


def _piston_rows(index: int) -> list[Row]:
    return [
        field_row("Neutral volume", _path(index, "volume"), Piston, unit=CM3),
        field_row("Smallest volume", _path(index, "volume_range", 0), Piston, unit=CM3),
        field_row("Largest volume", _path(index, "volume_range", 1), Piston, unit=CM3),
        field_row("Area", _path(index, "area"), Piston, unit=CM2),
    ]


def _bladder_rows(component: Bladder, index: int) -> list[Row]:
    def show(design: Design) -> str:
        part = design.vehicle.components[index]
        if not isinstance(part, Bladder):
            return ""
        return ", ".join(f"{e * 1e3:g}: {v * 1e6:g}" for e, v in zip(part.extensions, part.volumes, strict=True))

    hint = "Extension of the pump in mm and displaced volume in cm³, pair by pair; both must rise."
    return [
        Row("Table", "text", show, lambda _, value: table_patch(index, component, value), hint=hint),
        field_row("Neutral", _path(index, "neutral_extension"), Bladder, unit=MM),
    ]


def _actuator_rows(component: Component, index: int) -> list[Row]:
    kind = type(component)
    axis = getattr(component, "axis", AXES[0][1])
    choices = AXES if any(axis == choice for _, choice in AXES) else (*AXES, ("oblique", axis))
    return [
        field_row("Rate limit", _path(index, "rate_limit"), kind, unit=MM_PER_S, none=0.0, remark="0: no limit."),
        field_row("Lag", _path(index, "lag"), kind, unit=SECOND, step=0.1),
        field_row("Grows", _path(index, "axis"), kind, widget="choice", choices=choices),
    ]


def _schedule_of(design: Design, name: str) -> tuple[int, Schedule] | None:
    return next(((i, s) for i, s in enumerate(design.mission.control.schedules) if s.cell == name), None)


def schedule_rows(design: Design, index: int) -> list[Row]:
    """Return the rows of the schedule that component `index` follows; none where it cannot move."""
    component = design.vehicle.components[index]
    if isinstance(component, Rigid):
        return []
    found = _schedule_of(design, component.name)
    points = found[1].points if found else ()
    rows: list[Row] = []
    for k in range(min(len(points), MAX_POINTS_SHOWN)):
        path = ("mission", "control", "schedules", found[0] if found else 0, "points", k)
        shapes = (("step", "step"), ("ramp", "ramp"))
        rows += [
            field_row(f"Time {k + 1}", (*path, "time"), SchedulePoint, unit=SECOND),
            field_row(f"Extension {k + 1}", (*path, "extension"), SchedulePoint, unit=MM, step=0.1),
            field_row(f"Shape {k + 1}", (*path, "shape"), SchedulePoint, widget="choice", choices=shapes),
        ]
    if not points:
        rows.append(note(lambda _: "Holds its extension at start."))
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
