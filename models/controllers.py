"""Owns the description of closed-loop control: guidance, loops, allocation, and state feedback by a table of gains.

Heave is a change of net buoyancy (N, up), pitch a moment (N m, nose up), roll a moment (N m, starboard down), all from
those with every cell at neutral.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from models.components import Extension
from models.fields import LARGEST_WHOLE, Description, Name, Switch, quantity, text, vector

LARGEST_FORCE = 1e6
Angle = Annotated[float, Field(strict=True, ge=-math.pi, le=math.pi)]
Place = tuple[
    Annotated[float, Field(strict=True, ge=-1e7, le=1e7)], Annotated[float, Field(strict=True, ge=-1e7, le=1e7)]
]
Number = Annotated[float, Field(strict=True, ge=-1e12, le=1e12)]
MEASURED = ("z", "phi", "theta", "psi", "u", "v", "w", "p", "q", "r")
"""States that state feedback may use, in the kernel's order; extensions of cells by their names besides."""


class Noise(Description):
    """Errors of the instruments: normal, new at every sample, of the stated standard deviation."""

    depth: float = quantity("Of the depth.", unit="m", symbol="s_z", ge=0.0, le=1e3, default=0.0)
    attitude: float = quantity("Of roll, pitch and heading.", unit="rad", symbol="s_a", ge=0.0, le=3.0, default=0.0)
    velocity: float = quantity(
        "Of the velocity through the water.", unit="m/s", symbol="s_v", ge=0.0, le=10.0, default=0.0
    )
    rate: float = quantity("Of the angular velocity.", unit="rad/s", symbol="s_w", ge=0.0, le=10.0, default=0.0)
    place: float = quantity("Of the place north and east.", unit="m", symbol="s_x", ge=0.0, le=1e5, default=0.0)
    seed: int = quantity(
        "Seed: the same seed gives the same errors.", unit="1", symbol="seed", ge=0, le=LARGEST_WHOLE, default=0
    )


class Timing(Description):
    """When a controller samples, and when its commands arrive."""

    sample_time: float = quantity(
        "Time between samples; commands are held in between.", unit="s", symbol="T_s", ge=1e-3, le=1e4, default=1.0
    )
    delay: float = quantity(
        "Time from a sample until its commands reach the actuators.",
        unit="s", symbol="T_d", ge=0.0, le=1e4, default=0.0,
    )  # fmt: skip


class _Sampled(Timing):
    deadband: float = quantity(
        "Share of its stroke by which a command must change before an actuator is bothered.",
        unit="1", symbol="d", ge=0.0, le=1.0, default=0.0,
    )  # fmt: skip
    noise: Noise = text("Errors of what is measured.", default=Noise())


class Loop(Description):
    """A loop from an angle to a moment: P on the error, I on its integral, D on the measured rate of turning."""

    proportional: float = quantity("Gain on the error.", unit="N m/rad", symbol="k_p", ge=-1e9, le=1e9, default=0.0)
    integral: float = quantity(
        "Gain on the error's integral.", unit="N m/(rad s)", symbol="k_i", ge=-1e9, le=1e9, default=0.0
    )
    derivative: float = quantity(
        "Gain on the measured rate of turning.", unit="N m s/rad", symbol="k_d", ge=-1e9, le=1e9, default=0.0
    )
    limit: float = quantity(
        "Largest magnitude of the moment.", unit="N m", symbol="M_max", gt=0.0, le=1e9, default=LARGEST_FORCE
    )


class HeadingLoop(Description):
    """The loop from the heading to a bank: P on the error, I on its integral, D on the measured rate of turning."""

    proportional: float = quantity(
        "Bank for an error of heading, rad by rad.", unit="1", symbol="k_p", ge=-1e9, le=1e9, default=1.0
    )
    integral: float = quantity("Gain on the error's integral.", unit="1/s", symbol="k_i", ge=-1e9, le=1e9, default=0.0)
    derivative: float = quantity("Gain on the measured yaw rate.", unit="s", symbol="k_d", ge=-1e9, le=1e9, default=0.0)
    limit: float = quantity("Largest bank.", unit="rad", symbol="phi_max", gt=0.0, le=1.5, default=0.5)


