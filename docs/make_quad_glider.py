"""Writes docs/quad_glider.md: `python -m docs.make_quad_glider`. Every number in it is computed here.

Numbers are printed with so few digits that the rounding of another processor does not reach them.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from docs.formatting import bound, markdown_table, num, page_of, percent, signed
from docs.quad_studies import (
    DENSE,
    MOTION,
    STEADY,
    STRAIGHT,
    at,
    degrees,
    design,
    lake,
    lift_terms,
    lost_height,
    mission_row,
    modes,
    neutral,
    rest_angles,
    roots,
    run,
    twin_inertia,
    twin_rows,
    varied_rows,
)
from models.presets import quad_glider as glider
from models.presets import quad_hydrodynamics as water
from models.presets import strip_theory as strips

DOCS = Path(__file__).parent
ANGLES = (0.0, 5.0, 10.0, 15.0)
PAPER_CELL_FORCE = 0.4
"""What one of the paper's bellows makes over its stroke, N (its section I.B)."""
ACRYLIC = {"young": 3.0e9, "poisson": 0.37}
"""Young's modulus (Pa) and Poisson's ratio."""


def geometry_section() -> str:
    """Give sizes, weights and the balance."""
    s, fin, bar = water.SCALE, water.FIN, water.SAMPLER
    scaled = f"stand-in × {num(s, 2)}"
    rows = [
        ("Hull of revolution", f"{num(water.LENGTH, 3)} m long, {num(2e3 * water.RADIUS, 0)} mm across", scaled),
        ("Wing", f"span {num(water.SPAN, 2)} m, chord {num(water.CHORD, 3)} m, {num(1e3 * water.PLATE, 0)} mm thick, "
         f"at x = {num(water.WING_X, 3)} m", scaled),
        ("Four cells", f"{num(1e3 * water.RING_LENGTH, 0)} mm long, {num(2e3 * water.CELL_RADIUS, 0)} mm across, "
         f"at x = ±{num(water.RING_X, 2)} m, y = ±{num(glider.CELL_Y, 2)} m; stroke {num(1e3 * glider.STROKE, 0)} mm",
         "length, x, and the frontal area and volume of two together: the stand-in's ring; y and stroke ours"),
        ("Fin", f"{num(fin.span, 2)} m high, chord {num(fin.chord, 2)} to {num(fin.tip_chord, 2)} m, "
         f"{num(1e3 * fin.thickness, 0)} mm thick, leading edge from x = {num(fin.leading_x, 2)} m", "ours"),
        ("Core sampler", f"tube {num(bar.length, 2)} m long, {num(1e3 * bar.diameter, 0)} mm across, at x = "
         f"{num(bar.x, 2)} m, z = {num(bar.z, 2)} m", "ours"),
    ]  # fmt: skip
    parts = []
    for part in design().vehicle.components:
        x, y, z = part.position
        volume = glider.displaced(part.model_dump())[0]
        parts.append((part.name, num(part.mass, 2), num(1e3 * volume, 2), num(x, 3), num(y, 2), num(z, 3)))
    balance = neutral()
    inertia = ", ".join(num(float(i), 1) for i in np.diag(balance.inertia))
    return f"""## 1. Sizes and weights

{markdown_table(("Part", "Size", "From"), rows, left=3)}

{markdown_table(("Part", "Mass, kg", "Volume, L", "x, m", "y, m", "z, m"), parts)}

Together {num(balance.mass, 2)} kg and {num(1e3 * balance.volume, 2)} L; moments of inertia {inertia} kg m² about x, y,
z. The trim ballast sets two things. Mass: the glider, its cells at neutral, is as much too heavy at the surface as it
is too light at {num(glider.LAKE_DEPTH, 0)} m, so that dives and climbs ask the same of the cells. Place: the centre of
mass lies {num(1e3 * glider.METACENTRIC_HEIGHT, 0)} mm straight below the centre of buoyancy. That little, because bank
and pitch share one metacentric height, and the cells' arm in roll is a third of that in pitch. It must be trimmed
well: section 8 shows what a millimetre does."""


