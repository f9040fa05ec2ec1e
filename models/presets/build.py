"""Writes the preset files: `python -m models.presets.build`. The hydrodynamic rows come from models/data/*.csv."""

from __future__ import annotations

import json
import math
from importlib.resources import files
from pathlib import Path
from typing import Any

from models.components import Bellows
from models.design import Design, parse_design
from models.hydrodynamics import Provenance
from models.mass_properties import trim_ballast
from models.polar_csv import read_polar_csv
from models.presets.published import seawing, slocum
from models.presets.quad_control import TASKS, controlled_glider
from models.presets.quad_glider import movable_mass_twin, quad_glider
from models.presets.words import prose

MISSIONS = ("glide", "spiral", "s-turn", "yo-yo")
"""Missions of the quad-bellows glider."""
DATA = files("models").joinpath("data")


HULL_NOTE = prose("""
    The hull is a stand-in made to the paper's mass and volume, not its geometry: a body of revolution 0.600 m long and
    32.06 mm across, two coaxial cylinders for the bellows (48 mm across, 80 mm long, at x = +-0.180 m) and a flat wing
    of 0.500 m span and 0.100 m chord.
""")
CANETE_NOTE = prose(f"""
    The paper's glider with a front and a rear bellows: it dives for 10 s and climbs again, over stand-in CFD data.
    Source: L. Canete, J. Paquibot, M. Matsumoto, T. Takahashi, 'Investigation of Multiple Buoyancy Controller Equipped
    Underwater Glider Robot Modeling for Control System Development and Gliding Simulation': mass, centre of mass,
    inertia in pitch, damping and gravity are its Table II, declared and frozen as there; the inertias in roll and yaw,
    which only the spatial model reads, are ours. Cells, hull and forces are not the
    paper's, which prints no numbers for them. {HULL_NOTE} The paper's V0 makes the glider neutral without its bellows;
    here the cells at neutral extension count, so that only changes unbalance it. The front cell takes 0.02 N away for
    10 s, then adds 0.02 N: the size of the paper's tank run.
""")
THREE_CELL_NOTE = prose(f"""
    Two bellows, a piston and a sliding battery in one plane, each with its rate limit and lag: a sawtooth of two dives.
    A made-up glider on the stand-in hull that shows what the paper's model leaves room for; mass properties are
    composed from the parts. The piston sinks and raises it, the end cells and the slide pitch it. Its sizes are ours
    and no published glider's. {HULL_NOTE}
""")


def standin_hydrodynamics() -> dict[str, Any]:
    """Return the stand-in hull's table with its provenance."""
    about = json.loads(DATA.joinpath("standin_kepsilon.json").read_text())
    provenance = Provenance.model_validate(about["provenance"])
    table = read_polar_csv(DATA.joinpath("standin_kepsilon.csv"), provenance=provenance)
    return table.model_dump(mode="json")


def standin_added_mass(*, enabled: bool) -> dict[str, Any]:
    """Return the stand-in hull's added mass."""
    about = json.loads(DATA.joinpath("standin_added_mass.json").read_text())
    return {"enabled": enabled} | {key: about[key] for key in ("matrix", "density", "source")}


def standin_bellows(name: str, x: float, color: str, **changes: Any) -> dict[str, Any]:
    """Return a bellows of the stand-in at x (m): it displaces its cylinder (24 mm x 80 mm) at neutral extension."""
    radius, length, neutral = 0.024, 0.080, 0.016
    cell: dict[str, Any] = {
        "kind": "bellows",
        "name": name,
        "mass": 0.030,
        "position": [x, 0.0, 0.0],
        "axis": [math.copysign(1.0, x), 0.0, 0.0],
        "pleats": 8,
        "inner_radius": 0.016,
        "outer_radius": radius,
        "fixed_volume": 0.0,
        "extension_range": [0.0, 0.032],
        "neutral_extension": neutral,
        "color": color,
        "shapes": [{"kind": "bellows", "length": length, "inner_radius": 0.016, "outer_radius": radius, "pleats": 8}],
        "notes": "Stand-in: 8 pleats, radii 16 and 24 mm, stroke 32 mm, about 40.8 cm3 or 0.4 N. Not the paper's part.",
    }
    section = Bellows.model_validate(cell).section
    cell["fixed_volume"] = math.pi * radius**2 * length - section * neutral
    return cell | changes


