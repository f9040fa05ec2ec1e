"""Owns what a design's consequences give reason to warn of: trims that fail, margins lost, stops met, little reserve.

Each warning tells the inequality with its numbers, what to do, the field it is about, and when it holds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from models.components import Bladder, Piston, RollingMass, extension_unit
from models.design import Design
from models.moments import moment_in_words, stretch_in_words
from models.operating_point import down_in_body
from models.problems import Problem, pointer_to
from models.stability import Quantity, stretches_lost, worst_of
from studio.cell_reach import NEAR_STOP, CellReach, StopReach
from studio.holds import Span
from studio.run_marks import MOST_SPANS

if TYPE_CHECKING:
    from studio.consequences import Margins
    from studio.held_glides import HeldGlide

LITTLE = 0.1
"""Share of what the cells change net buoyancy by, in all, that should be left on the other side of neutral."""
NOISE = 1e-9
"""Share of the same that is a rounding error."""
OF_MARGINS = ("pitch_stiffness", "pitch_margin", "yaw_margin")
"""Margins warned of here; that weight lies above buoyancy is told by the run's own warnings."""
MARGIN_HINTS = {
    "pitch_stiffness": "place weight lower, or cells so that they swell higher",
    "pitch_margin": "move the wing or the fins aft, or weight forward",
    "yaw_margin": "add a vertical fin aft, or move weight forward",
}