class HoldHeave(Description):
    """One net buoyancy all the time: a dive, or a climb where it is positive."""

    kind: Literal["heave"] = text("Which vertical guidance this is: one heave.", default="heave")
    heave: float = quantity(
        "Change of net buoyancy, up.", unit="N", symbol="F", ge=-LARGEST_FORCE, le=LARGEST_FORCE, default=0.0
    )


class DepthBand(Description):
    """Yo-yo between two depths: heavy until the bottom of the band, light until its top."""

    kind: Literal["depth_band"] = text("Which vertical guidance this is: a yo-yo.")
    top: float = quantity("Depth at which a dive begins.", unit="m", symbol="z_top", ge=0.0, le=12e3)
    bottom: float = quantity("Depth at which a climb begins.", unit="m", symbol="z_bottom", ge=0.0, le=12e3)
    dive_heave: float = quantity(
        "Change of net buoyancy on dives (negative sinks).", unit="N", symbol="F_dive", ge=-LARGEST_FORCE, le=0.0
    )
    climb_heave: float = quantity(
        "Change of net buoyancy on climbs.", unit="N", symbol="F_climb", ge=0.0, le=LARGEST_FORCE
    )
    first: Literal["dive", "climb"] = text("What it begins with, between the two depths.", default="dive")

    @model_validator(mode="after")
    def _top_above_bottom(self) -> Self:
        if not self.top < self.bottom:
            raise ValueError(f"top {self.top:g} m is not above bottom {self.bottom:g} m: exchange them")
        return self


class Pitch(Description):
    """What is done about pitch: moments by phase, and a loop about target angles."""

    dive: float | None = quantity(
        "Pitch to hold on dives (and all the time, without a depth band); none leaves the loop open.",
        unit="rad", symbol="theta_dive", ge=-math.pi / 2, le=math.pi / 2, default=None,
    )  # fmt: skip
    climb: float | None = quantity(
        "Pitch to hold on climbs; minus that of dives if not given.",
        unit="rad", symbol="theta_climb", ge=-math.pi / 2, le=math.pi / 2, default=None,
    )  # fmt: skip
    dive_moment: float = quantity(
        "Moment on dives (and all the time, without a depth band), to which the loop adds.",
        unit="N m", symbol="M_dive", ge=-LARGEST_FORCE, le=LARGEST_FORCE, default=0.0,
    )  # fmt: skip
    climb_moment: float | None = quantity(
        "Moment on climbs, to which the loop adds; if not given none within a depth band, else that on dives.",
        unit="N m", symbol="M_climb", ge=-LARGEST_FORCE, le=LARGEST_FORCE, default=None,
    )  # fmt: skip
    loop: Loop = text("Gains from the error of pitch to a moment.", default=Loop())

    @model_validator(mode="after")
    def _climb_needs_dive(self) -> Self:
        if self.dive is None and self.climb is not None:
            raise ValueError("climb is given, dive is not: give the pitch of dives too")
        return self


class HoldRoll(Description):
    """One bank all the time, which turns the glider."""

    kind: Literal["roll"] = text("Which lateral guidance this is: one bank.")
    roll: float = quantity(
        "Bank on dives; on climbs times the sense of the bank.",
        unit="rad", symbol="phi", ge=-math.pi / 2, le=math.pi / 2, default=0.0,
    )  # fmt: skip


class HoldHeading(Description):
    """One heading all the time."""

    kind: Literal["heading"] = text("Which lateral guidance this is: one heading.")
    heading: float = quantity("Heading.", unit="rad", symbol="psi", ge=-math.pi, le=math.pi)


