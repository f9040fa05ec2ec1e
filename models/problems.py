"""Owns how wrong input is told: a JSON Pointer, a message with the value, the bound, and the way out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import ValidationError

LONGEST_ECHO = 60
UNION_ERRORS = {"union_tag_invalid", "union_tag_not_found"}
TOLD_WHOLE = {"missing", "value_error", "extra_forbidden", "too_short", "too_long"}
BOUNDS = ("ge", "gt", "le", "lt", "min_length", "max_length", "multiple_of", "pattern", "expected")


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a document.

    `pointer` is an RFC 6901 JSON Pointer ("" is the whole document), `limit` the bound that was broken, `hint` the
    way out.
    """

    pointer: str
    message: str
    limit: float | int | str | None = None
    hint: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the problem as a JSON object."""
        return asdict(self)

    def __str__(self) -> str:
        said = f"{self.message} ({self.hint})" if self.hint else self.message
        return f"{self.pointer}: {said}" if self.pointer else said


class DesignError(ValueError):
    """A document cannot be used as it is; `problems` says why, field by field."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("; ".join(str(problem) for problem in self.problems))


def escape(token: object) -> str:
    """Escape one reference token of a JSON Pointer (RFC 6901)."""
    return str(token).replace("~", "~0").replace("/", "~1")


def pointer_to(*tokens: object) -> str:
    """Join tokens to a JSON Pointer."""
    return "".join("/" + escape(token) for token in tokens)


def echo(value: Any) -> str:
    """Return a short, finite rendering of a value a user gave."""
    if isinstance(value, dict):
        return f"an object of {len(value)}"
    if isinstance(value, list | tuple):
        return f"an array of {len(value)}"
    rendered = repr(value) if isinstance(value, str) else json.dumps(value, default=str)
    return rendered if len(rendered) <= LONGEST_ECHO else rendered[: LONGEST_ECHO - 1] + "…"


def _path(location: Sequence[int | str], document: Any) -> list[int | str]:
    """Drop the tags that pydantic adds for unions, by walking the document alongside."""
    path: list[int | str] = []
    node, tagged = document, False
    for k, token in enumerate(location):
        last = k == len(location) - 1
        if isinstance(node, dict) and token in node:
            if token == node.get("kind") and not tagged:
                tagged = True  # a tag that is also the name of a field comes before it
                continue
            node, tagged = node[token], False
        elif isinstance(node, list | tuple) and isinstance(token, int) and token < len(node):
            node, tagged = node[token], False
        elif last and isinstance(node, list | tuple) and isinstance(token, int):
            pass  # the entry that is missing
        elif not (last and isinstance(node, dict)) or token in (node.get("kind"), "[key]"):
            continue
        path.append(token)
    return path


def _limit(context: dict[str, Any]) -> float | int | str | None:
    for name in BOUNDS:
        bound = context.get(name)
        if isinstance(bound, float) and not math.isfinite(bound):
            continue
        if isinstance(bound, float | int | str):
            return bound
    return None


def _hint(kind: str, context: dict[str, Any]) -> str | None:
    if kind == "extra_forbidden":
        return "remove it or check its spelling"
    if kind == "missing":
        return "add this field"
    if kind in UNION_ERRORS:
        return f"use one of {context.get('expected_tags', 'the kinds in the schema')}"
    if kind == "string_pattern_mismatch":
        return "start with a visible character; leave out slashes and control characters"
    if kind in {"finite_number", "float_type", "int_type"}:
        return "give a finite number"
    return None


def problems_from_validation(error: ValidationError, document: Any) -> list[Problem]:
    """Translate pydantic's errors into problems with JSON Pointers into the document."""
    problems = []
    for item in error.errors(include_url=False):
        context = item.get("ctx", {})
        message = item["msg"].removeprefix("Value error, ")
        path = _path(item["loc"], document)
        if item["type"] in UNION_ERRORS:
            given = item["input"].get("kind") if isinstance(item["input"], dict) else item["input"]
            message = "the kind is missing" if given is None else f"there is no kind {echo(given)}"
            path.append("kind")
        elif item["type"] not in TOLD_WHOLE:
            message = f"{message}, not {echo(item['input'])}"
        pointer = pointer_to(*path)
        problems.append(Problem(pointer, message, _limit(context), _hint(item["type"], context)))
    return problems
