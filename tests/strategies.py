"""Owns the random valid designs and states that tests share (hypothesis): any mix of components, near neutral."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st

from models.assemble import Assembly
from models.design import Design, parse_design
from models.mass_properties import mass_balance

KINDS = ("rigid", "bellows", "piston", "bladder", "movable_mass")
CELL_VOLUME = 1e-4
"""Largest volume of a random cell, m3: the body's, at least ten times that, can always balance seven of them."""


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Finite floats; zero or of a size that matters, so that products do not underflow."""
    small = 1e-6 * max(abs(low), abs(high))
    return st.floats(low, high, allow_subnormal=False).map(lambda x: 0.0 if abs(x) < small and low <= 0.0 else x)


@st.composite
def between(draw: st.DrawFn, low: float, high: float) -> float:
    """A number of a range that was itself drawn, its ends included, never beyond them by rounding."""
    return min(max(low + draw(numbers(0.0, 1.0)) * (high - low), low), high)


@st.composite
def vectors(draw: st.DrawFn, x: float, z: float, y: float = 0.0) -> list[float]:
    return [draw(numbers(-x, x)), draw(numbers(-y, y)) if y else 0.0, draw(numbers(-z, z))]


@st.composite
def axes(draw: st.DrawFn) -> list[float]:
    angle, length = draw(numbers(-math.pi, math.pi)), draw(numbers(0.1, 3.0))
    return [length * math.cos(angle), 0.0, length * math.sin(angle)]


@st.composite
def inertias(draw: st.DrawFn) -> dict[str, float]:
    """Tensors with principal moments that a body can have: products small beside the moments."""
    yy = draw(numbers(1e-3, 2e-2))
    return {"xx": 0.8 * yy, "yy": yy, "zz": yy, "xz": draw(numbers(-0.3, 0.3)) * yy}


@st.composite
def bladder_tables(draw: st.DrawFn) -> dict[str, Any]:
    count = draw(st.integers(2, 7))
    steps = draw(st.lists(numbers(1e-3, 1e-2), min_size=count - 1, max_size=count - 1))
    shares = draw(st.lists(numbers(0.05, 1.0), min_size=count, max_size=count))
    start = draw(numbers(-0.02, 0.02))
    e = [start, *(start + np.cumsum(steps))]
    V = CELL_VOLUME * np.cumsum(shares) / sum(shares)
    return {
        "extensions": [float(v) for v in e],
        "volumes": [float(v) for v in V],
        "neutral_extension": draw(between(float(e[0]), float(e[-1]))),
    }


@st.composite
def _laws(draw: st.DrawFn, kind: str) -> dict[str, Any]:
    if kind == "bladder":
        return draw(bladder_tables())
    if kind == "piston":
        low, high = draw(numbers(0.0, 2e-5)), draw(numbers(4e-5, CELL_VOLUME))
        volume = draw(between(low, high))
        return {"volume": volume, "volume_range": [low, high], "area": draw(numbers(5e-4, 3e-3))}
    stroke = draw(numbers(0.005, 0.05))
    low = draw(numbers(0.0, 0.02)) if kind == "bellows" else draw(numbers(-0.05, 0.0))
    ranged = {"extension_range": [low, low + stroke], "neutral_extension": draw(between(low, low + stroke))}
    if kind == "movable_mass":
        return ranged
    inner = draw(numbers(0.005, 0.015))
    return ranged | {
        "pleats": draw(st.integers(1, 12)),
        "inner_radius": inner,
        "outer_radius": inner + draw(numbers(0.0, 0.005)),
        "fixed_volume": draw(numbers(0.0, 2e-5)),
        "pleat_volume": draw(numbers(0.0, 5e-7)),
        "gap_volume": draw(numbers(0.0, 5e-7)),
        "as_printed": False,
    }


@st.composite
def components(draw: st.DrawFn, name: str, kind: str | None = None, *, ideal: bool = False) -> dict[str, Any]:
    """One component; `ideal` actuators are on their command at once."""
    kind = kind or draw(st.sampled_from(KINDS))
    part: dict[str, Any] = {
        "kind": kind, "name": name, "mass": draw(numbers(0.01, 0.2)),
        "position": draw(vectors(0.3, 0.03)), "inertia": draw(inertias()),
    }  # fmt: skip
    if draw(st.booleans()):
        part["center_of_mass"] = draw(vectors(0.3, 0.03))
    if kind == "rigid":
        return part | {"volume": draw(numbers(0.0, CELL_VOLUME))}
    if not ideal:
        part["rate_limit"] = draw(st.none() | numbers(5e-4, 2e-2))
        part["lag"] = draw(st.just(0.0) | numbers(0.05, 2.0))
    return part | {"axis": draw(axes())} | draw(_laws(kind))


@st.composite
def hydrodynamics(draw: st.DrawFn, law: str | None = None) -> dict[str, Any]:
    """A table of 8 to 19 angles at one to three speeds: smooth curves of the usual shape, with scatter for 'pchip'."""
    law = law or draw(st.sampled_from(["pchip", "polynomial"]))
    count = draw(st.integers(8, 19))
    alpha = np.linspace(0.0, 90.0, count)
    if draw(st.booleans()):
        inner = np.array(draw(st.lists(numbers(-0.3, 0.3), min_size=count - 2, max_size=count - 2)))
        alpha[1:-1] += inner * 90.0 / (count - 1)
    a = np.deg2rad(alpha)
    lift = draw(numbers(0.5, 12.0)) * np.sin(2 * a) * (1.0 - 0.2 * np.sin(a))
    drag = draw(numbers(1.0, 3.0)) + draw(numbers(0.0, 40.0)) * np.sin(a) ** 2
    moment = draw(numbers(-1.0, 1.0)) * np.sin(2 * a) + draw(numbers(-0.3, 0.3)) * np.sin(a)
    columns: dict[str, list[float]] = {f"row_{c}": [] for c in ("speed", "alpha_deg", "lift", "drag", "moment")}
    speeds = draw(st.lists(st.sampled_from([0.1, 0.2, 0.5, 1.0]), min_size=1, max_size=3, unique=True))
    for v in speeds:
        scatter = 1.0 + (0.05 * np.cos(np.arange(count) * draw(numbers(0.5, 3.0))) if law == "pchip" else 0.0)
        rows = (np.full(count, v), alpha, lift * scatter * v**2, drag * scatter * v**2, moment * scatter * v**2)
        for column, values in zip(columns.values(), rows, strict=True):
            column.extend(float(value) for value in values)
    columns["row_alpha_deg"] = [min(max(value, 0.0), 90.0) for value in columns["row_alpha_deg"]]
    return {
        "kind": "polar_table",
        "provenance": {"title": "Made up", "source": "Random curves for tests."},
        "law": law,
        "speed": draw(st.sampled_from([None, *speeds])),
        "reference_density": draw(st.sampled_from([1000.0, 1025.0])),
        "reference_point": draw(st.just([0.0, 0.0, 0.0]) | vectors(0.2, 0.02)),
        "includes_munk_moment": draw(st.booleans()),
        **columns,
    }


@st.composite
def added_masses(draw: st.DrawFn) -> dict[str, Any] | None:
    """None, or a random symmetric positive definite matrix of the size of a small glider's, on or off."""
    choice = draw(st.sampled_from(["none", "off", "on", "on"]))
    if choice == "none":
        return None
    values = draw(st.lists(numbers(-1.0, 1.0), min_size=21, max_size=21))
    lower = np.zeros((6, 6))
    lower[np.tril_indices(6)] = values
    scale = np.diag([0.3, 0.7, 1.5, 0.1, 0.15, 0.1])
    A = scale @ (lower @ lower.T + 0.01 * np.eye(6)) @ scale
    A = 0.5 * (A + A.T)
    return {"enabled": choice == "on", "matrix": A.tolist(), "density": draw(st.sampled_from([1000.0, 1025.0]))}