@dataclass(frozen=True)
class Warned:
    """A warning with its severity, `bad` or `warn` or `note`, and the stretches of the run (s) in which it holds."""

    severity: str
    problem: Problem
    times: tuple[Span, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the warning as the page shows it; `more_times` counts the stretches beyond those that it is sent."""
        sent = self.times[:MOST_SPANS]
        return self.problem.as_dict() | {
            "severity": self.severity, "times": sent, "more_times": len(self.times) - len(sent),
        }  # fmt: skip


def severity_of(problem: Problem) -> str:
    """Return how much a warning of a run counts: a run that is not accurate tells nothing at all."""
    return "bad" if problem.pointer.startswith("/mission/solver") else "warn"


def warnings_of(
    design: Design, glides: Sequence[HeldGlide], margins: Margins | None, cells: Sequence[CellReach], *, end: float
) -> Iterator[Warned]:
    """Yield everything to warn of, the hold's trims first; nothing of holds that the run, until `end` (s), missed."""
    glides = [glide for glide in glides if glide.hold.reached]
    for glide in glides:
        yield from _of_trim(design, glide, end)
    yield from _of_reserve(design, glides)
    if margins is not None:
        steady = all(glide.trim is not None and glide.trim.stable for glide in glides)
        yield from _of_margins(margins, end, steady=steady)
    for cell in cells:
        yield from _of_stops(design, cell, end)


def times_in_words(spans: Sequence[Span], end: float) -> str:
    """Return stretches of a run that ends at `end` (s) in words."""
    told = ", ".join(stretch_in_words(start, stop, end) for start, stop in spans[:3])
    return told if len(spans) <= 3 else f"{told} and {len(spans) - 3} more"


def _of_trim(design: Design, glide: HeldGlide, end: float) -> Iterator[Warned]:
    held, trim = times_in_words(glide.hold.spans, end), glide.trim
    if trim is not None and not trim.stable:
        doubles = f"double in {math.log(2.0) / trim.growth:.3g} s, " if trim.growth > 1e-6 else ""
        others = ", as are all others there" if glide.others else ""
        message = (
            f"unstable glide: small motions {doubles}growing by {trim.growth:.3g} 1/s about the trim with the cells as "
            f"held {held}{others}"
        )
        hint = "see which one in the modes; a fin, or weight placed lower, steadies most"
        yield Warned("bad", Problem("/vehicle/components", message, 0.0, hint), glide.hold.spans)
    elif trim is not None and down_in_body(trim.roll, trim.pitch)[2] < 0.0:
        message = (
            f"with the cells as held {held} the only glide it settles in is upside down: pitch "
            f"{math.degrees(trim.pitch):.0f} deg, roll {math.degrees(trim.roll):.0f} deg"
        )
        yield Warned("bad", Problem("/vehicle/components", message, 90.0, "place weight lower"), glide.hold.spans)
    elif trim is None and glide.why is not None and glide.searched:
        schedules = design.mission.control.schedules
        pointer = "/mission/control/schedules/0" if schedules else "/mission/initial/extensions"
        message = f"there is no steady glide with the cells as held {held}: {glide.why}"
        hint = "command extensions that make it heavier or lighter than the water"
        yield Warned("warn", Problem(pointer, message, None, hint), glide.hold.spans)


def _of_reserve(design: Design, glides: Sequence[HeldGlide]) -> Iterator[Warned]:
    """Warn where all cells together hardly bring net buoyancy to the other side of neutral, in the worst water met."""
    if not glides:
        return
    low, high = (max if down else min for down in (True, False))
    least = low(glide.reserve.least for glide in glides)
    most = high(glide.reserve.most for glide in glides)
    span = most - least
    if span <= 0.0:
        return
    for reached, sign, what, way in (
        (most, 1.0, "light", "rise"), (-least, -1.0, "heavy", "sink"),
    ):  # fmt: skip
        if reached >= LITTLE * span:
            continue
        reached = 0.0 if abs(reached) < NOISE * span else reached
        message = (
            f"with every cell as {what} as its stops allow net buoyancy is {sign * reached:+.3g} N, "
            f"{'less' if sign > 0 else 'more'} than {sign * LITTLE * span:+.3g} N, a tenth of what the cells change"
        )
        hint = (
            f"{'it can hardly' if reached > 0.0 else 'it cannot'} {way}: "
            f"{'make it lighter' if sign > 0 else 'make it heavier'}, trim the ballast, or give cells longer strokes"
        )
        yield Warned("warn" if reached > 0.0 else "bad", Problem("/vehicle/components", message, LITTLE * span, hint))


def margin_in_words(quantity: Quantity, value: float) -> str:
    """Return a margin in the units of the page's readouts: in mm, or in hundredths of the vehicle's length."""
    return f"{1e2 * value:.3g} % L" if quantity.unit == "1" else f"{1e3 * value:.3g} mm"


def _of_margins(margins: Margins, end: float, *, steady: bool) -> Iterator[Warned]:
    for quantity in margins.quantities:
        if quantity.name not in OF_MARGINS:
            continue
        values = margins.series[quantity.name]
        lost = stretches_lost(quantity, margins.times, values)
        worst = worst_of(quantity, margins.times, values)
        if not lost or worst is None:
            continue
        meanwhile = "; the trims are stable all the same" if steady else ""
        message = (
            f"{quantity.words} is below 0 from {times_in_words(lost, end)}, at worst "
            f"{margin_in_words(quantity, worst.value)} at {moment_in_words(worst.time, end)}{meanwhile}"
        )
        problem = Problem(quantity.pointer, message, 0.0, MARGIN_HINTS[quantity.name])
        yield Warned("note" if steady else "warn", problem, tuple(lost))


def _of_stops(design: Design, cell: CellReach, end: float) -> Iterator[Warned]:
    """Warn of each stop that a cell meets, and of one that it only comes near to."""
    index, part = next((i, part) for i, part in design.vehicle.actuated if part.name == cell.name)
    pointer = pointer_to("vehicle", "components", index, stop_field(part))
    for reach in (cell.low, cell.high):
        if not reach.near:
            continue
        shown = f"{reach.stop * 1e3:.4g} mm" if extension_unit(part) == "m" else f"{math.degrees(reach.stop):.4g} deg"
        stop = f"its {reach.side} stop, {shown}"
        hint = f"ask for less, or {'lower' if reach.side == 'lower' else 'raise'} the stop"
        if reach.at:
            message = f"'{cell.name}' is at {stop}, from {times_in_words(reach.at, end)}"
            yield Warned("note", Problem(pointer, message, reach.stop, hint), reach.at)
        else:
            message = f"'{cell.name}' {_nearness(reach, stop, end)}"
            yield Warned("note", Problem(pointer, message, reach.near_limit, hint), reach.near)


def _nearness(reach: StopReach, stop: str, end: float) -> str:
    return (
        f"comes within {1e2 * reach.least:.2g} % of its stroke of {stop}, at {moment_in_words(reach.time, end)}; "
        f"less than {1e2 * NEAR_STOP:.0f} % from {times_in_words(reach.near, end)}"
    )


def stop_field(part: object) -> str:
    """Return the field that sets the stops of a part."""
    match part:
        case Piston():
            return "volume_range"
        case Bladder():
            return "extensions"
        case RollingMass():
            return "angle_range"
    return "extension_range"