def plane_section() -> str:
    """Say how forces in the vertical plane come about."""
    speed = at("glide", STEADY["glide"])["speed"]
    table = water.polar()
    fastest = np.array(table["row_speed"]) == table["speed"]
    alpha = np.array(table["row_alpha_deg"])[fastest]
    values = np.array([table[f"row_{k}"] for k in ("lift", "drag", "moment")])[:, fastest] / table["speed"] ** 2
    added = strips.bar_forces(water.SAMPLER, np.radians(alpha), density=water.DENSITY)
    fin = strips.fin_drag(water.FIN, speed=water.CRUISE, density=water.DENSITY, viscosity=water.VISCOSITY)
    rows = [
        (f"{a:.0f}°", *(num(float(v), 1) for v in values[:, k]), num(float(added[1, k]), 2), num(fin, 2))
        for a in ANGLES for k in np.flatnonzero(alpha == a)
    ]  # fmt: skip
    header = ("α", "Lift / V²", "Drag / V²", "Moment / V²", "of the drag: sampler", "fin")
    reynolds = speed * water.CHORD / water.VISCOSITY
    return f"""## 2. Forces in the vertical plane

The CFD of the stand-in (its hull 0.600 m, at 0.1, 0.2 and 0.5 m/s) is scaled by λ = {num(water.SCALE, 3)}. At equal
Reynolds number ρ V² L² is the same, so each row keeps its forces at a speed λ times lower, and its moments grow by λ:
per squared speed, forces grow by λ² and moments by λ³. The fastest row, {num(table["speed"], 2)} m/s at this size, is
used at all speeds. The glider sails at {num(speed, 2)} m/s, where the chord's Reynolds number is
{num(1e-5 * reynolds, 1)} × 10⁵, {num(speed / table["speed"], 1)} times that of the row: friction is likely lower than
assumed. Core sampler and fin are added:

- Core sampler: blunt cylinder along the flow, C_D = {strips.BLUNT_CYLINDER}, and cross-flow drag across it, C_D =
  {strips.CYLINDER_CROSSFLOW} (Hoerner, 1965; Matthews, 2002), plus its Munk moment. The pitching moment of its drag,
  which hangs {num(water.SAMPLER.z, 2)} m low, is left out: the table holds moments odd in α only. It is
  {num(abs(float(added[1, 0]) * water.SAMPLER.z * speed**2), 3)} N m at this speed.
- Fin: turbulent friction on both sides (Prandtl-Schlichting) with Hoerner's form factor 1 + 2 t/c + 60 (t/c)⁴.

{markdown_table(header, rows)}

Per squared speed, N s²/m² and N m s²/m²."""


def lateral_section() -> str:
    """Derive the lateral coefficients."""
    parts = water.lateral_parts()
    names = tuple(parts)
    unit = {"Y": "N s²/m²", "K": "N s²/m", "N": "N s²/m", "Z": "", "M": ""}
    rows = []
    for symbol, total in water.lateral_totals().items():
        turning = symbol[2:] in ("p", "q", "r")
        of = ("N s²/m" if symbol[0] in "YZ" else "N s²") if turning else unit[symbol[0]]
        shares = [num(parts[name][symbol], 1) if symbol in parts[name] else "" for name in names]
        rows.append((f"{symbol[0]}_{symbol[2:]}", *shares, f"**{num(total, 1)}**", of))
    header = ("", *(name.capitalize() for name in names), "Total", "Unit (angles in rad)")
    return f"""## 3. Lateral coefficients and rate terms

Y = V² (Y_b sin β + Y_bb sin β |sin β|) + V (Y_p p + Y_r r), K and N likewise, about mid-length; Z_q and M_q times V q.
None is measured. They are computed by `models/presets/strip_theory.py` from the geometry above:

{markdown_table(header, rows)}

{fin_text()}
{hull_and_wing_text()}

Turning at rest, where terms with V vanish, is damped linearly: cross-flow drag of the wing (roll) and of the hull
(pitch, yaw), made equivalent at a swing of {num(water.SWING, 2)} rad/s (8/3π; Faltinsen, 1990): {damping_text()}."""


