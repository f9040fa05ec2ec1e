"""Owns what can be added to a vehicle: a small part of each kind, sized by the vehicle, with honest mass and volume.

Sizes are in metres. Wing, fin, ballast and core sampler are rigid parts with a fitting shape; masses follow from a
stated material, so that what is added weighs and displaces what it would.
"""

from __future__ import annotations

import math
from typing import Any

from models.design import Design
from models.problems import DesignError, Problem
from models.shapes import HullShape
from models.vehicle_length import vehicle_length

Part = dict[str, Any]

NAMES = {
    "rigid": "Part",
    "wing": "Wing",
    "fin": "Fin",
    "bellows": "Bellows",
    "piston": "Piston",
    "bladder": "Bladder",
    "movable_mass": "Movable mass",
    "rolling_mass": "Rolling mass",
    "ballast": "Ballast",
    "core_sampler": "Core sampler",
}
"""What can be added, and how it is called until somebody names it."""
POLYETHYLENE, LEAD, SAMPLER = 950.0, 11_340.0, 1415.0
"""Densities, kg/m3; that of the sampler is that of the quad glider's closed tube."""
BALLAST_MASS = 0.05
USUAL_LENGTH = 0.6
"""Length of the vehicle for which the moving parts below are sized, m; those of another grow or shrink with it."""
LEAST_SCALE, MOST_SCALE = 0.2, 10.0
FORCES_NOTE = "The forces of the water on it are not added: they are those of the whole vehicle, under Vehicle."
FLAT_NOTE = f"A plate of polyethylene, 950 kg/m3. {FORCES_NOTE}"


def new_part(design: Design, kind: str, place: float) -> Part:
    """Return a part of a kind without its name, at `place` along the vehicle, m; raises `DesignError` for others."""
    length, radius = vehicle_length(design.vehicle), _hull_radius(design)
    match kind:
        case "wing":
            part = _wing(length)
        case "fin":
            part, place = _fin(length, radius), _tail(design, place)
        case "ballast":
            part = _cylinder(BALLAST_MASS, LEAD, slender=8.0, notes="A bar of lead, 11,340 kg/m3.", down=0.6 * radius)
        case "core_sampler":
            part = _sampler(length, radius)
        case "rigid":
            cube = {"kind": "cylinder", "length": 0.03, "radius": 0.008}
            part = {"mass": 0.02, "volume": 6e-6, "shapes": [cube]}
        case _:
            part = _moving(kind, min(max(length / USUAL_LENGTH, LEAST_SCALE), MOST_SCALE))
    x, y, z = part.get("position", (0.0, 0.0, 0.0))
    known = kind if kind in ("bellows", "piston", "bladder", "movable_mass", "rolling_mass") else "rigid"
    return {"mass": 0.0} | part | {"kind": known, "position": [round(place + x, 4), y, z]}


def _moving(kind: str, scale: float) -> Part:
    """Return a moving part, `scale` times as long as in a vehicle of the usual length; strokes take the same time."""

    def sized(value: float, power: int = 1) -> float:
        return _rounded(value * scale**power)

    rate, mass = sized(0.002), sized(0.05, 3)
    match kind:
        case "bellows":
            return {
                "pleats": 8, "inner_radius": sized(0.016), "outer_radius": sized(0.024), "fixed_volume": sized(2e-5, 3),
                "extension_range": [0.0, sized(0.032)], "neutral_extension": sized(0.016), "rate_limit": rate,
            }  # fmt: skip
        case "piston":
            volumes = [sized(3e-5, 3), sized(5e-5, 3)]
            return {"volume": sized(4e-5, 3), "volume_range": volumes, "area": sized(5e-4, 2), "rate_limit": rate}
        case "bladder":
            return {
                "extensions": [0.0, sized(0.01), sized(0.02)], "volumes": [sized(v, 3) for v in (1e-5, 2e-5, 3e-5)],
                "neutral_extension": sized(0.01), "rate_limit": rate,
            }  # fmt: skip
        case "movable_mass":
            reach = sized(0.03)
            return {
                "mass": mass, "extension_range": [-reach, reach], "neutral_extension": 0.0, "rate_limit": sized(0.005),
            }  # fmt: skip
        case "rolling_mass":
            return {"mass": mass, "angle_range": [-1.5, 1.5], "neutral_angle": 0.0, "rate_limit": 0.2}
    hint = f"use one of {', '.join(NAMES)}"
    raise DesignError([Problem("/vehicle/components", f"there is no kind of component '{kind}'", hint=hint)])