def hull_shapes() -> list[dict[str, Any]]:
    """Return the shapes of the stand-in's fuselage and wing, for a component at the origin."""
    return [
        {"kind": "hull", "length": 0.600, "radius": 0.01603, "nose_length": 0.060, "tail_length": 0.100},
        {"kind": "wing", "span": 0.500, "chord": 0.100, "thickness": 0.004, "offset": [-0.020, 0.0, 0.0]},
    ]


def stroke_for(force: float, cell: dict[str, Any], density: float, gravity: float) -> float:
    """Return the extension that changes the buoyancy of a bellows by `force` (N) from neutral, m."""
    bellows = Bellows.model_validate(cell)
    return bellows.neutral_extension + force / (density * gravity * bellows.section)


def canete_dual_bellows() -> dict[str, Any]:
    """Return the paper's glider: Table II with the stand-in's cells, hull and forces."""
    density, gravity = 1000.0, 9.8
    front = standin_bellows("Front bellows", 0.180, "#f2b134")
    rear = standin_bellows("Rear bellows", -0.180, "#4fc3a1")
    return {
        "format": "glider-design",
        "version": 1,
        "name": "Dual-bellows lake glider",
        "notes": CANETE_NOTE,
        "vehicle": {
            "components": [
                {
                    "kind": "rigid",
                    "name": "Body",
                    "mass": 0.727,
                    "volume": 0.7877e-3 - 2.0 * math.pi * 0.024**2 * 0.080,
                    "position": [0.0, 0.0, 0.0],
                    "shapes": hull_shapes(),
                    "color": "#9fb3c8",
                    "notes": "Fuselage and wing, the paper's component 0; its volume is set by trimming the ballast.",
                },
                front,
                rear,
            ],
            "mass_properties": {
                "kind": "declared",
                "mass": 0.787,
                "center_of_mass": [0.0, 0.0, 0.001],
                "inertia": {"xx": 0.0025, "yy": 0.029, "zz": 0.031},
            },
            "hydrodynamics": standin_hydrodynamics(),
            "added_mass": standin_added_mass(enabled=False),
            "damping": {"pitch": 0.001},
        },
        "mission": {
            "environment": {"water": {"kind": "uniform", "density": density}, "gravity": gravity},
            "initial": {"position": [0.0, 0.0, 0.5]},
            "control": {
                "schedules": [
                    {
                        "cell": "Front bellows",
                        "points": [
                            {"time": 0.0, "extension": stroke_for(-0.02, front, density, gravity)},
                            {"time": 10.0, "extension": stroke_for(+0.02, front, density, gravity)},
                        ],
                    }
                ]
            },
            "duration": 20.0,
            "solver": {"output_interval": 0.05},
        },
    }


def _there_and_back(cell: str, down: float, up: float) -> dict[str, Any]:
    """Return a schedule that ramps to `down` for a dive, to `up` for a climb, and down again (m)."""
    legs = ((2.0, down), (40.0, down), (52.0, up), (90.0, up), (102.0, down))
    return {"cell": cell, "points": [{"time": t, "extension": e, "shape": "ramp"} for t, e in legs]}


