"""Owns the rows of the mission: the water, the start, the length, and how the equations are integrated."""

from __future__ import annotations

import math
from typing import Any

from models.design import Design, Vehicle
from models.environment import Environment, UniformCurrent, UniformWater
from models.mission import Initial, Mission, Solver
from models.water import density_at, gravity_of, profile_range
from studio.changes import Patch
from studio.panel.rows import (
    CM_PER_S,
    DEGREE,
    DENSITY,
    GRAVITY,
    METRE,
    MILLISECOND,
    SECOND,
    WATT,
    Row,
    field_row,
    hint_for,
    is_spatial,
    note,
)

TOLERANCES = tuple(10.0**-k for k in range(3, 13))
ROOT = ("mission", "environment")
INITIAL = ("mission", "initial")
RIGHT_ANGLE = math.pi / 2.0
OTHER_WATER = (
    "Profiles of temperature and salinity, of density and of currents come in by 'glider-studio attach' or in the JSON."
)


def water_rows(design: Design) -> list[Row]:
    """Return the water, its current, gravity, surface and bed."""
    uniform = isinstance(design.mission.environment.water, UniformWater)
    rows = [
        field_row("Density", (*ROOT, "water", "density"), UniformWater, unit=DENSITY)
        if uniform
        else note(profile_in_words),
        Row(
            "Gravity", "number", lambda d: gravity_of(d.mission.environment),
            lambda _, value: [{"op": "replace", "path": "/mission/environment/gravity", "value": value}],
            hint=hint_for(Environment, "gravity"), unit=GRAVITY, step=0.01,
        ),
        field_row("Bed depth", (*ROOT, "bed_depth"), Environment, unit=METRE, none=0.0, step=0.5, remark="0: no bed."),
    ]  # fmt: skip
    if is_spatial(design):
        bed = (("ends the run", "end"), ("it slides on it", "slide"))
        surface = (("ends the run", "end"), ("it floats there", "float"))
        rows += [
            field_row("Bed contact", (*ROOT, "bed_contact"), Environment, widget="choice", choices=bed),
            field_row("Surface", (*ROOT, "surface"), Environment, widget="choice", choices=surface),
            *_current_rows(design),
        ]
    return [*rows, note(lambda _: OTHER_WATER)]


def profile_in_words(design: Design) -> str:
    """Return what water that changes with depth is, in a sentence."""
    water = design.mission.environment.water
    depths = profile_range(water)
    if depths is None:
        return ""
    what = "TEOS-10 from temperature and salinity" if water.kind == "teos10" else "Density profile"
    low, high = (density_at(water, depth) for depth in depths)
    source = getattr(water, "source", "")
    levels = len(getattr(water, "depths", ()))
    return (
        f"{what}: {levels} levels from {depths[0]:g} to {depths[1]:g} m, {low:.2f} to {high:.2f} kg/m³. {source}"
    ).strip()


def _current_rows(design: Design) -> list[Row]:
    current = design.mission.environment.current
    kinds = [("none", None), ("uniform", "uniform")]
    if current is not None and current.kind != "uniform":
        kinds.append((current.kind, current.kind))
    choice = Row(
        "Current", "choice", lambda d: getattr(d.mission.environment.current, "kind", None), _switch_current,
        hint=hint_for(Environment, "current"), choices=tuple(kinds),
    )  # fmt: skip
    if isinstance(current, UniformCurrent):
        root = (*ROOT, "current", "velocity")
        return [
            choice,
            field_row("Current north", (*root, 0), UniformCurrent, unit=CM_PER_S),
            field_row("Current east", (*root, 1), UniformCurrent, unit=CM_PER_S),
        ]
    return [choice] if current is None else [choice, note(_current_in_words)]


def _current_in_words(design: Design) -> str:
    current = design.mission.environment.current
    if current is None or current.kind == "uniform":
        return ""
    if current.kind == "sheared":
        (north, east), (dn, de) = current.surface_velocity, current.shear
        return f"At the surface {north:g} m/s north, {east:g} m/s east; by {dn:g} and {de:g} m/s more a metre down."
    return f"Table of {len(current.depths)} depths and {len(current.times)} times. {current.source}".strip()


def _switch_current(design: Design, kind: Any) -> Patch:
    current = design.mission.environment.current
    if kind == getattr(current, "kind", None):
        return []
    value = None if kind is None else {"kind": "uniform", "velocity": [0.0, 0.0]}
    return [{"op": "replace", "path": "/mission/environment/current", "value": value}]


def mission_rows(design: Design) -> list[Row]:
    """Return the start and the length of the mission."""
    rows = [
        field_row("Duration", ("mission", "duration"), Mission, unit=SECOND),
        field_row("Start depth", (*INITIAL, "position", 2), Initial, unit=METRE, step=0.1),
        _angle_row("Initial pitch", "pitch", RIGHT_ANGLE),
    ]
    if is_spatial(design):
        rows += [
            _angle_row("Initial roll", "roll", math.pi),
            _angle_row("Initial yaw", "yaw", math.pi),
            field_row("Hotel load", ("vehicle", "hotel_power"), Vehicle, unit=WATT, step=0.1),
        ]
    return rows


def _angle_row(label: str, name: str, most: float) -> Row:
    path = (*INITIAL, name)
    return field_row(label, path, Initial, widget="slider", unit=DEGREE, span=lambda _: (-most, most))


def solver_rows(design: Design) -> list[Row]:
    """Return which equations are integrated, and how."""
    root = ("mission", "solver")
    solver = design.mission.solver
    models = (("planar", "planar"), ("spatial", "spatial"))
    methods = (("adaptive 5(4)", "adaptive"), ("Runge-Kutta 4", "rk4"))
    rows = [
        field_row("Model", (*root, "model"), Solver, widget="choice", choices=models),
        field_row("Method", (*root, "method"), Solver, widget="choice", choices=methods),
    ]
    if solver.method == "adaptive":
        known = sorted({*TOLERANCES, solver.tolerance}, reverse=True)
        tolerances = tuple((f"{v:.6g}", v) for v in known)
        rows.append(field_row("Tolerance", (*root, "tolerance"), Solver, widget="choice", choices=tolerances))
    else:
        rows.append(field_row("Step", (*root, "step"), Solver, unit=MILLISECOND))
    rows.append(field_row("Output interval", (*root, "output_interval"), Solver, unit=SECOND, step=0.01))
    return rows
