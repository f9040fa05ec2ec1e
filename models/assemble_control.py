"""Owns the kernel's records of closed-loop control: made from a description, and empty without one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.allocation import Effectiveness, effectiveness
from models.controllers import (
    MEASURED,
    Cascade,
    Controller,
    DepthBand,
    HoldHeading,
    HoldHeave,
    HoldRoll,
    Lateral,
    StateFeedback,
    Station,
    Waypoints,
)
from models.design import Design
from models.kernel import control_layout as layout
from models.kernel.allocate import COLUMNS
from models.kernel.control_layout import CONTROL
from models.problems import DesignError, Problem, pointer_to

Array = NDArray[np.float64]
AT = "/mission/control/controller"
LATERAL_CODES = {
    "roll": layout.HOLD_ROLL, "heading": layout.HOLD_HEADING, "waypoints": layout.WAYPOINTS, "station": layout.STATION,
}  # fmt: skip
LATERAL_STATES = ("phi", "psi", "v", "p", "r")
"""States that a planar glider does not have."""


def control_records(design: Design) -> dict[str, Any]:
    """Return the fields of `Params` that a controller reads; designs without one share them."""
    controller = design.mission.control.controller
    if controller is None:
        return WITHOUT
    cells = controlled_cells(design, controller)
    arrays, values = dict(WITHOUT), UNSCALED | _sampling(controller)
    match controller:
        case Cascade():
            arrays["cells"], scales = _rows(cells, controller)
            values |= dict(zip(UNSCALED, scales.tolist(), strict=True))
            values |= _loops(controller)
            if controller.lateral is not None and isinstance(controller.lateral.guidance, Waypoints):
                arrays["waypoints"] = np.array(controller.lateral.guidance.points)
        case StateFeedback():
            arrays["cells"], _ = cells.rows()
            values |= {"kind": layout.FEEDBACK, "integrals": controller.integrals}
            arrays |= _table(design, controller)
    return arrays | {"control": _record(values)}


def _record(values: dict[str, float]) -> NDArray[np.void]:
    record = np.zeros(1, dtype=CONTROL)
    for name, value in values.items():
        record[name] = value
    return record


UNSCALED: dict[str, float] = {"heave_scale": 1.0, "pitch_scale": 1.0, "roll_scale": 1.0}
WITHOUT: dict[str, Any] = {
    "cells": np.zeros((0, COLUMNS)), "waypoints": np.zeros((0, 2)), "gains": np.zeros((1, 1)),
    "setpoints": np.zeros((1, 2)), "chosen": np.zeros(0, dtype=np.int64), "control": _record(UNSCALED),
}  # fmt: skip
"""The fields without a controller."""


def controlled_cells(design: Design, controller: Controller) -> Effectiveness:
    """Return what the cells under control do; raises `DesignError` where one is unknown."""
    if isinstance(controller, Cascade):
        at = f"{AT}/allocation/cells"
        return effectiveness(design, controller.allocation.cells, pointer=at)
    return effectiveness(design, controller.cells, pointer=f"{AT}/cells")


def control_problems(design: Design) -> Iterator[Problem]:
    """Yield what is wrong with a controller beyond its fields' limits."""
    controller = design.mission.control.controller
    if controller is None:
        return
    most = layout.MOST_PENDING - 1
    if controller.delay > most * controller.sample_time:
        yield Problem(
            f"{AT}/delay", f"delay {controller.delay:g} s is more than {most} samples of {controller.sample_time:g} s",
            limit=most * controller.sample_time, hint="shorten it, or sample less often",
        )  # fmt: skip
    try:
        cells = controlled_cells(design, controller).cells
    except DesignError as error:
        yield from error.problems
        return
    for i, schedule in enumerate(design.mission.control.schedules):
        if schedule.cell in cells:
            yield Problem(
                pointer_to("mission", "control", "schedules", i, "cell"),
                f"'{schedule.cell}' has a schedule and is under control",
                hint="remove the schedule, or name the controller's cells without it",
            )
    yield from _out_of_plane(design, controller)
    if isinstance(controller, Cascade):
        unknown = next((name for name in controller.allocation.effort if name not in cells), None)
        if unknown is not None:
            yield Problem(
                f"{AT}/allocation/effort{pointer_to(unknown)}", f"'{unknown}' is not under control",
                hint=f"those are: {', '.join(cells)}",
            )  # fmt: skip
    else:
        yield from _beyond_table(design, controller)
        moving = [part.name for _, part in design.vehicle.actuated]
        for k, name in enumerate(controller.states):
            if name not in MEASURED and name not in moving:
                yield Problem(
                    f"{AT}/states/{k}", f"there is no state '{name}'",
                    hint=f"use {', '.join(MEASURED)}, or the name of a component that moves",
                )  # fmt: skip


def _beyond_table(design: Design, controller: StateFeedback) -> Iterator[Problem]:
    """Yield extensions of the table beyond the stops, and set points beyond the table."""
    cells = controlled_cells(design, controller)
    for k, point in enumerate(controller.points):
        for i, (name, e) in enumerate(zip(cells.cells, point.extensions, strict=True)):
            slack = 1e-9 * cells.span[i]
            if not cells.low[i] - slack <= e <= cells.high[i] + slack:
                yield Problem(
                    f"{AT}/points/{k}/extensions/{i}",
                    f"extension {e:g} of '{name}' lies outside its stops [{cells.low[i]:g}, {cells.high[i]:g}]",
                    limit=float(cells.low[i] if e < cells.low[i] else cells.high[i]), hint="stay within the stops",
                )  # fmt: skip
    low, high = controller.points[0].value, controller.points[-1].value
    for k, asked in enumerate(controller.set_points):
        if not low <= asked.value <= high:
            yield Problem(
                f"{AT}/set_points/{k}/value", f"set point {asked.value:g} is outside the table, {low:g} to {high:g}",
                limit=low if asked.value < low else high, hint="add a point to the table, or stay within it",
            )  # fmt: skip


