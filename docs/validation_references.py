"""Owns sections 7 to 10 of docs/validation.md: published figures and closed forms beside what is simulated."""

from __future__ import annotations

import math

import numpy as np

from docs import validation_energy as energy
from docs import validation_seawing as seawing
from docs import validation_slocum as slocum
from docs import validation_trims as trims
from docs import validation_water as water
from docs.formatting import bound, markdown_table, num, percent, signed


def spiral_table() -> str:
    """Return published, independent and simulated values of the spiral."""
    rows = []
    for row in seawing.rows():
        q, digits = row.quantity, row.quantity.digits
        apart = signed(100.0 * row.difference, 2) + " %" if q.relative else signed(row.difference, 3)
        limit = percent(row.demanded, 1) if q.relative else num(row.demanded, 2)
        values = (num(v, digits) for v in (row.published, row.independent, row.ours))
        rows.append((f"{q.words}, {q.unit}", *values, apart, limit))
    header = ("", "Published", "Independent solution", "Ours", "Ours less published", "Demanded")
    return markdown_table(header, rows)


def variants_table() -> str:
    """Return where the spiral ends with one thing wrong, and by how much of what is demanded it misses at worst."""
    rows = [
        (words, num(math.degrees(final["theta"]), 1), num(final["turn_rate"], 4), num(seawing.worst_miss(final), 0))
        for words, final in seawing.variants().items()
    ]
    header = ("One thing wrong", "Pitch, deg", "Turn rate, rad/s", "Worst miss, in units of the demand")
    return markdown_table(header, rows)


def radius_text() -> str:
    """Compare radii."""
    radii = seawing.radii()
    return f"""- Radius: printed as {num(radii["printed"], 1)} m, which is V cos(θ − α) / turn rate of the printed
  figures ({num(radii["formula, printed"], 1)} m). That formula gives {num(radii["formula, ours"], 1)} m with ours,
  {percent(radii["formula, ours"] / radii["printed"] - 1.0, 1)} more, as the turn rate is lower. It takes pitch less
  angle of attack as the path angle, which leaves the roll out: the radius of our path itself is
  {num(radii["path"], 1)} m."""


def seawing_section() -> str:
    """Describe check 7."""
    rows = {row.quantity.name: row for row in seawing.rows()}
    roll, turn, run = rows["phi"], rows["turn_rate"], seawing.spiral()
    steepest = math.degrees(float(np.abs(run.values["alpha"][1:]).max()))
    return f"""## 7. The Seawing's spiral

{seawing.published()["source"]}. The preset `seawing-spiral`, started level and at rest instead of in its spiral, with
the battery turned by {seawing.published()["input"]["gamma_deg"]}°. Pitch, roll, sideslip and turn rate are within
{percent(seawing.SETTLED)} of their final values after {num(seawing.settled(), 0)} s. At
{num(seawing.DURATION, 0)} s:

{spiral_table()}

- Published figures are rounded. Half a unit of the last digit of the turn rate is
  {percent(5e-5 / turn.published, 1)}; ours, {percent(abs(turn.difference), 1)} lower, would have been printed as
  {num(turn.ours, 4)}.
- The independent solution was made apart from this project; its roll differs from ours by
  {num(abs(roll.ours - roll.independent), 3)} deg, all else by no more than its last digit. The root of the six
  accelerations of our own second simulator (check 1) is where our run ends, within
  {bound(seawing.largest_from_root())}; the trim solver finds it within {bound(trims.largest_difference())} (rad, m/s,
  rad/s): so the pitch, {num(abs(rows["theta"].difference), 2)} deg from the published
  one, follows from the parameters as printed.
{radius_text()}

What the comparison would notice. Rate terms times V instead of V²; the sign of K_M0 and K_MY as in another public
transcription; and the Munk moment taken out as if the coefficients held it:

{variants_table()}

![The spiral](img/validation-seawing.svg)

*Figure 7. Left: the path from above, and a circle of the published radius about its axis. Right: the way to the
published values (dashed). In the first seconds from rest the angle of attack reaches {num(steepest, 0)}°, where these
coefficients mean nothing; the steady state does not depend on it.*
"""


def glides_table() -> str:
    """Return the closed form at every path angle, and the larger of both models' differences from it."""
    rows = []
    for case in slocum.glides():
        g = case.closed
        pairs = zip(*(slocum.differences(case, run) for run in case.runs.values()), strict=True)
        rows.append((
            num(math.degrees(g.xi), 0), num(math.degrees(g.alpha), 3), num(math.degrees(g.theta), 3),
            num(g.ballast, 4), num(100.0 * g.rp1, 3), *(bound(max(pair)) for pair in pairs),
        ))  # fmt: skip
    header = ("Path angle, deg", "α, deg", "Pitch, deg", "Ballast, kg", "Mass at, cm", "Run: α", "pitch", "speed")
    return markdown_table(header, rows, left=0)


