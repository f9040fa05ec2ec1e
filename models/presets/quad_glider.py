"""Owns the quad-bellows lake glider that Canete et al. propose, and its twin with movable masses; the sizes are ours.

The hull, wing and forces are the stand-in of the paper's glider scaled by `SCALE`; fin and core sampler are added by
`strip_theory`. Body axes with the origin at mid-length, SI units; changes of volume in missions in cm3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from models.components import Bellows
from models.environment import Environment
from models.presets import quad_hydrodynamics as hydrodynamics
from models.presets import strip_theory as strips
from models.presets.quad_hydrodynamics import (
    CELL_RADIUS,
    CHORD,
    DENSITY,
    FIN,
    LENGTH,
    NOSE,
    PLATE,
    RADIUS,
    RING_LENGTH,
    RING_X,
    SAMPLER,
    SPAN,
    TAIL,
    WING_X,
    tidy,
)
from models.presets.words import prose
from models.water import density_at, gravity_of

Part = dict[str, Any]

CELL_Y, STROKE, PLEATS, CELL_RATE = 0.200, 0.100, 8, 0.001
"""Of the cells: place to the side and stroke (m), pleats, fastest stroke (m/s)."""
METACENTRIC_HEIGHT = 0.004
WALL, YOUNG, POISSON = 0.0025, 69e9, 0.33
"""Hull of aluminium: wall (m), Young's modulus (Pa), Poisson's ratio."""
BULK_MODULUS = strips.tube_bulk_modulus(RADIUS, WALL, young=YOUNG, poisson=POISSON)
HULL_NOTE = """
    Every size, the lake (fresh, made up) and the timing are ours, not the authors'. Hull, wing and their forces are our
    stand-in of the paper's smaller glider with its CFD, scaled to 2.0 m at equal Reynolds number; it sails at up to
    three times the Reynolds number of that CFD, and its cells stand beside the hull where the CFD has rings around it.
    Fin, core sampler and all lateral coefficients are computed from the geometry by strip theory, and measured nowhere.
    How each number comes about: docs/quad_glider.md.
"""
QUAD_NOTE = """
    The glider that L. Canete, J. Paquibot, M. Matsumoto and T. Takahashi propose in 'Investigation of Multiple Buoyancy
    Controller Equipped Underwater Glider Robot Modeling for Control System Development and Gliding Simulation', section
    I.C, and do not describe yet: about 30 kg, for lakes of 100 m, with a core sampler outside and four bellows, front
    and rear on either side, whose differences pitch and roll it.
"""
TWIN_NOTE = """
    The quad-bellows lake glider with the means of other gliders: one buoyancy engine, a battery that slides for pitch
    and a ballast that rolls for bank. It has the hull, weight, metacentric height, changes of volume and moments of the
    quad glider's spiral, so that the two can be laid side by side. The rolling ballast also rises, so it banks a little
    more; and its ends are lighter, since no cell stands there.
"""
BORE = math.pi * 0.050**2
"""Area of the twin's piston, m2."""
LAKE_DEPTH, BED_DEPTH = 100.0, 120.0
HOTEL_POWER, EFFICIENCY = 3.0, 0.5

CELLS = {
    "Front port cell": (1.0, -1.0, "#f2b134"), "Front starboard cell": (1.0, 1.0, "#e58a6b"),
    "Rear port cell": (-1.0, -1.0, "#4fc3a1"), "Rear starboard cell": (-1.0, 1.0, "#7aa7ff"),
}  # fmt: skip
"""Name of each cell: sign of its x, sign of its y, colour."""


def environment() -> Part:
    """Return a made-up temperate lake in summer."""
    levels = {0: 20.0, 4: 19.8, 8: 19.0, 12: 15.0, 16: 11.0, 20: 8.5, 30: 6.5, 50: 5.5, 80: 5.1, 100: 5.0, 120: 5.0}
    water = {
        "kind": "teos10", "latitude": 46.45,
        "depths": [float(z) for z in levels], "temperatures": list(levels.values()),
        "source": "Made up: a temperate lake in summer, fresh, with its thermocline between 8 and 20 m. Not measured.",
    }  # fmt: skip
    return {"water": water, "surface": "float", "bed_depth": BED_DEPTH, "bed_contact": "end"}


