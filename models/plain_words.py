"""Owns how a document of a wrong shape is told in plain words: what is wanted, and which name was probably meant.

It says anew what pydantic says of a document; the JSON Schema tells which fields there are at a place. A value alone,
such as of a query or a setting, is told with all that its own JSON Schema allows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from models.problems import BOUNDS, UNION_ERRORS, Problem, echo, problems_from_validation
from models.suggestions import suggestion

WANTED = {
    "tuple_type": "a list", "list_type": "a list", "dict_type": "an object", "model_type": "an object",
    "model_attributes_type": "an object", "string_type": "text", "bool_type": "true or false",
    "int_type": "a whole number", "int_from_float": "a whole number", "int_parsing": "a whole number",
    "float_type": "a number", "float_parsing": "a number", "bool_parsing": "true or false",
    "finite_number": "a finite number", "literal_error": "{expected}", "multiple_of": "a multiple of {multiple_of}",
    "greater_than": "a number above {gt}", "greater_than_equal": "a number of at least {ge}",
    "less_than": "a number below {lt}", "less_than_equal": "a number of at most {le}",
    "string_too_short": "text of at least {min_length} characters",
    "string_too_long": "text of at most {max_length} characters",
}  # fmt: skip
"""What is wanted, by pydantic's name of the error and with its context."""
COUNTS = {
    "too_short": "there must be at least {min_length}, not {actual_length}",
    "too_long": "there may be at most {max_length}, not {actual_length}",
}
BOUND_WORDS = {
    "minimum": "of at least", "exclusiveMinimum": "above", "maximum": "of at most", "exclusiveMaximum": "below",
}  # fmt: skip
"""How the bounds of a number in a JSON Schema are told."""
OBJECTS = ("dict_type", "model_type", "model_attributes_type")
QUOTED = re.compile(r"'([^']*)'")
Schema = dict[str, Any]


def plainly(error: ValidationError, document: Any, schema: Schema) -> list[Problem]:
    """Return what is wrong with a document, whose JSON Schema is given, each problem at its place."""
    problems = problems_from_validation(error, document)
    items = error.errors(include_url=False)
    return [_told(problem, item, document, schema) for problem, item in zip(problems, items, strict=True)]


def _told(problem: Problem, item: Any, document: Any, schema: Schema) -> Problem:
    kind, given = item["type"], item["input"]
    context = {name: f"{v:.15g}" if isinstance(v, float) else v for name, v in item.get("ctx", {}).items()}
    path = _path(problem.pointer, document)
    if kind == "extra_forbidden":
        known = fields_at(schema, document, path[:-1])
        meant = suggestion(str(path[-1]), known)
        hint = meant or f"remove it; there are {', '.join(known)}"
        return replace(problem, message=f"there is no field {echo(path[-1])} here", hint=hint)
    if kind == "missing":
        last = path[-1]
        if isinstance(last, int):
            return replace(problem, message=f"entry {last + 1} is missing", hint="add this entry")
        return replace(problem, message=f"the field {echo(last)} is missing")
    if kind in COUNTS:
        return replace(problem, message=COUNTS[kind].format(**context))
    if kind in UNION_ERRORS:
        return replace(problem, hint=_kinds(problem, given, context, schema))
    if kind not in WANTED:
        return problem
    way_out: str | None = None
    if kind in OBJECTS:
        way_out = f"its fields are {', '.join(fields_at(schema, document, path))}"
    elif kind == "literal_error":
        way_out = _meant(given, context["expected"])
    return replace(problem, message=f"{WANTED[kind].format(**context)} is wanted, not {echo(given)}", hint=way_out)


def _kinds(problem: Problem, given: Any, context: dict[str, Any], schema: Schema) -> str | None:
    """Return which kinds there are, the one that was probably meant before them."""
    kind = given.get("kind") if isinstance(given, dict) else given
    if kind is None and problem.pointer == "/kind" and "discriminator" in schema:  # pydantic tells no kinds here
        return f"use one of {', '.join(map(repr, schema['discriminator']['mapping']))}"
    meant = _meant(kind, context.get("expected_tags", ""))
    return f"{meant} {problem.hint}" if meant else problem.hint


def _meant(given: Any, expected: str) -> str | None:
    return suggestion(given, QUOTED.findall(expected)) if isinstance(given, str) else None


def _path(pointer: str, document: Any) -> list[str | int]:
    """Return a pointer's tokens, those into lists as numbers."""
    path: list[str | int] = []
    node = document
    for part in pointer.split("/")[1:]:
        token: str | int = part.replace("~1", "/").replace("~0", "~")
        if isinstance(node, list | tuple):
            token = int(token)
        path.append(token)
        node = _child(node, token)
    return path