def slocum_section() -> str:
    """Describe check 8."""
    other = slocum.published()["derived"]["glides"][0]
    speed = slocum.published()["parameters"]["V_d"]
    return f"""## 8. Graver's steady glides

J. G. Graver, 2005, *Underwater gliders: dynamics, control and design*, PhD thesis, Princeton: for a path angle ξ and a
speed V the angle of attack is a root of K_D α² + K_L tan ξ α + K_D0 + K_L0 tan ξ = 0, the ballast follows from lift and
drag, and the place of the movable mass from pitch, viscous moment and Munk moment. Both are set in the preset
`slocum-glide`, which is then flown {num(slocum.DURATION, 0)} s by both models, started
{num(slocum.START_PITCH_DEG, 0)}° of pitch and {percent(1.0 - slocum.START_SPEED)} of the speed off. At V =
{num(speed, 1)} m/s, with the larger of both models' differences, relative:

{glides_table()}

- By a script made apart from this project, at {num(other["xi"], 0)}°: α {num(other["alpha"], 4)}°, pitch
  {num(other["theta"], 4)}°, ballast {num(other["mb"], 5)} kg, mass at {num(other["rp1_cm"], 4)} cm: the same to its
  last digit.
- The quadratic has a root only for tan |ξ| of at least 2 √(K_D K_D0) / K_L: the shallowest glide that these
  coefficients admit is {num(math.degrees(slocum.shallowest()), 3)}°, at α =
  {num(math.degrees(slocum.largest_attack()), 1)}°.
- The polar in the figure has one ballast, {num(other["mb"], 5)} kg: the mass alone sets the path angle. Same agreement.

![Steady glides](img/validation-slocum.svg)

*Figure 8. Closed form (line) and where the runs end, planar (dots) and spatial (crosses).*
"""


def densities_table() -> str:
    """Return published densities and ours."""
    data = water.published()
    points = zip(data["SA"], data["CT"], data["p"], data["rho"], water.densities(), strict=True)
    rows = [
        (num(SA, 4), num(CT, 4), num(p, 0), num(rho, 3), num(ours, 3), signed(1e3 * (ours - rho), 1))
        for SA, CT, p, rho, ours in points
    ]
    header = (
        "Salinity, g/kg",
        "Temperature, °C",
        "Pressure, dbar",
        "Published, kg/m³",
        "Ours, kg/m³",
        "Difference, g/m³",
    )
    return markdown_table(header, rows, left=0)


def floats_table() -> str:
    """Return the periods of the floats."""
    rows = [
        (case.name.capitalize(), num(case.amplitude, 2), num(2.0 * math.pi / case.omega, 1), num(case.period, 1),
         bound(case.period * case.omega / (2.0 * math.pi) - 1.0), bound(case.largest))
        for case in water.oscillations()
    ]  # fmt: skip
    header = ("Float", "Let go off by, m", "Period, closed form, s", "Simulated, s", "Difference", "Path")
    return markdown_table(header, rows)


def water_section() -> str:
    """Describe check 9."""
    return f"""## 9. Water

**Density.** {water.published()["source"]}; absolute salinity, conservative temperature. Ours comes from the table
against depth that the kernel reads, so it shows what tabulation costs beside what a CTD resolves (3 g/m³):

{densities_table()}

**Neutral depth.** In a density that rises by {num(1e3 * water.SLOPE, 0)} g/m³ a metre a float without drag swings about
the depth where it is neutral, {num(water.NEUTRAL, 0)} m here. With a stiff hull ω² = N² m / (m + A₃₃), N² = g ρ′/ρ, at
any amplitude; with one of bulk modulus K it is ω² = g V (ρ′ (1 − p/K) − ρ² g/K) / (m + A₃₃), V its volume without
pressure, at small ones. {water.PERIODS} periods by the spatial model; differences relative, of the path to the
amplitude:

{floats_table()}

![Floats and densities](img/validation-water.svg)

*Figure 9. Left: lines closed form, dots simulated. Right: density less the published one; dashed: demanded.*
"""


def bill_section() -> str:
    """Describe check 10."""
    cases = [bill for bill in energy.bills() if bill.depth in (energy.DEPTHS[0], energy.DEPTHS[-1])]
    rows = [
        (num(b.depth, 0), num(b.efficiency, 2), num(b.recovery, 1), num(b.expected, 1), num(b.taken, 1),
         bound(b.difference))
        for b in cases
    ]  # fmt: skip
    header = ("Depth, m", "Efficiency", "Recovery", "Closed form, J", "Simulated, J", "Difference")
    load, expected, moved = energy.hotel_bill()
    return f"""## 10. Energy bill

One piston fills by {num(1e6 * energy.AREA * energy.STROKE, 0)} cm³ while its twin empties by the same, so that the
glider keeps its depth (within {bound(moved)} m). The battery gives p ΔV / efficiency, and gets back only the recovered
share of what the water does on the emptying one:

{markdown_table(header, rows, left=0)}

The hotel load of {num(energy.HOTEL, 1)} W adds {num(load, 2)} J over the run; power times time is
{num(expected, 2)} J.

![Energy of an expansion](img/validation-bill.svg)

*Figure 10. Energy that the expansion takes, against depth.*
"""