def solid_cylinder(mass: float, radius: float, length: float) -> Part:
    """Return the inertia of a solid cylinder along x."""
    across = mass * (radius**2 / 4.0 + length**2 / 12.0)
    return {"xx": tidy(mass * radius**2 / 2.0), "yy": tidy(across), "zz": tidy(across)}


def cell(name: str) -> Part:
    """Return one of the four cells; it displaces its cylinder at neutral extension, as the stand-in's bellows do."""
    fore, side, color = CELLS[name]
    shape = {"inner_radius": tidy(2.0 * CELL_RADIUS / 3.0), "outer_radius": tidy(CELL_RADIUS), "pleats": PLEATS}
    part: Part = {
        "kind": "bellows", "name": name, "mass": 0.9, "position": [fore * RING_X, side * CELL_Y, 0.0],
        "axis": [fore, 0.0, 0.0], "fixed_volume": 0.0, "extension_range": [0.0, STROKE],
        "neutral_extension": STROKE / 2.0, "rate_limit": CELL_RATE, "lag": 0.5, "efficiency": EFFICIENCY,
        "inertia": solid_cylinder(0.9, CELL_RADIUS, RING_LENGTH), "height": tidy(2.0 * CELL_RADIUS), "color": color,
        "shapes": [{"kind": "bellows", "length": tidy(RING_LENGTH), **shape}],
        "notes": "Radii in the ratio of the stand-in's bellows, 2 to 3; sizes, rate, lag and efficiency are ours.",
        **shape,
    }  # fmt: skip
    law = Bellows.model_validate(part)
    part["fixed_volume"] = tidy(math.pi * CELL_RADIUS**2 * RING_LENGTH - law.section * law.neutral_extension)
    return part


def rigid(name: str, mass: float, volume: float, position: Sequence[float], **fields: Any) -> Part:
    """Return a rigid part; what displaces water is as stiff as the hull."""
    stiff = {"bulk_modulus": tidy(BULK_MODULUS)} if volume > 0.0 else {}
    place = [tidy(x) for x in position]
    return {"kind": "rigid", "name": name, "mass": mass, "volume": tidy(volume), "position": place, **stiff, **fields}


def hull_centroid() -> float:
    """Return where the hull's volume is centred, m forward of mid-length."""
    parts = (
        (LENGTH - NOSE - TAIL, 0.5 * (TAIL - NOSE)),
        (2.0 / 3.0 * NOSE, 0.5 * LENGTH - 5.0 / 8.0 * NOSE),
        (2.0 / 3.0 * TAIL, -0.5 * LENGTH + 5.0 / 8.0 * TAIL),
    )
    return math.fsum(v * x for v, x in parts) / math.fsum(v for v, _ in parts)


def structure() -> list[Part]:
    """Return hull, wing, fin and core sampler."""
    x, mass = hull_centroid(), 7.5
    across = mass * (RADIUS**2 / 2.0 + LENGTH**2 / 12.0)
    shell = {"xx": tidy(mass * RADIUS**2), "yy": tidy(across), "zz": tidy(across)}
    hull = {
        "kind": "hull", "length": LENGTH, "radius": tidy(RADIUS), "nose_length": NOSE, "tail_length": tidy(TAIL),
        "offset": [tidy(-x), 0.0, 0.0],
    }  # fmt: skip
    wing = {"xx": tidy(6.6 * SPAN**2 / 12), "yy": tidy(6.6 * CHORD**2 / 12), "zz": tidy(6.6 * SPAN**2 / 12)}
    plate = {"kind": "wing", "span": tidy(SPAN), "chord": tidy(CHORD), "thickness": tidy(PLATE)}
    area = FIN.area
    fin_x, fin_z = (FIN.integral(f) / area for f in (lambda c, x, z: c * x, lambda c, x, z: c * z))
    panel = {
        "kind": "fin", "span": FIN.span, "chord": FIN.chord, "tip_chord": FIN.tip_chord, "sweep": FIN.sweep,
        "thickness": FIN.thickness, "direction": [0.0, 0.0, -1.0],
        "offset": [tidy(FIN.leading_x - FIN.chord / 2 - fin_x), 0.0, tidy(FIN.root_z - fin_z)],
    }  # fmt: skip
    tube = {"kind": "cylinder", "length": SAMPLER.length, "radius": SAMPLER.diameter / 2}
    section, wing_volume = math.pi * RADIUS**2, PLATE * CHORD * (SPAN - 2.0 * RADIUS)
    soft = {"height": tidy(2.0 * RADIUS)}
    return [
        rigid("Hull", mass, section * (LENGTH - (NOSE + TAIL) / 3.0), [x, 0, 0], inertia=shell, color="#9fb3c8",
              shapes=[hull], notes="Shell of aluminium, drives and electronics.", **soft),
        rigid("Wing", 6.6, wing_volume, [WING_X, 0, 0], inertia=wing, color="#b8c4d0", shapes=[plate], **soft),
        rigid("Fin", 0.5, area * FIN.thickness, [fin_x, 0, fin_z], color="#8fa3b8", shapes=[panel], height=FIN.span),
        rigid("Core sampler", 1.6, math.pi / 4 * SAMPLER.diameter**2 * SAMPLER.length, [SAMPLER.x, 0, SAMPLER.z],
              inertia=solid_cylinder(1.6, SAMPLER.diameter / 2, SAMPLER.length), color="#c9a27a", shapes=[tube], **soft,
              notes="The paper's payload outside the hull, as a closed tube."),
    ]  # fmt: skip


