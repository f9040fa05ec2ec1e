"""Owns sections 1 to 6 and 11 of docs/validation.md: what must hold by itself, whatever others have found."""

from __future__ import annotations

import math

from docs import validation_conservation as conservation
from docs import validation_energy as energy
from docs import validation_equations as equations
from docs import validation_linear as linear
from docs import validation_motions as motions
from docs import validation_slocum as slocum
from docs import validation_symmetries as symmetries
from docs.formatting import bound, markdown_table, num, order_of
from docs.validation_claims import exactly


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits."""
    return num(value, max(digits - 1 - math.floor(math.log10(abs(value))), 0))


def equations_section() -> str:
    """Describe check 1."""
    rows = [(str(case.count), bound(case.M), bound(case.V), bound(case.G)) for case in equations.planar_differences()]
    cases = equations.spatial_differences()
    return f"""## 1. The equations

**Planar.** `models/derivation.py` derives M, V and G of Eq. 5 by symbolic differentiation of T and U for any number of
components. Beside it stands what the compiled kernel does: M from its kinetic energy, V from its acceleration without
weight, G from its acceleration at rest. Random vehicles of a body, piston, movable mass, bellows and bladder with full
added mass, {equations.STATES} random states each; largest relative difference:

{markdown_table(("Components", "M", "V", "G"), rows, left=0)}

**Spatial.** The tests hold a second simulator, written from the equations and sharing no code with the kernel: momenta
in world axes, a rotation matrix instead of a quaternion, NumPy and SciPy. Accelerations at
{sum(len(case.relative) for case in cases)} random states (any attitude, up to 1 m/s and 1 rad/s about each axis) of
{len(cases)} designs, a test glider with everything off its plane of symmetry and every preset, agree within
{bound(max(float(case.relative.max()) for case in cases))}. The second simulator reads the same description and takes
the density against depth from the same table: check 9 holds that table.

![Differences of the equations](img/validation-equations.svg)

*Figure 1. Left: largest difference by components. Right: all states of the spatial comparison. Dashed: demanded.*
"""


def conservation_section() -> str:
    """Describe check 2."""
    words = {"drift": "drift of T + U", "state": "error of the states"}
    rows = [
        (case.model, words[case.what], case.method, str(case.theory), num(case.order, 1))
        for case in conservation.convergences()
    ]
    return f"""## 2. Conservation and order

Without forces of the water and at fixed extensions T + U must stay: what drifts is the integrator's error, and falls
with its order. Planar: the paper's glider in a slow swing, and the states of a fast tumble. Spatial: a glider turning
about all axes in stratified water, all parts off its plane of symmetry, with added mass; and the states of its glide
with all forces, against a step 64 times finer than the coarsest. Fixed steps, halved three times; order between the two
finest:

{markdown_table(("Model", "What", "Method", "Order by theory", "Observed"), rows, left=3)}

An error nearly along the surface of constant energy makes a drift fall faster than theory says: the demand is on the
least.

![Drift and error against the step](img/validation-conservation.svg)

*Figure 2. Marks: measured. Lines: the slope by theory through the finest step (blue 4, orange 5).*
"""


def moved_table() -> str:
    """Return the largest differences of the mirrored, turned and carried runs."""
    kinds = ("mirror", "yaw", "current")
    moved = [
        (case.name, num(float(case.original.times[-1]), 0), *(bound(case.places[k]) for k in kinds),
         *(bound(case.angles[k]) for k in kinds))
        for case in symmetries.moved_cases()
    ]  # fmt: skip
    header = (
        "Design",
        "Time, s",
        "Path, m: mirrored",
        "turned",
        "carried",
        "Attitude, rad: mirrored",
        "turned",
        "carried",
    )
    return markdown_table(header, moved)


def symmetries_section() -> str:
    """Describe check 3."""
    planar = [(case.preset_id, bound(case.difference), exactly(case.off_plane)) for case in symmetries.plane_cases()]
    north, east = symmetries.CURRENT
    return f"""## 3. Symmetries

**In its plane, space is the plane.** Every planar preset flown by both models at tolerance 10⁻¹²; position, attitude,
velocities and angle of attack, relative to 1 plus their largest value:

{markdown_table(("Preset", "Largest difference", "Out of the plane"), planar)}

**Mirror, heading, current.** A test glider and every spatial preset that goes by the clock, at tolerance 10⁻¹¹: port
and starboard exchanged; the start turned by {num(math.degrees(symmetries.YAW), 0)}°; and a constant current of
{num(north, 2)} m/s north and {num(east, 2)} m/s east, started with the same velocity through the water. Each path is
mapped back onto that of the original in still water; largest differences:

{moved_table()}

![Paths laid over each other](img/validation-symmetries.svg)

