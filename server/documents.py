"""Owns how a request becomes a design: the document itself or {design, ...}, with pointers into what was sent."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from models.design import Design, parse_design
from models.limits import Limits
from models.problems import DesignError, Problem, problems_from_validation

RequestT = TypeVar("RequestT", bound=BaseModel)


def read_request(document: Any, model: type[RequestT], limits: Limits) -> tuple[Design, RequestT, str]:
    """Return the design of a request, the request itself, and the pointer under which the design was sent.

    Raises
    ------
    DesignError
        With all that is wrong with the design and with what came beside it.

    """
    wrapped = isinstance(document, dict) and "design" in document and "format" not in document
    sent = document if wrapped else {"design": document}
    prefix = "/design" if wrapped else ""
    problems: list[Problem] = []
    request, design = None, None
    try:
        request = model.model_validate(sent)
    except ValidationError as error:
        problems += problems_from_validation(error, sent)
    try:
        design = read_design(sent["design"], limits)
    except DesignError as error:
        problems += under(prefix, error.problems)
    if design is None or request is None:
        raise DesignError(problems)
    return design, request, prefix


def read_design(document: Any, limits: Limits) -> Design:
    """Parse a document whose lists are within the limits: so that a huge one is refused before it is looked into."""
    problems = list(_size_problems(document, limits))
    if problems:
        raise DesignError(problems)
    return parse_design(document)


def under(prefix: str, problems: Iterable[Problem]) -> list[Problem]:
    """Return problems with their pointers moved under a prefix."""
    return [replace(problem, pointer=prefix + problem.pointer) for problem in problems]


@contextmanager
def design_sent_at(prefix: str, *, beside: str | None = None) -> Iterator[None]:
    """Move the pointers of a `DesignError` under `prefix`, save those that begin with `beside`."""
    try:
        yield
    except DesignError as error:
        moved = (p if beside and p.pointer.startswith(beside) else under(prefix, [p])[0] for p in error.problems)
        raise DesignError(moved) from None


def _size_problems(document: Any, limits: Limits) -> Iterable[Problem]:
    schedules = _at(document, "mission", "control", "schedules")
    points = sum(len(_at(schedule, "points") or ()) for schedule in schedules or ())
    counts = (
        ("/vehicle/components", "components", len(_at(document, "vehicle", "components") or ()), limits.components),
        ("/mission/control/schedules", "schedules", len(schedules or ()), limits.components),
        ("/mission/control/schedules", "schedule points", points, limits.schedule_points),
        *(
            (f"/vehicle/hydrodynamics/{name}", "table rows", len(rows), limits.table_rows)
            for name, rows in (_at(document, "vehicle", "hydrodynamics", kind=dict) or {}).items()
            if isinstance(rows, list)
        ),
    )
    for pointer, what, count, bound in counts:
        if count > bound:
            yield Problem(pointer, f"{count} {what} exceed the limit of {bound}", limit=bound, hint="use fewer")


def _at(node: Any, *names: str, kind: type = list) -> Any:
    for name in names:
        node = node.get(name) if isinstance(node, dict) else None
    return node if isinstance(node, kind) else None
