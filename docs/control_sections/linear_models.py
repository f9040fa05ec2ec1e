"""Owns the section of docs/control.md on linear models: modes, layouts of cells, responses, root loci."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from docs.control_sections.trim_and_polar import PATH, PRESET, SPEED, dive, glider, shown
from docs.formatting import markdown_table, num, percent
from docs.quad_studies import degrees
from docs.validation_linear import in_one_density
from models.assemble import assemble
from models.controllability import Controllability, HoldingPower, controllability, holding_power
from models.design import Design, parse_design
from models.frequency_response import FrequencyResponse, frequency_response
from models.kernel.steady import LOADS, ROWS, TURN
from models.linear_model import LinearModel
from models.linearize import linearize
from models.mass_properties import mass_balance
from models.modes import Mode, modes_of
from models.operating_point import STEEPEST, OperatingPoint, point_of
from models.presets import load_preset
from models.presets.quad_glider import METACENTRIC_HEIGHT
from models.problems import DesignError, Problem
from models.root_locus import RootLocus, root_locus
from models.steady_problem import steady_problem
from models.targeted_trim import trim_for
from models.trim import Trim, trim_of

Array = NDArray[np.float64]
LAYOUTS = {
    "canete-dual-bellows": "the paper's two cells", "three-cell-glider": "three cells and a sliding battery",
    PRESET: "four cells", "movable-mass-twin": "movable-mass twin",
}  # fmt: skip
SHALLOW = 10.0
"""Depth at which layouts are compared, m: open water for all of them."""
HEIGHTS = 1e-3 * np.concatenate([np.linspace(6.0, 1.0, 26), np.linspace(0.95, -0.7, 34), np.linspace(-0.8, -2.0, 13)])
"""Metacentric heights of the root locus, m."""
BALLAST = "Trim ballast"
LAG = "actuator lag"
SYMBOLS = {"phi": "φ", "theta": "θ", "psi": "ψ"}
CODE = """
import math

from models.linearize import linearize
from models.modes import modes_of
from models.operating_point import point_of
from models.presets import load_preset
from models.targeted_trim import trim_for

glider = load_preset("quad-bellows-glide")
cells = [part.name for _, part in glider.vehicle.actuated]
dive = trim_for(glider, {"glide_angle": math.radians(-30), "speed": 0.3}, cells, depth=30.0)
model = linearize(glider, point_of(dive))
modes = modes_of(model.A, model.state_names)
print("A", model.A.shape, "B", model.B.shape, "C", model.C.shape, "D", model.D.shape)
print(f"stable: {modes.stable}; slowest: {modes.leading.name}, growth {modes.growth:.3f} 1/s")
"""


class Layout(NamedTuple):
    """One layout of cells: what it holds at rest, and what it moves in a dive, in its plane and in space."""

    name: str
    power: HoldingPower
    planar: Controllability | None
    spatial: Controllability


@cache
def model() -> LinearModel:
    """Return the linear model of the dive."""
    return linearize(glider(), point_of(dive()))


def in_a_dive(design: Design) -> Controllability:
    """Return what the cells of a design can move in the dive."""
    assembly = assemble(design)
    trim = trim_for(assembly, {"glide_angle": PATH, "speed": SPEED}, assembly.cells, depth=SHALLOW)
    assert isinstance(trim, Trim)
    parts = assembly.params.parts
    return controllability(linearize(assembly, point_of(trim)), parts["stop_high"] - parts["stop_low"])


@cache
def layouts() -> tuple[Layout, ...]:
    """Return what each layout can do."""
    found = []
    for preset, name in LAYOUTS.items():
        document = load_preset(preset).model_dump(mode="json")
        planar = in_a_dive(load_preset(preset)) if document["mission"]["solver"]["model"] == "planar" else None
        document["mission"]["solver"]["model"] = "spatial"
        spatial = parse_design(document)
        found.append(Layout(name, holding_power(spatial), planar, in_a_dive(spatial)))
    return tuple(found)


@cache
def response() -> FrequencyResponse:
    """Return the response of pitch to one cell."""
    return frequency_response(model(), input=model().input_names[0], output="theta")


def held_path(design: Design, _held: Mapping[str, float], last: OperatingPoint | None) -> OperatingPoint:
    """Return the upright glide on the path at the speed; after the first one, by Newton's method from the last.

    The last cell stays: four cells have one freedom more than is asked for.
    """
    assembly = assemble(design)
    if last is None:
        first = trim_for(assembly, {"glide_angle": PATH, "speed": SPEED}, assembly.cells)
        assert isinstance(first, Trim)
        return point_of(first)
    problem = steady_problem(assembly)
    motion = np.array([[last.roll, last.pitch, *last.velocity, 0.0, *last.extensions.values()]])
    wanted = np.zeros(len(ROWS))
    wanted[ROWS.index("glide_angle")], wanted[ROWS.index("speed")] = PATH, SPEED
    rows = np.array([*range(LOADS), *(ROWS.index(name) for name in ("glide_angle", "speed", "turn_rate"))])
    unknowns = np.arange(TURN + len(assembly.cells))
    if not problem.newton(motion, unknowns, rows, wanted=wanted)[0]:
        raise DesignError([Problem("", "no glide on this path near the last one")])
    return point_of(trim_of(problem, motion[0]))


@cache
def locus() -> tuple[RootLocus, Array]:
    """Return the root locus as the trim ballast rises, and the metacentric heights of the crossings, m."""
    design = in_one_density(PRESET)
    parts = design.vehicle.components
    index = next(i for i, part in enumerate(parts) if part.name == BALLAST)
    per_height = mass_balance(design.vehicle).mass / parts[index].mass
    neutral = parts[index].position[2] - METACENTRIC_HEIGHT * per_height
    pointer = f"/vehicle/components/{index}/position/2"
    found = root_locus(design, pointer, (neutral + HEIGHTS * per_height).tolist(), trim_at=held_path)
    return found, np.array([(crossing.value - neutral) / per_height for crossing in found.crossings])


def section() -> str:
    """Return the section."""
    parts = (model_text(), shown(CODE), modes_text(), control_text(), response_text(), locus_text())
    return "\n\n".join(parts) + "\n"


def model_text() -> str:
    """Tell what a linear model is."""
    return f"""## Linear models and modes