def three_cell_glider() -> dict[str, Any]:
    """Return a glider of three cells and a movable mass in the plane, composed from its parts."""
    moving = {"rate_limit": 0.002, "lag": 0.3}
    front = standin_bellows("Front bellows", 0.180, "#f2b134", **moving)
    rear = standin_bellows("Rear bellows", -0.180, "#4fc3a1", **moving)
    engine = {
        "kind": "piston", "name": "Middle piston", "mass": 0.060, "position": [0.030, 0.0, 0.0], "volume": 40e-6,
        "volume_range": [30e-6, 50e-6], "area": 5e-4, "rate_limit": 0.002, "lag": 0.2, "color": "#7aa7ff",
        "notes": "A piston of 5 cm2 with 40 mm of stroke; sizes are ours.",
    }  # fmt: skip
    trimmer = {
        "kind": "movable_mass", "name": "Battery slide", "mass": 0.120, "position": [-0.060, 0.0, 0.006],
        "extension_range": [-0.030, 0.030], "neutral_extension": 0.0, "rate_limit": 0.005, "color": "#d98cc4",
        "shapes": [{"kind": "cylinder", "length": 0.05, "radius": 0.009}],
        "notes": "Slides along the hull; sizes are ours.",
    }  # fmt: skip
    rigid: list[dict[str, Any]] = [
        {
            "kind": "rigid", "name": "Fuselage", "mass": 0.342, "volume": 0.27e-3, "position": [0.0, 0.0, 0.0],
            "inertia": {"xx": 5e-5, "yy": 0.0118, "zz": 0.0118}, "shapes": hull_shapes()[:1], "color": "#9fb3c8",
        },
        {
            "kind": "rigid", "name": "Wing", "mass": 0.085, "volume": 0.1872e-3, "position": [-0.020, 0.0, 0.0],
            "inertia": {"xx": 0.00177, "yy": 7.1e-5, "zz": 0.00184}, "color": "#b8c4d0",
            "shapes": [{"kind": "wing", "span": 0.500, "chord": 0.100, "thickness": 0.004}],
        },
        {
            "kind": "rigid", "name": "Keel ballast", "mass": 0.120, "volume": 10.6e-6, "position": [0.043, 0.0, 0.024],
            "shapes": [{"kind": "cylinder", "length": 0.06, "radius": 0.004}], "color": "#76828f",
        },
    ]  # fmt: skip
    return {
        "format": "glider-design",
        "version": 1,
        "name": "Three-cell glider with battery slide",
        "notes": THREE_CELL_NOTE,
        "vehicle": {
            "components": [*rigid, front, engine, rear, trimmer],
            "mass_properties": {"kind": "composite"},
            "hydrodynamics": standin_hydrodynamics(),
            "added_mass": standin_added_mass(enabled=True),
            "damping": {"pitch": 0.02},
        },
        "mission": {
            "environment": {"water": {"kind": "uniform", "density": 1000.0}, "gravity": 9.80665, "bed_depth": 20.0},
            "initial": {"position": [0.0, 0.0, 1.0]},
            "control": {
                "schedules": [
                    _there_and_back("Middle piston", -0.012, 0.012),
                    _there_and_back("Battery slide", 0.012, -0.012),
                    _there_and_back("Front bellows", 0.0157, 0.0163),
                    _there_and_back("Rear bellows", 0.0163, 0.0157),
                ]
            },
            "duration": 130.0,
            "solver": {"output_interval": 0.1},
        },
    }  # fmt: skip


def build() -> dict[str, Design]:
    """Return all presets by identifier; those on the stand-in hull are trimmed to neutral buoyancy."""
    trimmed = {"canete-dual-bellows": canete_dual_bellows(), "three-cell-glider": three_cell_glider()}
    quads = {f"quad-bellows-{mission}": quad_glider(mission) for mission in MISSIONS}
    quads |= {f"quad-bellows-{task}": controlled_glider(task) for task in TASKS}
    stated = quads | {"movable-mass-twin": movable_mass_twin(), "seawing-spiral": seawing(), "slocum-glide": slocum()}
    return {name: trim_ballast(parse_design(document))[0] for name, document in trimmed.items()} | {
        name: parse_design(document) for name, document in stated.items()
    }


if __name__ == "__main__":
    for preset_id, design in build().items():
        Path(__file__).with_name(f"{preset_id}.json").write_text(design.to_json(), encoding="utf-8")
