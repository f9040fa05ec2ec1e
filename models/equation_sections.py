"""Owns the pieces of which printed equations are made: displays, sections of them, and their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import sympy as sp

from models.derivation import DENSITY, GRAVITY, Equations
from models.equation_forces import Forces
from models.equation_parts import Composition
from models.equation_symbols import CANCELLED, Group, Notation


class Written(NamedTuple):
    """What no expression says: a formula for every n, a vector product."""

    text: str
    latex: str


@dataclass(frozen=True)
class Display:
    """One equation. `unit` is that of a definition, whose value may follow it as `value`; words stay as they are."""

    left: Any
    right: Any
    kind: Literal["definition", "equation", "words"] = "equation"
    unit: str = ""
    value: float | None = None

    def with_numbers(self, values: Mapping[Any, float], digits: int) -> Display:
        """Return the display with numbers: after a definition, in the place of symbols elsewhere."""
        if self.kind == "definition":
            return replace(self, value=values[self.left])
        if self.kind == "words":
            return self
        return replace(self, right=substituted(self.right, values, digits))


@dataclass(frozen=True)
class Section:
    """A title, a sentence or two, and the equations."""

    title: str
    words: str
    displays: tuple[Display, ...]

    def with_numbers(self, values: Mapping[Any, float], digits: int) -> Section:
        """Return the section with numbers."""
        return replace(self, displays=tuple(display.with_numbers(values, digits) for display in self.displays))


class Derived(NamedTuple):
    """What the derivation of either model hands on."""

    sections: tuple[Section, ...]
    equations: Equations
    forces: Forces
    position: tuple[Any, ...]
    velocity: tuple[Any, ...]


def substituted(expression: Any, values: Mapping[Any, float], digits: int) -> Any:
    """Return an expression or matrix with values in it, expanded, its numbers rounded to so many digits."""
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: substituted(entry, values, digits))
    coefficients: dict[Any, list[float]] = {}
    for term in sp.Add.make_args(sp.expand(expression)):
        known = {s: sp.Float(values[s]) for s in term.free_symbols if s in values}
        number, rest = term.xreplace(known).as_coeff_Mul()
        coefficients.setdefault(rest, []).append(float(number))
    total: Any = sp.Integer(0)
    for rest, numbers in coefficients.items():
        number = math.fsum(numbers)
        if abs(number) > CANCELLED * sum(map(abs, numbers)):
            total += (sp.Integer(number) if abs(number) == 1.0 else sp.Float(number, digits)) * rest
    return total


def buoyancies(parts: Composition, notation: Notation) -> dict[str, Any]:
    """Return F_bn = rho g V_n of each component that displaces water, by its index."""
    notation.begin("Whole vehicle")
    return {
        n: notation.defined(f"F_b{n}", f"buoyancy of component {n}", "N", DENSITY * GRAVITY * part.volume)
        for n, part in zip(parts.indices, parts.parts, strict=True)
        if part.volume != 0
    }


def laws_section(groups: Sequence[Group]) -> Section:
    """Show what follows the extensions, component by component; V_n(e_n) of a bladder is a table."""
    components = [group for group in groups if group.title[0].isdigit()]
    words = "A cell's fixed part stays where it is, and the centre of its stack moves by half the growth."
    displays = definitions([entry.symbol for group in components for entry in group.entries], components)
    return Section("What follows the extensions", words if displays else "Nothing: no component moves.", displays)


def definitions(symbols: Iterable[Any], groups: Sequence[Group]) -> tuple[Display, ...]:
    """Return the definitions of the symbols that have one."""
    wanted = set(symbols)
    return tuple(
        Display(entry.symbol, entry.definition, "definition", entry.unit)
        for group in groups
        for entry in group.entries
        if entry.definition is not None and entry.symbol in wanted
    )
