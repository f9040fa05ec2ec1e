"""Owns the one shape of every error, `application/problem+json` (RFC 9457), and the handlers that make it."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from pydantic_core import to_json
from starlette.exceptions import HTTPException
from starlette.routing import Match

from models.problems import DesignError, Problem, echo, pointer_to
from server.queries_declared import parameter_problem
from server.quotas import QuotaError
from server.store.errors import CursorError, DeletedError, NotFoundError, RevisionError, StoreError, UnavailableError
from server.store.job_records import JobStateError, KeyReusedError

PROBLEM_JSON = "application/problem+json"
MOST_ERRORS = 100
TITLES = {413: "Content Too Large"}
"""Names that newer versions of Python changed."""
NOT_DESIGN = "The document cannot be used as it is"
NOT_REQUEST = "The request cannot be used as it is"
STORE_STATUS: dict[type[StoreError], int] = {
    NotFoundError: 404, DeletedError: 410, RevisionError: 412, CursorError: 422, UnavailableError: 503,
    JobStateError: 409, KeyReusedError: 422,
}  # fmt: skip
_log = logging.getLogger(__name__)


class MalformedJsonError(DesignError):
    """A body is not JSON at all."""


class RequestError(Exception):
    """A request is wrong beside its body: in its query or its headers."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(f"{p.message} ({p.hint})" if p.hint else p.message for p in self.problems))


def problem_response(
    status: int,
    title: str,
    *,
    detail: str | None = None,
    errors: Iterable[Problem] = (),
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Return an answer in the shape of RFC 9457; of very many errors only the first are told."""
    problems = tuple(errors)
    shown = [problem.as_dict() for problem in problems[:MOST_ERRORS]]
    if len(problems) > MOST_ERRORS:
        detail = f"{len(problems)} errors, of which the first {MOST_ERRORS} are listed"
    content: dict[str, Any] = {"type": "about:blank", "title": title, "status": status}
    if detail is not None:
        content["detail"] = detail
    content["errors"] = shown
    return Response(to_json(content, inf_nan_mode="null"), status, headers, media_type=PROBLEM_JSON)


def design_problem(error: DesignError) -> Response:
    """Return the answer to a wrong document: 400 where it is not JSON, else 422."""
    if isinstance(error, MalformedJsonError):
        return problem_response(400, "The body is not JSON", detail=error.problems[0].message, errors=error.problems)
    return problem_response(422, NOT_DESIGN, detail=_detail(error.problems), errors=error.problems)


def _detail(problems: Sequence[Problem]) -> str:
    """Return the one thing that is wrong, or how many there are."""
    return str(problems[0]) if len(problems) == 1 else f"{len(problems)} errors"


def quota_problem(error: QuotaError) -> Response:
    """Return the answer to one who has used a quota up: 429 and when to come again, or 413 where nothing would help."""
    problem = Problem("", error.message, error.bound, f"the limit is GLIDER_STUDIO_{error.limit.upper()} of the server")
    if error.retry_after is None:
        return problem_response(413, "Content Too Large", detail=error.message, errors=[problem])
    headers = {"Retry-After": str(max(1, math.ceil(error.retry_after)))}
    return problem_response(429, "Too Many Requests", detail=error.message, errors=[problem], headers=headers)


def store_problem(error: StoreError) -> Response:
    """Return the answer to what the store cannot do."""
    status = STORE_STATUS[type(error)]
    headers: dict[str, str] = {}
    if isinstance(error, RevisionError):
        headers["ETag"] = f'"{error.current}"'
    if isinstance(error, UnavailableError):
        headers["Retry-After"] = "5"
    where = {CursorError: "query parameter 'cursor'", KeyReusedError: "header parameter 'Idempotency-Key'"}.get(
        type(error)
    )
    errors = [Problem("", f"{where}: {error}")] if where is not None else []
    return problem_response(status, HTTPStatus(status).phrase, detail=str(error), errors=errors, headers=headers)


def install_error_handlers(app: FastAPI) -> None:
    """Make every error of `app` a problem document."""
    app.add_exception_handler(DesignError, _on_design_error)
    app.add_exception_handler(RequestValidationError, _on_invalid_request)
    app.add_exception_handler(RequestError, _on_request_error)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(QuotaError, _on_quota_error)
    app.add_exception_handler(StoreError, _on_store_error)
    app.add_exception_handler(Exception, on_crash)


async def _on_design_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, DesignError)
    return design_problem(error)


async def _on_quota_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, QuotaError)
    return quota_problem(error)


async def _on_store_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, StoreError)
    return store_problem(error)


async def _on_invalid_request(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    problems = [
        parameter_problem(request, item) if item["loc"][0] != "body" else _body_problem(item) for item in error.errors()
    ]
    return problem_response(422, NOT_REQUEST, detail=_detail(problems), errors=problems)


def _body_problem(item: Any) -> Problem:
    """Return what is wrong with a body that FastAPI itself reads."""
    return Problem(pointer_to(*item["loc"][1:]), f"{item['msg']}, not {echo(item['input'])}")


async def _on_request_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestError)
    return problem_response(422, NOT_REQUEST, detail=str(error), errors=error.problems)


async def _on_http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    status, headers = error.status_code, error.headers
    title = TITLES.get(status) or HTTPStatus(status).phrase
    detail = error.detail if error.detail != HTTPStatus(status).phrase else None
    if status == 404 and detail is None:
        detail = f"there is nothing at {echo(request.url.path)}"
    if status == 405:
        allowed = ", ".join(_methods_at(request)) or (headers or {}).get("Allow", "")
        detail, headers = f"{request.method} is not possible here; possible: {allowed}", {"Allow": allowed}
    return problem_response(status, title, detail=detail, headers=headers)


def _methods_at(request: Request) -> list[str]:
    """Return the methods that any route has for a request's path; the framework names those of one route only."""
    scope = {key: request.scope[key] for key in ("type", "path", "root_path", "headers", "query_string")}
    routes = request.app.router.routes
    return [
        method
        for method in ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE")
        if any(route.matches(scope | {"method": method})[0] is Match.FULL for route in routes)
    ]


async def on_crash(request: Request, error: Exception) -> Response:
    """Return the answer to a fault of the program, which the log tells and the answer does not."""
    _log.error("%s %s failed", request.method, request.url.path, exc_info=error)
    detail = "this is a fault of the program; its log says more"
    return problem_response(500, "The server failed", detail=detail)
