"""Owns the runs that docs/quad_glider.md tells of, and what is computed from them.

Every variant is the preset of models/presets/quad_glider.py with one thing changed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from docs.formatting import num, signed
from models.design import Design, parse_design
from models.mass_properties import MassBalance, mass_balance
from models.presets import quad_glider as glider
from models.presets import quad_hydrodynamics as water
from models.presets import strip_theory as strips
from models.run import Run
from models.simulate import simulate
from models.water import density_at, gravity_of

Array = NDArray[np.complex128]
DENSE = 1000.0
"""Density by which forces of the cells are told, kg/m3."""
STEADY = {"glide": 300.0, "spiral": 800.0, "twin": 800.0}
"""Instants at which the motion is steady, s."""
STRAIGHT = 119.0
"""Instant at which the spiral and the twin still go straight, s."""
MOTION = ("", "Pitch", "α", "V, m/s", "Down, m/s", "Path", "Bank", "β", "Radius, m", "Turn, deg/s")
"""Header of a table of motions."""


def degrees(value: float, digits: int = 0) -> str:
    """Return an angle in rad as degrees."""
    return f"{num(math.degrees(value), digits)}°"


@cache
def run(name: str) -> Run:
    """Return the run of a mission, or of the twin."""
    return simulate(parse_design(glider.movable_mass_twin() if name == "twin" else glider.quad_glider(name)))


def at(name: str, time: float) -> dict[str, float]:
    """Return the variables of a run at an instant."""
    r = run(name)
    k = int(np.searchsorted(r.times, time - 1e-9))
    return {key: float(column[k]) for key, column in r.values.items()}


def design() -> Design:
    """Return the glider on its straight glide."""
    return run("glide").design


def lake() -> tuple[float, float, float, float]:
    """Return the densities at the surface and at the working depth (kg/m3), gravity, and the pressure there (Pa)."""
    environment = design().mission.environment
    levels = np.linspace(0.0, glider.LAKE_DEPTH, 401)
    density, g = density_at(environment.water, levels), gravity_of(environment)
    return float(density[0]), float(density[-1]), g, g * float(np.trapezoid(density, levels))


def neutral() -> MassBalance:
    """Return how the glider weighs and floats with its cells at neutral."""
    return mass_balance(design().vehicle)


def modes(name: str, time: float, *, fin: bool) -> Array:
    """Return the lateral eigenvalues about a straight glide, with or without the fin in all its effects."""
    state, r = at(name, time), run(name)
    k = int(np.searchsorted(r.times, time - 1e-9))
    balance = mass_balance(r.design.vehicle, dict(zip(r.cells, r.cell_values["extension"][k].tolist(), strict=True)))
    g, m, center = lake()[2], balance.mass, balance.center_of_mass
    S = np.array([[0.0, -center[2], center[1]], [center[2], 0.0, -center[0]], [-center[1], center[0], 0.0]])
    rigid = np.block([[m * np.eye(3), -m * S], [m * S, balance.inertia_about_origin]])
    lift = m * g + state["net_buoyancy"]
    arm = (m * g * state["com_x"] - lift * state["cob_x"], m * g * state["com_z"] - lift * state["cob_z"])
    keep = [name for name in ("fin", "hull", "core sampler", "wing") if fin or name != "fin"]
    parts = water.lateral_parts()
    total = {f"{f}_{b}": math.fsum(parts[n].get(f"{f}_{b}", 0.0) for n in keep) for f in "YKN" for b in "bpr"}
    added = sum((A for n, A in water.added_mass_parts().items() if fin or n != "fin"), start=np.zeros((6, 6)))
    damping = np.diag([0.0, 0.0, 0.0, *(water.damping()[axis] for axis in ("roll", "pitch", "yaw"))])
    matrix = strips.lateral_matrix(
        rigid + added, total, damping, velocity=(state["u"], state["w"]), pitch=state["theta"],
        heaviness=-state["net_buoyancy"], arm=arm,
    )  # fmt: skip
    return np.sort_complex(np.linalg.eigvals(matrix).astype(complex))


def lost_height() -> float:
    """Return how much the rolling ballast takes off the metacentric height, m."""
    angle = float(run("twin").cell_values["extension"][-1, run("twin").cells.index("Lower ballast")])
    mass, arm = glider.LEAD["mass"], glider.LEAD["position"][2]
    return float(mass * arm * (1.0 - math.cos(angle)) / neutral().mass)


def twin_inertia() -> float:
    """Return the twin's moment of inertia in yaw, kg m2."""
    return float(mass_balance(run("twin").design.vehicle).inertia[2, 2])


