"""Owns the runs that docs/control.md tells of, and what is computed from them.

The missions are the presets of models/presets/quad_control.py, or those with one thing changed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.design import parse_design
from models.energy import energy_bill
from models.presets import load_preset
from models.presets.quad_control import DEADBAND, SLOPE, SLOW, cascade, controlled_glider, controlled_mission
from models.presets.quad_glider import movable_mass_twin
from models.run import Run
from models.simulate import simulate

Array = NDArray[np.float64]
HOUR = 3600.0
SETTLED = math.radians(2.0)
"""A heading within this of what is wanted counts as held, rad."""
LESS_MOMENT = 1.2
"""A limit of the pitch loop that is tried instead of the preset's, N m."""
S_TURN: dict[str, Any] = {
    "kind": "waypoints", "points": [[50.0, 0.0], [90.0, -50.0], [400.0, 200.0]], "radius": 12.0, "repeat": False,
}  # fmt: skip
"""Straight at one place after the other: first to port, then to starboard."""


class Held(NamedTuple):
    """How a heading was held across a current: errors (rad), time until held (s), tracks over ground (rad), drift."""

    settled: float
    rms: float
    largest: float
    track: float
    expected: float


def flown(controller: dict[str, Any], duration: float, *, twin: bool = False, interval: float = 2.0,
          initial: Mapping[str, Any] | None = None, **mission: Any) -> Run:  # fmt: skip
    """Fly the quad glider, or its twin, under a controller."""
    document = movable_mass_twin() if twin else controlled_glider("heading")
    document["mission"] = controlled_mission(controller, duration=duration, **mission)
    document["mission"]["solver"]["output_interval"] = interval
    document["mission"]["initial"] |= initial or {}
    return simulate(parse_design(document))


@cache
def preset_run(name: str) -> Run:
    """Return the run of a preset of the quad glider."""
    return simulate(load_preset(f"quad-bellows-{name}"))


@cache
def s_turn() -> Run:
    """Return the S-turn in one slow dive."""
    return flown(cascade(S_TURN, SLOW), 930.0, interval=1.0)


def per_km(run: Run) -> float:
    """Return the energy per kilometre over ground, J/km."""
    bill = energy_bill(run)
    assert bill is not None and bill.whole.per_km is not None
    return bill.whole.per_km


def moves(run: Run) -> float:
    """Return how often an hour any cell was given a new command."""
    commands = run.cell_values["command"]
    return float(np.any(np.diff(commands, axis=0) != 0.0, axis=1).sum()) * HOUR / float(run.times[-1])


def turned(angle: Array | float) -> Array:
    """Return angles within -pi to pi."""
    return np.asarray((np.asarray(angle) + math.pi) % (2.0 * math.pi) - math.pi)


def track(run: Run, begin: float) -> tuple[float, float]:
    """Return the direction over ground (rad) and the speed (m/s) from a time to the end."""
    k = int(np.searchsorted(run.times, begin))
    north, east = (float(run.values[n][-1] - run.values[n][k]) for n in "xy")
    return math.atan2(east, north), math.hypot(north, east) / float(run.times[-1] - run.times[k])


def since(run: Run, kind: str) -> float:
    """Return when the first phase of a kind began, s."""
    return next(event.time for event in run.events if event.kind == kind)


@cache
def held() -> Held:
    """Return how the preset held its heading, and its track beside the current triangle with still water's speed."""
    run = preset_run("heading")
    mission = run.design.mission
    wanted = float(run.values["heading_target"][-1])
    error = turned(run.values["psi"] - wanted)
    settled = float(run.times[np.flatnonzero(np.abs(error) > SETTLED)[-1]])
    begin = since(run, "dive")
    late = run.times >= begin
    still = flown(cascade({"kind": "heading", "heading": wanted}), mission.duration)
    _, speed = track(still, begin)
    north, east = mission.environment.current.velocity
    expected = math.atan2(speed * math.sin(wanted) + east, speed * math.cos(wanted) + north)
    rms = float(np.sqrt(np.mean(error[late] ** 2)))
    return Held(settled, rms, float(np.abs(error[late]).max()), track(run, begin)[0], expected)


def across_track(run: Run) -> Array:
    """Return the distance to starboard of the leg in force over time, m."""
    guidance = run.design.mission.control.controller.lateral.guidance
    points = np.array(guidance.points)
    start = np.array([run.values["x"][0], run.values["y"][0]])
    leg = run.values["leg"].astype(int)
    flight = np.cumsum(np.concatenate([[0], np.diff(leg) != 0]))
    begins = np.where(flight[:, None] == 0, start, points[leg - 1])
    way = points[leg] - begins
    course = np.arctan2(way[:, 1], way[:, 0])
    off = np.column_stack([run.values["x"], run.values["y"]]) - begins
    return np.asarray(np.cos(course) * off[:, 1] - np.sin(course) * off[:, 0])


class Leg(NamedTuple):
    """One leg: until when (s), largest distance from its line, and that over its last quarter (m)."""

    end: float
    largest: float
    late: float


def legs(run: Run) -> list[Leg]:
    """Return what happened on every leg that was ended by its waypoint."""
    ends = [0.0, *(event.time for event in run.events if event.kind == "waypoint")]
    off, found = np.abs(across_track(run)), []
    for begin, end in pairwise(ends):
        inside = (run.times > begin) & (run.times < end)
        last = inside & (run.times > end - 0.25 * (end - begin))
        found.append(Leg(end, float(off[inside].max()), float(off[last].max())))
    return found