class Waypoints(Description):
    """From place to place: along the line between two, by integral line of sight, or straight at the next.

    Place is taken as known under water, which real gliders only estimate between fixes.
    """

    kind: Literal["waypoints"] = text("Which lateral guidance this is: waypoints.")
    points: tuple[Place, ...] = vector(
        "Places north and east; the first leg begins where the glider starts.",
        unit="m", symbol="x_k, y_k", min_length=1, max_length=1000,
    )  # fmt: skip
    radius: float = quantity(
        "Distance at which a waypoint counts as reached.", unit="m", symbol="R_a", gt=0.0, le=1e6, default=20.0
    )
    lookahead: float | None = quantity(
        "Distance ahead on the line at which the glider aims; none heads straight for the waypoint.",
        unit="m", symbol="Delta", gt=0.0, le=1e6, default=None,
    )  # fmt: skip
    integral: float = quantity(
        "Gain of the integral that leans into a current, with a lookahead.",
        unit="m/s", symbol="sigma", ge=0.0, le=1e3, default=0.0,
    )  # fmt: skip
    repeat: Switch = text("Begin again after the last, or hold on along the last leg.", default=False)

    @model_validator(mode="after")
    def _legs_have_a_length(self) -> Self:
        for k, (a, b) in enumerate(pairwise(self.points), start=1):
            if math.dist(a, b) == 0.0:
                raise ValueError(f"points {k} and {k + 1} are the same place: remove one")
        if self.repeat and math.dist(self.points[0], self.points[-1]) == 0.0:
            raise ValueError(
                "repeat needs two places or more, and the last point is not the first: the way goes back there anyway"
            )
        return self


class Station(Description):
    """Keep a station: spiral near it, head back where the spiral has drifted out of a circle."""

    kind: Literal["station"] = text("Which lateral guidance this is: station keeping.")
    center: Place = vector("Place north and east.", unit="m", symbol="x_s, y_s")
    radius: float = quantity(
        "Radius beyond which the glider heads back, until it is within half of it.",
        unit="m", symbol="R_s", gt=0.0, le=1e6,
    )  # fmt: skip
    bank: float = quantity(
        "Bank of the spiral on dives.", unit="rad", symbol="phi_s", ge=-math.pi / 2, le=math.pi / 2, default=0.35
    )


Vertical = Annotated[HoldHeave | DepthBand, Field(discriminator="kind")]
LateralGuidance = Annotated[HoldRoll | HoldHeading | Waypoints | Station, Field(discriminator="kind")]


class Lateral(Description):
    """What is done about bank and heading."""

    guidance: LateralGuidance = text("Which bank or heading, or way, is wanted.")
    roll_loop: Loop = text("Gains from the error of bank to a roll moment.")
    heading_loop: HeadingLoop = text(
        "Gains from the error of heading to a bank; its limit is the largest bank.",
        default=HeadingLoop(),
    )
    climb_bank: Literal["same", "opposite"] = text(
        "Sense of the bank that turns to the same side on climbs: opposite where the wing's lift turns the glider, "
        "since it points down on climbs.",
        default="opposite",
    )


class Weights(Description):
    """How much each axis counts where the cells cannot do all, relative to what they can do on it."""

    heave: float = quantity("Of heave.", unit="1", symbol="w_F", gt=0.0, le=1e6, default=1.0)
    pitch: float = quantity("Of the pitch moment.", unit="1", symbol="w_M", gt=0.0, le=1e6, default=1.0)
    roll: float = quantity("Of the roll moment.", unit="1", symbol="w_K", gt=0.0, le=1e6, default=1.0)


class AllocationRule(Description):
    """Which cells share what is wanted, and how: bounded least squares over any number of them."""

    cells: tuple[Name, ...] | None = text("Cells under control; none means all that move.", default=None)
    weights: Weights = text("How much each axis counts.", default=Weights())
    effort: dict[Name, Annotated[float, Field(strict=True, gt=0.0, le=1e6)]] = vector(
        "How unwillingly a cell leaves neutral beside the others, by name; 1 where not named.",
        unit="1", symbol="r_i", default={},
    )  # fmt: skip


