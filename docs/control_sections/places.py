"""Owns the section of docs/control.md on waypoints and station keeping in a current."""

from __future__ import annotations

import math

from docs.control_studies import kept, legs, per_km, preset_run, without_integral
from docs.formatting import markdown_table, num, percent


def section() -> str:
    """Return the section."""
    way, station = preset_run("waypoints"), kept()
    settled, expected = without_integral()
    guidance = way.design.mission.control.controller.lateral.guidance
    current = math.hypot(*way.design.mission.environment.current.velocity)
    drift = math.hypot(*preset_run("station").design.mission.environment.current.velocity)
    rows = [
        (str(k + 1), num(leg.end, 0), num(leg.largest, 0), num(leg.late, 0)) for k, leg in enumerate(legs(way))
    ]  # fmt: skip
    return f"""## Waypoints and a station in a current

![Paths around waypoints and on station](img/control-places.svg)

*Figure 4. Left: `quad-bellows-waypoints`, circles of arrival of {num(guidance.radius, 0)} m. Right:
`quad-bellows-station`, the circle beyond which it heads back, and that within which it spirals again.*

**Waypoints.** A triangle, lookahead Δ = {num(guidance.lookahead, 0)} m, σ = {num(guidance.integral, 1)} m/s, current
{num(current, 2)} m/s to the east:

{markdown_table(("Leg", "Reached at, s", "Largest distance from the line, m", "In the last quarter, m"), rows, left=0)}

The large distances are the turns: the glider turns with a radius of tens of metres and meanwhile drifts. Without the
integral it would stay beside the line: to go straight it must lean by asin(c / U), line of sight leans by atan(e / Δ),
so e = Δ tan(asin(c / U)), {num(expected, 0)} m on the first leg; a run without it settles at {num(settled, 0)} m. The
whole round takes {num(1e-3 * per_km(way), 1)} kJ/km.

**Station.** In {num(drift, 2)} m/s it stays within {num(station.largest, 0)} m of its place for two hours. The bound
is the radius, {num(station.radius, 0)} m, two radii of the turn back ({num(station.turn, 0)} m each), and the drift in
half a turn: {num(station.bound, 0)} m. It spirals for {percent(station.spiral)} of the time and goes back for the rest.
"""