@cache
def without_integral() -> tuple[float, float]:
    """Return where a long dive along a line settles across the waypoints' current without the integral, and Delta tan.

    m to starboard; the line of sight alone leans by atan(e / Delta), and must lean by asin(current / speed).
    """
    guidance = preset_run("waypoints").design.mission.control.controller.lateral.guidance
    current = preset_run("waypoints").design.mission.environment.current.velocity
    line = {"kind": "waypoints", "points": [[9e3, 0.0]], "radius": 30.0, "lookahead": guidance.lookahead}
    run = flown(cascade(line), 2.0 * HOUR, current=current)
    begin = since(run, "dive")
    late = run.times > begin + HOUR
    speed = float(np.hypot(run.values["x_dot"] - current[0], run.values["y_dot"] - current[1])[late].mean())
    return float(run.values["y"][late].mean()), guidance.lookahead * math.tan(math.asin(current[1] / speed))


class Kept(NamedTuple):
    """How a station was kept: radius, largest distance, bound (m), share of the time in the spiral, turn radius."""

    radius: float
    largest: float
    bound: float
    spiral: float
    turn: float


@cache
def kept() -> Kept:
    """Return how the station was kept; the bound adds two turn radii and the drift in half a turn to the radius."""
    run = preset_run("station")
    guidance = run.design.mission.control.controller.lateral.guidance
    current = math.hypot(*run.design.mission.environment.current.velocity)
    v = run.values
    spiral = np.isfinite(v["roll_target"]) & np.isnan(v["heading_target"])
    rate = float(np.median(np.abs(v["turn_rate"][spiral])))
    through = np.hypot(v["x_dot"] - v["current_x"], v["y_dot"] - v["current_y"])
    turn = float(np.median(through[spiral])) / rate
    bound = guidance.radius + 2.0 * turn + current * math.pi / rate
    return Kept(guidance.radius, float(np.hypot(v["x"], v["y"]).max()), bound, float(spiral.mean()), turn)


class Slide(NamedTuple):
    """Time that a turn slides backwards (s), and the largest error of heading (rad) from the second dive on."""

    backwards: float
    error: float


def slide(run: Run, wanted: float) -> Slide:
    """Return how a yo-yo on a heading slides backwards at its turns."""
    late = run.times >= since(run, "dive")
    turns = sum(event.kind in ("dive", "climb") and event.time >= since(run, "dive") for event in run.events)
    v = run.values
    ahead = np.cos(v["psi"]) * (v["x_dot"] - v["current_x"]) + np.sin(v["psi"]) * (v["y_dot"] - v["current_y"])
    seconds = float(np.sum(ahead[late] < 0.0)) * float(run.times[1] - run.times[0])
    return Slide(seconds / turns, float(np.abs(turned(v["psi"][late] - wanted)).max()))


@cache
def slides() -> tuple[Slide, Slide]:
    """Return the slides of the preset that holds a heading, and with less pitch moment allowed."""
    run = preset_run("heading")
    mission, wanted = run.design.mission, float(run.values["heading_target"][-1])
    controller = cascade({"kind": "heading", "heading": wanted})
    controller["pitch"] |= {"loop": SLOPE | {"limit": LESS_MOMENT}}
    current = mission.environment.current.velocity
    other = flown(controller, mission.duration, current=current)
    return slide(run, wanted), slide(other, wanted)


class Integrated(NamedTuple):
    """Pitch (rad) in the second half of each dive with an integral in the loop, and without; and what is wanted."""

    target: float
    integral: float
    with_it: list[float]
    without: list[float]


@cache
def integrated() -> Integrated:
    """Return what a slow integral makes of the pitch of dive after dive."""
    gain = 0.003
    loops = (SLOPE | {"integral": gain}, SLOPE)
    found = []
    for loop in loops:
        controller = cascade({"kind": "heading", "heading": 0.0})
        controller["pitch"] |= {"loop": loop | {"limit": 1.5}}
        run = flown(controller, 1.5 * HOUR)
        turns = [0.0, *(e.time for e in run.events if e.kind in ("dive", "climb"))]
        dives = list(zip(turns[::2], turns[1::2], strict=False))
        found.append([
            float(run.values["theta"][(run.times > 0.5 * (a + b)) & (run.times < b)].mean()) for a, b in dives
        ])  # fmt: skip
    return Integrated(controller["pitch"]["dive"], gain, *found)


class Peace(NamedTuple):
    """New commands an hour, energy (J/km) and rms error of heading (rad) with noise and a deadband."""

    noise: float
    deadband: float
    moves: float
    energy: float
    rms: float


@cache
def peace() -> tuple[Peace, ...]:
    """Return what noise of the attitude and the deadband do to the preset that holds a heading."""
    results = []
    for noise, deadband in ((0.0, DEADBAND), (0.005, 0.0), (0.005, DEADBAND), (0.005, 4.0 * DEADBAND)):
        controller = cascade({"kind": "heading", "heading": 0.8}, deadband=deadband,
                             noise={"attitude": noise, "depth": 10.0 * noise, "seed": 1})  # fmt: skip
        run = flown(controller, HOUR)
        late = run.times > since(run, "dive")
        rms = float(np.sqrt(np.mean((run.values["psi"][late] - 0.8) ** 2)))
        results.append(Peace(noise, deadband, moves(run), per_km(run), rms))
    return tuple(results)
