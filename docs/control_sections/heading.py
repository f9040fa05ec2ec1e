"""Owns the sections of docs/control.md on holding a heading across a current, on the S-turn, and on noise."""

from __future__ import annotations

import math

import numpy as np

from docs.control_studies import LESS_MOMENT, held, integrated, moves, peace, per_km, preset_run, s_turn, slides
from docs.formatting import markdown_table, num, percent
from docs.quad_studies import degrees
from models.presets.quad_control import SAMPLE_TIME, SLOPE

SAMPLES = 3600.0 / SAMPLE_TIME
"""Samples an hour."""


def section() -> str:
    """Return the section."""
    return f"{heading_text()}\n\n{integral_text()}\n\n{noise_text()}\n\n{s_turn_text()}\n"


def heading_text() -> str:
    """Tell of the heading held across a current."""
    run, result = preset_run("heading"), held()
    current = run.design.mission.environment.current
    speed = math.hypot(*current.velocity)
    wide, narrow = slides()
    wanted = float(run.values["heading_target"][-1])
    return f"""## A heading across a current

![Path, heading, bank and cells of the glider that holds a heading](img/control-heading.svg)

*Figure 1. The preset `quad-bellows-heading`: yo-yo between 10 m and 90 m, heading {degrees(wanted)}, current
{num(speed, 2)} m/s from the left.*

It is within 2° of its heading after {num(result.settled, 0)} s; from the second dive on the error is
{degrees(result.rms, 1)} (rms) and at most {degrees(result.largest, 1)}, at the turns. The heading is held, not the
track: that leads {degrees(result.track, 1)}, and the current triangle with the speed of the same yo-yo in still water
says {degrees(result.expected, 1)}. It takes {num(1e-3 * per_km(run), 1)} kJ/km over ground,
{num(1e-3 * peace()[0].energy, 1)} in still water; the open-loop yo-yo, which floats at each surfacing,
{num(1e-3 * per_km(preset_run("yo-yo")), 1)}. A cell gets a new command at {percent(moves(run) / SAMPLES)} of the
samples.

At the turns the cells travel at their rate limit for about a minute, and for {num(wide.backwards, 0)} s the glider is
already light and still nose down, or the other way round: it slides backwards, the fin leads, and any error of heading
grows. A loop that may ask for much pitch moment there helps, because the cells then change their difference before
they change their sum: with the limit of the pitch loop at {num(LESS_MOMENT, 1)} instead of
{num(SLOPE["limit"], 1)} N m it slides for {num(narrow.backwards, 0)} s, and the largest error of heading is
{degrees(narrow.error, 0)}."""


def integral_text() -> str:
    """Tell what an integral does to pitch, and why these loops have none."""
    found = integrated()
    first, *later = (degrees(x) for x in found.with_it)
    return f"""### An integral in pitch

Wanted are {degrees(found.target)} on dives. Without an integral they are flown at
{degrees(found.without[0])}: the moment of the phase is near enough. With k_i = {num(found.integral, 3)} N m/(rad s)
the first of {len(found.with_it)} dives is flown at {first}, the others at {", ".join(later)}. While the glider turns
from dive to climb, pitch is off by a radian for half a minute; the limit of the loop cuts most of that off, and the
integral gives it back. The cells' rate limits it does not know, so a loop whose limit is wide adds up some of each
turn. These presets go without."""


def noise_text() -> str:
    """Tell what noise and a deadband do."""
    rows = [
        (num(1e3 * p.noise, 0), percent(p.deadband, 1), percent(p.moves / SAMPLES), num(1e-3 * p.energy, 1),
         degrees(p.rms, 1))
        for p in peace()
    ]  # fmt: skip
    header = ("Noise, mrad", "Deadband", "Samples with a new command", "kJ/km", "Heading, rms")
    return f"""### Noise and the deadband

The same yo-yo in still water, with noise of roll, pitch and heading and ten times as many metres of depth:

{markdown_table(header, rows, left=0)}

At depth every move costs: a cell that grows pays pressure times volume, and one that shrinks gives nothing back. So
noise is paid for in energy, and a deadband saves it at the price of some accuracy. Filters are not modelled."""


def s_turn_text() -> str:
    """Tell of the S-turn."""
    run = s_turn()
    psi, phi = np.degrees(run.values["psi"]), np.degrees(np.abs(run.values["phi"]))
    short = float(np.abs(run.values["roll_moment_missing"]).max())
    missing = "The cells make every moment asked for" if short < 1e-3 else f"At most {num(short, 2)} N m are missing"
    return f"""## An S-turn

![Path, heading, bank and cells in an S-turn](img/control-s-turn.svg)

*Figure 2. One slow dive that heads for one place after another, to port and back to starboard.*

The heading goes to {num(float(psi.min()), 0)}° and comes back to {num(float(psi[-1]), 0)}°, at a bank of
{num(float(phi.max()), 1)}° while it turns. {missing}. The bank stays at less than half of what the heading loop asks
for: in a turn the fin above the hull and the wing roll the glider out, and the roll loop has no integral. The heading
loop does not mind, since the bank only sets how fast it turns."""
