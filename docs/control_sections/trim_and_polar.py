"""Owns the section of docs/control.md on trims and on the glide polar, and the runnable code that sections show."""

from __future__ import annotations

import io
import math
from contextlib import redirect_stdout
from functools import cache

from docs.formatting import markdown_table, num, signed
from docs.quad_studies import degrees
from models.assemble import Assembly, assemble
from models.glide_polar import GLIDING, GlidePolar, glide_polar
from models.presets import load_preset
from models.targeted_trim import trim_for
from models.trim import Trim, TrimSearch, find_trims
from models.trim_search import Search
from models.trim_targets import UNITS

PRESET = "quad-bellows-glide"
PATH, SPEED, DEPTH = math.radians(-30.0), 0.3, 30.0
"""The dive that sections tell of: path (rad), speed (m/s), depth (m)."""
TOO_FAST = 0.8
CODE = """
import math
from textwrap import fill

from models.glide_polar import glide_polar
from models.presets import load_preset
from models.targeted_trim import trim_for

glider = load_preset("quad-bellows-glide")
cells = [part.name for _, part in glider.vehicle.actuated]
for speed in (0.3, 0.8):
    found = trim_for(glider, {"glide_angle": math.radians(-30), "speed": speed}, cells, depth=30.0)
    print(f"{speed} m/s:", fill(str(found), 110))
best = glide_polar(glider).best_energy
print(f"{best.per_km / 1e3:.1f} kJ/km: {best.trim}")
"""


def shown(code: str) -> str:
    """Return code and what it prints as blocks of Markdown; it is run."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(code, {})
    text = printed.getvalue().replace("-0.00 deg", "+0.00 deg")  # the sign of a rounding error is not told
    return f"```python{code.rstrip()}\n```\n\nprints\n\n```text\n{text.rstrip()}\n```"


@cache
def glider() -> Assembly:
    """Return the quad glider, put together."""
    return assemble(load_preset(PRESET))


@cache
def dive() -> Trim:
    """Return the dive that sections tell of."""
    found = trim_for(glider(), {"glide_angle": PATH, "speed": SPEED}, glider().cells, depth=DEPTH)
    assert isinstance(found, Trim)
    return found


@cache
def held() -> TrimSearch:
    """Return all trims at the extensions of the dive."""
    return find_trims(glider(), extensions=dive().extensions, depth=DEPTH)


@cache
def polar() -> GlidePolar:
    """Return the polar of the quad glider."""
    return glide_polar(glider())


def slow() -> Trim:
    """Return what is found for the path alone, from cells near neutral."""
    found = trim_for(glider(), {"glide_angle": PATH}, glider().cells, depth=DEPTH)
    assert isinstance(found, Trim)
    return found


def named_points() -> dict[str, Trim]:
    """Return the named points of the polar that there are."""
    p = polar()
    points = {
        "best range": p.best_range, "least energy": None if p.best_energy is None else p.best_energy.trim,
        "slowest sink": p.slowest_sink, "tightest turn": p.tightest_turn,
    }  # fmt: skip
    return {name: trim for name, trim in points.items() if trim is not None}


def section() -> str:
    """Return the section."""
    return f"{trim_text()}\n\n{target_text()}\n\n{shown(CODE)}\n\n{polar_text()}\n"


def trim_text() -> str:
    """Tell what a trim is and what is searched."""
    search, step = held(), Search()
    banks = ", ".join(num(math.degrees(bank), 0) for bank in step.banks)
    turned = any(abs(trim.roll) > math.radians(170.0) for trim in search.solutions if not trim.stable)
    over = "; the other is the same glide upside down" if turned and len(search.solutions) == 2 else ""
    return f"""## Trim and polar

A **trim** is a steady motion at fixed extensions: forces and moments balance, and only position and heading change.
It is a straight glide, or a spiral about the vertical. It is sought in still water (a uniform current carries it
along unchanged) at one depth; in layered water the glider drifts off it slowly as it sinks. Unknown are roll, pitch,
u, v, w and the turn rate (planar: pitch, u, w). Every trim is marked stable or not by its growth, the largest real
part of the eigenvalues of small motions with extensions and depth held.

