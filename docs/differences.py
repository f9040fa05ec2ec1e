"""Owns section 1 and 2 of docs/paper.md: the paper's model, where we differ, and by how much in numbers."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from docs.formatting import markdown_table, num, percent, signed
from docs.printed_model import RUNAWAY, Forms, PrintedModel, generalized_force
from docs.studies import (
    DEEP,
    body_volume_as_printed,
    case_of_glide,
    center_of_mass,
    deep,
    edited,
    force_law,
    preset,
    preset_run,
    table,
)
from models.components import Bellows
from models.design import DeclaredMass
from models.hydrodynamic_law import DEGREES, QUANTITIES, HydrodynamicLaw, build_law, coefficients_by_speed, select_data
from models.mass_properties import mass_balance
from models.simulate import simulate

Array = NDArray[np.float64]

LOW_CENTER = 0.5e-3
"""A centre of mass so little below the centre of buoyancy that the glider loops, m."""
EQUATIONS = (
    ("1, 2", "body to world by R(θ) = [[c, s], [−s, c]]", "as printed"),
    ("3, 4", "T of one mass M, I at (l_gx, l_gz); U of weight and one buoyancy force a component",
     "as printed in the preset (*declared* mass); *composite* mass sums T over the components"),
    ("5", "M(q) q″ + V(q, q′) + C q′ + G(q) = Q",
     "as printed but for τ_bx; any number of components; solved in body axes"),
    ("6, 7", "Q from lift, drag and moment", "R(θ) of Eq. 2 as the first matrix"),
    ("8", "forces go with V²", "as printed; S and the coefficients are not needed, as the paper says"),
    ("9, 10", "volume of a bellows", "Eq. 9 as printed, Eq. 10 with the height of one frustum"),
    ("11, 12", "α and V² from the velocity", "Eq. 12 as printed, Eq. 11 with atan2"),
)  # fmt: skip
"""The paper's equations, and what became of each."""


def model_section() -> str:
    """Say what the paper's model is and where we take it over."""
    declared = preset().vehicle.mass_properties
    assert isinstance(declared, DeclaredMass)
    balance, environment = mass_balance(preset().vehicle), preset().mission.environment
    l_gx, _, l_gz = declared.center_of_mass
    body = preset().vehicle.components[0]
    cells = balance.volume - (body.volume if body.kind == "rigid" else 0.0)
    rows = [
        ("M", "kg", num(declared.mass, 3), "as printed"),
        ("I", "kg m²", num(declared.inertia.yy, 3), "as printed; about the centre of mass"),
        ("l_gx, l_gz", "m", ", ".join((num(l_gx, 0), num(l_gz, 3))), "as printed"),
        ("V₀", "m³", f"{num(1e3 * balance.volume, 3)} × 10⁻³",
         f"as printed for the sum: body {num(1e6 * (balance.volume - cells), 1)} cm³, "
         f"cells at neutral {num(1e6 * cells, 1)} cm³"),
        ("C₃₃", "N m s", num(preset().vehicle.damping.pitch, 3),
         "as printed (Table I names a \"wheel axis\"; read as pitch damping)"),
        ("g", "m/s²", num(environment.gravity, 1), "as printed"),
        ("ρ", "kg/m³", num(environment.water.density, 0), "ours: M / V₀ of Table II"),
    ]  # fmt: skip
    return f"""## 1. The model

The paper derives Euler-Lagrange equations of a rigid body in the vertical plane, q = [x, z, θ], z down, pitch
positive nose up. Followed as printed, unless section 2 says otherwise:

{markdown_table(("Equations", "What they say", "Here"), EQUATIONS, left=3)}

The mass, its centre and the inertia are frozen while a cell moves, volumes and centres of buoyancy are not: so in the
paper, so in the preset. The design also offers what the paper leaves out (composite mass, actuator rate and lag, added
mass, density and bed); the preset has all of it off.

### Parameters (Table II)

{markdown_table(("Symbol", "Unit", "Preset", "Against the paper"), rows, left=4)}
"""