def fin_text() -> str:
    """Derive the fin's coefficients."""
    fin, density = water.FIN, water.DENSITY
    strength = strips.fin_strength(fin, density=density, body_factor=water.BODY_FACTOR)
    x, z = (fin.integral(f) / fin.area for f in (lambda c, x, z: c * x, lambda c, x, z: c * z))
    ratio = water.BODY_FACTOR * fin.aspect_ratio
    return f"""- **Fin.** Area S = {num(1e4 * fin.area, 0)} cm², aspect ratio A = s²/S =
  {num(fin.aspect_ratio, 2)}. The hull's tail is an
end plate: A is taken {num(water.BODY_FACTOR, 1)} times (1: free, 2: a plane wall; DATCOM 5.3.1.1), {num(ratio, 2)}.
Lift slope by Helmbold (1942; DATCOM 4.1.3.2), a = 2π A / (2 + √(A² + 4)) = {num(strips.helmbold_slope(ratio), 2)} a
radian. G = ρ a / 2 = {num(strength, 0)} kg/m³. Each strip c dz meets the cross velocity at its three-quarter chord, v
+ (x − c/4) r − z p (Pistolesi; Thwaites, 1960), and answers with −G V times it at its mid-chord (x, z): Y_b = −G ∫c,
N_b = −G ∫c x, K_b = G ∫c z, Y_p = G ∫c z, Y_r = −G ∫c (x − c/4), K_p = −G ∫c z², K_r = G ∫c z (x − c/4), N_p = G ∫c z
x, N_r = −G ∫c x (x − c/4), as the vertical tail of Etkin and Reid (1996, sections 5.6 to 5.8). Mean place x =
{num(x, 3)} m, z = {num(z, 3)} m. Lift really acts at the quarter chord; the difference is the fin's own Munk moment,
which its added mass brings."""


def hull_and_wing_text() -> str:
    """Derive the coefficients of hull, core sampler and wing, and say what is left out."""
    side, first = strips.hull_side(water.LENGTH, water.RADIUS, water.NOSE, water.TAIL)
    wing = water.SPAN / water.CHORD
    friction = strips.friction(water.CRUISE * water.CHORD / water.VISCOSITY)
    roll, yaw = lift_terms()
    return f"""- **Hull and core sampler.** Without viscosity a body has no side force, only the Munk
  moment (section 5). Viscosity adds
cross-flow drag (Hoerner, 1965, chapter III; Fossen, 2011, section 6.4.3): Y_bb = −½ ρ C_D ∫dA, N_bb = −½ ρ C_D ∫x dA,
K_bb = ½ ρ C_D ∫z dA with C_D = {strips.CYLINDER_CROSSFLOW}, for the hull over its silhouette of {num(side, 3)} m²,
centred at {num(1e3 * first / side, 0)} mm. The cells lie in its shadow.
- **Wing in roll.** Lifting line (Glauert, 1926, chapter XI), solved for α = p y / V: C_lp =
  −{num(strips.roll_damping_slope(wing), 3)} on p b / 2V at an aspect ratio of {num(wing, 1)} (strips alone:
  −{num(math.pi / 3.0, 3)}; an elliptic wing: −{num(0.25 * math.pi * wing / (wing + 4.0), 3)}), and K_p = C_lp ρ S b² /
  4.
- **Wing in pitch.** Z_q = ½ ρ a S (x − c/4), M_q = −x Z_q, with Helmbold's a = {num(strips.helmbold_slope(wing), 2)};
  the cross velocity at its three-quarter chord again (Etkin and Reid, section 5.4).
- **Wing in yaw.** Drag of strips at V − r y: N_r = −ρ C_D c b³ / 12 with C_D = {num(2.0 * friction, 4)}, turbulent
  friction on both sides.
- **Left out.** What the wing does in proportion to its lift: the form has one number for dive and climb, and it
  changes sign between them. In the spiral the wing's K_r would take off {percent(roll)} of what its K_p makes, its N_p
  would change the fin's N_r r by {percent(yaw)} (strips: K_r = ρ c C_L b³/12, N_p = −K_r/2). Cells, struts, downwash,
  mutual interference, and all dependence on α are left out too."""


def damping_text() -> str:
    """Return the linear damping in words."""
    return ", ".join(f"{name} {num(value, 1)}" for name, value in water.damping().items()) + " N m s"


