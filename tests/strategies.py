"""Owns the random valid designs and states that tests share (hypothesis): any mix of components, near neutral."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st

from models.assemble import Assembly
from models.design import Design, parse_design
from models.mass_properties import mass_balance

RATE_SCALINGS = ("speed", "speed_squared", "none")
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


@st.composite
def coefficients(draw: st.DrawFn) -> dict[str, Any]:
    """A coefficient form in which every term counts."""
    free = {
        name: draw(numbers(-2.0, 2.0))
        for name in (
            "side_sideslip", "lift_zero", "lift_attack", "roll_sideslip", "roll_rate", "pitch_zero", "pitch_attack",
            "pitch_rate", "pitch_rate_square", "yaw_sideslip", "yaw_rate",
        )
    }  # fmt: skip
    return free | {
        "kind": "coefficients", "provenance": {"title": "Made up", "source": "Random numbers for tests."},
        "reference_density": draw(st.sampled_from([1000.0, 1025.0])), "reference_point": draw(points(0.05)),
        "includes_munk_moment": draw(st.booleans()), "rate_scaling": draw(st.sampled_from(RATE_SCALINGS)),
        "drag_zero": draw(numbers(0.5, 2.0)), "drag_attack": draw(numbers(0.0, 5.0)),
        "drag_sideslip": draw(numbers(0.0, 5.0)),
    }  # fmt: skip


@st.composite
def laterals(draw: st.DrawFn) -> dict[str, Any]:
    names = (
        "sway_sideslip", "sway_crossflow", "roll_sideslip", "roll_crossflow", "yaw_sideslip", "yaw_crossflow",
    )  # fmt: skip
    rates = ("heave_pitch", "pitch_pitch", "sway_roll", "sway_yaw", "roll_roll", "roll_yaw", "yaw_roll", "yaw_yaw")
    return {
        "source": "Random numbers for tests.", "includes_munk_moment": draw(st.booleans()),
        **{name: draw(numbers(-2.0, 2.0)) for name in names},
        "rates": {"scaling": draw(st.sampled_from(RATE_SCALINGS[:2])), **{n: draw(numbers(-1.0, 1.0)) for n in rates}},
    }  # fmt: skip


def points(reach: float) -> st.SearchStrategy[list[float]]:
    """Any point of the body within `reach` (m) of the origin along each axis."""
    return st.lists(numbers(-reach, reach), min_size=3, max_size=3)


@st.composite
def spatial_components(draw: st.DrawFn, name: str) -> dict[str, Any]:
    """One ideal component anywhere in the body: cells with compression, masses that slide or roll."""
    kind = draw(st.sampled_from([*KINDS, "rolling_mass"]))
    if kind == "rolling_mass":
        return {
            "kind": kind, "name": name, "mass": draw(numbers(0.05, 0.3)), "position": draw(points(0.1)),
            "pivot": draw(points(0.05)), "axis": [1.0, draw(numbers(-1.0, 1.0)), draw(numbers(-1.0, 1.0))],
            "inertia": draw(inertias()), "angle_range": [-2.0, 2.0], "neutral_angle": draw(numbers(-1.0, 1.0)),
        }  # fmt: skip
    part = draw(components(name, kind, ideal=True)) | {"position": draw(points(0.2))}
    if "axis" in part:
        part["axis"] = [1.0, draw(numbers(-1.0, 1.0)), draw(numbers(-1.0, 1.0))]
    if kind != "movable_mass":
        part["bulk_modulus"] = draw(st.none() | numbers(2e6, 2e8))
    return part


def currents() -> st.SearchStrategy[dict[str, Any] | None]:
    """Still water, a uniform, a sheared or a tabulated current."""
    pair = st.lists(numbers(-0.3, 0.3), min_size=2, max_size=2)
    shear = st.lists(numbers(-0.02, 0.02), min_size=2, max_size=2)
    profile = st.lists(numbers(-0.3, 0.3), min_size=4, max_size=4)
    return (
        st.none()
        | st.builds(lambda v: {"kind": "uniform", "velocity": v}, pair)
        | st.builds(lambda v, s: {"kind": "sheared", "surface_velocity": v, "shear": s}, pair, shear)
        | st.builds(
            lambda x, y: {"kind": "tabulated", "depths": [2.0, 6.0, 15.0, 30.0], "north": [x], "east": [y]},
            profile, profile,
        )
    )  # fmt: skip


@st.composite
def spatial_designs(draw: st.DrawFn, *, most: int = 6, source: str | None = None) -> Design:
    """Designs for the spatial model with ideal actuators: everything off its plane of symmetry."""
    body = {
        "kind": "rigid", "name": "Body", "mass": draw(numbers(1.0, 3.0)), "position": draw(points(0.02)),
        "center_of_mass": draw(points(0.02)), "volume": draw(numbers(1e-3, 3e-3)),
        "inertia": draw(inertias()) | {"xy": 1e-4, "yz": -1e-4},
    }  # fmt: skip
    count = draw(st.integers(0, most - 1))
    source = source or draw(st.sampled_from(["polar", "coefficients"]))
    forces = draw(coefficients()) if source == "coefficients" else draw(hydrodynamics()) | {"lateral": draw(laterals())}
    damping = np.diag([0.3, 0.4, 0.5, 0.02, 0.03, 0.04]) + 0.01
    declared = {
        "kind": "declared", "mass": draw(numbers(0.5, 3.0)), "center_of_mass": draw(points(0.02)),
        "inertia": {"xx": 0.02, "yy": 0.03, "zz": 0.04, "xy": 1e-3, "xz": -2e-3, "yz": 1e-3},
    }  # fmt: skip
    return parse_design({
        "format": "glider-design", "version": 1, "name": "Random in space",
        "vehicle": {
            "components": [body, *(draw(spatial_components(f"Part {i}")) for i in range(count))],
            "mass_properties": draw(st.sampled_from([{"kind": "composite"}, {"kind": "composite"}, declared])),
            "hydrodynamics": forces,
            "added_mass": draw(added_masses()),
            "damping": {"yaw": 0.01, "matrix": draw(st.sampled_from([None, damping.tolist()]))},
        },
        "mission": {
            "environment": {
                "water": draw(waters()), "current": draw(currents()), "gravity": 9.81,
                "surface": draw(st.sampled_from(["end", "float"])),
            },
            "initial": {"position": [0.0, 0.0, draw(numbers(1.0, 20.0))], "velocity": [0.3, 0.05, 0.1]},
            "duration": 3.0,
            "solver": {"model": "spatial"},
        },
    })  # fmt: skip


@st.composite
def waters(draw: st.DrawFn) -> dict[str, Any]:
    """Water of one density, or a stratified one."""
    if draw(st.booleans()):
        return {"density": draw(st.sampled_from([998.0, 1025.0]))}
    steps = draw(st.lists(numbers(0.0, 3.0), min_size=4, max_size=4))
    densities = [float(v) for v in 998.0 + np.cumsum(steps)]
    return {"kind": "density_profile", "depths": [1.0, 5.0, 20.0, 60.0], "densities": densities}


@st.composite
def spatial_states(draw: st.DrawFn, assembly: Assembly) -> np.ndarray:
    """A state of a spatial design: any attitude and motion, extensions anywhere within the stops."""
    attitude = np.array(draw(st.lists(numbers(-1.0, 1.0), min_size=4, max_size=4)))
    attitude = attitude / np.linalg.norm(attitude) if np.linalg.norm(attitude) > 0.1 else np.array([1.0, 0, 0, 0])
    place = [draw(numbers(-50.0, 50.0)), draw(numbers(-50.0, 50.0)), draw(numbers(-0.1, 0.3) | numbers(1.0, 50.0))]
    motion = [draw(numbers(-1.0, 1.0)) for _ in range(6)]
    parts = [part for _, part in assembly.design.vehicle.actuated]
    extensions = [draw(between(*part.stroke)) for part in parts]
    return np.array([*place, *attitude, *motion, 0.0, 0.0, 0.0, *extensions, *np.zeros(len(parts))])