def _rotation_numbers() -> dict[str, str]:
    """Compare the water's power along our path under either first matrix of Eq. 7."""
    d = preset_run().data
    columns = ("x", "z", "theta", "x_dot", "z_dot", "q")
    states = np.array([d[name].values for name in columns]).T[1:]
    law = build_law(table())
    power = {
        form: np.array([generalized_force(q, law, Forms(rotation=form))[:2] @ q[3:5] for q in states])
        for form in (False, True)
    }
    drag_power = (d["drag"] * d["speed"]).values[1:]
    worst = int(np.argmax(power[True] / drag_power))
    glide = case_of_glide("", PrintedModel(edited(deep), Forms(rotation=True)).glide())
    return {
        "share": percent(float(np.mean(power[True] > 0.0))),
        "ratio": signed(float(power[True][worst] / drag_power[worst]), 1),
        "here": signed(float(np.max(power[False] / drag_power)), 0),
        "at": num(float(d["time"][1 + worst]), 0),
        "end": num(float(glide.time[-1]), 1),
    }


def _arctangent_numbers() -> dict[str, str]:
    """Say when the glider moves backward, and what drag does then by the printed Eq. 11."""
    ahead = float(preset_run().data["x_dot"].min())
    d = simulate(edited(deep, center_of_mass(LOW_CENTER))).data
    backward = d["x_dot"].values < 0.0
    columns = ("x", "z", "theta", "x_dot", "z_dot", "q")
    states = np.array([d[name].values for name in columns]).T[backward]
    law = build_law(table())
    printed = np.array([generalized_force(q, law, Forms(arctangent=True))[:2] @ q[3:5] for q in states])
    ratio = np.mean(printed / (d["drag"] * d["speed"]).values[backward])
    return {
        "ahead": num(1e3 * ahead, 0),
        "share": percent(float(backward.mean())),
        "l_gz": num(1e3 * LOW_CENTER, 1),
        "ratio": signed(float(ratio), 0),
    }


def _cell_numbers() -> dict[str, str]:
    """Compare volumes and forces of the cells by Eq. 10 and Table II."""
    cell = next(c for c in preset().vehicle.components if isinstance(c, Bellows))
    environment = preset().mission.environment
    weight_per_volume = environment.water.density * environment.gravity
    command = preset().mission.control.schedules[0].points[0].extension - cell.neutral
    heavy = simulate(edited(body_volume_as_printed))
    body = preset().vehicle.components[0]
    force_body = weight_per_volume * (body.volume if body.kind == "rigid" else 0.0)
    force_cell = weight_per_volume * (cell.core_volume + cell.section * cell.neutral)
    stroke = cell.stroke[1] - cell.stroke[0]
    return {
        "section": num(1e6 * cell.section, 0),
        "section_printed": num(1e6 * cell.model_copy(update={"as_printed": True}).section, 0),
        "stroke": num(1e3 * stroke, 0),
        "force": num(weight_per_volume * cell.section * stroke, 2),
        "travel": signed(1e3 * command, 1),
        "change": signed(weight_per_volume * cell.section * command, 2),
        "change_printed": signed(2.0 * weight_per_volume * cell.section * command, 2),
        "excess": signed(float(heavy.data["net_buoyancy"][-1]), 1),
        "surface": num(float(heavy.data["time"][-1]), 1),
        "start": num(float(heavy.data["z"][0]), 1),
        "slip": num(force_body - force_cell, 1),
        "pitching": num(1e3 * abs(weight_per_volume * cell.section * command) * abs(cell.position[0]), 1),
    }


def _center_numbers() -> tuple[str, str]:
    moving, fixed = (PrintedModel(edited(deep), Forms(fixed_centers=fixed)).glide() for fixed in (False, True))
    pitches = (case_of_glide("", glide).at(6.0) for glide in (moving, fixed))
    first, second = (num(sample.pitch, 1) for sample in pitches if sample is not None)
    return first, second