def added_mass_section() -> str:
    """Give the added mass by part."""
    parts = water.added_mass_parts()
    entries = {
        "surge": (0, 0), "sway": (1, 1), "heave": (2, 2), "roll": (3, 3), "pitch": (4, 4), "yaw": (5, 5),
        "heave-pitch": (2, 4), "sway-roll": (1, 3), "sway-yaw": (1, 5), "roll-yaw": (3, 5),
    }  # fmt: skip
    units, total = {0: "kg", 1: "kg m", 2: "kg m²"}, sum(parts.values(), start=np.zeros((6, 6)))
    rows = [
        (name, *(num(float(A[i, j]), 2) for A in parts.values()), f"**{num(float(total[i, j]), 2)}**",
         units[(i > 2) + (j > 2)])
        for name, (i, j) in entries.items()
    ]  # fmt: skip
    fin = water.FIN
    factor = strips.plate_factor(fin.area / fin.span / (2.0 * fin.span))
    return f"""## 4. Added mass

The stand-in's boundary-element matrix times λ³, λ⁴ and λ⁵ by block, plus:

- Fin: strips of (π/4) ρ c² at their mid-chord and π ρ c⁴/128 about it (Newman, 1977, Table 4.3), times the factor of a
  plate of twice the span, which the hull mirrors: {num(factor, 2)} (Pabst, 1930; within 4 % of DNV-RP-H103).
- Core sampler: ρ π d²/4 a length, both ways across.

{markdown_table(("", *(name.capitalize() for name in parts), "Total", "Unit"), rows)}"""


def yaw_section() -> str:
    """Show that the glider is stable in yaw, and why."""
    parts = water.added_mass_parts()
    A = sum(parts.values(), start=np.zeros((6, 6)))
    munk, without = strips.munk_yaw_slope(A), strips.munk_yaw_slope(A - parts["fin"])
    total = water.lateral_totals()
    quick, slow = ("glide", STEADY["glide"]), ("spiral", STRAIGHT)
    rows = [
        (label, num(at(*where)["speed"], 2), *(roots(modes(*where, fin=fin)) for fin in (True, False)))
        for label, where in (("straight glide", quick), ("straight part of the spiral", slow))
    ]
    return f"""## 5. Stability in yaw

The Munk moment −(A₂₂ − A₁₁) u v (Munk, 1924) turns the hull broadside: {num(without, 1)} N m/rad V² without the fin,
{num(munk, 1)} with the fin's own added mass. It comes with the added mass and is not in the coefficients. Against it
stands N_b = {signed(total["N_b"], 1)}: together {signed(total["N_b"] + munk, 1)} N m/rad V², so the glider points into
the flow.

Small motions of v, p, r and roll about a straight glide, with rigid body, added mass (Kirchhoff's equations, Fossen,
2011, chapter 6), coefficients, damping, weight and buoyancy, have these eigenvalues, 1/s:

{markdown_table(("", "V, m/s", "With the fin", "Without it"), rows, left=1)}

All decay with the fin. Without it the hull goes broadside within seconds. In the vertical plane there is no tail: the
CFD's moment is slightly nose up at small α; weight below buoyancy, the wing's lift and its M_q steady it, and the runs
below show no swing left half a minute after a manoeuvre."""