*Figure 3. Left: three presets by both models. Right: `{symmetries.DRAWN}` from above; dots lie where the mirrored,
turned and carried paths come when mapped back.*
"""


def terminal_section() -> str:
    """Describe check 4."""
    speeds, falls = motions.resting_speeds(), motions.falls()
    lightest, heaviest = (min(abs(f.net_weight) for f in falls), max(abs(f.net_weight) for f in falls))
    return f"""## 4. Terminal speed, and rest

A level body without lift or moment falls or rises broadside from rest, in the spatial model. Drag P_D V² must come to
the net weight W, V = √(W / P_D), on the way V tanh(t √(W P_D) / m). {len(falls)} net weights from
{num(lightest, 3)} to {num(heaviest, 0)} N, up and down: terminal speeds from
{num(1e3 * min(abs(f.speed) for f in falls), 1)} to {num(1e3 * max(abs(f.speed) for f in falls), 1)} mm/s, right within
{bound(max(abs(f.speed / f.expected - 1.0) for f in falls))}.

A neutral glider at rest, its centre of mass below its centre of buoyancy, stays: where weight and volume are exact in
binary its speed after 1000 s is {exactly(max(speeds["planar exact"], speeds["spatial exact"]))} in both models; the
paper's glider, neutral to rounding, stays below
{bound(max(speeds["planar paper"], speeds["spatial paper"]))} m/s.

![Terminal speed](img/validation-terminal.svg)

*Figure 4. Left: terminal speeds on the law. Right: every fall comes to it along one curve.*
"""


def trim_section() -> str:
    """Describe check 5."""
    still = max(
        float(slocum.departure(slocum.started_at_trim(0.0, model)).max()) for model in ("planar", "spatial")
    )  # fmt: skip
    last = float(slocum.departure(slocum.started_at_trim(slocum.OFFSETS_DEG[-1], "spatial"))[-1])
    return f"""## 5. A trim is a fixed point

Started in the closed-form equilibrium of check 8 (path angle {num(slocum.DESIGN_ANGLE_DEG, 0)}°), the Slocum stays:
over 600 s pitch, surge, heave and pitch rate depart by less than {bound(still)} (rad, m/s, rad/s) in both models.
Started with the pitch {num(slocum.OFFSETS_DEG[-1], 0)}° off, it comes back within {bound(last)}: the equilibrium of the
simulation is that of the formula.

Trims that are solved for: check 7 holds one against its simulation. Linear models about them: check 11.

![Departure from the equilibrium](img/validation-trim.svg)

*Figure 5. Started on the equilibrium, the departure is the integrator's error at tolerance 10⁻¹¹. Dashed: demanded.*
"""


def balance_section() -> str:
    """Describe check 6."""
    cases = energy.balances()
    rows = [
        (case.preset_id, case.run.model, num(float(case.run.times[-1]), 0), significant(case.run.energy_exchanged),
         *(bound(case.relative[tol]) if tol in case.relative else "—" for tol in energy.TOLERANCES))
        for case in cases
    ]  # fmt: skip
    left_out = [case.preset_id for case in cases if not case.whole]
    said = (
        f"Flown at the default tolerance only, since it takes more than {energy.MOST_STEPS:,} steps: "
        + ", ".join(left_out) if left_out else "Every preset is flown whole at every tolerance."
    )  # fmt: skip
    header = ("Preset", "Model", "Time, s", "Exchanged, J",
              *(f"Residual at {order_of(tol).removeprefix('1 × ')}" for tol in energy.TOLERANCES))  # fmt: skip
    return f"""## 6. Work-energy balance

Kinetic and potential energy less the works of actuators, water and bed must not change. The works are integrated with
the motion, inside its error control. The largest residual of each preset, as a share of the energy exchanged (the
largest of kinetic energy, works, and what weight and buoyancy released); the default tolerance is
{order_of(energy.DEFAULT_TOLERANCE).removeprefix("1 × ")}:

{markdown_table(header, rows, left=2)}

{said}

![Energy residual](img/validation-balance.svg)

*Figure 6. Left: residual over time, largest in each of 120 windows. Right: largest against the tolerance. Dashed:
demanded.*
"""


def linear_section() -> str:
    """Describe check 11."""
    rows = [
        (case.preset_id, case.model, case.part, *map(order_of, case.differences), num(float(case.orders[-1]), 2))
        for case in linear.step_responses()
    ]
    header = ("Preset", "Model", "Part", *(f"Step {num(1e3 * step, 1)} mm" for step in linear.STEPS), "Order")
    return f"""## 11. Linear models

From a stable trim the command of one part steps (in mrad where it rolls), and the response over
{num(linear.DURATION, 0)} s is computed twice: by the full equations at tolerance 10⁻¹², and by the linear model about
the trim, exactly, as a matrix exponential. What is left between them must be of second order in the step: halved, it
falls to a quarter. A wrong slope would leave an error of first order. Largest difference in depth, angles, velocities
and rates (m, rad, m/s, rad/s), in water of one density and with parts that keep their volume, where a trim holds at
every depth:

{markdown_table(header, rows, left=3)}
"""