BATTERY: Part = {
    "name": "Battery", "mass": 5.0, "position": [0.0, 0.0, 0.0], "inertia": solid_cylinder(5.0, 0.035, 0.40),
    "shapes": [{"kind": "cylinder", "length": 0.40, "radius": 0.035}], "color": "#d98cc4",
}  # fmt: skip
LEAD: Part = {
    "name": "Lower ballast", "mass": 4.0, "position": [0.0, 0.0, 0.035], "inertia": solid_cylinder(4.0, 0.012, 0.60),
    "shapes": [{"kind": "cylinder", "length": 0.60, "radius": 0.012}], "color": "#76828f",
}  # fmt: skip


def displaced(part: Part) -> tuple[float, float]:
    """Return a part's volume at neutral extension (m3) and how much of it a pascal takes away (m3/Pa)."""
    if part["kind"] == "bellows":
        law = Bellows.model_validate(part)
        return law.core_volume + law.section * law.neutral_extension, 0.0
    volume = part.get("volume", 0.0)
    return volume, volume / part["bulk_modulus"] if part.get("bulk_modulus") else 0.0


def floats(parts: Sequence[Part], depth: float) -> float:
    """Return the mass of water that parts displace at a depth (m) with every cell at neutral extension, kg."""
    lake = Environment.model_validate(environment())
    levels = np.linspace(0.0, depth, 401)
    density = density_at(lake.water, levels)
    pressure = gravity_of(lake) * float(np.trapezoid(density, levels))
    return float(density[-1]) * math.fsum(v - pressure * c for v, c in map(displaced, parts))


def trimmed(parts: list[Part]) -> list[Part]:
    """Return the parts with a trim ballast that sets weight and centre of mass.

    It weighs as much as it displaces at the surface and at `LAKE_DEPTH` on average, so that diving and climbing ask the
    same of the cells; its centre of mass lies `METACENTRIC_HEIGHT` below its centre of buoyancy.
    """
    volumes = np.array([displaced(part)[0] for part in parts])
    places = np.array([part["position"] for part in parts])
    masses = np.array([part["mass"] for part in parts])
    weight = 0.5 * (floats(parts, 0.0) + floats(parts, LAKE_DEPTH))
    center = volumes @ places / volumes.sum() + np.array([0.0, 0.0, METACENTRIC_HEIGHT])
    ballast = weight - masses.sum()
    place = (weight * center - masses @ places) / ballast
    shape = {"kind": "cylinder", "length": 0.10, "radius": 0.016}
    notes = "Its mass and place make the glider neutral at half the lake's change of density, and level."
    part = {
        "kind": "rigid",
        "name": "Trim ballast",
        "mass": float(f"{ballast:.9g}"),
        "position": [float(x) for x in place],
    }
    return [*parts, part | {"shapes": [shape], "color": "#59636e", "notes": notes}]


