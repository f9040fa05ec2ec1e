"""Owns the published gliders: their parameters as printed, each with its source and what it is not."""

from __future__ import annotations

import math
from typing import Any

from models.presets.words import prose

SEAWATER = 1025.0
"""Density that the sources leave open, kg/m3: coefficients and displaced mass are stated at it."""

SEAWING_NOTE = prose("""
    The Seawing glider in a steady spiral. Source: S. Zhang, J. Yu, A. Zhang, F. Zhang, 2013, 'Spiraling motion of
    underwater gliders: modeling, analysis, and experimental results', Ocean Engineering 60, 1-13, as transcribed in
    the public repository Ivarsak/Underwater-Glider-6DOF-Nonlinear-Dynamics. The battery lies at x = 0.4216 m,
    turned by 45 deg, and the glider is 0.3 kg heavy. The published steady spiral: roll -13.703 deg, pitch -35.641
    deg, 0.49 m/s, angle of attack 1.267 deg, sideslip -1.283 deg, 0.0039 rad/s, radius 100.5 m. It banks away from
    its turn, rolled to port while turning to starboard, since the side force of sideslip makes the turn, as
    published; the quad-bellows glider banks inwards. Turned by +45 deg about x, the battery lies to port. The inertia
    of the battery as published breaks the triangle inequality; it has no visible effect here. Density is not stated
    there; ours is 1025 kg/m3, and shapes are ours, for drawing only.
""")
SLOCUM_NOTE = prose("""
    A Slocum-like glider in a steady glide at -25 deg. Source: J. G. Graver, 2005, 'Underwater gliders: dynamics,
    control and design', PhD thesis, Princeton, with the parameters in the public repositories
    YogangSingh/2D-Simulations- Underwater-Glider-Motion and AIM75/Underwater-Glider. The thesis' closed form gives
    an angle of attack of 2.0227 deg, a pitch of -22.9773 deg, a ballast of 1.04732 kg and the movable mass at
    1.9831 cm for 0.3 m/s. The source gives forces of the vertical plane only, so the design is planar. Total
    inertias with added inertia are given to the hull. Density is not stated there; ours is 1025 kg/m3, and shapes
    are ours, for drawing only.
""")


def _document(name: str, notes: str, vehicle: dict[str, Any], mission: dict[str, Any]) -> dict[str, Any]:
    return {
        "format": "glider-design",
        "version": 1,
        "name": name,
        "notes": notes,
        "vehicle": vehicle,
        "mission": mission,
    }


def _diagonal(xx: float, yy: float, zz: float) -> dict[str, float]:
    return {"xx": xx, "yy": yy, "zz": zz}


def _torpedo(length: float, radius: float, span: float) -> list[dict[str, Any]]:
    return [
        {"kind": "hull", "length": length, "radius": radius, "nose_length": 0.18 * length, "tail_length": 0.3 * length},
        {
            "kind": "wing", "span": span, "chord": 0.16, "tip_chord": 0.1, "sweep": 0.35, "thickness": 0.01,
            "offset": [-0.15, 0.0, 0.0],
        },
        {
            "kind": "fin", "span": 0.22, "chord": 0.16, "tip_chord": 0.1, "sweep": 0.1, "thickness": 0.008,
            "offset": [-0.42 * length, 0.0, -0.3 * radius],
        },
    ]  # fmt: skip


