"""Owns the shape of the quad-bellows lake glider and the forces of the water on it, scaled and built up from it.

Hull, wing and forces are the stand-in of the paper's glider (data/standin_*.csv, .json) scaled by `SCALE`; fin and core
sampler are added by `strip_theory`. Body axes with the origin at mid-length, SI units.
"""

from __future__ import annotations

import json
import math
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.hydrodynamics import PolarTable, Provenance
from models.polar_csv import read_polar_csv
from models.presets import strip_theory as strips
from models.presets.strip_theory import Bar, Fin
from models.presets.words import prose

Array = NDArray[np.float64]
DATA = files("models").joinpath("data")

SCALE = 10.0 / 3.0
"""Length over that of the stand-in: makes the hull 2.000 m and the displacement about 30 kg."""
DENSITY, VISCOSITY, CRUISE = 1000.0, 1e-6, 0.30
"""Reference density (kg/m3) and viscosity (m2/s) of all coefficients, and the speed taken for friction (m/s)."""
LENGTH, RADIUS, NOSE, TAIL = (SCALE * x for x in (0.600, 0.01603, 0.060, 0.100))
SPAN, CHORD, PLATE, WING_X = (SCALE * x for x in (0.500, 0.100, 0.004, -0.020))
RING_RADIUS, RING_LENGTH, RING_X = (SCALE * x for x in (0.024, 0.080, 0.180))
"""The scaled stand-in's two bellows around the hull, which are the ones that the CFD knows."""
CELL_RADIUS = math.sqrt((RING_RADIUS**2 - RADIUS**2) / 2.0)
"""Two cells side by side have the frontal area and the volume of the ring that they replace."""
FIN = Fin(span=0.26, chord=0.22, tip_chord=0.16, sweep=0.06, thickness=0.008, leading_x=-0.76, root_z=-0.045)
BODY_FACTOR = 1.5
"""End-plate effect of the hull's tail on the fin, between 1 (none) and 2 (plane wall)."""
SAMPLER = Bar(length=0.40, diameter=0.060, x=0.35, z=0.090)
SWING = 0.05
"""Amplitude at which quadratic damping in turning is made linear, rad/s."""

FIELDS = {
    "Y_b": "sway_sideslip", "Y_bb": "sway_crossflow", "K_b": "roll_sideslip", "K_bb": "roll_crossflow",
    "N_b": "yaw_sideslip", "N_bb": "yaw_crossflow",
}  # fmt: skip
RATE_FIELDS = {
    "Z_q": "heave_pitch", "M_q": "pitch_pitch", "Y_p": "sway_roll", "Y_r": "sway_yaw", "K_p": "roll_roll",
    "K_r": "roll_yaw", "N_p": "yaw_roll", "N_r": "yaw_yaw",
}  # fmt: skip


def tidy(value: float) -> float:
    """Return a number with six digits, so that the file is readable and the same on every machine."""
    return float(f"{value:.6g}")


def standin() -> PolarTable:
    """Return the stand-in's CFD table as it was computed, at its own size."""
    about = json.loads(DATA.joinpath("standin_kepsilon.json").read_text())
    provenance = Provenance.model_validate(about["provenance"])
    return read_polar_csv(DATA.joinpath("standin_kepsilon.csv"), provenance=provenance)


def lateral_parts() -> dict[str, dict[str, float]]:
    """Return every lateral coefficient, by the part of the glider that makes it and by symbol, at `DENSITY`."""
    side, first = strips.hull_side(LENGTH, RADIUS, NOSE, TAIL)
    bar = SAMPLER.length * SAMPLER.diameter
    across = {"drag": strips.CYLINDER_CROSSFLOW, "density": DENSITY}
    profile = 2.0 * strips.friction(CRUISE * CHORD / VISCOSITY)
    return {
        "fin": strips.fin_coefficients(FIN, density=DENSITY, body_factor=BODY_FACTOR),
        "hull": strips.crossflow(side, first, 0.0, **across),
        "core sampler": strips.crossflow(bar, bar * SAMPLER.x, bar * SAMPLER.z, **across),
        "wing": {
            **strips.wing_pitch_rate(SPAN, CHORD, WING_X, density=DENSITY),
            "K_p": strips.wing_roll_damping(SPAN, CHORD, density=DENSITY),
            "N_r": strips.wing_yaw_damping(SPAN, CHORD, drag=profile, density=DENSITY),
        },
    }


def lateral_totals() -> dict[str, float]:
    """Return the lateral coefficients of the whole glider by symbol."""
    parts = lateral_parts().values()
    return {name: math.fsum(p.get(name, 0.0) for p in parts) for name in (*FIELDS, *RATE_FIELDS)}


