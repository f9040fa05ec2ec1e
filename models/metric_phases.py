"""Owns the descriptions of parts of a run over which a metric may be taken: a dive, a stretch of time, while it turns.

How each is found in a run's samples is in `models.metric_windows`.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from models.fields import Description, Name, Switch, quantity, text

LONGEST = 1e9
"""Largest time that a phase may name, s."""
DEEPEST_NESTING = 4
"""Phases and metrics may be nested this deep."""
EventKind = Literal["surface", "bed", "end_of_stroke", "dive", "climb", "waypoint"]
Output = Annotated[str, Field(min_length=1, max_length=80)]


def _counts(number: int) -> int:
    if number == 0:
        raise ValueError("numbers count from 1, or from the last with -1: there is no 0")
    return number


Number = Annotated[int, AfterValidator(_counts)]


def counting(description: str, **options: int | None) -> Number:
    """Make a field that counts things from 1, or from the last with -1."""
    return quantity(description, unit="1", symbol="n", ge=-1000, le=1000, **options)  # type: ignore[no-any-return]


class EventAt(Description):
    """An event of a run."""

    event: EventKind = text("What happened: see the events of a run.")
    cell: Name | None = text("Which cell it happened to; none is any.", default=None)
    number: Number = counting("Which of them: 1 is the first, -1 the last.", default=1)

    @property
    def event_words(self) -> str:
        """The event in words."""
        named = self.event if self.cell is None else f"{self.event} of {self.cell}"
        return f"{named} {self.number}"


class Limited(Description):
    """What asks for a limit, above or below."""

    of: Output = text("Which output of the run, by its name.")
    cell: Name | None = text("Which cell, where the output is of cells.", default=None)
    above: float | None = quantity("Counts while larger than this.", unit="that of the output", symbol="l",
                                   ge=-1e15, le=1e15, default=None)  # fmt: skip
    below: float | None = quantity("Counts while smaller than this.", unit="that of the output", symbol="l",
                                   ge=-1e15, le=1e15, default=None)  # fmt: skip
    absolute: Switch = text("Whether magnitudes count, whatever the sign.", default=False)

    @model_validator(mode="after")
    def _has_one_limit(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give one limit: above or below")
        return self

    @property
    def bound(self) -> float:
        """The limit, of either side."""
        return self.above if self.above is not None else self.below  # type: ignore[return-value]

    @property
    def limit_words(self) -> str:
        """The condition in words."""
        side = f"above {self.above:g}" if self.above is not None else f"below {self.below:g}"
        return f"{output_words(self.of, self.cell, absolute=self.absolute)} {side}"


class WholeRun(Description):
    """The whole run."""

    kind: Literal["whole"] = text("Which phase this is: the whole run.", default="whole")

    @property
    def words(self) -> str:
        """The phase in words; none, as it is what is meant without any."""
        return ""


class TimeSpan(Description):
    """A stretch of time."""

    kind: Literal["time"] = text("Which phase this is: a stretch of time.")
    begin: float = quantity("Its begin.", unit="s", symbol="t", ge=0.0, le=LONGEST, default=0.0)
    end: float | None = quantity(
        "Its end; none is that of the run.", unit="s", symbol="t", gt=0.0, le=LONGEST, default=None
    )

    @model_validator(mode="after")
    def _goes_forward(self) -> Self:
        if self.end is not None and not self.end > self.begin:
            raise ValueError(f"end {self.end:g} s must be later than begin {self.begin:g} s")
        return self

    @property
    def words(self) -> str:
        """The phase in words."""
        return f"from {self.begin:g} s" + ("" if self.end is None else f" to {self.end:g} s")


class LastSeconds(Description):
    """The end of the run, where it may have become steady."""

    kind: Literal["last"] = text("Which phase this is: the end of the run.")
    seconds: float = quantity("Its length; a shorter run counts whole.", unit="s", symbol="T", gt=0.0, le=LONGEST)

    @property
    def words(self) -> str:
        """The phase in words."""
        return f"over the last {self.seconds:g} s"


class Dive(Description):
    """A dive, down and up again, as in the energy bill."""

    kind: Literal["dive"] = text("Which phase this is: a dive, down and up again.")
    number: Number = counting("Which dive: 1 is the first, -1 the last.")

    @property
    def words(self) -> str:
        """The phase in words."""
        return f"in dive {self.number}"


class DivePart(Description):
    """The way of dives down to their deepest points, or up from there."""

    kind: Literal["descent", "climb"] = text("Which phase this is: of dives the way down, or the way up.")
    number: Number | None = counting("Of which dive: 1 is the first, -1 the last; none is all of them.", default=None)

    @property
    def words(self) -> str:
        """The phase in words."""
        return f"in all {self.kind}s" if self.number is None else f"in {self.kind} {self.number}"


class While(Limited):
    """All times at which an output is beyond a limit, interpolated between samples."""

    kind: Literal["while"] = text("Which phase this is: while an output is beyond a limit.")

    @property
    def words(self) -> str:
        """The phase in words."""
        return f"while {self.limit_words}"


class BetweenEvents(Description):
    """From one event to another."""

    kind: Literal["between_events"] = text("Which phase this is: from one event to another.")
    begin: EventAt | None = text("The event at its begin; none is the begin of the run.", default=None)
    end: EventAt | None = text("The event at its end; none is the end of the run.", default=None)

    @property
    def words(self) -> str:
        """The phase in words."""
        begin, end = (None if event is None else event.event_words for event in (self.begin, self.end))
        return f"from {begin or 'the begin'} to {end or 'the end'}"


class Both(Description):
    """Where several phases overlap."""

    kind: Literal["both"] = text("Which phase this is: where several overlap.")
    of: Annotated[tuple[Phase, ...], Field(min_length=2, max_length=4)] = text("The phases that must all hold.")

    @model_validator(mode="after")
    def _is_not_deep(self) -> Self:
        require_shallow("phases", self.depth)
        return self

    @property
    def depth(self) -> int:
        """How deep phases are nested."""
        return 1 + max(phase.depth if isinstance(phase, Both) else 0 for phase in self.of)

    @property
    def words(self) -> str:
        """The phase in words."""
        return " and ".join(phase.words or "in the whole run" for phase in self.of)


Phase = Annotated[
    WholeRun | TimeSpan | LastSeconds | Dive | DivePart | While | BetweenEvents | Both, Field(discriminator="kind")
]
"""A part of a run; it may consist of several stretches, or of none."""
Both.model_rebuild()
WHOLE = WholeRun()


def output_words(output: str, cell: str | None, *, absolute: bool = False) -> str:
    """Return an output in words."""
    named = output if cell is None else f"{output} of {cell}"
    return f"|{named}|" if absolute else named


def require_shallow(what: str, depth: int) -> None:
    """Raise `ValueError` where something is nested too deep."""
    if depth > DEEPEST_NESTING:
        raise ValueError(f"{what} are nested {depth} deep, {DEEPEST_NESTING} at most")