def differences_section(printed_rows: str) -> str:
    """Say where we differ from the print, why, and what it does."""
    turned, back, cell, (moving, fixed) = _rotation_numbers(), _arctangent_numbers(), _cell_numbers(), _center_numbers()
    rows = [
        ("Eq. 5, τ_bx", "−F_b1 l_b0x − …", "−F_b0 l_b0x − …",
         "Each force acts at its own arm; it follows from Eq. 4.",
         f"none in the preset, where l_b0x = 0. Each millimetre of l_b0x would misplace {cell['slip']} mN m; the whole "
         f"command of the front cell is {cell['pitching']} mN m"),
        ("Eqs. 6, 7, first matrix", "[[c, −s], [s, c]]", "R(θ) = [[c, s], [−s, c]]",
         "With Eqs. 2 and 11 the product must be the rotation by the flow angle, else drag does not oppose the motion.",
         f"along our path the power of lift and drag over F_D V is {turned['here']} at every instant; as printed it "
         f"reaches {turned['ratio']} (at {turned['at']} s) and is positive {turned['share']} of the time. The glide "
         f"runs away: {num(RUNAWAY, 0)} m/s at {turned['end']} s"),
        ("Eq. 11", "arctan(z′/x′)", "atan2(z′, x′), wrapped",
         "The arctangent takes backward motion for forward motion.",
         f"none in the preset, where x′ never falls below {back['ahead']} mm/s. With l_gz = {back['l_gz']} mm the "
         f"glider moves backward {back['share']} of the time, and there drag as printed drives it: power over F_D V "
         f"{back['ratio']}"),
        ("Eqs. 9, 10", "l_d = L_total / m_p, 2 m_p frustums", "l_d = stroke / (2 m_p)",
         "The stack must grow by its stroke.",
         f"dV/de {cell['section']} → {cell['section_printed']} mm² as printed: the same {cell['travel']} mm give "
         f"{cell['change_printed']} N instead of {cell['change']} N (option `as_printed`)"),
        ("Table II, V₀", "M / ρ, the cells on top", "M / ρ with the cells at neutral extension",
         "Only changes from neutral may unbalance a glider that dives and climbs.",
         f"as printed, the stand-in's cells add {cell['excess']} N: it surfaces from {cell['start']} m in "
         f"{cell['surface']} s"),
    ]  # fmt: skip
    return f"""## 2. Where we differ from the print

{markdown_table(("Where", "Printed", "Here", "Why", "Effect"), rows, left=5)}

![Forms as the paper prints them](img/paper-printed.svg)

*Figure 1. One printed form at a time, from {num(DEEP, 0)} m depth; a cross marks where a run ended early (at the
surface, or above {num(RUNAWAY, 0)} m/s).*

{printed_rows}

Centres of buoyancy move with half the growth of a stack, as section II.A of the paper asks for without giving a rule.
Held fixed, the pitch at 6 s would be {fixed}° instead of {moving}°.
"""


def _law(name: str) -> HydrodynamicLaw:
    return build_law(edited(force_law(name, None)).vehicle.hydrodynamics)


def _least_squares(x: Array, y: Array, powers: NDArray[np.int64]) -> Polynomial:
    solution = np.linalg.lstsq(x[:, None] ** powers, y, rcond=None)[0]
    full = np.zeros(int(powers.max()) + 1)
    full[powers] = solution
    return Polynomial(full)