def _hull_radius(design: Design) -> float:
    """Return the radius of the widest hull, or a slender one's where no hull is drawn, m."""
    radii = [s.radius for c in design.vehicle.components for s in c.shapes if isinstance(s, HullShape)]
    return max(radii) if radii else 0.05 * vehicle_length(design.vehicle)


def _tail(design: Design, place: float) -> float:
    """Return where a fin stands at the end of the longest hull, m; `place` where no hull is drawn."""
    hulls = [(s.length, c.position[0] + s.offset[0]) for c in design.vehicle.components for s in c.shapes
             if isinstance(s, HullShape)]  # fmt: skip
    length, middle = max(hulls, default=(0.0, place))
    return middle - 0.42 * length


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def _plate(area: float, thickness: float) -> Part:
    volume = _rounded(area * thickness)
    return {"volume": volume, "mass": _rounded(POLYETHYLENE * volume), "notes": FLAT_NOTE}


def _wing(length: float) -> Part:
    span, chord, tip, thickness = (_rounded(share * length) for share in (0.7, 0.1, 0.06, 0.006))
    shape = {
        "kind": "wing", "span": span, "chord": chord, "tip_chord": tip, "sweep": _rounded(chord - tip),
        "thickness": thickness,
    }  # fmt: skip
    plate = _plate(span * (chord + tip) / 2.0, thickness)
    mass = plate["mass"]
    roll, pitch = mass * span**2 / 12.0, mass * chord**2 / 12.0
    inertia = {"xx": _rounded(roll), "yy": _rounded(pitch), "zz": _rounded(roll + pitch)}
    return plate | {"shapes": [shape], "inertia": inertia}


def _fin(length: float, radius: float) -> Part:
    span, chord, tip, thickness = (_rounded(share * length) for share in (0.1, 0.08, 0.05, 0.004))
    shape = {
        "kind": "fin", "span": span, "chord": chord, "tip_chord": tip, "sweep": _rounded(chord - tip),
        "thickness": thickness, "direction": [0.0, 0.0, -1.0], "offset": [0.0, 0.0, _rounded(span / 2.0)],
    }  # fmt: skip
    up = -_rounded(radius + span / 2.0)
    return _plate(span * (chord + tip) / 2.0, thickness) | {"shapes": [shape], "position": [0.0, 0.0, up]}


def _sampler(length: float, radius: float) -> Part:
    tube = _rounded(0.015 * length)
    volume = _rounded(math.pi * tube**2 * 0.2 * length)
    mass = _rounded(SAMPLER * volume)
    shape = {"kind": "cylinder", "length": _rounded(0.2 * length), "radius": tube}
    notes = f"A closed tube outside the hull, 1415 kg/m3. {FORCES_NOTE}"
    place = [0.0, 0.0, _rounded(radius + tube)]
    return {"mass": mass, "volume": volume, "shapes": [shape], "notes": notes, "position": place}


def _cylinder(mass: float, density: float, *, slender: float, notes: str, down: float) -> Part:
    """Return a solid bar along x, `slender` radii long, below the axis by `down`, m."""
    volume = mass / density
    radius = (volume / (math.pi * slender)) ** (1.0 / 3.0)
    shape = {"kind": "cylinder", "length": _rounded(slender * radius), "radius": _rounded(radius)}
    place = [0.0, 0.0, _rounded(down)]
    return {"mass": mass, "volume": _rounded(volume), "shapes": [shape], "notes": notes, "position": place}
