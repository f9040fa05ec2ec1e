"""Owns that a query holds no parameter that its route does not read: a misspelt one is told, not passed over."""

from __future__ import annotations

from fastapi import Request

from models.problems import Problem, echo
from models.suggestions import suggestion
from server.errors import RequestError
from server.queries_declared import declared

MOST_TOLD = 20
"""Most parameters of one request that are looked for among those known."""


async def refuse_unknown_parameters(request: Request) -> None:
    """Raise `RequestError` where a query names a parameter that its route does not declare: a dependency of routers."""
    if not request.query_params:
        return
    known = sorted({field.alias for field in declared(request, "query")})
    unknown = [name for name in request.query_params if name not in known]
    if unknown:
        raise RequestError(_problem(name, known) for name in unknown[:MOST_TOLD])


def _problem(name: str, known: list[str]) -> Problem:
    there_are = f"known are {', '.join(known)}" if known else "there are none"
    way_out = suggestion(name, known) or "leave it out"
    return Problem("", f"query parameter {echo(name)} is unknown here; {there_are}", hint=way_out)