def lateral() -> dict[str, Any]:
    """Return the lateral coefficients as the design holds them."""
    total = lateral_totals()
    rates = {field: tidy(total[symbol]) for symbol, field in RATE_FIELDS.items()}
    return {
        "source": prose("""
            Computed by models/presets/strip_theory.py from the geometry; docs/quad_glider.md derives each. Fin: lift
            slope by Helmbold (1942) on strips; hull and core sampler: cross-flow principle (Hoerner, 1965); the wing in
            roll: lifting line (Glauert, 1926), and in pitch: three-quarter-chord theorem. Meant for sideslips up to
            some 15 deg. What the wing does in proportion to its lift (K_r, N_p) is left out, for it changes sign
            between dive and climb; so is all mutual interference.
        """),
        "includes_munk_moment": False,
        **{field: tidy(total[symbol]) for symbol, field in FIELDS.items()},
        "rates": {"scaling": "speed", **rates},
    }


def polar() -> dict[str, Any]:
    """Return the scaled table with the drag of fin and core sampler.

    At equal Reynolds number rho V^2 L^2 is the same, so each row keeps its forces at a speed `SCALE` times lower, and
    its moment grows by `SCALE`: forces per squared speed grow by its square, moments by its cube.
    """
    table = standin()
    speed, alpha = np.array(table.row_speed) / SCALE, np.radians(table.row_alpha_deg)
    added = strips.bar_forces(SAMPLER, alpha, density=DENSITY)
    added[1] += strips.fin_drag(FIN, speed=CRUISE, density=DENSITY, viscosity=VISCOSITY)
    measured = np.array([table.row_lift, table.row_drag, np.array(table.row_moment) * SCALE])
    rows = measured + added * speed**2
    return {
        "kind": "polar_table",
        "provenance": {
            "title": "Stand-in CFD scaled to 2 m, with fin and core sampler added",
            "source": prose(f"""
                Scaled geometrically by {SCALE:.4f} at equal Reynolds number: forces at a speed lower by the scale,
                moments times the scale; fin and core sampler added by models/presets/strip_theory.py.
                {table.provenance.source}"""),
            "limits": prose(f"""
                The glider sails at two to three times the Reynolds number of the fastest rows, which are used. Its four
                cells beside the hull have the frontal area and volume of the CFD's two around it, not their place.
                {table.provenance.limits}"""),
        },
        "speed": tidy(max(table.row_speed) / SCALE),
        "includes_munk_moment": True,
        "row_speed": [tidy(v) for v in speed],
        "row_alpha_deg": list(table.row_alpha_deg),
        **{f"row_{name}": [tidy(x) for x in row] for name, row in zip(("lift", "drag", "moment"), rows, strict=True)},
        "lateral": lateral(),
    }  # fmt: skip


def added_mass_parts() -> dict[str, Array]:
    """Return the added mass by part: the scaled stand-in's with wing (L^3, L^4, L^5 by block), fin, core sampler."""
    about = json.loads(DATA.joinpath("standin_added_mass.json").read_text())
    lengths = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    scaled = np.array(about["matrix"], dtype=float) * SCALE ** (3.0 + np.add.outer(lengths, lengths))
    return {
        "hull, wing and ring cells": scaled,
        "fin": strips.fin_added_mass(FIN, density=DENSITY),
        "core sampler": strips.bar_added_mass(SAMPLER, density=DENSITY),
    }


def added_mass() -> dict[str, Any]:
    """Return the added mass as the design holds it."""
    matrix = sum(added_mass_parts().values(), start=np.zeros((6, 6)))
    source = prose("""
        The stand-in's boundary-element matrix scaled by L^3, L^4 and L^5 in its blocks, plus fin and core sampler by
        strips (models/presets/strip_theory.py). The fin resists sway, roll and yaw, and couples them.
    """)
    return {"matrix": [[tidy(x) for x in row] for row in matrix], "density": DENSITY, "source": source}


def damping() -> dict[str, Any]:
    """Return linear damping for turning at rest, where the terms that go with speed are zero."""
    cylinder, plate = strips.CYLINDER_CROSSFLOW, strips.PLATE_CROSSFLOW
    half = 0.5 * LENGTH
    hull = strips.strip_moment_damping(2.0 * RADIUS, (-half, half), drag=cylinder, density=DENSITY)
    wing = strips.strip_moment_damping(CHORD, (-0.5 * SPAN, 0.5 * SPAN), drag=plate, density=DENSITY)
    return {
        "roll": tidy(strips.linearised(wing, SWING)),
        "pitch": tidy(strips.linearised(hull, SWING)),
        "yaw": tidy(strips.linearised(hull, SWING)),
    }
