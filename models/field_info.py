"""Owns what a JSON Pointer into a design leads to: the way there, and what the field's metadata say of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel

from models.components import RollingMass
from models.design import Design
from models.problems import DesignError, Problem, echo

HEADER = ("format", "version")
"""Fields that say what the document is; they are no part of the glider."""
UNTOLD = ("vehicle", "mission", "environment", "control")
"""Levels of the document that a readable name leaves out."""
NAMED = ("components", "schedules")
"""Lists whose entries go by the names of components."""
AXES = ("x", "y", "z")
INDEX = re.compile(r"0|[1-9][0-9]{0,8}")
MOST_NAMED = 40
NUMBERS = ("number", "integer")


@dataclass(frozen=True, slots=True)
class Step:
    """One step on the way to a field: what holds it, and under which name or number."""

    holder: Any
    token: str | int


@dataclass(frozen=True, slots=True)
class FieldInfo:
    """A field of a design: `name` for people, bounds where it is a number, and the value it has."""

    pointer: str
    name: str
    unit: str
    symbol: str
    meaning: str
    number: bool
    integer: bool
    low: float | None
    high: float | None
    value: Any


def field_at(design: Design, pointer: str) -> FieldInfo:
    """Return what is known of the field that a pointer leads to.

    Raises
    ------
    DesignError
        Where the pointer leads to no field that may vary, with what exists there.

    """
    steps = steps_to(design, pointer)
    at = max(k for k, step in enumerate(steps) if isinstance(step.holder, BaseModel))
    schema, definitions = _property(type(steps[at].holder), str(steps[at].token))
    told = schema
    for step in steps[at + 1 :]:
        schema = _entry(_resolved(schema, definitions), step.token)
    numeric = _numeric(_resolved(schema, definitions), definitions)
    return FieldInfo(
        pointer=pointer,
        name=_readable(steps),
        unit="rad" if _turns(design, steps) else str(told.get("unit", "")),
        symbol=str(told.get("symbol", "")),
        meaning=str(told.get("description", "")),
        number=numeric is not None,
        integer=numeric is not None and numeric["type"] == "integer",
        low=_bound(numeric, "minimum", "exclusiveMinimum"),
        high=_bound(numeric, "maximum", "exclusiveMaximum"),
        value=_inside(steps[-1].holder, steps[-1].token),
    )


def steps_to(design: Design, pointer: str) -> list[Step]:
    """Return the way from the design to a field; raises `DesignError` where there is none."""
    if not pointer.startswith("/"):
        raise _refusal(pointer, f"{echo(pointer)} leads to no field", "begin with /vehicle or /mission")
    steps: list[Step] = []
    node: Any = design
    for escaped in pointer[1:].split("/"):
        token = _token(design, node, escaped.replace("~1", "/").replace("~0", "~"), pointer)
        steps.append(Step(node, token))
        node = _inside(node, token)
    if steps[0].token in HEADER:
        raise _refusal(pointer, f"{pointer} says what the document is, and cannot vary", "vary a field of the glider")
    return steps


def _inside(node: Any, token: str | int) -> Any:
    if isinstance(node, BaseModel):
        return getattr(node, str(token))
    return node.get(token) if isinstance(node, dict) else node[token]


def _token(design: Design, node: Any, token: str, pointer: str) -> str | int:
    """Return a token as the name or number under which `node` holds something; raises where it does not."""
    if isinstance(node, BaseModel):
        names = list(type(node).model_fields)
        if token in names:
            return token
        raise _refusal(pointer, f"there is no field {echo(token)}{_of(node)}", f"those are: {_listed(names)}")
    if isinstance(node, dict):
        # both maps of a design say something of components by name, and need not name all of them
        names = [part.name for _, part in design.vehicle.actuated]
        if token in node or token in names:
            return token
        raise _refusal(pointer, f"no component that moves is named {echo(token)}", f"those are: {_listed(names)}")
    if isinstance(node, tuple):
        if INDEX.fullmatch(token) and int(token) < len(node):
            return int(token)
        there = f"entries 0 to {len(node) - 1}" if node else "no entries"
        raise _refusal(pointer, f"there is no entry {echo(token)}: the list has {there}", _components(node))
    what = "is null" if node is None else f"is {echo(node)}, which holds no fields"
    raise _refusal(pointer, f"there is no {echo(token)}: what holds it {what}", "vary the whole object instead")


def _of(node: BaseModel) -> str:
    name = getattr(node, "name", None)
    return f" of '{name}'" if isinstance(name, str) else ""


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")


def _components(node: Sequence[Any]) -> str | None:
    """Return which component has which number, where the entries have names."""
    named = [f"{k} '{item.name}'" for k, item in enumerate(node) if isinstance(getattr(item, "name", None), str)]
    return f"those are: {_listed(named)}" if named else None


def _refusal(pointer: str, message: str, hint: str | None) -> DesignError:
    return DesignError([Problem(pointer, message, hint=hint)])


@cache
def _schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    return kind.model_json_schema()


def _property(kind: type[BaseModel], name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the JSON Schema of a field, and the definitions that it may refer to."""
    schema = _schema_of(kind)
    definitions = schema.get("$defs", {})
    if "$ref" in schema:
        schema = _resolved(schema, definitions)
    return schema["properties"][name], definitions