def seawing() -> dict[str, Any]:
    """Return the Seawing of Zhang et al. (2013) in its published spiral."""
    turned = math.radians(45.0)
    battery = {
        "kind": "rolling_mass", "name": "Battery", "mass": 11.0, "position": [0.4216, 0.0, 0.014],
        "pivot": [0.4216, 0.0, 0.0], "axis": [1.0, 0.0, 0.0], "inertia": _diagonal(0.02, 10.16, 0.17),
        "angle_range": [-math.pi / 2, math.pi / 2], "neutral_angle": 0.0, "rate_limit": 0.1, "color": "#f2b134",
        "shapes": [{"kind": "cylinder", "length": 0.4, "radius": 0.06}],
        "notes": "Slides in the real glider too; here its place along the hull is its position.",
    }  # fmt: skip
    static = {
        "kind": "rigid", "name": "Hull", "mass": 54.28, "volume": 65.28 / SEAWATER, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [-0.0814, 0.0, 0.0032], "inertia": _diagonal(0.6, 15.27, 15.32), "color": "#9fb3c8",
        "shapes": _torpedo(2.0, 0.11, 1.2), "notes": "All that does not move, and all displaced water.",
    }  # fmt: skip
    ballast = {
        "kind": "rigid", "name": "Ballast", "mass": 0.3, "volume": 0.0, "position": [0.0, 0.0, 0.0], "color": "#4fc3a1",
        "shapes": [{"kind": "cylinder", "length": 0.12, "radius": 0.05}],
        "notes": "Net heaviness.",
    }  # fmt: skip
    added = [[0.0] * 6 for _ in range(6)]
    for i, value in enumerate((1.48, 49.58, 65.92, 0.53, 7.88, 10.18)):
        added[i][i] = value
    added[1][5] = added[5][1] = 3.61
    added[2][4] = added[4][2] = 2.57
    source = "Zhang et al., 2013: viscous coefficients; the Munk moment comes from the added mass in addition."
    return _document(
        "Seawing in a spiral", SEAWING_NOTE,
        {
            "components": [static, battery, ballast],
            "hydrodynamics": {
                "kind": "coefficients", "provenance": {"title": "Seawing, Zhang et al. 2013", "source": source},
                "reference_density": SEAWATER, "includes_munk_moment": False, "rate_scaling": "speed_squared",
                "alpha_limit_deg": 15.0, "beta_limit_deg": 15.0,
                "drag_zero": 7.19, "drag_attack": 386.29, "side_sideslip": -115.65, "lift_zero": -0.36,
                "lift_attack": 440.99, "roll_sideslip": -58.27, "roll_rate": -19.83, "pitch_zero": 0.28,
                "pitch_attack": -65.84, "pitch_rate": -205.64, "yaw_sideslip": 34.1, "yaw_rate": -389.3,
            },
            "added_mass": {"matrix": added, "density": SEAWATER, "source": "Zhang et al., 2013, M_A, I_A and C_A."},
        },
        {
            "environment": {"water": {"kind": "uniform", "density": SEAWATER}, "gravity": 9.81},
            "initial": {
                "position": [0.0, 0.0, 5.0], "pitch": math.radians(-35.0), "velocity": [0.45, 0.0, 0.01],
                "extensions": {"Battery": turned},
            },
            "duration": 1800.0,
            "solver": {"model": "spatial", "output_interval": 1.0},
        },
    )  # fmt: skip


def slocum() -> dict[str, Any]:
    """Return the Slocum-like glider of Graver (2005) in its steady glide at -25 deg."""
    hull = {
        "kind": "rigid", "name": "Hull", "mass": 40.0, "volume": 50.0 / SEAWATER, "position": [0.0, 0.0, 0.0],
        "inertia": _diagonal(4.0, 12.0, 11.0), "color": "#9fb3c8", "shapes": _torpedo(1.5, 0.107, 1.0),
        "notes": "Uniformly distributed mass; all displaced water.",
    }  # fmt: skip
    ballast = {
        "kind": "rigid", "name": "Ballast", "mass": 1.04732, "volume": 0.0, "position": [0.0, 0.0, 0.0],
        "color": "#4fc3a1", "shapes": [{"kind": "cylinder", "length": 0.12, "radius": 0.05}],
        "notes": "Variable ballast for 0.3 m/s at -25 deg, by Graver's closed form.",
    }  # fmt: skip
    slide = {
        "kind": "movable_mass", "name": "Movable mass", "mass": 9.0, "position": [0.0, 0.0, 0.05],
        "axis": [1.0, 0.0, 0.0], "extension_range": [-0.05, 0.05], "neutral_extension": 0.0, "rate_limit": 0.005,
        "color": "#f2b134", "shapes": [{"kind": "cylinder", "length": 0.3, "radius": 0.05}],
    }  # fmt: skip
    added = [[0.0] * 6 for _ in range(6)]
    for i, value in enumerate((5.0, 60.0, 70.0)):
        added[i][i] = value
    source = "Graver, 2005: viscous coefficients; the Munk moment comes from the added mass in addition."
    return _document(
        "Slocum in a steady glide", SLOCUM_NOTE,
        {
            "components": [hull, ballast, slide],
            "hydrodynamics": {
                "kind": "coefficients", "provenance": {"title": "Slocum, Graver 2005", "source": source},
                "reference_density": SEAWATER, "rate_scaling": "speed_squared", "alpha_limit_deg": 15.0,
                "drag_zero": 2.15, "drag_attack": 25.0, "lift_zero": 0.0, "lift_attack": 132.5,
                "pitch_zero": 0.0, "pitch_attack": -100.0, "pitch_rate": -50.0, "pitch_rate_square": -50.0,
            },
            "added_mass": {"matrix": added, "density": SEAWATER, "source": "Graver, 2005, m_f1 to m_f3."},
        },
        {
            "environment": {"water": {"kind": "uniform", "density": SEAWATER}, "gravity": 9.816},
            "initial": {
                "position": [0.0, 0.0, 2.0], "pitch": math.radians(-22.9773), "velocity": [0.29, 0.0, 0.01],
                "extensions": {"Movable mass": 0.019831},
            },
            "duration": 300.0,
            "solver": {"output_interval": 0.25},
        },
    )  # fmt: skip