`find_trims` (`models/trim.py`) looks at given extensions. At each angle of attack, every
{num(math.degrees(step.angle_step), 0)}° all around, force balance gives speed and pitch; where the moment left over
changes sign, a glide is pinned down by Newton's method. From every glide it also starts turns banked by {banks}° to
either side. At the extensions of the dive below it finds {len(search.solutions)} motions, of which
{len(search.stable)} is stable{over}. **May be missed:** two glides closer together than a step, and spirals that no
start leads to. `searched` says what was done; an empty answer does not prove that there is none. Where weight and
buoyancy are equal nothing drives a glide, and the answer is the attitude at rest."""


def target_text() -> str:
    """Tell of targets, free cells and failure."""
    names = ", ".join(f"`{name}`" for name in UNITS)
    return f"""`trim_for` (`models/targeted_trim.py`) goes the other way: from **targets** to extensions. Targets are
any of {names}; angles in rad, climbs and turns to the right positive. Without one of a turn the trim is straight.
**Free cells** may move between their stops, the others stay as given or as the mission starts. More free cells than
conditions are welcome: of several trims a stable one is taken first, and then the one nearest to the given
extensions, in strokes. So name what matters. With the path alone, from cells near neutral, the nearest glide may be a
crawl: here {num(1e3 * slow().speed, 1)} mm/s. Give a speed or a sink rate as well, or the extensions of a dive.

That targets are not met is an answer, not an error: a `TrimFailure` that says why, which cells are at a stop, what
would be out of balance, and the nearest motion there is."""


def polar_text() -> str:
    """Tell of the polar and its named points."""
    p = polar()
    assert p.best_energy is not None
    left, (reason, most) = sum(p.left_out.values()), max(p.left_out.items(), key=lambda item: item[1])
    stable = sum(trim.stable for trim in p.points)
    rows = [_row(name, trim) for name, trim in named_points().items()]
    header = ("Point", "Speed, m/s", "Path", "Pitch", "Sinks, m/s", "kJ/km", "Radius, m")
    return f"""### The polar

![Envelope of the quad glider: vertical against horizontal speed](img/control-polar.svg)

*Figure 5. Trims of the quad glider at shares of its largest heave, dives below. Dotted where unstable, a square where
there is but one; rays: path.*

`glide_polar` (`models/glide_polar.py`) fixes the heave of the cells, a change of net buoyancy, and lets their
pitching moment go from stop to stop; four shares of the largest heave, dives and climbs, make the envelope. Heave and
moment are shared out by the allocation of the controller. Of {len(p.points)} glides {stable} are stable; {left}
points have none, {most} of them because {reason}: at full heave the cells have no stroke left to pitch with.

{markdown_table(header, rows)}

Best range is the flattest path; slowest sink is that of dives at the levels drawn, and a smaller level sinks slower
still. The tightest turn rolls some glides of every curve to the stops; turns beyond {degrees(GLIDING)} of attack are
stalled falls and not counted. Stable trims are taken before unstable ones.

**What the energy assumes:** {p.energy}. As a formula, P_hotel / (V cos γ) + p |B| tan |γ| / (η ρ g H), B the net
buoyancy, H the depth of the cycle. The climb is taken as the mirror image of the dive. Steering, pitching by moving
masses and the turns from dive to climb are not in it. Of the cheapest kilometre the hotel load takes
{num(1e-3 * p.best_energy.hotel, 1)} kJ and the pump {num(1e-3 * p.best_energy.pump, 1)} kJ.

On the command line: `glider-studio trim DESIGN --target glide_angle=-30deg --target speed=0.3 --depth 30`,
`glider-studio polar DESIGN --plot polar.svg`; over REST: `POST /api/v1/analyses:trim` and
`POST /api/v1/analyses:polar`.
"""


def _row(name: str, trim: Trim) -> tuple[str, ...]:
    """Return a row of the table of named points."""
    best = polar().best_energy
    energy = num(1e-3 * best.per_km, 1) if best is not None and trim is best.trim else ""
    radius = "" if trim.turn_radius is None else num(abs(trim.turn_radius), 1)
    return (
        name, num(trim.speed, 3), degrees(trim.glide_angle, 1), degrees(trim.pitch, 1), signed(trim.sink_rate, 3),
        energy, radius,
    )  # fmt: skip