def rest_angles() -> tuple[float, float]:
    """Return the pitch and the bank at which weight and buoyancy balance the turning dive's differences, rad."""
    weight, lever = neutral().mass * glider.METACENTRIC_HEIGHT, 4e-6 * DENSE
    pitch = -math.atan(lever * glider.TURN[1] * water.RING_X / weight)
    return pitch, math.atan(lever * glider.BANK * glider.CELL_Y / weight)


def variant(body_factor: float, roll: float, height: float) -> dict[str, Any]:
    """Return the spiral with another end-plate effect, roll damping of the wing, and height of the centre of mass."""
    document = glider.quad_glider("spiral")
    parts = dict(water.lateral_parts())
    parts["fin"] = strips.fin_coefficients(water.FIN, density=water.DENSITY, body_factor=body_factor)
    parts["wing"] = parts["wing"] | {"K_p": roll * parts["wing"]["K_p"]}
    lateral = document["vehicle"]["hydrodynamics"]["lateral"]
    for target, fields in ((lateral, water.FIELDS), (lateral["rates"], water.RATE_FIELDS)):
        target |= {field: math.fsum(p.get(symbol, 0.0) for p in parts.values()) for symbol, field in fields.items()}
    ballast = document["vehicle"]["components"][-1]
    ballast["position"][2] += height * neutral().mass / ballast["mass"]
    return document


def roots(values: Array) -> str:
    """Return eigenvalues as text, a conjugate pair as one."""
    texts = []
    for value in values:
        if value.imag > 1e-9:
            texts.append(f"{num(value.real, 2)} ± {num(value.imag, 2)} i")
        elif value.imag > -1e-9:
            texts.append(signed(value.real, 2))
    return ", ".join(texts)


def lift_terms() -> tuple[float, float]:
    """Return what the wing's K_r and N_p, which are left out, would be in the spiral as shares of K_p p and N_r r."""
    state, total = at("spiral", STEADY["spiral"]), water.lateral_totals()
    lift = strips.helmbold_slope(water.SPAN / water.CHORD) * state["alpha"]
    K_r = DENSE * water.CHORD * lift * water.SPAN**3 / 12.0
    roll = K_r * state["r"] / (water.lateral_parts()["wing"]["K_p"] * state["p"])
    return abs(roll), abs(0.5 * K_r * state["p"] / (total["N_r"] * state["r"]))


def mission_row(label: str, state: Mapping[str, float]) -> tuple[str, ...]:
    """Return the row of a table of motions."""
    turning = abs(state["phi"]) > 1e-3
    return (
        label, degrees(state["theta"], 1), degrees(state["alpha"], 1), num(state["speed"], 3), num(state["z_dot"], 3),
        degrees(math.atan2(-state["z_dot"], math.hypot(state["x_dot"], state["y_dot"])), 0),
        degrees(state["phi"], 1), degrees(state["beta"], 1), num(abs(state["turn_radius"]), 1) if turning else "",
        num(math.degrees(state["turn_rate"]), 2) if turning else "",
    )  # fmt: skip


def twin_rows() -> list[tuple[str, ...]]:
    """Return the motions of both gliders."""
    names = (("quad", "spiral"), ("twin", "twin"))
    straight = [mission_row(f"{label}, straight", at(name, STRAIGHT)) for label, name in names]
    return straight + [mission_row(f"{label}, turning", at(name, STEADY[name])) for label, name in names]


def varied_rows() -> list[tuple[str, ...]]:
    """Return the motion in the spiral with one uncertain thing changed at a time."""
    rows = [mission_row("as above", at("spiral", STEADY["spiral"]))]
    for label, fin, roll, height in (
        ("fin as a free panel (1 instead of 1.5)", 1.0, 1.0, 0.0),
        ("fin on a plane wall (2)", 2.0, 1.0, 0.0),
        ("the wing's K_p less 30 %", water.BODY_FACTOR, 0.7, 0.0),
        ("the wing's K_p plus 30 %", water.BODY_FACTOR, 1.3, 0.0),
        ("centre of mass 1 mm higher", water.BODY_FACTOR, 1.0, -0.001),
        ("centre of mass 1 mm lower", water.BODY_FACTOR, 1.0, 0.001),
    ):
        r = simulate(parse_design(variant(fin, roll, height)))
        k = int(np.searchsorted(r.times, STEADY["spiral"] - 1e-9))
        rows.append(mission_row(label, {name: float(column[k]) for name, column in r.values.items()}))
    return rows