@st.composite
def schedules(draw: st.DrawFn, name: str, stroke: tuple[float, float], duration: float) -> dict[str, Any]:
    count = draw(st.integers(1, 4))
    gaps = draw(st.lists(numbers(0.2, 1.0), min_size=count, max_size=count))
    times = np.cumsum(gaps) - draw(st.sampled_from([gaps[0], 0.0]))
    low, high = stroke
    points = []
    for t in times:
        shape = draw(st.sampled_from(["step", "ramp"]))
        extension = draw(st.sampled_from([low, high]) | between(low, high))
        points.append({"time": float(t) * duration / 5.0, "extension": extension, "shape": shape})
    return {"cell": name, "points": points}


@st.composite
def designs(
    draw: st.DrawFn, *, most: int = 8, ideal: bool = False, neutral: bool = True, law: str | None = None
) -> Design:
    """Designs of 1 to `most` components that assemble; `neutral` ones have a body that nearly balances the weight."""
    count = draw(st.integers(1, most))
    body = {
        "kind": "rigid", "name": "Body", "mass": draw(numbers(1.0, 3.0)), "position": draw(vectors(0.02, 0.005)),
        "center_of_mass": [draw(numbers(-0.02, 0.02)), 0.0, draw(numbers(0.0, 0.02))],
        "volume": 1e-3, "inertia": draw(inertias()),
    }  # fmt: skip
    first = [body] if neutral or draw(st.booleans()) else []
    parts = first + [draw(components(f"Part {i}", ideal=ideal)) for i in range(len(first), count)]
    declared = {
        "kind": "declared", "mass": draw(numbers(0.5, 3.0)), "inertia": {"yy": draw(numbers(0.01, 0.05))},
        "center_of_mass": draw(vectors(0.02, 0.01)),
    }  # fmt: skip
    duration = draw(numbers(2.0, 6.0))
    document: dict[str, Any] = {
        "format": "glider-design", "version": 1, "name": "Random",
        "vehicle": {
            "components": parts,
            "mass_properties": draw(st.sampled_from([{"kind": "composite"}, declared])),
            "hydrodynamics": draw(hydrodynamics(law)),
            "added_mass": draw(added_masses()),
            "damping": {
                "surge": draw(st.just(0.0) | numbers(0.0, 0.5)), "heave": draw(st.just(0.0) | numbers(0.0, 0.5)),
                "pitch": draw(numbers(0.005, 0.1)),
            },
        },
        "mission": {
            "environment": {
                "water": {"density": draw(st.sampled_from([998.0, 1000.0, 1025.0]))},
                "gravity": draw(st.sampled_from([9.8, 9.80665])), "bed_depth": draw(st.sampled_from([None, 50.0])),
            },
            "initial": {
                "position": [draw(numbers(-5.0, 5.0)), 0.0, draw(numbers(5.0, 20.0))],
                "pitch": draw(numbers(-1.0, 1.0)),
                "velocity": [draw(numbers(-0.1, 0.3)), 0.0, draw(numbers(-0.1, 0.1))],
                "angular_velocity": [0.0, draw(numbers(-0.3, 0.3)), 0.0],
            },
            "duration": duration,
        },
    }  # fmt: skip
    design = parse_design(document)
    balance = mass_balance(design.vehicle)
    if neutral:
        density = document["mission"]["environment"]["water"]["density"]
        spare = balance.volume - body["volume"]
        imbalance = draw(numbers(-0.01, 0.01))
        body["volume"] = max(balance.mass * (1.0 + imbalance) / density - spare, 0.0)
    moving = [c for _, c in design.vehicle.actuated]
    told = [c for c in moving if draw(st.booleans())]
    document["mission"]["control"] = {"schedules": [draw(schedules(c.name, c.stroke, duration)) for c in told]}
    return parse_design(document)


@st.composite
def states(draw: st.DrawFn, assembly: Assembly) -> np.ndarray:
    """A state of an assembled design: any attitude and motion, extensions anywhere within the stops."""
    motion = [
        draw(numbers(-50.0, 50.0)), draw(numbers(0.0, 50.0)), draw(numbers(-10.0, 10.0)),
        draw(numbers(-2.0, 2.0)), draw(numbers(-2.0, 2.0)), draw(numbers(-3.0, 3.0)),
    ]  # fmt: skip
    strokes = [part.stroke for _, part in assembly.design.vehicle.actuated]
    extensions = [draw(between(*stroke)) for stroke in strokes]
    return np.array([*motion, 0.0, 0.0, *extensions])