def _resolved(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """Follow a reference, and leave the null of an optional field out."""
    if "$ref" in schema:
        found: dict[str, Any] = definitions[schema["$ref"].rsplit("/", 1)[1]]
        return found
    given = [choice for choice in schema.get("anyOf", []) if choice.get("type") != "null"]
    return _resolved(given[0], definitions) if len(given) == 1 else schema


def _entry(schema: dict[str, Any], token: str | int) -> dict[str, Any]:
    """Return the schema of an entry of a list, or of a value of a map."""
    if isinstance(token, int):
        ordered: list[dict[str, Any]] = schema.get("prefixItems", [])
        return ordered[token] if token < len(ordered) else schema.get("items", {})
    named = [*schema.get("patternProperties", {}).values(), schema.get("additionalProperties")]
    return next((part for part in named if isinstance(part, dict)), {})


def _numeric(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any] | None:
    schema = _resolved(schema, definitions)
    return schema if schema.get("type") in NUMBERS and "const" not in schema else None


def _bound(schema: dict[str, Any] | None, *names: str) -> float | None:
    return next((float(schema[name]) for name in names if name in schema), None) if schema else None


def _turns(design: Design, steps: Sequence[Step]) -> bool:
    """Whether the field is the extension of a rolling mass, which is an angle."""
    path = [step.token for step in steps]
    if path[:3] == ["mission", "initial", "extensions"] and len(path) == 4:
        name = path[3]
    elif path[:3] == ["mission", "control", "schedules"] and path[-1] == "extension":
        name = design.mission.control.schedules[int(path[3])].cell
    else:
        return False
    return any(part.name == name and isinstance(part, RollingMass) for part in design.vehicle.components)


def _readable(steps: Sequence[Step]) -> str:
    """Return a name for people, such as "Front bellows position x" or "water density"."""
    words: list[str] = []
    for k, step in enumerate(steps):
        inside = _inside(step.holder, step.token)
        listed = k + 1 < len(steps) and isinstance(inside, tuple) and isinstance(_first(inside), BaseModel)
        if isinstance(step.token, int):
            words += _entry_words(step, inside, steps[k - 1])
        elif not (
            k < len(steps) - 1 and (step.token in UNTOLD or (listed and step.token in ("components", "schedules")))
        ):
            word = step.token.replace("_", " ") if isinstance(step.holder, BaseModel) else step.token
            words.append(word.removesuffix("s") if listed else word)
    return " ".join(words)


def _entry_words(step: Step, inside: Any, list_step: Step) -> list[str]:
    """Return how an entry of a list is called: by its own name, its axis, its end of a range, or its number."""
    name = getattr(inside, "name", None)
    if isinstance(name, str):
        return [name]
    cell = getattr(inside, "cell", None)
    if isinstance(cell, str):
        return [cell, "schedule"]
    if len(step.holder) == len(AXES) and isinstance(inside, float):
        return [AXES[int(step.token)]]
    if str(list_step.token).endswith("_range"):
        return [("low", "high")[int(step.token)]]
    return [str(step.token)]


def _first(entries: tuple[Any, ...]) -> Any:
    return entries[0] if entries else None