Leg = tuple[float, float, float, float]
"""Time (s); then, in cm3 a cell: change of all, shift from the front to the rear, shift from starboard to port."""
DIVE, TURN, BANK, TRAVEL = (-120.0, 32.0), (-60.0, 25.0), 80.0, 80.0
"""Changes of a fast and of a turning dive, shift that banks it (cm3 a cell); time from one leg to the next, s."""
AFLOAT, APPROACH = (120.0, 0.0), (60.0, -15.0)
"""Changes while it floats, and while it comes up to the surface slowly enough not to leap out."""
CYCLES, PERIOD, CLIMB_AT, APPROACH_AT, AFLOAT_AT = 10, 1380.0, 600.0, 1092.0, 1255.0
"""Of the yo-yo: cycles, length of one, and when in it climb, approach and floating are commanded, s."""


def cell_section() -> float:
    """Return the volume that a cell gains per stroke, m2."""
    return Bellows.model_validate(cell("Front port cell")).section


def ramps(start: float, stages: Sequence[tuple[float, float]]) -> list[Part]:
    """Return the points of a schedule that holds `start` and ramps to each value, from its time on, in `TRAVEL`."""
    points: list[Part] = []
    before = tidy(start)
    for time, value in stages:
        points.append({"time": time, "extension": before})
        points.append({"time": time + TRAVEL, "extension": tidy(value), "shape": "ramp"})
        before = tidy(value)
    return points


def cell_schedules(legs: Sequence[Leg], start: float) -> list[Part]:
    """Return a schedule for each cell: all ramp together, so that weight, pitch and bank change sign at one time."""
    schedules, per_cm3 = [], 1e-6 / cell_section()
    for name, (fore, side, _) in CELLS.items():
        changes = [(t, mean - fore * pitch - side * bank) for t, mean, pitch, bank in legs]
        stages = [(t, STROKE / 2.0 + per_cm3 * change) for t, change in changes]
        schedules.append({"cell": name, "points": ramps(STROKE / 2.0 + per_cm3 * start, stages)})
    return schedules


def yo_yo_legs() -> tuple[Leg, ...]:
    """Return dive, climb, approach and float of every cycle."""
    climb = (-DIVE[0], -DIVE[1])
    cycle = ((0.0, *DIVE), (CLIMB_AT, *climb), (APPROACH_AT, *APPROACH), (AFLOAT_AT, *AFLOAT))
    return tuple((k * PERIOD + t, mean, pitch, 0.0) for k in range(CYCLES) for t, mean, pitch in cycle)


@dataclass(frozen=True)
class Flight:
    """One mission: title, legs, duration and output interval (s), and what it shows (the figures are of the run).

    It begins level and at rest at `depth` (m), each cell changed by `start` (cm3).
    """

    title: str
    legs: tuple[Leg, ...]
    duration: float
    interval: float
    shows: str
    depth: float = 2.0
    start: float = 0.0


MISSIONS = {
    "glide": Flight("straight glide", ((0.0, *DIVE, 0.0), (330.0, -DIVE[0], -DIVE[1], 0.0)), 600.0, 0.2, """
        It dives straight at a pitch of -30 deg and 0.34 m/s (0.18 m/s down), turns at 56 m and
        climbs at a pitch of 33 deg."""),
    "spiral": Flight("spiral", ((0.0, *TURN, 0.0), (120.0, *TURN, BANK)), 960.0, 0.2, """
        After two minutes of straight dive the starboard cells give volume to the port cells: it banks by 15 deg and
        spirals down to starboard with a radius of 19 m, one turn and a fifth."""),
    "s-turn": Flight("S-turn", ((0.0, *TURN, 0.0), (120.0, *TURN, -BANK), (400.0, *TURN, BANK)), 760.0, 0.2, """
        In one dive it banks by 15 deg to port and turns left, then to starboard and turns back."""),
    "yo-yo": Flight("ten-cycle yo-yo to 100 m", yo_yo_legs(), CYCLES * PERIOD, 1.0, """
        Ten times it dives from the surface to 100 m, climbs, slows below the surface, and floats for three minutes, by
        the clock alone: 3.8 hours, 3.2 km.""", depth=0.1, start=AFLOAT[0]),
}  # fmt: skip


def document(name: str, notes: str, parts: list[Part], mission: Part) -> Part:
    """Return a design document of the glider with the given parts."""
    return {
        "format": "glider-design", "version": 1, "name": name, "notes": notes,
        "vehicle": {
            "components": parts, "mass_properties": {"kind": "composite"}, "hydrodynamics": hydrodynamics.polar(),
            "added_mass": hydrodynamics.added_mass(), "damping": hydrodynamics.damping(), "hotel_power": HOTEL_POWER,
        },
        "mission": {"environment": environment(), **mission},
    }  # fmt: skip


