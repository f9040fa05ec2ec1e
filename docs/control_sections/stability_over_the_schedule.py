"""Owns the section of docs/control.md on stability along a mission: margins, growth, and a schedule that fails."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from docs.control_sections.trim_and_polar import DEPTH, PATH, SPEED, shown
from docs.formatting import markdown_table, num, percent, signed
from docs.quad_studies import degrees
from models.assemble import assemble
from models.design import parse_design
from models.presets.quad_glider import LEAD, quad_glider
from models.run import Run
from models.simulate import simulate
from models.stability import QUANTITIES, SAMPLES, StabilityHistory, stability_over
from models.targeted_trim import trim_for
from models.trim import Trim, design_from

LIFT, PROBE = 0.034, 0.015
"""How far the ballast is lifted, and a smaller lift at which the cells are found too, m."""
LIFTED = (120.0, 150.0, 210.0, 240.0)
"""When the ballast begins to rise, is up, begins to sink, is down, s."""
DURATION = 360.0
CODE = """
from models.presets import load_preset
from models.simulate import simulate
from models.stability import stability_over

history = stability_over(simulate(load_preset("quad-bellows-glide")))
for worst in history.extremes:
    print(f"{worst.name:18} {worst.value:+.4f} {worst.unit:3} at {worst.time:3.0f} s")
print(f"{len(history.warnings)} warnings, the first: {history.warnings[0].message}")
"""


class Lifted(NamedTuple):
    """The dive in which the ballast is lifted, and its stability."""

    run: Run
    history: StabilityHistory


def liftable() -> dict[str, Any]:
    """Return the quad glider with a lower ballast that can be lifted."""
    document = quad_glider("glide")
    for part in document["vehicle"]["components"]:
        if part["name"] == LEAD["name"]:
            part |= {"kind": "movable_mass", "axis": [0.0, 0.0, -1.0], "extension_range": [0.0, 0.05],
                     "neutral_extension": 0.0, "rate_limit": 0.002, "lag": 0.5}  # fmt: skip
    return document


@cache
def lifted() -> Lifted:
    """Fly a dive in which the ballast is lifted and lowered, while the cells keep the path.

    What the cells have to hold is linear in the lift, so two trims tell their extensions at any.
    """
    design = parse_design(liftable())
    assembly = assemble(design)
    cells = [name for name in assembly.cells if name != LEAD["name"]]
    wish = {"glide_angle": PATH, "speed": SPEED}
    low, high = (trim_for(assembly, wish, cells, depth=DEPTH, extensions={LEAD["name"]: lift}) for lift in (0.0, PROBE))
    assert isinstance(low, Trim) and isinstance(high, Trim)
    document = design_from(low, design).model_dump(mode="json")
    schedules = [
        {"cell": name, "points": points(first, first + (high.extensions[name] - first) * LIFT / PROBE)}
        for name, first in low.extensions.items()
    ]
    document["mission"] |= {"duration": DURATION, "control": {"schedules": schedules}}
    document["mission"]["solver"]["output_interval"] = 1.0
    run = simulate(parse_design(document))
    return Lifted(run, stability_over(run, 2 * SAMPLES))


def points(low: float, high: float) -> list[dict[str, Any]]:
    """Return the points of a schedule that goes up and down again with the ballast."""
    steps = ((0.0, low), (LIFTED[0], low), (LIFTED[1], high), (LIFTED[2], high), (LIFTED[3], low))
    return [
        {"time": time, "extension": value, "shape": "step" if k == 0 else "ramp"}
        for k, (time, value) in enumerate(steps)
    ]


def at(name: str, time: float) -> float:
    """Return a quantity of the lifted run at an instant."""
    run, history = lifted()
    values = getattr(history, name) if hasattr(history, name) else run.values[name]
    times = history.growth_times if name == "growth" else run.times
    return float(values[int(abs(times - time).argmin())])


def section() -> str:
    """Return the section."""
    return f"{definitions_text()}\n\n{schedule_text()}\n\n{shown(CODE)}\n\n{use_text()}\n"


def definitions_text() -> str:
    """Tell what the margins are."""
    rows = (
        ("hydrostatic margin, m", "d · k", "the centre of buoyancy lies above that of mass"),
        ("pitch stiffness, m", "D_x k_x + D_z k_z", "weight and buoyancy right pitch"),
        ("roll stiffness, m", "D_y k_y + D_z k_z", "weight and buoyancy right roll"),
        ("pitch margin, 1", "(x_G − x_n) / L, x_n = −M_α / Z_α", "the flow turns the nose into the stream, in pitch"),
        ("yaw margin, 1", "(x_G − x_n) / L, x_n = N_β / Y_β", "the same in yaw (spatial only)"),
        ("growth, 1/s", "largest Re λ of the motion", "*negative is good*: small motions die out"),
    )
    return f"""## Stability over the schedule