`linearize` (`models/linearize.py`) gives x' = drift + A x + B c, y = C x + D c for departures from an operating
point: a trim, an instant of a mission, or plain numbers. It need not be an equilibrium; `is_equilibrium`, `drift` and
`notes` say so.

- **States x:** z (m); φ, θ, ψ (rad); u, v, w through the water (m/s); p, q, r (rad/s), planar z, θ, u, w, q; and the
  extension (m; rad of a part that rolls) of each cell with a lag.
- **Inputs c:** the commanded extension of each cell. A cell without a lag follows at once.
- **Outputs y:** the minimal states, speed, α, β, flow angle, velocity over ground, turn rate, lift, drag, net
  buoyancy, every extension.
- **Left out:** position north and east (nothing depends on it); the quaternion (three angles do, but within
  {degrees(0.5 * math.pi - STEEPEST, 1)} of straight up or down there are none); rate limits and stops (they do not
  act on small motions); the change of the water as a dive goes on (frozen at its depth, but its slope over depth is
  in A).

**How:** the simulation's own kernel is differentiated by central differences with Richardson's extrapolation, so no
second set of equations can disagree with the first. What a step of the linear model leaves to the full one is of
second order in the step, in four presets: [validation.md](validation.md), 11."""


def modes_text() -> str:
    """Tell of the modes of the dive."""
    modes = modes_of(model().A, model().state_names)
    rows = [_mode_row(mode) for mode in modes.modes if not mode.name.startswith(LAG)]
    lags = [mode for mode in modes.modes if mode.name.startswith(LAG)]
    slow = next(mode for mode in modes.modes if mode.name == "depth")
    assert slow.time_constant is not None and lags[0].time_constant is not None
    header = ("Mode", "Growth, 1/s", "Time constant, s", "Period, s", "Damping", "States that take part most")
    return f"""### Modes of the dive

The dive at {num(math.degrees(dive().glide_angle), 0)}° and {num(SPEED, 1)} m/s, {num(dive().depth, 0)} m deep:

{markdown_table(header, rows)}

And {len(lags)} lags of the cells, {num(lags[0].time_constant, 1)} s each. Heading is neutral, since nothing depends
on it; depth falls back in {num(slow.time_constant / 3600.0, 0)} h, by the little that water and hull change with
depth. Neither tells of stability, so `modes.leading` passes over them. Shares are participation factors: they do not
depend on units. A mode is named after the states that take part most, so a name can change where two modes meet."""


def _mode_row(mode: Mode) -> tuple[str, ...]:
    shares = sorted(zip(mode.shares.tolist(), model().state_names, strict=True), reverse=True)
    constant = mode.time_constant
    told = ", ".join(f"{SYMBOLS.get(name, name)} {percent(share)}" for share, name in shares if share >= 0.05)
    return (
        mode.name, num(mode.growth, 3), "" if constant is None else _seconds(constant),
        "" if mode.period is None else num(mode.period, 1),
        "" if mode.damping_ratio is None or not mode.oscillates else num(mode.damping_ratio, 2), told,
    )  # fmt: skip


def _seconds(value: float) -> str:
    return num(value, 1) if value < 1e3 else num(round(value, -3), 0)


def control_text() -> str:
    """Tell what layouts can hold and move."""
    rows = []
    for each in layouts():
        of = each.power.authority
        values = ", ".join(num(value, 2) for value in of.singular_values)
        plane = "" if each.planar is None else f"{each.planar.rank} of {each.planar.states}"
        space = f"{each.spatial.rank} of {each.spatial.states}"
        rows.append((each.name, ", ".join(of.holds), str(of.rank), values, plane, space))
    header = ("Layout", "Holds apart", "Rank", "Singular values", "Planar states", "Spatial states")
    two = layouts()[0].spatial
    return f"""### What a layout of cells can hold and move

