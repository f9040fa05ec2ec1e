"""Owns what is asked of the design of a controller: about which trim, by which method, for which cells and states."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from models.components import Extension
from models.controllers import SetPoint, Timing
from models.fields import Description, Name, quantity, text, vector

Deviation = Annotated[float, Field(strict=True, gt=0.0, le=1e6)]
Share = Annotated[float, Field(strict=True, gt=0.0, le=1.0)]
Part = Annotated[float, Field(strict=True, ge=-1e4, le=1e4)]
Pole = tuple[Part, Part]
Departure = Annotated[float, Field(strict=True, ge=-10.0, le=10.0)]
Target = Annotated[float, Field(strict=True, ge=-1e6, le=1e6)]
MOST_TRIMS = 50
"""Trims of one table: each is sought, designed for and looked at in about a second."""
STEPPED = ("theta", "phi", "psi", "u")
"""States whose set point can be stepped."""


class TrimOptions(Description):
    """The steady motion to design about: one that meets targets, or the first stable one at given extensions."""

    targets: dict[Name, Target] = vector(
        "What the steady motion must meet: any of glide_angle, speed, sink_rate, turn_rate, pitch, roll, turn_radius.",
        unit="rad, m/s, rad/s, m", symbol="y_t", default={},
    )  # fmt: skip
    free: tuple[Name, ...] | None = text(
        "Cells that may move to meet the targets; all that move if not given (in a table, those under control).",
        default=None,
    )
    extensions: dict[Name, Extension] = vector(
        "Extensions by cell; those of the mission's start where not named.", unit="m", symbol="e", default={}
    )
    depth: float | None = quantity(
        "Depth; that of the mission's start if not given.", unit="m", symbol="z", ge=0.0, le=12e3, default=None
    )
    heading: float = quantity("Heading to hold.", unit="rad", symbol="psi", ge=-math.pi, le=math.pi, default=0.0)


class StepOptions(Description):
    """A step of one set point at the start, flown to see how the loop answers."""

    state: Literal["theta", "phi", "psi", "u"] = text("Which state is asked to change.", default="theta")
    amount: float = quantity("By how much, rad or m/s.", unit="1", symbol="a", ge=-10.0, le=10.0, default=0.02)
    duration: float = quantity("How long to watch.", unit="s", symbol="t_end", gt=0.0, le=1e5, default=120.0)

    @model_validator(mode="after")
    def _is_a_step(self) -> Self:
        if self.amount == 0.0:
            raise ValueError("amount 0 is no step: give the change that is asked for")
        return self


class TableOptions(Description):
    """A table of gains over one target of the trim, and what is asked of it over time."""

    target: Literal["glide_angle", "pitch", "speed", "sink_rate"] = text(
        "Which target the table is over.", default="glide_angle"
    )
    values: tuple[Target, ...] = vector(
        "Its values, in rising order.", unit="rad or m/s", symbol="s", min_length=2, max_length=MOST_TRIMS
    )
    set_points: tuple[SetPoint, ...] = text("What is asked for over time.", default=(), max_length=10_000)

    @model_validator(mode="after")
    def _values_rise(self) -> Self:
        if any(not a < b for a, b in pairwise(self.values)):
            raise ValueError("values must rise")
        return self


class ControllerOptions(Timing):
    """How a state feedback is designed.

    Weights follow Bryson's rule: one over the square of the largest acceptable deviation (Bryson and Ho, 1975, 5.2).
    """

    trim: TrimOptions = text("The steady motion to design about.", default=TrimOptions())
    method: Literal["lqr", "poles"] = text("Least quadratic cost, or poles where they are asked for.", default="lqr")
    states: tuple[Name, ...] | None = text(
        "States fed back; if not given, all of the motion that the cells can move, and the extensions of cells that "
        "lag.",
        default=None,
    )
    cells: tuple[Name, ...] | None = text("Cells under control; none means all that move.", default=None)
    deviations: dict[Name, Deviation] = vector(
        "Largest acceptable deviation by state, in its unit; 0.1 rad, m/s and rad/s, 1 m of depth, half a stroke where "
        "not named.",
        unit="m, rad, m/s, rad/s", symbol="dx_max", default={},
    )  # fmt: skip
    shares: dict[Name, Share] = vector(
        "Largest acceptable departure of a cell's command, as a share of its stroke; `share` where not named.",
        unit="1", symbol="du_max", default={},
    )  # fmt: skip
    share: Share = quantity(
        "Largest acceptable departure of the commands that `shares` does not name, as a share of the stroke.",
        unit="1", symbol="du_max", default=0.2,
    )  # fmt: skip
    integrals: int = quantity(
        "How many of the first states are integrated, so that they settle without an error.",
        unit="1", symbol="n_i", ge=0, le=8, default=0,
    )  # fmt: skip
    integral_time: float = quantity(
        "The largest acceptable integral is this time the state's largest deviation.",
        unit="s", symbol="T_i", gt=0.0, le=1e6, default=60.0,
    )  # fmt: skip
    poles: tuple[Pole, ...] = vector(
        "Poles (real and imaginary part) of the closed loop, one a state and integral, with their conjugates.",
        unit="1/s", symbol="s_k", default=(), max_length=72,
    )  # fmt: skip
    step: StepOptions | None = text("A step to fly; none if not given.", default=None)
    departures: dict[Name, Departure] = vector(
        "Departures of states from the trim at the start, from which the loop is flown back; the first is watched.",
        unit="rad, m/s, rad/s", symbol="dx_0", default={},
    )  # fmt: skip
    recovery_duration: float = quantity(
        "How long to watch the way back from departures.", unit="s", symbol="t_end", gt=0.0, le=1e5, default=120.0
    )
    table: TableOptions | None = text("A table of gains over a target; one trim if not given.", default=None)

    @model_validator(mode="after")
    def _poles_are_what_the_method_needs(self) -> Self:
        if (self.method == "poles") != bool(self.poles):
            raise ValueError("poles are given with the method 'poles', and only then")
        poles = [complex(*pole) for pole in self.poles]
        for pole in poles:
            if poles.count(pole) != poles.count(pole.conjugate()):
                raise ValueError(f"pole {pole.real:g} {pole.imag:+g}j lacks its conjugate: give both")
        return self
