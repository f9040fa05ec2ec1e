"""Owns which parameters a route declares, beside its body, and how a value that does not fit one is told."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from fastapi import Request
from pydantic import TypeAdapter

from models.plain_words import value_problem, values_of
from models.problems import Problem, echo


def declared(request: Request, place: str) -> Iterator[Any]:
    """Yield the parameters of a request's route in its query, path, headers or cookies, its dependencies' too."""
    # where routers are nested, the route itself knows only its own part
    whole: Any = request.scope.get("fastapi", {}).get("effective_route_context")
    yield from _parameters((whole or request.scope["route"]).dependant, place)


def _parameters(dependant: Any, place: str) -> Iterator[Any]:
    yield from getattr(dependant, f"{place}_params")
    for inner in dependant.dependencies:
        yield from _parameters(inner, place)


def parameter_problem(request: Request, item: Any) -> Problem:
    """Return what FastAPI finds wrong with a parameter, in plain words: which, what it takes, and the value."""
    place, name, *_ = item["loc"]
    field = next(field for field in declared(request, place) if _plain(field.alias) == _plain(name))
    schema, where = _schema(field.field_info), f"{place} parameter {echo(name)}"
    if item["type"] == "missing":
        return Problem("", f"{where} is missing", hint=f"add it: {values_of(schema)}")
    told = value_problem(item, schema, shown=echo(item["input"]), otherwise=_without(field.field_info))
    return Problem("", f"{where}: {told.message}", told.limit, told.hint)


def _plain(name: str) -> str:
    """Return a name as headers are compared: FastAPI tells them with hyphens, its fields have underscores."""
    return name.lower().replace("_", "-")


def _schema(info: Any) -> dict[str, Any]:
    kind: Any = Annotated[(info.annotation, *info.metadata)] if info.metadata else info.annotation
    schema = TypeAdapter(kind).json_schema()
    return schema | {"description": info.description} if info.description else schema


def _without(info: Any) -> str | None:
    """Return what becomes of a request without a parameter, where it may do without."""
    if info.is_required():
        return None
    return f"leave it out for {echo(info.default)}" if info.default not in (None, "") else "leave it out"