def cells_section() -> str:
    """Size the cells against the lake."""
    top, bottom, g, pressure = lake()
    balance = neutral()
    stiff = math.fsum(glider.displaced(c.model_dump())[1] for c in design().vehicle.components)
    density, squeeze = g * balance.volume * (bottom - top), g * bottom * pressure * stiff
    asked, section = density - squeeze, glider.cell_section()
    stop = 1e6 * section * glider.STROKE / 2.0
    capacity, fitted = 2.0 * g * DENSE * section * glider.STROKE, 2.0 * PAPER_CELL_FORCE
    dive, climb = abs(glider.DIVE[0]), abs(glider.DIVE[1])
    shallow, deep = (4e-6 * dive * rho * g for rho in (top, bottom))
    acrylic = strips.tube_bulk_modulus(water.RADIUS, 2.0 * glider.WALL, **ACRYLIC)
    rows = [
        ("density of the lake, surface / 100 m", f"{num(top, 2)} / {num(bottom, 2)} kg/m³"),
        ("more buoyancy at 100 m, rigid hull", f"{signed(density, 2)} N"),
        (f"hull squeezed, K = {num(1e-9 * glider.BULK_MODULUS, 2)} GPa", f"{signed(-squeeze, 2)} N"),
        ("change between surface and 100 m", f"**{signed(asked, 2)} N**, half of it either way from neutral"),
        ("all four cells, either way", f"±{num(capacity, 2)} N (±{num(stop, 0)} cm³ a cell)"),
        (f"straight dive (−{num(dive, 0)} cm³ a cell): net at the surface / 100 m",
         f"{num(-shallow - asked / 2, 2)} / {num(-deep + asked / 2, 2)} N"),
        (f"climb (+{num(dive, 0)} cm³ a cell): net at 100 m / surface",
         f"{signed(deep + asked / 2, 2)} / {signed(shallow - asked / 2, 2)} N"),
        ("for comparison: four of the paper's bellows, either way",
         f"±{num(fitted, 2)} N: leaves {num(fitted - asked / 2, 2)} N"),
    ]  # fmt: skip
    return f"""## 6. Cells against the lake

The lake is made up: fresh, 20 °C at the surface, a thermocline from 8 to 20 m, 5 °C below (TEOS-10). Every rigid part
has the stiffness of an aluminium tube of {num(1e3 * glider.WALL, 1)} mm wall, K = E t / (r (2.5 − 2 ν)) (Young and
Budynas, 2002, Table 13.1), a little softer than water; the cells keep their volume, since a spindle holds them.

{markdown_table(("", ""), rows, left=2)}

Even the paper's own bellows, made for {num(PAPER_CELL_FORCE, 1)} N each, would carry this glider up and down, slowly.
The cells are larger for two reasons: speed, and room for differences. A dive at −{num(dive, 0)} cm³ with
±{num(climb, 0)} cm³ between front and rear leaves the front cells
{num(stop - dive - climb, 0)} cm³ from their stop; the turning dive uses
−{num(abs(glider.TURN[0]), 0)} ± {num(glider.TURN[1], 0)} ± {num(glider.BANK, 0)} cm³ of
±{num(stop, 0)}. A hull of acrylic with twice the wall (K = {num(1e-9 * acrylic, 2)} GPa)
would lose {num(squeeze * glider.BULK_MODULUS / acrylic, 2)} N at 100 m instead of {num(squeeze, 2)} N: more than the
lake gives. At 100 m the spindle of a cell works against {num(1e-3 * pressure * section, 1)} kN."""


