"""Owns the rows of one component: place, mass, and the laws of its cell or of its motion."""

from __future__ import annotations

from models.components import Actuated, Bellows, Bladder, Component, MovableMass, Mover, Piston, Rigid, RollingMass
from models.design import Design
from models.mass_properties import initial_extensions
from models.mission import Initial
from models.problems import pointer_to
from models.volumes import volume
from studio.changes import Patch, renamed, table_patch
from studio.panel.rows import (
    CM2,
    CM3,
    COUNT,
    DEGREE,
    DEGREE_PER_S,
    GRAM,
    KG_CM2,
    MM,
    MM_PER_S,
    PERCENT,
    SECOND,
    Row,
    Unit,
    at,
    field_row,
    hint_for,
    is_spatial,
    readout,
)
from studio.scene import vehicle_length

AXES = (
    ("forward", (1.0, 0.0, 0.0)),
    ("aft", (-1.0, 0.0, 0.0)),
    ("down", (0.0, 0.0, 1.0)),
    ("up", (0.0, 0.0, -1.0)),
    ("starboard", (0.0, 1.0, 0.0)),
    ("port", (0.0, -1.0, 0.0)),
)


def unit_of(component: Component) -> Unit:
    """Return the unit in which people read a component's extension."""
    return DEGREE if isinstance(component, RollingMass) else MM


def component_rows(design: Design, index: int) -> list[Row]:
    """Return the rows of component `index`."""
    component, spatial = design.vehicle.components[index], is_spatial(design)
    rows = _common_rows(component, index, spatial=spatial)
    match component:
        case Rigid():
            rows += _rigid_rows(index, spatial=spatial)
        case Bellows():
            rows += _bellows_rows(component, index)
        case Piston():
            rows += _piston_rows(index)
        case Bladder():
            rows += _bladder_rows(component, index)
        case MovableMass():
            rows += _stroke_rows(MovableMass, index)
        case RollingMass():
            rows += _rolling_rows(index)
    if not isinstance(component, Rigid):
        place = next(k for k, row in enumerate(rows) if row.label == "Mass") + 1
        rows[place:place] = _extension_rows(component)
        rows += _actuator_rows(component, index, spatial=spatial)
    return rows


def _path(index: int, *fields: str | int) -> tuple[str | int, ...]:
    return "vehicle", "components", index, *fields


def _common_rows(component: Component, index: int, *, spatial: bool) -> list[Row]:
    kind = type(component)
    path = _path(index, "position")

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
    rows = [
        field_row("Position x", (*path, 0), kind, widget="slider", unit=MM, span=reach, remark="Here x: forward."),
        field_row("Position z", (*path, 2), kind, widget="slider", unit=MM, span=height, remark="Here z: down."),
        field_row("Mass", _path(index, "mass"), kind, unit=GRAM),
        name,
    ]
    if spatial or component.position[1] != 0.0:
        remark = "Here y: to starboard."
        rows.insert(1, field_row("Position y", (*path, 1), kind, widget="slider", unit=MM, span=height, remark=remark))
    return rows


def _rigid_rows(index: int, *, spatial: bool) -> list[Row]:
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

    def inertia_row(label: str, name: str) -> Row:
        path = _path(index, "inertia", name)
        about = f"Moment of inertia in {label.split()[0].lower()} about its own centre of mass (I_{name})."
        return Row(
            label, "number", lambda design: at(design, *path),
            lambda _, value: [{"op": "replace", "path": pointer_to(*path), "value": value}], hint=about, unit=KG_CM2,
        )  # fmt: skip

    volume_row = field_row("Volume", _path(index, "volume"), Rigid, unit=CM3)
    if not spatial:
        return [
            volume_row, center_row("Centre of mass x", 0), center_row("Centre of mass z", 2),
            inertia_row("Pitch inertia", "yy"),
        ]  # fmt: skip
    centers = [center_row(f"Centre of mass {name}", i) for i, name in enumerate("xyz")]
    inertias = [inertia_row(f"{name} inertia", axis) for name, axis in (("Roll", "xx"), ("Pitch", "yy"), ("Yaw", "zz"))]
    return [volume_row, *centers, *inertias]


def _extension_rows(component: Component) -> list[Row]:
    name = component.name

    def write(_: Design, value: float) -> Patch:
        return [{"op": "add", "path": pointer_to("mission", "initial", "extensions", name), "value": value}]

    def stops(design: Design) -> tuple[float, float]:
        return next(c.stroke for _, c in design.vehicle.actuated if c.name == name)

    label = "Angle at start" if isinstance(component, RollingMass) else "Extension at start"
    rows = [
        Row(
            label, "slider", lambda design: initial_extensions(design)[name], write,
            hint=hint_for(Initial, "extensions"), unit=unit_of(component), span=stops, step=0.1,
        )
    ]  # fmt: skip
    if not isinstance(component, Mover):

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


def _rolling_rows(index: int) -> list[Row]:
    return [
        field_row("Angle from", _path(index, "angle_range", 0), RollingMass, unit=DEGREE),
        field_row("Angle to", _path(index, "angle_range", 1), RollingMass, unit=DEGREE),
        field_row("Neutral", _path(index, "neutral_angle"), RollingMass, unit=DEGREE),
        *(
            field_row(f"Pivot {name}", _path(index, "pivot", i), RollingMass, unit=MM, remark=f"Here {name}.")
            for i, name in enumerate("xyz")
        ),
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


def _actuator_rows(component: Actuated, index: int, *, spatial: bool) -> list[Row]:
    kind, axis = type(component), component.axis
    rolls = isinstance(component, RollingMass)
    rate = DEGREE_PER_S if rolls else MM_PER_S
    choices = AXES if any(axis == choice for _, choice in AXES) else (*AXES, ("oblique", axis))
    label = "Turns about" if rolls else "Slides" if isinstance(component, Mover) else "Grows"
    rows = [
        field_row("Rate limit", _path(index, "rate_limit"), kind, unit=rate, none=0.0, remark="0: no limit."),
        field_row("Lag", _path(index, "lag"), kind, unit=SECOND, step=0.1),
        field_row(label, _path(index, "axis"), kind, widget="choice", choices=choices),
    ]
    if spatial:  # the planar model keeps no account of the battery
        rows += [
            field_row("Efficiency", _path(index, "efficiency"), kind, unit=PERCENT),
            field_row("Recovery", _path(index, "recovery"), kind, unit=PERCENT),
        ]
    return rows
