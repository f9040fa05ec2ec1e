"""Owns the section of docs/control.md that compares four cells with movable masses at equal energy."""

from __future__ import annotations

import math
from collections.abc import Callable

from docs.control_comparison import STEP, STEP_DEPTH, STEP_TIME, WITHIN, Compared, compared, rate
from docs.formatting import bound, markdown_table, num, percent, signed
from docs.quad_studies import degrees
from models.presets.quad_control import FAST, SLOW

AT_BANK = math.radians(6.0)
"""Bank at which radii are compared: both gliders reach it in either dive."""
ROWS: tuple[tuple[str, Callable[[Compared], str]], ...] = (
    ("net buoyancy either way, N", lambda c: num(c.glider.drive.heave, 2)),
    ("speed in a dive, m/s", lambda c: num(c.speed, 3)),
    ("path in a dive", lambda c: degrees(c.path, 1)),
    ("one straight cycle, s", lambda c: num(c.cycles[0].time, 0)),
    ("energy, straight, kJ/h", lambda c: num(1e-3 * c.cycles[0].per_hour, 2)),
    ("energy, turning, kJ/h", lambda c: num(1e-3 * c.cycles[1].per_hour, 2)),
    ("**energy, both cycles, kJ/h**", lambda c: f"**{num(1e-3 * rate(c.cycles), 2)}**"),
    ("energy, straight, kJ/km", lambda c: num(1e-3 * c.cycles[0].per_km, 2)),
    (f"radius at a bank of {num(math.degrees(AT_BANK), 0)}°, m", lambda c: num(c.radius_at(AT_BANK), 1)),
    ("largest bank tried that it can make", lambda c: degrees(c.within[-1].bank, 0)),
    ("radius there, m", lambda c: num(c.within[-1].radius, 0)),
    ("pitch there", lambda c: degrees(c.within[-1].pitch, 0)),
    (f"step of the heading by {num(math.degrees(STEP), 0)}°: settled after, s", lambda c: num(c.step.settled, 0)),
    ("the step takes, J", lambda c: num(c.step.energy, 0)),
)


def section() -> str:
    """Return the section."""
    slow, fast = compared(SLOW), compared(FAST)
    columns = [slow[0], slow[2], fast[0], fast[2]]
    rows = [(words, *(show(column) for column in columns)) for words, show in ROWS]
    header = ("", "quad, slow", "twin, slow", "quad, fast", "twin, fast")
    saved = 1.0 - rate(slow[1].cycles) / rate(slow[0].cycles)
    return f"""## Four cells beside movable masses, at equal energy

![Radius against bank, a step of the heading, and what the actuators take](img/control-twin.svg)

*Figure 3. Left: steady turns in dives; hollow where the cells cannot make all that is asked for. Right: a
step of the heading by {num(math.degrees(STEP), 0)}°, asked for {num(STEP_DEPTH, 0)} m deep in a slow dive.*

Quad glider and movable-mass twin ([quad_glider.md](quad_glider.md), 7) have one hull, one weight, one range of
buoyancy and the same loops. Equal energy means: the quad glider's net buoyancy is given, that of the twin is changed
until both take the same energy an hour, hotel load included, over one straight and one turning cycle of the yo-yo
(10 m to 90 m). Pitch is the same: for each glider the moments M_phase are set so that its steady pitch is what is
wanted. There is no deadband, no noise, no current.

{markdown_table(header, rows)}

A step counts as settled within {degrees(WITHIN)}; what it takes is the difference to going straight on for
{num(STEP_TIME, 0)} s.

{difference_text(slow, fast, saved)}"""


def difference_text(slow: tuple[Compared, ...], fast: tuple[Compared, ...], saved: float) -> str:
    """Say what makes the difference, and what is uncertain."""
    quad, _, twin = slow
    faster = twin.speed / quad.speed - 1.0
    more = twin.glider.drive.heave / quad.glider.drive.heave - 1.0
    shorter = 1.0 - fast[2].cycles[0].time / fast[0].cycles[0].time
    return f"""**What makes the difference**

- *Straight, almost nothing.* At the same net buoyancy and pitch the speeds agree within
  {bound(abs(slow[1].speed / quad.speed - 1.0))} (slow): it is the same hull. To pitch from dive to climb costs the quad
  glider nothing extra, since all cells grow anyway.
- *Steering at depth.* A shift of volume costs p ΔV / η for the cells that grow, and what the others give up is lost:
  {num(quad.step.energy, 0)} J for the step (slow), {num(fast[0].step.energy, 0)} J (fast). The twin's ballast is lifted
  by millimetres: {num(twin.step.energy, 1)} J. At equal net buoyancy the twin takes {percent(saved, 1)} less over the
  two cycles (slow); spent on buoyancy, that is {signed(100.0 * more, 0)} % net buoyancy and
  {signed(100.0 * faster, 0)} % speed.
- *Turning from dive to climb.* The quad glider's front cells travel {num(fast[0].travel, 0)} s (fast), further than the
  rear ones, for they pitch it as well; the twin's piston {num(fast[2].travel, 0)} s. So the twin overshoots the band
  less and its cycle is {percent(shorter, 0)} shorter. A shorter cycle pumps more often: in the fast yo-yo that eats up
  what it saves on steering, and both end at the same net buoyancy.
- *Settling is the same*, for the bank limits it and both reach it.
- *Room for both.* The quad glider's cells share one stroke between sinking and banking. In the fast dive they give
  {degrees(fast[0].within[-1].bank, 0)} of bank before something else is cut; the twin goes on to
  {degrees(fast[2].within[-1].bank, 0)}. In the slow dive both have room.
- *Tight turns.* At large banks the twin's ballast has risen, the metacentric height is less, and it noses down
  ({degrees(twin.within[-1].pitch, 0)} instead of {degrees(quad.within[-1].pitch, 0)} in the slow dive): faster and
  wider.

**What is uncertain**

- The efficiency is 0.5 at any depth for cells, piston and drives alike, and no part recovers energy; both are assumed.
  Full recovery in the cells that shrink would give back half of the price of steering.
- Sliding and rolling masses have no friction and need no power to hold; real ones do. Rails and drives are not counted.
- The lateral coefficients are not measured: [quad_glider.md](quad_glider.md), 8, shows a radius no better than a half.
  Both gliders share them, so differences are better known than the radii.
- One set of gains flies both, and neither was tuned to its best."""
