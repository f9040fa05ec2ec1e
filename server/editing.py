"""Owns the application of a JSON Patch (RFC 6902) to a design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from jsonpatch import JsonPatch, JsonPatchException, JsonPatchTestFailed
from jsonpointer import EndOfList, JsonPointer, JsonPointerException

from models.design import Design, parse_design
from models.problems import DesignError, Problem, echo, pointer_to

MAX_OPERATIONS = 1000
MAX_COPIED_VALUES = 100_000
MEMBERS = {
    "add": ("path", "value"),
    "remove": ("path",),
    "replace": ("path", "value"),
    "move": ("from", "path"),
    "copy": ("from", "path"),
    "test": ("path", "value"),
}
"""The operations, and the members that each must have."""
LONGEST_REASON = 200


def apply_patch(design: Design, patch: Sequence[Mapping[str, Any]]) -> Design:
    """Return the design that a JSON Patch makes of `design`; all of it applies, or nothing.

    Raises
    ------
    DesignError
        Pointers that begin with "/patch" lead into the patch, all others into the design it would have made.

    """
    _check_operations(patch)
    document: Any = design.model_dump(mode="json")
    copied = 0
    for i, operation in enumerate(patch):
        if operation["op"] == "copy":
            copied += _size(_resolve(document, operation["from"], pointer_to("patch", i, "from")))
            if copied > MAX_COPIED_VALUES:
                message = f"the patch copies more than {MAX_COPIED_VALUES} values"
                raise DesignError([Problem(pointer_to("patch", i), message, MAX_COPIED_VALUES, "copy smaller parts")])
        document = _apply(document, operation, i)
    return parse_design(document)


def _check_operations(patch: object) -> None:
    if not isinstance(patch, Sequence) or isinstance(patch, str | bytes):
        message = f"a patch is a list of operations, not {type(patch).__name__}"
        raise DesignError([Problem("/patch", message, hint='such as [{"op": "remove", "path": "/notes"}]')])
    if len(patch) > MAX_OPERATIONS:
        message = f"{len(patch)} operations exceed the limit of {MAX_OPERATIONS}"
        raise DesignError([Problem("/patch", message, MAX_OPERATIONS, "send several patches")])
    for i, operation in enumerate(patch):
        problem = _shape_problem(operation, pointer_to("patch", i))
        if problem is not None:
            raise DesignError([problem])


def _shape_problem(operation: object, pointer: str) -> Problem | None:
    if not isinstance(operation, Mapping):
        return Problem(pointer, f"an operation is an object, not {type(operation).__name__}")
    verb = operation.get("op")
    if not isinstance(verb, str) or verb not in MEMBERS:
        return Problem(f"{pointer}/op", f"there is no operation {echo(verb)}", hint=f"use one of {', '.join(MEMBERS)}")
    for member in MEMBERS[verb]:
        if member not in operation:
            return Problem(f"{pointer}/{member}", f"'{verb}' needs '{member}'", hint="add this field")
        if member != "value" and not isinstance(operation[member], str):
            return Problem(f"{pointer}/{member}", f"'{member}' is a JSON Pointer, not {echo(operation[member])}")
    return None


def _apply(document: Any, operation: Mapping[str, Any], i: int) -> Any:
    verb = operation["op"]
    if verb == "move":
        _resolve(document, operation["from"], pointer_to("patch", i, "from"))
    try:
        # a copy of the operation: its path is then never rewritten in the caller's patch
        return JsonPatch([dict(operation)]).apply(document, in_place=True)
    except JsonPatchTestFailed:
        found = echo(_resolve(document, operation["path"], pointer_to("patch", i, "path")))
        message = f"test failed: {echo(operation['path'])} is {found}, not {echo(operation['value'])}"
        raise DesignError([Problem(pointer_to("patch", i, "value"), message)]) from None
    except (JsonPatchException, JsonPointerException) as error:
        message = f"cannot {verb} {echo(operation['path'])}: {_short(error)}"
        raise DesignError([Problem(pointer_to("patch", i, "path"), message)]) from None
    except RecursionError:
        raise DesignError([Problem(pointer_to("patch", i), "the document becomes nested too deeply")]) from None


def _resolve(document: Any, path: str, pointer: str) -> Any:
    try:
        value = JsonPointer(path).resolve(document)
    except JsonPointerException as error:
        raise DesignError([Problem(pointer, f"there is nothing at {echo(path)}: {_short(error)}")]) from None
    if isinstance(value, EndOfList):
        raise DesignError([Problem(pointer, f"there is nothing at {echo(path)}: '-' is past the end of a list")])
    return value


def _short(error: Exception) -> str:
    # jsonpointer ends some messages with the whole document
    reason = str(error).partition(" in {")[0]
    return reason if len(reason) <= LONGEST_REASON else reason[: LONGEST_REASON - 1] + "…"


def _size(value: Any) -> int:
    """Return how many values a JSON value holds, itself included."""
    count, stack = 0, [value]
    while stack:
        node = stack.pop()
        count += 1
        if isinstance(node, dict):
            stack.extend(node.values())
        elif isinstance(node, list):
            stack.extend(node)
    return count
