"""Owns the descriptions of metrics as they are asked for: built-in ones by name, others composed of outputs of a run.

Times in s, angles in rad, all else in the unit of the output.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from models.fields import Description, Name, Switch, quantity, text
from models.metric_phases import (
    WHOLE,
    EventAt,
    EventKind,
    Limited,
    Output,
    Phase,
    output_words,
    require_shallow,
)  # fmt: skip

KINDS = ("statistic", "time_beyond", "built_in", "event_time", "event_count", "ratio", "difference", "sum", "product")
MOST_OPERANDS = 8
StatisticName = Literal[
    "maximum", "minimum", "mean", "final", "first", "rms", "standard_deviation", "span", "travel", "time_integral",
    "percentile",
]  # fmt: skip
STATISTIC_WORDS = {
    "final": "last", "rms": "root mean square", "standard_deviation": "standard deviation",
    "time_integral": "time integral",
}  # fmt: skip
JOINED = {"ratio": "per", "difference": "less", "sum": "plus", "product": "times"}


class _Named(Description):
    name: Name | None = text("Its name, unique in a batch; made of what it is where it is not given.", default=None)
    over: Phase = text("Over which part of the run it is taken.", default=WHOLE)

    @property
    def words(self) -> str:
        """What it is, in words."""
        return f"{self._what} {self.over.words}".rstrip()

    @property
    def _what(self) -> str:
        raise NotImplementedError


class Statistic(_Named):
    """A statistic of an output over time; means weigh by time, and values go straight from sample to sample."""

    kind: Literal["statistic"] = text("Which metric this is: a statistic of an output over time.")
    of: Output = text("Which output of the run, by its name.")
    cell: Name | None = text("Which cell, where the output is of cells.", default=None)
    statistic: StatisticName = text("Which statistic: span is largest less smallest, travel the sum of all changes.",
                                    default="maximum")  # fmt: skip
    percent: float | None = quantity(
        "Of a percentile: the share of time in which the output is smaller.",
        unit="%", symbol="P", ge=0.0, le=100.0, default=None,
    )  # fmt: skip
    absolute: Switch = text("Whether magnitudes count, whatever the sign.", default=False)

    @model_validator(mode="after")
    def _percent_is_of_percentiles(self) -> Self:
        if self.statistic == "percentile" and self.percent is None:
            raise ValueError("a percentile needs percent, between 0 and 100")
        if self.statistic != "percentile" and self.percent is not None:
            raise ValueError(f"percent belongs to a percentile, not to a {self.statistic}")
        return self

    @property
    def _what(self) -> str:
        of = output_words(self.of, self.cell, absolute=self.absolute)
        which = STATISTIC_WORDS.get(self.statistic, self.statistic)
        return f"{self.percent:g} % percentile of {of}" if self.percent is not None else f"{which} of {of}"


class TimeBeyond(_Named, Limited):
    """How long an output was beyond a limit; crossings are interpolated between samples."""

    kind: Literal["time_beyond"] = text("Which metric this is: how long an output was beyond a limit.")

    @property
    def _what(self) -> str:
        return f"time of {self.limit_words}"


class BuiltInOver(_Named):
    """A built-in metric over one stretch of a run, as if it were a run of its own."""

    kind: Literal["built_in"] = text("Which metric this is: a built-in one over a stretch of the run.")
    of: Output = text("Which built-in metric, by its name.")

    @property
    def _what(self) -> str:
        return self.of


class EventTime(_Named, EventAt):
    """When something happened, since the start of the mission; missing where it did not."""

    kind: Literal["event_time"] = text("Which metric this is: when something happened.")

    @property
    def _what(self) -> str:
        return f"time of {self.event_words}"


class EventCount(_Named):
    """How often something happened."""

    kind: Literal["event_count"] = text("Which metric this is: how often something happened.")
    event: EventKind = text("What happened: see the events of a run.")
    cell: Name | None = text("Which cell it happened to; none is any.", default=None)

    @property
    def _what(self) -> str:
        return f"number of {self.event}" + ("" if self.cell is None else f" of {self.cell}")


class Composed(Description):
    """Metrics divided, subtracted, added or multiplied; missing where one of them is, or where the divisor is zero."""

    kind: Literal["ratio", "difference", "sum", "product"] = text("How the metrics are joined.")
    name: Name | None = text("Its name, unique in a batch; made of what it is where it is not given.", default=None)
    of: Annotated[tuple[MetricRequest, ...], Field(min_length=2, max_length=MOST_OPERANDS)] = text(
        "The metrics; a ratio or a difference is of two."
    )

    @model_validator(mode="after")
    def _is_not_deep(self) -> Self:
        require_shallow("metrics", self.depth)
        if self.kind in ("ratio", "difference") and len(self.of) != 2:
            raise ValueError(f"a {self.kind} is of two metrics, not of {len(self.of)}")
        return self

    @property
    def depth(self) -> int:
        """How deep metrics are nested."""
        return 1 + max(part.depth if isinstance(part, Composed) else 0 for part in self.of)

    @property
    def words(self) -> str:
        """What it is, in words."""
        parts = [f"({words_of(part)})" if isinstance(part, Composed) else words_of(part) for part in self.of]
        return f" {JOINED[self.kind]} ".join(parts)


def _kind(value: Any) -> Any:
    """Return the tag of a request: its kind, or that of a name."""
    if isinstance(value, dict):
        return value.get("kind")
    return getattr(value, "kind", "name")


MetricRequest = Annotated[
    Annotated[Output, Tag("name")]
    | Annotated[Statistic, Tag("statistic")]
    | Annotated[TimeBeyond, Tag("time_beyond")]
    | Annotated[BuiltInOver, Tag("built_in")]
    | Annotated[EventTime, Tag("event_time")]
    | Annotated[EventCount, Tag("event_count")]
    | Annotated[Composed, Tag("ratio")]
    | Annotated[Composed, Tag("difference")]
    | Annotated[Composed, Tag("sum")]
    | Annotated[Composed, Tag("product")],
    Discriminator(
        _kind,
        custom_error_type="union_tag_invalid",
        custom_error_context={"discriminator": "kind", "tag": "", "expected_tags": ", ".join(KINDS)},
    ),
]
"""A metric as it is asked for: the name of a built-in one, or an object that composes one."""
Composed.model_rebuild()


def words_of(request: MetricRequest) -> str:
    """Return the name that a metric was given, or else what it is in words."""
    return request if isinstance(request, str) else request.name or request.words