def _out_of_plane(design: Design, controller: Controller) -> Iterator[Problem]:
    if design.mission.solver.model != "planar":
        return
    hint = "use the spatial model (/mission/solver/model), or leave it out"
    if isinstance(controller, Cascade):
        if controller.lateral is not None:
            yield Problem(f"{AT}/lateral", "the planar model has no bank and no heading", hint=hint)
        return
    for k, name in enumerate(controller.states):
        if name in LATERAL_STATES:
            yield Problem(f"{AT}/states/{k}", f"the planar model has no state '{name}'", hint=hint)


def _sampling(controller: Controller) -> dict[str, float]:
    noise = controller.noise
    return {
        "sample_time": controller.sample_time, "delay": controller.delay, "deadband": controller.deadband,
        "noise_depth": noise.depth, "noise_attitude": noise.attitude, "noise_velocity": noise.velocity,
        "noise_rate": noise.rate, "noise_place": noise.place, "seed": noise.seed,
    }  # fmt: skip


def _rows(cells: Effectiveness, controller: Cascade) -> tuple[Array, Array]:
    weights, rule = controller.allocation.weights, controller.allocation
    return cells.rows((weights.heave, weights.pitch, weights.roll), effort=rule.effort)


def _loops(controller: Cascade) -> dict[str, float]:
    pitch = controller.pitch
    held = pitch.dive is not None
    dive = pitch.dive if pitch.dive is not None else math.nan
    climb = -dive if pitch.climb is None else pitch.climb
    moment = 0.0 if pitch.climb_moment is None else pitch.climb_moment
    if isinstance(controller.vertical, HoldHeave):
        # what is said of dives holds all the time, unless climbs have their own
        climb = dive if pitch.climb is None else pitch.climb
        moment = pitch.dive_moment if pitch.climb_moment is None else pitch.climb_moment
    return {
        # within a sample no more can be given back than there is
        "kind": layout.CASCADE, "unwind": 1.0 / max(controller.unwind_time, controller.sample_time),
        "holds_pitch": held, "dive_pitch": dive, "climb_pitch": climb,
        "dive_moment": pitch.dive_moment, "climb_moment": moment,
        "pitch_p": pitch.loop.proportional, "pitch_i": pitch.loop.integral, "pitch_d": pitch.loop.derivative,
        "pitch_limit": pitch.loop.limit,
    } | _vertical(controller.vertical) | _lateral(controller.lateral)  # fmt: skip


def _vertical(vertical: HoldHeave | DepthBand) -> dict[str, float]:
    if isinstance(vertical, HoldHeave):
        return {
            "vertical": layout.HOLD_HEAVE, "dive_heave": vertical.heave, "climb_heave": vertical.heave,
            "starts_climbing": vertical.heave > 0.0,
        }  # fmt: skip
    return {
        "vertical": layout.DEPTH_BAND, "top": vertical.top, "bottom": vertical.bottom,
        "dive_heave": vertical.dive_heave, "climb_heave": vertical.climb_heave,
        "starts_climbing": vertical.first == "climb",
    }  # fmt: skip


def _lateral(lateral: Lateral | None) -> dict[str, float]:
    if lateral is None:
        return {"lateral": layout.NO_LATERAL}
    values: dict[str, float] = {
        "lateral": LATERAL_CODES[lateral.guidance.kind],
        "climb_bank_sign": -1.0 if lateral.climb_bank == "opposite" else 1.0,
        "roll_p": lateral.roll_loop.proportional, "roll_i": lateral.roll_loop.integral,
        "roll_d": lateral.roll_loop.derivative, "roll_limit": lateral.roll_loop.limit,
        "heading_p": lateral.heading_loop.proportional, "heading_i": lateral.heading_loop.integral,
        "heading_d": lateral.heading_loop.derivative, "bank_limit": lateral.heading_loop.limit,
    }  # fmt: skip
    match lateral.guidance:
        case HoldRoll() as guidance:
            values["lateral_target"] = guidance.roll
        case HoldHeading() as guidance:
            values["lateral_target"] = guidance.heading
        case Waypoints() as guidance:
            values |= {
                "arrival": guidance.radius, "lookahead": guidance.lookahead or 0.0,
                "path_integral": guidance.integral, "repeats": guidance.repeat,
            }  # fmt: skip
        case Station() as guidance:
            values |= {
                "center_x": guidance.center[0], "center_y": guidance.center[1], "station_radius": guidance.radius,
                "station_bank": guidance.bank,
            }  # fmt: skip
    return values


def _table(design: Design, controller: StateFeedback) -> dict[str, Any]:
    """Return the table of gains, the set points, and which states are fed back."""
    moving = [part.name for _, part in design.vehicle.actuated]
    asked = controller.set_points
    return {
        "gains": np.array(
            [[p.value, *p.extensions, *p.state, *(k for row in p.gains for k in row)] for p in controller.points]
        ),
        "setpoints": np.array([[s.time, s.value] for s in asked] or [[0.0, controller.points[0].value]]),
        "chosen": np.array(
            [
                MEASURED.index(name) if name in MEASURED else layout.MEASURED + moving.index(name)
                for name in controller.states
            ],
            dtype=np.int64,
        ),
    }