class Cascade(_Sampled):
    """Guidance, loops over pitch, bank and heading, and allocation of heave, pitch and roll to the cells."""

    kind: Literal["cascade"] = text("Which controller this is: guidance, loops and allocation.")
    vertical: Vertical = text("Heave, and when to dive and to climb.", default=HoldHeave())
    pitch: Pitch = text("What is done about pitch.", default=Pitch())
    lateral: Lateral | None = text("What is done about bank and heading; none leaves them alone.", default=None)
    allocation: AllocationRule = text("How the cells share what is wanted.", default=AllocationRule())
    unwind_time: float = quantity(
        "Time in which an integral gives back what the cells or a limit cut off.",
        unit="s", symbol="T_t", ge=1e-2, le=1e6, default=20.0,
    )  # fmt: skip


class GainPoint(Description):
    """Trim and gains at one value of the set point."""

    value: float = quantity("Value of the set point.", unit="1", symbol="s", ge=-1e12, le=1e12)
    extensions: tuple[Extension, ...] = vector("Extensions in trim, by cell.", unit="m", symbol="e_0")
    state: tuple[Number, ...] = vector("States in trim, in their own units.", unit="1", symbol="x_0")
    gains: tuple[tuple[Number, ...], ...] = vector(
        "A row a cell: gains on the states, then on the integrals, m by the state's unit.", unit="1", symbol="K"
    )


class SetPoint(Description):
    """What is asked for at a time; linear between two."""

    time: float = quantity("Time since the start of the mission.", unit="s", symbol="t", ge=0.0, le=1e9)
    value: float = quantity("Value of the set point.", unit="1", symbol="s", ge=-1e12, le=1e12)


class StateFeedback(_Sampled):
    """e = e_0 - K (x - x_0) - K_i integral of (x - x_0), with trim and gains from a table over a set point."""

    kind: Literal["state_feedback"] = text("Which controller this is: state feedback.")
    cells: tuple[Name, ...] = text("Cells under control, in the order of the gains' rows.", min_length=1)
    states: tuple[Name, ...] = text(
        f"States fed back, in the order of the gains' columns: {', '.join(MEASURED)}, or a cell's name for its "
        "extension.",
        min_length=1, max_length=64,
    )  # fmt: skip
    integrals: int = quantity(
        "How many of the first states are integrated too.", unit="1", symbol="n_i", ge=0, le=8, default=0
    )
    points: tuple[GainPoint, ...] = text("Table of trims and gains, in rising order.", min_length=1, max_length=1000)
    set_points: tuple[SetPoint, ...] = text(
        "What is asked for over time; the first point of the table if none is given.", default=(), max_length=10_000
    )
    scheduled_by: str = text("What the set point is, for people.", default="", max_length=200)

    @model_validator(mode="after")
    def _shapes_agree(self) -> Self:
        cells, states = len(self.cells), len(self.states)
        for names, what in ((self.cells, "cells"), (self.states, "states")):
            twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
            if twice is not None:
                raise ValueError(f"{what} name '{twice}' twice: name it once")
        if self.integrals > states:
            raise ValueError(f"integrals {self.integrals} exceed the {states} states")
        for k, point in enumerate(self.points, start=1):
            shape = (len(point.extensions), len(point.state), len(point.gains), {len(row) for row in point.gains})
            if shape != (cells, states, cells, {states + self.integrals}):
                raise ValueError(
                    f"point {k} has {shape[0]} extensions, {shape[1]} states and gains of {shape[2]} rows by "
                    f"{sorted(shape[3])} columns; {cells} cells, {states} states and {self.integrals} integrals need "
                    f"{cells}, {states} and {cells} by {states + self.integrals}"
                )
        rising = {
            "values of points": [point.value for point in self.points],
            "times of set_points": [point.time for point in self.set_points],
        }
        for what, values in rising.items():
            if any(not a < b for a, b in pairwise(values)):
                raise ValueError(f"{what} must rise")
        return self


Controller = Annotated[Cascade | StateFeedback, Field(discriminator="kind")]


def names_under_control(controller: Controller | None, moving: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the cells that a controller commands, of those that move."""
    match controller:
        case None:
            return ()
        case Cascade():
            return controller.allocation.cells if controller.allocation.cells is not None else tuple(moving)
        case StateFeedback():
            return controller.cells