{markdown_table(header, rows, left=3)}

*At rest* (`holding_power`): the matrix of what a stroke of each cell does to heave, pitch and roll, each axis divided
by the authority of all cells on it. Its rank is how many axes are independent; an axis is held apart if it can be
given any small value with the other two at zero. Singular values that lie together mean that no combination of axes
is weaker than another: 1/√n where n cells share every axis, 1 where each axis has a part of its own. Whether an axis
is strong enough is another matter: `authority.alone` has newtons.

*In the dive* (`controllability`): how many states can be reached from the commands. Two cells in line move the plane
only; in space no command reaches {", ".join(two.unmoved)}. `modes[i].cosines` tells how well each cell moves a mode,
`distance` how far the model is from one in which it cannot be moved. `glider-studio allocate DESIGN` and
`POST /api/v1/analyses:allocation` answer for any design."""


def response_text() -> str:
    """Tell of the frequency response."""
    found = response()
    assert found.dc_gain is not None
    k = int(np.argmax(found.magnitude))
    per_mm = 1e-3 * math.degrees(1.0)
    return f"""### Frequency response

G(jω) = C (jω I − A)⁻¹ B + D from any input to any output (`frequency_response`). From the {found.input} to θ the gain
at rest is {num(found.dc_gain * per_mm, 2)}° per mm, and it is largest, {num(found.magnitude[k] * per_mm, 2)}° per mm,
at {num(found.frequencies[k], 2)} rad/s: a pitch loop has to be slower than that, or damp it. Where an output runs
away under a constant input, as heading does, the gain at rest is None."""


def locus_text() -> str:
    """Tell of the root locus."""
    found, heights = locus()
    (crossing,), (height,) = found.crossings, heights.tolist()
    roll = [k for k, name in enumerate(found.names) if name == "roll-sway oscillation"]
    last = found.eigenvalues[-1]
    return f"""### Root locus

![Eigenvalues of the dive as the metacentric height shrinks](img/control-locus.svg)

*Figure 6. Left: slow eigenvalues while the trim ballast rises, upper half. Right: their growth. The cells follow, so
that path and speed stay.*

`root_locus` takes any number of the design by its JSON Pointer (or an extension), finds the trim anew at each value
and follows each eigenvalue by continuity. Here `{found.pointer}`, the height of the trim ballast, takes the
metacentric height from {num(1e3 * HEIGHTS[0], 0)} to {num(1e3 * HEIGHTS[-1], 0)} mm, in water of one density. The
pitch oscillation slows down, at {num(1e3 * _splits(found), 2)} mm it splits into two real roots, and one crosses at
{num(1e3 * height, 2)} mm without oscillating (ω = {num(crossing.frequency, 2)} rad/s): from there on pitch runs away.
That this is as good as zero has a reason: where pitch departs slowly the path follows, the angle of attack hardly
changes, and the flow has nothing to right; only the weight has. The other root meets surge. Roll does not follow:
wing and fin keep its oscillation at {num(float(last[roll[0]].real), 2)} 1/s even at {num(1e3 * HEIGHTS[-1], 0)} mm.

`glider-studio linearize DESIGN --target glide_angle=-30deg --bode "command of Front port cell" theta --plot bode.svg`
and, with `--locus {found.pointer} -0.03 -0.05 -0.07`, eigenvalues at these values, there with the extensions of the
first trim held; over REST `POST /api/v1/analyses:linearize`."""


def _splits(found: RootLocus) -> float:
    """Return the metacentric height at which the pitch oscillation has become two real roots, m."""
    branches = [k for k, name in enumerate(found.names) if name == "pitch oscillation"]
    return float(HEIGHTS[np.flatnonzero(found.eigenvalues[:, branches[0]].imag == 0.0)[0]])
