"""Owns the description of what varies in a batch: parameters, the fields that they set, levels, ranges, distributions.

Numbers are in the unit of the field that the pointer leads to.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from models.fields import LARGEST_WHOLE, Description, text
from models.variation import Target

LARGEST_SEED = LARGEST_WHOLE
"""The largest whole number that JSON, tables and the documents of designs all keep exactly."""

ColumnName = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x20\x7f][^\x00-\x1f\x7f]*$")]


def number(description: str, *, unit: str = "that of the field", **limits: Any) -> Any:
    """Make a field that is a number, with its unit in the JSON Schema; strings and booleans are no numbers."""
    return Field(description=description, strict=True, json_schema_extra={"unit": unit}, **limits)


class Follower(Description):
    """A further field that follows a parameter, such as that of a mirrored part."""

    pointer: str = text("JSON Pointer to the field in the design.", min_length=1, max_length=1000)
    factor: float = number("It becomes this many times the parameter's value...", unit="1", default=1.0)
    offset: float = number("...plus this.", default=0.0)


class Parameter(Description):
    """A field of the design that the cases of a batch set."""

    pointer: str = text("JSON Pointer to the field in the design.", min_length=1, max_length=1000)
    name: ColumnName | None = text("Name of its column; a readable one by default.", default=None)
    also: tuple[Follower, ...] = text("Further fields that follow it.", default=(), max_length=100)

    @property
    def targets(self) -> tuple[Target, ...]:
        """All fields that the parameter sets."""
        return (Target(self.pointer), *(Target(f.pointer, f.factor, f.offset) for f in self.also))


def _require_rising(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low {low:g} does not lie below high {high:g}: exchange them, or widen the range")


class Levels(Parameter):
    """A parameter with levels: those listed, or `count` of them evenly from `low` to `high`."""

    values: tuple[Any, ...] | None = text("The levels: any JSON values.", default=None, min_length=1)
    low: float | None = number("First of evenly spaced levels.", default=None)
    high: float | None = number("Last of evenly spaced levels.", default=None)
    count: int | None = number("How many evenly spaced levels.", unit="1", default=None, ge=2, le=10**9)

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        given = [name for name in ("low", "high", "count") if getattr(self, name) is not None]
        if (self.values is not None and given) or (self.values is None and len(given) < 3):
            what = ["values"] * (self.values is not None) + given
            raise ValueError(f"give either values, or low, high and count; given are {', '.join(what) or 'none'}")
        if self.low is not None and self.high is not None:
            _require_rising(self.low, self.high)
        return self

    @property
    def levels(self) -> int:
        """How many levels there are."""
        return len(self.values) if self.values is not None else self.count or 0

    def level(self, k: int) -> Any:
        """Return level `k`; the ends are exact."""
        if self.values is not None:
            return self.values[k]
        low, high, last = self.low or 0.0, self.high or 0.0, self.levels - 1
        return low + (high - low) * (k / last) if k < last else high


class Interval(Description):
    """All values between two."""

    low: float = number("Smallest value.")
    high: float = number("Largest value.")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        _require_rising(self.low, self.high)
        return self


class Range(Interval, Parameter):
    """A parameter anywhere between two values."""


class Normal(Description):
    """A normal distribution."""

    kind: Literal["normal"] = text("Which distribution this is: normal.")
    mean: float = number("Mean.")
    sd: float = number("Standard deviation.", gt=0.0)


class Uniform(Interval):
    """All values between two are equally likely."""

    kind: Literal["uniform"] = text("Which distribution this is: uniform.")


class TruncatedNormal(Interval):
    """A normal distribution, given that it lies between two values."""

    kind: Literal["truncated_normal"] = text("Which distribution this is: a truncated normal.")
    mean: float = number("Mean before it is truncated.")
    sd: float = number("Standard deviation before it is truncated.", gt=0.0)

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        reach = max((self.low - self.mean) / self.sd, (self.mean - self.high) / self.sd)
        if reach > MOST_SD:
            raise ValueError(
                f"[{self.low:g}, {self.high:g}] lies {reach:.3g} standard deviations from the mean {self.mean:g}: "
                f"bring it within {MOST_SD:g}"
            )
        return self


class CaseSeed(Description):
    """A seed of its own for every case, such as that of a controller's noise: a whole number from 0 to 2^53 - 1."""

    kind: Literal["case_seed"] = text("Which distribution this is: a seed for each case.")


MOST_SD = 8.0
"""How far from its mean a normal may be truncated, in standard deviations; beyond, its tail has no digits left."""
Distribution = Annotated[Normal | Uniform | TruncatedNormal | CaseSeed, Field(discriminator="kind")]


class Drawn(Parameter):
    """A parameter drawn at random."""

    distribution: Distribution = text("From which distribution.")


class Correlation(Description):
    """How two drawn parameters go together: the correlation of the normals behind them (a Gaussian copula)."""

    between: tuple[ColumnName, ColumnName] = text("Names of the two parameters.")
    value: float = number("Correlation.", unit="1", ge=-1.0, le=1.0)