def law_section() -> str:
    """Say how the forces depend on the angle of attack by the paper's polynomials and by PCHIP, and how well."""
    angles, mean = select_data(table())
    lift, drag = mean[0], mean[1]
    laws = {name: _law(name) for name in ("pchip", "polynomial")}
    raw = _least_squares(angles, lift, np.arange(1, DEGREES["lift"] + 1))
    odd = _least_squares(angles, lift, np.arange(1, DEGREES["lift"] + 1, 2))
    free = _least_squares(angles, lift, np.arange(0, DEGREES["lift"] + 1))
    miss = float(np.abs(odd(angles) - lift).max() / np.ptp(lift))
    kink = 2.0 * float(PchipInterpolator(angles, drag).derivative()(0.0))
    grid = np.linspace(-np.pi, np.pi, 7201)
    lowest = {
        name: (float(law(grid)[1].min()), float(np.degrees(abs(grid[law(grid)[1].argmin()]))))
        for name, law in laws.items()
    }
    units = {"lift": "N s²/m²", "drag": "N s²/m²", "moment": "N m s²/m²"}
    rows = []
    for j, quantity in enumerate(QUANTITIES):
        digits = 3 if quantity == "moment" else 2
        spread = np.ptp([values[j] for _, values in coefficients_by_speed(table()).values()], axis=0)
        error = laws["polynomial"].errors[j]
        through = laws["pchip"].errors[j]
        rows.append((
            quantity, units[quantity], str(DEGREES[quantity]), num(error.range, digits), num(error.rms, digits),
            f"{num(error.largest, digits)} at {num(error.largest_at_deg, 0)}°", percent(error.relative, 1),
            num(through.largest, digits), num(float(spread.max()), digits),
        ))  # fmt: skip
    header = ("Per V²", "Unit", "Degree", "Range of data", "RMS error", "Largest error", "of range",
              "PCHIP, largest", "Spread of speeds, largest")  # fmt: skip
    start = ", ".join(
        f"{num(values[1][0], 2)} at {v:g} m/s" for v, (_, values) in coefficients_by_speed(table()).items()
    )
    speeds = preset_run().data["speed"].values
    return f"""## 3. Forces over the angle of attack (the paper's Fig. 5)

The data are **not the paper's**: {table().provenance.title}. {table().provenance.limits}

![Lift, drag and moment per squared speed](img/paper-forces.svg)

*Figure 2. Force and moment per squared speed: all runs, their mean over the speeds, and both laws.*

The paper fits polynomials of degree {DEGREES["lift"]} (lift), {DEGREES["drag"]} (drag) and {DEGREES["moment"]}
(moment) to data on 0° to 90° and states the mirror symmetry (lift and moment odd, drag even). We read it so: all
powers of |α|, the constants of lift and moment zero, used on 0° to 90° only, mirrored by sign, and past 90°
reflected to 180° − |α| (drag and moment keep their value, lift changes sign). The text names
Fig. 5 b, d and e as the data of the fits; e must be f. The alternatives fail:

- odd powers alone miss the lift by {percent(miss)} of its range;
- a free constant gives a lift of {num(float(free(0.0)), 2)} N s²/m² at 0°;
- past 90° the raw polynomial gives a lift of {num(float(raw(np.pi)), 0)} N s²/m² at 180°.

The default is PCHIP through the data mirrored to the whole circle, with L(0) = L(90°) = M(0) = 0 exactly. Built on
0° to 90° alone it would give the drag a kink of {num(kink, 1)} N s²/m² per rad at 0°.

{markdown_table(header, rows, left=2)}

PCHIP misses only the points that symmetry moves to zero. Drag stays positive under both laws: its least value is
{num(lowest["pchip"][0])} N s²/m² (PCHIP, at {num(lowest["pchip"][1], 0)}°) and {num(lowest["polynomial"][0])} N s²/m²
(polynomials, at {num(lowest["polynomial"][1], 0)}°); assembly refuses a law whose drag is not positive.

The preset glides at {num(float(speeds.mean()), 2)} m/s in the mean and {num(float(speeds.max()), 2)} m/s at most,
below the slowest run of the data. Drag at 0° rises as speed falls ({start} N s²/m²): squared-speed forces understate
friction here.
"""