`stability_over` (`models/stability.py`, `models/margins.py`) follows {len(QUANTITIES)} quantities along a run:

{markdown_table(("Quantity", "Is", "Positive means"), rows, left=3)}

k is the unit vector down in body axes, d = r_G − r_B the way from the centre of buoyancy to that of mass, D = r_G −
(1 + net buoyancy / m g) r_B; stiffnesses are righting moments per rad over the weight. x_n is the neutral point,
where a change of force acts, at fixed speed and without rotation; L is the length of the vehicle. Munk's moment
counts. Where there is no flow, or the force does not oppose the turn (broadside, past a stall), there is no neutral
point and no number. Growth holds depth, heading and extensions and freezes the motion at an instant.

**Why one number at one instant is not enough.** Cells and masses move, so the centres move; gravity's direction in
the body and the angle of attack change with the phase; and no single margin decides. A glider may be righted by its
weight against a flow that turns it, as here, or the other way round. Only growth weighs all of it, damping included,
but says nothing of why. And a mission that begins and ends well can be unstable in between."""


def schedule_text() -> str:
    """Tell of the schedule that turns unstable."""
    history = lifted().history
    told = "\n".join(f"- {warning.message}" for warning in history.warnings)
    worst = history.extreme("growth")
    assert worst is not None
    return f"""### A schedule that turns unstable in the middle

![Margins, growth and pitch of a dive in which the ballast is lifted](img/control-stability.svg)

*Figure 7. The quad glider dives while its lower ballast is lifted by {num(1e3 * LIFT, 0)} mm and lowered again.
Shaded: growth above zero.*

For this page the lower ballast of the quad glider can be lifted: the less metacentric height, the less the cells have
to do to pitch it. They follow so that the path of {degrees(PATH)} at {num(SPEED, 1)} m/s stays in balance. At the
start and at the end the hydrostatic margin is {num(1e3 * at("hydrostatic_margin", 0.0), 1)} mm and growth
{num(at("growth", 0.0), 2)} 1/s; who looks there sees a stable glider. In between growth rises to
{signed(worst.value, 3)} 1/s, and pitch, still in balance when the ballast is up, leaves it: from
{degrees(at("theta", LIFTED[1]), 1)} to {degrees(at("theta", LIFTED[2]), 1)} in {num(LIFTED[2] - LIFTED[1], 0)} s.
Lowering the ballast brings it back. The warnings are one a quantity; every change of sign is in `history.changes`
({len(history.changes)} here):

{told}

The pitch margin is {signed(100.0 * at("pitch_margin", 0.0), 1)} % of the length all along: the flow turns this glider
away from the stream, weakly, and the weight holds it. In yaw it is {percent(at("yaw_margin", 0.0))}, by the fin."""


def use_text() -> str:
    """Tell how to use it."""
    return f"""The preset flies well, and yet it is warned of: it starts at rest and falls broadside until it glides,
and there small margins change sign often; the warning says whether small motions are stable then. It counts where
the glider is settled; growth of a glider that is
turning over says only which way things go at that instant. Times of a change are interpolated between samples; growth
is looked at {SAMPLES} instants unless told otherwise, and one shorter than their distance is missed.

`glider-studio stability DESIGN --plot stability.svg` flies the mission, prints the worst values and warnings and
draws them, `--samples 1000` looks more often; over REST `POST /api/v1/analyses:stability`.
"""
