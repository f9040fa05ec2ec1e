"""Owns what every description shares: the frozen base model, and fields with unit, symbol, limits and a sentence."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

LENGTH_LIMIT = 1e4
"""Largest coordinate or extension in a vehicle, m."""
LARGEST_WHOLE = 2**53 - 1
"""Largest whole number that is the same on every machine: canonical JSON (RFC 8785) holds none beyond."""


class Description(BaseModel):
    """Base of all descriptions: immutable, and a misspelt or non-finite field is refused by its path."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def quantity(description: str, *, unit: str, symbol: str, **limits: Any) -> Any:
    """Make a numeric field whose unit, symbol, limits and sentence reach the JSON Schema, the docs and the studio.

    `limits` are pydantic's own (`ge`, `gt`, `le`, `lt`, `default`). Strings and booleans are not numbers here.
    """
    return Field(description=description, strict=True, json_schema_extra={"unit": unit, "symbol": symbol}, **limits)


def vector(description: str, *, unit: str, symbol: str, **options: Any) -> Any:
    """Make a field that holds several numbers of one unit (a vector, a range, a column of a table, a matrix)."""
    return Field(description=description, json_schema_extra={"unit": unit, "symbol": symbol}, **options)


def text(description: str, **options: Any) -> Any:
    """Make a field of words or a switch: it has a sentence, but no unit."""
    return Field(description=description, **options)


Switch = Annotated[bool, Field(strict=True)]
"""True or false, which numbers and words are not."""
Coordinate = Annotated[float, Field(strict=True, ge=-LENGTH_LIMIT, le=LENGTH_LIMIT)]
Vector3 = tuple[Coordinate, Coordinate, Coordinate]
Rate = Annotated[float, Field(strict=True, ge=-1e3, le=1e3)]
Rate3 = tuple[Rate, Rate, Rate]
Name = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^[^\x00-\x20\x7f/][^\x00-\x1f\x7f/]*$")]
"""A name that fits in a pointer, a file and a label: it starts with a visible character and has no slash or control."""
SHORTEST_AXIS = 1e-9


def require_direction(axis: tuple[float, float, float]) -> None:
    """Raise `ValueError` where a vector that gives a direction has none."""
    if math.hypot(*axis) < SHORTEST_AXIS:
        raise ValueError("axis has no direction: its length is 0; give a vector such as [1, 0, 0]")
