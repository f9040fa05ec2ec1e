"""Owns changes of one component by its name: what is added, merged or removed is a patch of the whole design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from models.assemble import assemble
from models.components import Component
from models.design import Design
from models.limits import Limits
from models.problems import DesignError, Problem, echo, pointer_to
from server.editing import apply_patch
from server.store.errors import NotFoundError

FOLDER = ("vehicle", "components")


def find_component(design: Design, name: str) -> tuple[int, Component]:
    """Return a component and its place; raises `NotFoundError`."""
    for i, component in enumerate(design.vehicle.components):
        if component.name == name:
            return i, component
    known = ", ".join(repr(component.name) for component in design.vehicle.components[:20])
    raise NotFoundError(f"the design has no component {echo(name)}; it has {known}")


def with_component(design: Design, sent: Any, limits: Limits) -> Design:
    """Return the design with one more component; raises `DesignError` with pointers into what was sent."""
    count = len(design.vehicle.components)
    if isinstance(sent, Mapping) and any(c.name == sent.get("name") for c in design.vehicle.components):
        message = f"there is a component {echo(sent['name'])} already"
        raise DesignError([Problem("/name", message, hint="choose another name, or change that one by PATCH")])
    patch = [{"op": "add", "path": pointer_to(*FOLDER, "-"), "value": sent}]
    return _patched(design, patch, pointer_to(*FOLDER, count), limits)


def with_merged(design: Design, name: str, fields: Any, limits: Limits) -> Design:
    """Return the design with fields of one component merged in (RFC 7386): null takes a field back to its default.

    Raises `NotFoundError`, or `DesignError` with pointers into what was sent.
    """
    i, component = find_component(design, name)
    if not isinstance(fields, Mapping):
        raise DesignError([Problem("", f"the changes are an object of fields, not {echo(fields)}")])
    merged = _merge(component.model_dump(mode="json"), fields)
    patch = [{"op": "replace", "path": pointer_to(*FOLDER, i), "value": merged}]
    return _patched(design, patch, pointer_to(*FOLDER, i), limits)


def without_component(design: Design, name: str, limits: Limits) -> Design:
    """Return the design without one component; raises `NotFoundError`, or `DesignError` where others need it."""
    i, _ = find_component(design, name)
    return _patched(design, [{"op": "remove", "path": pointer_to(*FOLDER, i)}], None, limits)


def _merge(target: Any, fields: Mapping[str, Any]) -> dict[str, Any]:
    result = dict(target) if isinstance(target, Mapping) else {}
    for name, value in fields.items():
        if value is None:
            result.pop(name, None)
        else:
            result[name] = _merge(result.get(name), value) if isinstance(value, Mapping) else value
    return result


def _patched(design: Design, patch: Sequence[Mapping[str, Any]], sent_at: str | None, limits: Limits) -> Design:
    try:
        changed = apply_patch(design, patch)
        assemble(changed, limits)
        return changed
    except DesignError as error:
        raise DesignError(_told(problem, sent_at) for problem in error.problems) from None


def _told(problem: Problem, sent_at: str | None) -> Problem:
    """Move a pointer into what was sent; what is wrong elsewhere in the design is told by its place there."""
    if sent_at is not None and (problem.pointer == sent_at or problem.pointer.startswith(f"{sent_at}/")):
        return replace(problem, pointer=problem.pointer.removeprefix(sent_at))
    message = f"the design would be wrong at {problem.pointer or 'its top'}: {problem.message}"
    return replace(problem, pointer="", message=message, hint=problem.hint or "change both together: PATCH the design")