def mission_of(schedules: list[Part], flight: Flight) -> Part:
    """Return a mission whose parts begin where their schedules do."""
    extensions = {schedule["cell"]: schedule["points"][0]["extension"] for schedule in schedules}
    return {
        "initial": {"position": [0.0, 0.0, flight.depth], "extensions": extensions},
        "control": {"schedules": schedules}, "duration": flight.duration,
        "solver": {"model": "spatial", "tolerance": 1e-8, "output_interval": flight.interval},
    }  # fmt: skip


def quad_glider(mission: str) -> Part:
    """Return the glider with four cells on one of `MISSIONS`."""
    flight = MISSIONS[mission]
    parts = trimmed([*structure(), *map(cell, CELLS), {"kind": "rigid", **BATTERY}, {"kind": "rigid", **LEAD}])
    name, notes = f"Quad-bellows lake glider, {flight.title}", prose(f"{flight.shows} {QUAD_NOTE} {HULL_NOTE}")
    return document(name, notes, parts, mission_of(cell_schedules(flight.legs, flight.start), flight))


def fairings() -> Part:
    """Return the four cells as rigid bodies, as stiff as the cells, so that the twin has the same hull."""
    volume, tube = (
        4.0 * displaced(cell("Front port cell"))[0],
        {"length": tidy(RING_LENGTH), "radius": tidy(CELL_RADIUS)},
    )
    shapes = [
        {"kind": "cylinder", **tube, "offset": [fore * RING_X, side * CELL_Y, 0.0]} for fore, side, _ in CELLS.values()
    ]
    return rigid("Fairings", 1.6, volume, [0, 0, 0], shapes=shapes, height=tidy(2 * CELL_RADIUS), color="#b8c4d0",
                 bulk_modulus=None)  # fmt: skip


def engine() -> Part:
    """Return a piston in the hull with the range of all four cells and their joint rate of volume."""
    change = 4.0 * cell_section() * STROKE / 2.0
    return {
        "kind": "piston", "name": "Buoyancy engine", "mass": 2.0, "position": [tidy(hull_centroid()), 0.0, 0.0],
        "volume": 0.8e-3, "volume_range": [tidy(0.8e-3 - change), tidy(0.8e-3 + change)], "area": tidy(BORE),
        "rate_limit": tidy(4.0 * cell_section() * CELL_RATE / BORE), "lag": 0.5, "efficiency": EFFICIENCY,
        "color": "#7aa7ff", "notes": "One engine where the other glider has four cells; sizes are ours.",
    }  # fmt: skip


def movable_mass_twin() -> Part:
    """Return the glider with one buoyancy engine, a sliding battery and a rolling ballast, on the spiral's legs."""
    hull, *others = structure()
    hull = hull | {"volume": tidy(hull["volume"] - 0.8e-3)}
    drive = {"lag": 0.5, "efficiency": EFFICIENCY}
    slide = {"kind": "movable_mass", **BATTERY, "extension_range": [-0.08, 0.08], "neutral_extension": 0.0,
             "rate_limit": 0.002, **drive}  # fmt: skip
    roll = {"kind": "rolling_mass", **LEAD, "angle_range": [-1.2, 1.2], "rate_limit": 0.05, **drive}
    parts = trimmed([hull, *others, fairings(), engine(), slide, roll])
    (mean, pitch), lever = TURN, 4e-6 * DENSITY
    angle = -math.asin(lever * BANK * CELL_Y / (LEAD["mass"] * LEAD["position"][2]))
    moves = (
        ("Buoyancy engine", 0.0, 4e-6 * mean / BORE),
        ("Battery", 0.0, lever * pitch * RING_X / BATTERY["mass"]),
        ("Lower ballast", MISSIONS["spiral"].legs[1][0], angle),
    )
    schedules = [{"cell": name, "points": ramps(0.0, [(time, end)])} for name, time, end in moves]
    name = "Movable-mass twin of the quad-bellows glider, glide and turn"
    return document(name, prose(f"{TWIN_NOTE} {HULL_NOTE}"), parts, mission_of(schedules, MISSIONS["spiral"]))
