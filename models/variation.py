"""Owns varying a design by JSON Pointer: many designs that differ in a few fields, cheaply and exactly.

A varied design equals `parse_design` of the patched document. Only the objects on the way to a field are built again,
from the leaf upwards, so that every check of every ancestor runs; all others are shared. Where that refuses, the whole
document is parsed, which says why in the same words.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from models.design import Design, parse_design
from models.field_info import Step, field_at, steps_to
from models.problems import DesignError, Problem, echo


@dataclass(frozen=True, slots=True)
class Target:
    """A field that follows a parameter: it becomes `factor` times the parameter's value plus `offset`."""

    pointer: str
    factor: float = 1.0
    offset: float = 0.0

    @property
    def copies(self) -> bool:
        """Whether the field takes the value as it is, which then need not be a number."""
        return self.factor == 1.0 and self.offset == 0.0


class Varied:
    """One design, and the fields of it that parameters set.

    Parameters
    ----------
    design
        What stays the same.
    targets
        For each parameter the fields that it sets.

    Raises
    ------
    DesignError
        Where a pointer leads nowhere, or two lead to the same field or one into the other; with the design's pointers.

    """

    def __init__(self, design: Design, targets: Sequence[Sequence[Target]]) -> None:
        self._base = design
        leaves = [
            _Leaf(k, target, field_at(design, target.pointer).integer)
            for k, group in enumerate(targets)
            for target in group
        ]
        problems = list(overlaps([leaf.target.pointer for leaf in leaves]))
        if problems:
            raise DesignError(problems)
        self._ways = [(steps_to(design, leaf.target.pointer), leaf) for leaf in leaves]
        self._root = _branch(self._ways) if leaves else None

    def design(self, row: Sequence[Any]) -> Design:
        """Return the design in which each parameter has its value of `row`.

        Raises
        ------
        DesignError
            With the problems that the patched document has.

        """
        if self._root is None:
            return self._base
        try:
            varied: Design = self._root.value(row)
        except ValidationError:
            return parse_design(self._document(row))
        return varied

    def _document(self, row: Sequence[Any]) -> dict[str, Any]:
        document = self._base.model_dump(mode="json")
        for steps, leaf in self._ways:
            node: Any = document
            for step in steps[:-1]:
                node = node[step.token]
            node[steps[-1].token] = leaf.value(row)
        return document


def overlaps(pointers: Iterable[str]) -> Iterable[Problem]:
    """Yield a problem for every pointer that leads where an earlier one does, into it, or around it."""
    seen: list[tuple[str, ...]] = []
    for pointer in pointers:
        path = tuple(pointer.split("/"))
        for other in seen:
            shared = min(len(path), len(other))
            if path[:shared] == other[:shared]:
                what = "sets the same field as" if path == other else "overlaps with"
                yield Problem(pointer, f"{pointer} {what} {'/'.join(other)}", hint="let one parameter set it")
                break
        seen.append(path)


@dataclass(frozen=True, slots=True)
class _Leaf:
    """A field that takes its value from a row."""

    parameter: int
    target: Target
    integer: bool

    def value(self, row: Sequence[Any]) -> Any:
        value = row[self.parameter]
        if self.target.copies:
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            message = f"{echo(value)} is not a number, so that no factor or offset applies"
            raise DesignError([Problem(self.target.pointer, message, hint="give numbers, or leave factor and offset")])
        number = self.target.factor * value + self.target.offset
        return round(number) if self.integer and math.isfinite(number) else number


@dataclass(frozen=True, slots=True)
class _Model:
    """A description on the way: its class checks what it held and what is new."""

    kind: type[BaseModel]
    kept: dict[str, Any]
    children: list[tuple[str, _Node]]

    def value(self, row: Sequence[Any]) -> Any:
        fields = dict(self.kept)
        for name, child in self.children:
            fields[name] = child.value(row)
        return self.kind.model_validate(fields)


@dataclass(frozen=True, slots=True)
class _List:
    """A tuple on the way; the description that holds it checks it."""

    kept: tuple[Any, ...]
    children: list[tuple[int, _Node]]

    def value(self, row: Sequence[Any]) -> Any:
        entries = list(self.kept)
        for place, child in self.children:
            entries[place] = child.value(row)
        return tuple(entries)


@dataclass(frozen=True, slots=True)
class _Map:
    """A dictionary on the way; the description that holds it checks it."""

    kept: dict[str, Any]
    children: list[tuple[str, _Node]]

    def value(self, row: Sequence[Any]) -> Any:
        return self.kept | {name: child.value(row) for name, child in self.children}


_Node = _Leaf | _Model | _List | _Map


def _branch(ways: Sequence[tuple[Sequence[Step], _Leaf]]) -> _Node:
    """Return the tree over all ways that begin at one holder."""
    holder = ways[0][0][0].holder
    groups: dict[Any, list[tuple[Sequence[Step], _Leaf]]] = {}
    for steps, leaf in ways:
        groups.setdefault(steps[0].token, []).append((steps[1:], leaf))
    children: list[tuple[Any, _Node]] = [
        (token, group[0][1] if not group[0][0] else _branch(group)) for token, group in groups.items()
    ]
    if isinstance(holder, BaseModel):
        # what was never set stays so: a default is not validated anew, and some rules ask whether a field was given
        kept = {name: getattr(holder, name) for name in holder.model_fields_set | {"kind"} if hasattr(holder, name)}
        return _Model(type(holder), kept, children)
    return _Map(holder, children) if isinstance(holder, dict) else _List(holder, children)
