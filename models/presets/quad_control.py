"""Owns the missions of the quad-bellows lake glider under control: heading across a current, waypoints, a station.

The gains are ours. Pitch: the moments of the open-loop missions, and a gain on what is left. Bank: a gain on its error
with some damping. Heading: a gain to a bank. No loop integrates: an integral would also add up the turns from dive to
climb, in which the cells travel for a minute (docs/control.md). SI units, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from models.presets.quad_glider import (
    BATTERY,
    CELLS,
    HULL_NOTE,
    LEAD,
    QUAD_NOTE,
    Part,
    cell,
    document,
    environment,
    structure,
    trimmed,
)
from models.presets.words import prose

SAMPLE_TIME, DEADBAND = 2.0, 0.005
"""Time between samples, s; share of a stroke by which a command must change."""
TOP, BOTTOM = 10.0, 90.0
"""Depths at which a dive and a climb are commanded, m: it turns some 5 m further on."""
SLOPE: Part = {"proportional": 1.0, "derivative": 4.0, "limit": 2.5}
BANK: Part = {"proportional": 2.0, "derivative": 20.0, "limit": 0.8}
TURN: Part = {"proportional": 1.0, "derivative": 6.0, "limit": 0.35}
"""Loops from pitch and bank to moments, and from heading to bank."""


@dataclass(frozen=True)
class Drive:
    """How hard it dives and climbs: net buoyancy either way (N), pitch on dives and climbs (rad), moment (N m)."""

    heave: float
    dive: float
    climb: float
    moment: float


FAST, SLOW = Drive(4.7, -0.53, 0.57, 0.79), Drive(2.35, -0.44, 0.46, 0.57)
"""The changes of buoyancy of the open-loop yo-yo and of the open-loop spiral, with their pitch and their moments."""


@dataclass(frozen=True)
class Task:
    """One mission under control: title, lateral guidance, drive, current (m/s), heading at the start, duration (s)."""

    title: str
    guidance: Part
    drive: Drive
    current: tuple[float, float]
    yaw: float
    duration: float
    shows: str


TASKS = {
    "heading": Task("heading across a current", {"kind": "heading", "heading": 0.8},
                    FAST, (-0.07, 0.07), 0.0, 3600.0, """
        A yo-yo between 10 m and 90 m that turns from north to a heading of 46 deg and holds it, while a current of
        0.1 m/s carries it to the right."""),
    "waypoints": Task("waypoints in a current", {
        "kind": "waypoints", "points": [[800.0, 0.0], [800.0, 600.0], [0.0, 0.0]], "radius": 30.0, "lookahead": 100.0,
        "integral": 0.2, "repeat": True,
    }, FAST, (0.0, 0.06), 0.0, 9600.0, """
        A yo-yo around a triangle of 2.4 km by integral line of sight, which leans into a current of 0.06 m/s to the
        east. Place is taken as known under water."""),
    "station": Task("station keeping", {"kind": "station", "center": [0.0, 0.0], "radius": 80.0, "bank": 0.35},
                    SLOW, (0.0, 0.05), 0.0, 7200.0, """
        It spirals near a place; when the current of 0.05 m/s has carried it 80 m away, it heads back until it is within
        40 m. Place is taken as known under water."""),
}  # fmt: skip


def cascade(guidance: Part | None, drive: Drive = FAST, **changes: Any) -> Part:
    """Return the controller of a yo-yo; `changes` replace its fields."""
    controller: Part = {
        "kind": "cascade", "sample_time": SAMPLE_TIME, "deadband": DEADBAND,
        "vertical": {
            "kind": "depth_band", "top": TOP, "bottom": BOTTOM, "dive_heave": -drive.heave, "climb_heave": drive.heave,
        },
        "pitch": {
            "dive": drive.dive, "climb": drive.climb, "dive_moment": -drive.moment, "climb_moment": drive.moment,
            "loop": SLOPE,
        },
    }  # fmt: skip
    if guidance is not None:
        controller["lateral"] = {"guidance": guidance, "roll_loop": BANK, "heading_loop": TURN}
    return controller | changes


def controlled_mission(
    controller: Part, *, duration: float, current: tuple[float, float] = (0.0, 0.0), yaw: float = 0.0
) -> Part:
    """Return a mission under control that begins level and at rest at 2 m, every cell at neutral."""
    moving = {"current": {"kind": "uniform", "velocity": list(current)}} if any(current) else {}
    return {
        "environment": environment() | moving, "initial": {"position": [0.0, 0.0, 2.0], "yaw": yaw},
        "control": {"controller": controller}, "duration": duration,
        "solver": {"model": "spatial", "tolerance": 1e-8, "output_interval": 2.0},
    }  # fmt: skip


def controlled_glider(name: str) -> Part:
    """Return the glider with four cells on one of `TASKS`."""
    task = TASKS[name]
    parts = trimmed([*structure(), *map(cell, CELLS), {"kind": "rigid", **BATTERY}, {"kind": "rigid", **LEAD}])
    mission = controlled_mission(
        cascade(task.guidance, task.drive), duration=task.duration, current=task.current, yaw=task.yaw
    )
    title = f"Quad-bellows lake glider, {task.title}"
    return document(title, prose(f"{task.shows} {QUAD_NOTE} {HULL_NOTE}"), parts, mission)