def _child(node: Any, token: str | int) -> Any:
    if isinstance(node, dict):
        return node.get(token)
    return node[token] if isinstance(node, list | tuple) and isinstance(token, int) and token < len(node) else None


def fields_at(schema: Schema, document: Any, path: Sequence[str | int]) -> list[str]:
    """Return the fields that an object at a place of a document may have."""
    nodes, value = list(_resolved(schema, schema, document)), document
    for token in path:
        value = _child(value, token)
        nodes = [found for node in nodes for part in _parts(node, token) for found in _resolved(part, schema, value)]
    return list(dict.fromkeys(name for node in nodes for name in node.get("properties", ())))


def _parts(node: Schema, token: str | int) -> Iterator[Schema]:
    """Yield the schema of what lies in an object or a list under a token."""
    if isinstance(token, str):
        part = node.get("properties", {}).get(token)
    else:
        first = node.get("prefixItems", ())
        part = first[token] if token < len(first) else node.get("items")
    if isinstance(part, dict):
        yield part


def _resolved(node: Schema, whole: Schema, value: Any) -> Iterator[Schema]:
    """Yield the schemas that a value may be meant for: references followed, alternatives by their kind."""
    if "$ref" in node:
        yield from _resolved(whole["$defs"][node["$ref"].rpartition("/")[2]], whole, value)
    elif "discriminator" in node:
        if not isinstance(value, dict):
            yield {"properties": {"kind": {}}}
        elif (reference := node["discriminator"]["mapping"].get(value.get("kind"))) is not None:
            yield from _resolved({"$ref": reference}, whole, value)
    else:
        yield node
        for name in ("anyOf", "oneOf", "allOf"):
            for part in node.get(name, ()):
                yield from _resolved(part, whole, value)


def value_problem(item: Any, schema: Schema, *, shown: str, otherwise: str | None) -> Problem:
    """Return what is wrong with one value by itself.

    `item` is pydantic's error, `schema` the value's own JSON Schema, `shown` the value as it may be told, `otherwise`
    the way out where nothing better is known.
    """
    kind, context = item["type"], item.get("ctx", {})
    limit = next((context[name] for name in BOUNDS if name in context), None)
    if kind == "value_error":
        return Problem("", item["msg"].removeprefix("Value error, "))
    if kind == "string_pattern_mismatch":
        about = schema.get("description", "").rstrip(".")
        hint = f"give {about[0].lower()}{about[1:]}" if about else otherwise
        return Problem("", f"{shown} does not have the form {context['pattern']}", limit, hint)
    given = item["input"]
    meant = suggestion(given, map(str, _choices(schema))) if isinstance(given, str) else None
    return Problem("", f"{values_of(schema)} is wanted, not {shown}", limit, meant or otherwise)


def values_of(schema: Schema) -> str:
    """Return which values a JSON Schema of one value takes, such as "a whole number from 1 to 200"."""
    kinds = [kind for kind in schema.get("anyOf", ()) if kind.get("type") != "null"]
    if kinds:
        return " or ".join(map(values_of, kinds))
    if choices := _choices(schema):
        *others, last = map(repr, choices)
        return f"{', '.join(others)} or {last}" if others else last
    match schema.get("type"):
        case "boolean":
            return "true or false"
        case "integer":
            return f"a whole number{_range(schema)}"
        case "number":
            return f"a number{_range(schema)}"
        case "array":
            return values_of(schema["items"])
    lengths = {"minimum": schema.get("minLength"), "maximum": schema.get("maxLength")}
    extent = _range({name: length for name, length in lengths.items() if length is not None})
    return f"text{extent.replace(' from ', ' of ')} characters" if extent else "text"


def _choices(schema: Schema) -> list[Any]:
    """Return the values that are named one by one."""
    if "anyOf" in schema:
        return [choice for part in schema["anyOf"] for choice in _choices(part)]
    named = [schema["const"]] if "const" in schema else schema.get("enum", [])
    return list(named) if schema.get("type") != "array" else _choices(schema["items"])


def _range(schema: Schema) -> str:
    """Return the bounds of a number, told after it."""
    bounds = {name: _number(schema[name]) for name in BOUND_WORDS if name in schema}
    if "minimum" in bounds and "maximum" in bounds:
        return f" from {bounds['minimum']} to {bounds['maximum']}"
    told = " and ".join(f"{BOUND_WORDS[name]} {bound}" for name, bound in bounds.items())
    return f" {told}" if told else ""


def _number(value: float) -> str:
    return f"{value:.15g}" if isinstance(value, float) else str(value)
