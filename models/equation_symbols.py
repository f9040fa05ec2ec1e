"""Owns the symbols in which a design's equations are written: what each means, its unit, its definition and its value.

A symbol's name in text is `base_index` (`l_g1x`: of component 1, along x). Its LaTeX follows from it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

BASES = {
    "en": ("e", "0,"), "Vc": ("V", "c,"), "Ac": ("A", "c,"), "rho": (r"\rho", ""), "rhoref": (r"\rho", r"\mathrm{ref}"),
    "tau": (r"\tau", ""), "alpha": (r"\alpha", ""), "beta": (r"\beta", ""), "theta": (r"\theta", ""),
    "phi": (r"\phi", ""), "nu": (r"\nu", ""),
}  # fmt: skip
"""How a base is set, and what comes before its index."""
CANCELLED = 1e-12
"""A sum below this share of its terms' size is their rounding: it counts as zero."""


@dataclass(frozen=True)
class Entry:
    """One symbol. `definition` is an expression of earlier symbols; a symbol without one has its `value` given."""

    symbol: Any
    words: str
    unit: str
    definition: Any = None
    value: float = math.nan


@dataclass(frozen=True)
class Group:
    """The symbols of one component, or of the whole vehicle."""

    title: str
    entries: tuple[Entry, ...]


@dataclass
class Notation:
    """Collects symbols group by group, in the order in which they are defined."""

    _groups: dict[str, list[Entry]] = field(default_factory=dict)
    _title: str = ""

    def begin(self, title: str) -> None:
        """Put what follows under this title, a new one or an old one."""
        self._title = title
        self._groups.setdefault(title, [])

    def given(self, name: str, words: str, unit: str, value: float) -> Any:
        """Return a new symbol whose value the design states."""
        return self.add(sp.Symbol(name, real=True), words, unit, value)

    def add(self, symbol: Any, words: str, unit: str, value: float) -> Any:
        """Take in a symbol made elsewhere, with its value."""
        self._groups[self._title].append(Entry(symbol, words, unit, value=float(value)))
        return symbol

    def defined(self, name: str, words: str, unit: str, definition: Any, otherwise: float = math.nan) -> Any:
        """Return a new symbol that stands for an expression; `otherwise` is its value where that has none."""
        symbol = sp.Symbol(name, real=True)
        self._groups[self._title].append(Entry(symbol, words, unit, definition, float(otherwise)))
        return symbol

    @property
    def groups(self) -> tuple[Group, ...]:
        """Everything collected so far."""
        return tuple(Group(title, tuple(entries)) for title, entries in self._groups.items())


def closed_forms(groups: Iterable[Group]) -> dict[Any, Any]:
    """Return each defined symbol as an expression of given ones.

    A cell's V_n l_bn becomes its first moment here, so that an empty cell needs no centre.
    """
    closed: dict[Any, Any] = {}
    for entry in (entry for group in groups for entry in group.entries):
        if entry.definition is not None and not entry.definition.has(sp.core.function.AppliedUndef):
            closed[entry.symbol] = entry.definition.xreplace(closed)
    return closed


def values_of(groups: Iterable[Group]) -> dict[Any, float]:
    """Return the value of every symbol: given, or by its definition."""
    groups = tuple(groups)
    closed = closed_forms(groups)
    values: dict[Any, float] = {}
    for entry in (entry for group in groups for entry in group.entries):
        form = closed.get(entry.symbol)
        values[entry.symbol] = entry.value if form is None else _number(form, values, entry.value)
    return values


def _number(form: Any, values: Mapping[Any, float], otherwise: float) -> float:
    terms = [term.xreplace({s: sp.Float(values[s]) for s in term.free_symbols}) for term in sp.Add.make_args(form)]
    numbers = [term.evalf() for term in terms]
    if not all(number.is_Number and number.is_finite for number in numbers):
        return otherwise
    total, size = math.fsum(map(float, numbers)), sum(abs(float(number)) for number in numbers)
    return 0.0 if abs(total) <= CANCELLED * size else total


def latex_name(name: str) -> str:
    """Return the LaTeX of a symbol's name."""
    for ending, dots in (("_ddot", "ddot"), ("_dot", "dot")):
        if name.endswith(ending):
            return rf"\{dots}{{{latex_name(name.removesuffix(ending))}}}"
    base, _, index = name.partition("_")
    index = re.sub("(beta|tau)", r"\\\1 ", index).strip()
    head, before = BASES.get(base, (base, ""))
    return f"{head}_{{{before}{index}}}" if before + index else head


def text_name(name: str) -> str:
    """Return a symbol's name in plain text: x' for x_dot."""
    return name.replace("_ddot", "''").replace("_dot", "'")