def missions_section() -> str:
    """Describe the runs."""
    yo_yo = run("yo-yo")
    t, z = yo_yo.times, yo_yo.values["z"]
    turns = [z[(t >= k * glider.PERIOD) & (t < (k + 1) * glider.PERIOD)].max() for k in range(glider.CYCLES)]
    heading = np.degrees(np.unwrap(run("s-turn").values["psi"]))
    rows = [
        mission_row("straight dive", at("glide", STEADY["glide"])),
        mission_row("straight climb", at("glide", 520.0)),
        mission_row("dive before the spiral", at("spiral", STRAIGHT)),
        mission_row("spiral", at("spiral", STEADY["spiral"])),
    ]
    residual = max(run(name).relative_residual for name in (*glider.MISSIONS, "twin"))
    energy, hotel = float(yo_yo.values["battery_energy"][-1]), glider.HOTEL_POWER * float(t[-1])
    return f"""## 7. What it does

{markdown_table(MOTION, rows)}

- Moments at rest would give a pitch of {degrees(rest_angles()[0], 0)} in the turning dive and a bank of
  {degrees(rest_angles()[1], 0)} in the spiral. The bank is smaller because the glider rolls about its path as it
  circles down: p = {num(math.degrees(at("spiral", 800.0)["p"]), 2)} deg/s against the wing's K_p, and the fin above
  the hull rolls it out of its sideslip.
- Spiral: {num(math.degrees(float(np.unwrap(run("spiral").values["psi"])[-1])) / 360.0, 1)} turns down to
  {num(float(run("spiral").values["z"].max()), 0)} m. S-turn: the heading goes to {num(float(heading.min()), 0)}° and
  comes back by {num(float(heading[-1] - heading.min()), 0)}°.
- Yo-yo: {len(turns)} dives turn at {num(float(np.mean(turns)), 1)} m, alike within {bound(float(np.ptp(turns)))} m. It
  floats with its axis {num(float(z[-1]), 2)} m deep; {num(float(t[-1]) / 3600.0, 1)} h,
  {num(1e-3 * float(yo_yo.values["x"][-1]), 1)} km, {num(1e-3 * energy, 0)} kJ at {num(glider.HOTEL_POWER, 0)} W of
  hotel load ({percent(hotel / energy)}) and an efficiency of {num(glider.EFFICIENCY, 1)}, both assumed.
- At speeds above 5 cm/s no run leaves ±60° of attack or ±15° of sideslip; afloat, at rest, the angle of attack has no
  meaning.
- Energy: the balance of works leaves less than {bound(residual)} of what is exchanged.

### The same turn with movable masses

The twin has one piston with the four cells' range, a battery of {num(glider.BATTERY["mass"], 0)} kg that slides and a
ballast of {num(glider.LEAD["mass"], 0)} kg that rolls, with the moments of the quad glider's spiral:

{markdown_table(MOTION, twin_rows())}

Straight they are alike. In the turn the rolling ballast also rises, which takes {num(1e3 * lost_height(), 1)} mm off
the metacentric height: more bank, steeper, faster, and wider, for it rolls more as it circles down. The twin's moment
of inertia in yaw is {num(twin_inertia(), 1)} instead of {num(float(neutral().inertia[2, 2]), 1)} kg m², for no cell
stands at its ends."""


def sensitivity_section() -> str:
    """Vary what is least certain."""
    return f"""## 8. What the spiral depends on

{markdown_table(MOTION, varied_rows())}

The same commands each time: the bank is worth some three degrees, and the radius no better than a half."""


INTRODUCTION = """# The quad-bellows lake glider

L. Canete, J. Paquibot, M. Matsumoto and T. Takahashi propose, in section I.C of their paper, a glider that they do not
describe yet: four bellows, front and rear on either side, so that differences of buoyancy pitch and roll it; for lakes
of 100 m, carried by two people, with a mud core sampler outside. They print no sizes. This page says how the presets
of the quad-bellows lake glider and of its twin with movable masses come by theirs: **every size is ours**, and no
coefficient but the stand-in's CFD is more than a textbook's formula.

This page is generated by `python -m docs.make_quad_glider`; its numbers are computed, not typed. The equations and
symbols: [physics.md](physics.md). The stand-in hull and its CFD: [paper.md](paper.md).
"""

LIMITS = """## 9. What it is not

- Not the authors' design, and no vehicle that exists. Sizes, weights, rates, efficiency, hotel load and lake are made
  up.
- Its hull is not the CFD's. Geometric scaling carries the CFD's shape, Reynolds number and faults to 2 m; the four
  cells beside the hull, their struts, the fin and the core sampler were never in it.
- The CFD is at the edge of stall from 5° of attack on; steady glides stay below 3°.
- Lateral coefficients are linear but for cross-flow drag: good for sideslips up to some 15°, and at speed. They do not
  depend on α, and nothing was checked against a tank.
- Buoyancy fades at the surface part by part, each part as if it were a ball of its own height: the way it floats and
  leaps is a sketch. There are no waves.
- The cells keep their volume under pressure; PTFE bellows will not quite.
- The missions go by the clock, in this water. A real one turns by depth.
- Chapters and sections of books are named so that the formulas can be found; what holds them here are the limits and
  closed forms in `tests/models/test_strip_theory.py`.
"""


def page() -> str:
    """Return docs/quad_glider.md."""
    sections = (
        INTRODUCTION, geometry_section(), plane_section(), lateral_section(), added_mass_section(), yaw_section(),
        cells_section(), missions_section(), sensitivity_section(), LIMITS,
    )  # fmt: skip
    return page_of([f"{section.strip()}\n" for section in sections])


def make(folder: Path = DOCS) -> None:
    """Write quad_glider.md into the folder."""
    (folder / "quad_glider.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    make()
