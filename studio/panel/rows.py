"""Owns the rows of the panel: each shows one field of the design in a handy unit and says how to write it back.

Hints come from the fields' own metadata: sentence, symbol, unit and limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from pydantic import BaseModel

from models.design import Design
from models.problems import pointer_to
from studio.changes import Patch

Widget = Literal["slider", "number", "integer", "switch", "choice", "text", "readout", "note", "actions"]


@dataclass(frozen=True)
class Unit:
    """A unit for people: its symbol, how many of it make the SI unit, and the decimals worth showing."""

    symbol: str
    per_si: float
    decimals: int


PLAIN = Unit("", 1.0, 6)
COUNT = Unit("", 1.0, 0)
MM, METRE = Unit("mm", 1e3, 3), Unit("m", 1.0, 4)
GRAM, CM2, CM3 = Unit("g", 1e3, 3), Unit("cm²", 1e4, 4), Unit("cm³", 1e6, 4)
DEGREE_PER_S, CM_PER_S = Unit("°/s", 57.29577951308232, 3), Unit("cm/s", 1e2, 3)
MM_PER_S, SECOND, MILLISECOND = Unit("mm/s", 1e3, 3), Unit("s", 1.0, 3), Unit("ms", 1e3, 4)
DEGREE = Unit("°", 57.29577951308232, 3)
KG_CM2 = Unit("kg cm²", 1e4, 4)
PERCENT, WATT = Unit("%", 1e2, 2), Unit("W", 1.0, 3)
DENSITY, GRAVITY = Unit("kg/m³", 1.0, 3), Unit("m/s²", 1.0, 5)
DAMPING, DAMPING_LINEAR = Unit("N m s", 1.0, 6), Unit("N s/m", 1.0, 5)


@dataclass(frozen=True)
class Row:
    """One row: its label, what it shows of a design, and the patch that writes a value into it.

    `read` and `write` use the design's own units. `none` is the number that stands for an absent value.
    """

    label: str
    widget: Widget
    read: Callable[[Design], Any]
    write: Callable[[Design, Any], Patch] = lambda _design, _value: []
    hint: str | None = None
    unit: Unit = PLAIN
    step: float = 1.0
    span: Callable[[Design], tuple[float, float]] | None = None
    choices: tuple[tuple[str, Any], ...] = ()
    none: float | None = None

    def show(self, design: Design) -> Any:
        """Return what the widget shows."""
        value = self.read(design)
        match self.widget:
            case "choice":
                return next((label for label, choice in self.choices if choice == value), self.choices[0][0])
            case "slider" | "number" | "readout":
                return self.none if value is None else round(float(value) * self.unit.per_si, self.unit.decimals)
            case "integer":
                return int(value)
            case _:
                return value

    def patch(self, design: Design, shown: Any) -> Patch:
        """Return the patch for what a person put into the widget."""
        match self.widget:
            case "choice":
                value = next((choice for label, choice in self.choices if label == shown), shown)
            case "slider" | "number":
                absent = self.none is not None and shown == self.none
                value = None if absent else float(f"{shown / self.unit.per_si:.12g}")
            case _:
                value = shown
        return self.write(design, value)

    def slider_range(self, design: Design) -> tuple[float, float]:
        """Return the ends of the slider in the shown unit; a value beyond them widens it."""
        low, high = self.span(design) if self.span else (0.0, 1.0)
        value = self.show(design)
        low, high = round(low * self.unit.per_si, 6), round(high * self.unit.per_si, 6)
        return float(min(low, value)), float(max(high, value, low + self.step))

    @property
    def shape(self) -> tuple[Any, ...]:
        """What a widget made for this row cannot change: rows that differ in it need a new widget."""
        return self.label, self.widget, self.unit.symbol, self.choices


def at(design: Design, *tokens: str | int) -> Any:
    """Return the value at a path of a design."""
    node: Any = design
    for token in tokens:
        node = getattr(node, str(token)) if isinstance(node, BaseModel) else node[token]
    return node


@cache
def hint_for(model: type[BaseModel], field: str) -> str:
    """Return a field's sentence with its symbol, unit and limits."""
    info = model.model_fields[field]
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    limits = [
        f"{sign} {getattr(m, name):g}"
        for m in info.metadata
        for name, sign in (("ge", "≥"), ("gt", ">"), ("le", "≤"), ("lt", "<"))
        if isinstance(getattr(m, name, None), int | float)
    ]
    unit = extra.get("unit")
    about = [str(extra["symbol"])] if "symbol" in extra else []
    if limits:
        about.append(" and ".join(limits) + (f" {unit}" if unit not in (None, "1") else ""))
    return f"{info.description} ({', '.join(about)})" if about else str(info.description)


def field_row(
    label: str, path: tuple[str | int, ...], model: type[BaseModel], *, widget: Widget = "number", unit: Unit = PLAIN,
    step: float = 1.0, span: Callable[[Design], tuple[float, float]] | None = None, none: float | None = None,
    choices: tuple[tuple[str, Any], ...] = (), remark: str = "",
) -> Row:  # fmt: skip
    """Return the row of one field at a path whose last name is a field of `model` (an index may follow it)."""
    name = next(str(token) for token in reversed(path) if isinstance(token, str))
    hint = f"{hint_for(model, name)} {remark}".strip()

    def write(_: Design, value: Any) -> Patch:
        return [{"op": "replace", "path": pointer_to(*path), "value": value}]

    return Row(
        label, widget, lambda design: at(design, *path), write, hint=hint, unit=unit, step=step, span=span,
        none=none, choices=choices,
    )  # fmt: skip


def is_spatial(design: Design) -> bool:
    """Whether a design is simulated in three dimensions."""
    return design.mission.solver.model == "spatial"


def readout(label: str, read: Callable[[Design], float], unit: Unit, *, hint: str | None = None) -> Row:
    """Return a row that only shows a number."""
    return Row(label, "readout", read, hint=hint, unit=unit)


def note(read: Callable[[Design], str]) -> Row:
    """Return a row of plain text."""
    return Row("", "note", read)


def actions(label: str, options: tuple[tuple[str, Any], ...], write: Callable[[Design, Any], Patch]) -> Row:
    """Return a row of buttons, each of which writes a patch of its own."""
    return Row(label, "actions", lambda _: None, write, choices=options)
