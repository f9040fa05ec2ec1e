"""Owns what may come in as a body: its size, its type, and JSON that is nothing but finite numbers and clean text."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import Depends, Request
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from models.problems import DesignError, Problem, echo, pointer_to
from server.errors import MalformedJsonError, problem_response

MAX_DEPTH = 64
MOST_PROBLEMS = 20


class BodyLimit:
    """ASGI middleware that answers 413 to a body above `max_bytes`, whether it announces its size or streams.

    `larger` holds what may be larger, by path and media type.
    """

    def __init__(self, app: ASGIApp, max_bytes: int, *, larger: Mapping[tuple[str, str], int] | None = None) -> None:
        self.app = app
        self.max_bytes, self._larger = max_bytes, larger or {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, its body counted."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        most = max(self.max_bytes, self._larger.get((scope["path"], media_type(headers)), 0))
        announced = headers.get("content-length", "")
        if announced.isdecimal() and int(announced[:20]) > most:
            await _refusal(most)(scope, receive, send)
            return
        received, started = 0, False

        async def counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > most:
                raise _TooLargeError(most)
            return message

        async def watched(message: Message) -> None:
            nonlocal started
            started = started or message["type"] == "http.response.start"
            await send(message)

        try:
            await self.app(scope, counted, watched)
        except _TooLargeError:
            if started:
                raise
            await _refusal(most)(scope, receive, send)


def _refusal(most: int) -> ASGIApp:
    detail = _TooLargeError(most).detail
    return problem_response(413, "Content Too Large", detail=detail, headers={"Connection": "close"})


def media_type(headers: Headers) -> str:
    """Return the media type of a body, without its parameters."""
    return headers.get("content-type", "").split(";")[0].strip().lower()


class _TooLargeError(HTTPException):
    """Raised while a body is read; as an HTTP error it passes through frameworks that read bodies themselves."""

    def __init__(self, max_bytes: int) -> None:
        detail = f"the body exceeds the limit of {max_bytes} bytes"
        super().__init__(413, detail, {"Connection": "close"})


async def json_body(request: Request) -> bytes:
    """Return the body of a request that says it is JSON; answers 415 to any other."""
    given, kind = request.headers.get("content-type", ""), media_type(request.headers)
    if kind != "application/json" and not (kind.startswith("application/") and kind.endswith("+json")):
        raise HTTPException(415, f"the body must be application/json, not {echo(given)}")
    return await request.body()


JsonBody = Annotated[bytes, Depends(json_body)]


class _Duplicate:
    """Stands in a parsed document where a name is given twice, until `_check` tells where that is."""


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        seen: set[str] = set()
        for name, _ in pairs:
            if name in seen:
                result[name] = _Duplicate()
            seen.add(name)
    return result


def loads(body: bytes, *, max_values: int) -> Any:
    """Decode a body.

    Raises
    ------
    MalformedJsonError
        Where it is not JSON.
    DesignError
        With pointers, where a number is not finite, a name comes twice, text is not Unicode, or there is too much.

    """
    if not body.strip():
        raise MalformedJsonError([Problem("", "the body is empty", hint="send a JSON document")])
    try:
        document = json.loads(body.decode("utf-8"), object_pairs_hook=_object)
    except UnicodeDecodeError as error:
        raise MalformedJsonError([Problem("", f"the body is not UTF-8: byte {error.start} is not text")]) from None
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise MalformedJsonError([Problem("", f"the body is not JSON: {error.msg} at {where}")]) from None
    except RecursionError:
        raise MalformedJsonError([_too_deep("")]) from None
    except ValueError:
        # Python itself refuses to read an integer of thousands of digits
        raise MalformedJsonError([Problem("", "a number has too many digits")]) from None
    problems = _check(document, max_values)
    if problems:
        raise DesignError(problems)
    return document


def _too_deep(pointer: str) -> Problem:
    return Problem(pointer, f"the document is nested more than {MAX_DEPTH} deep", MAX_DEPTH, "flatten it")


def _check(document: Any, max_values: int) -> list[Problem]:
    """Return what is wrong with the values of a document, by a walk that no depth can break."""
    problems: list[Problem] = []
    stack: list[tuple[Any, tuple[Any, ...]]] = [([document], ())]
    count = -1  # the document itself is no value in it
    while stack and len(problems) < MOST_PROBLEMS:
        node, path = stack.pop()
        count += len(node)
        if count > max_values:
            message = f"the document holds more than {max_values} values"
            return [Problem("", message, max_values, "send a smaller one: fewer points, rows or components")]
        if len(path) > MAX_DEPTH:
            return [_too_deep(pointer_to(*path[1:5]))]
        named = isinstance(node, dict)
        if named and (complaint := _text_complaint("".join(node))) is not None:
            problems.append(_at(path, complaint))
        inner = []
        for name, child in node.items() if named else enumerate(node):
            kind = type(child)
            if kind is dict or kind is list:
                inner.append((child, (*path, name)))
            elif kind is not float or not math.isfinite(child):  # most are such numbers
                complaint = _complaint(child)
                if complaint is not None:
                    problems.append(_at((*path, name), complaint))
        stack.extend(reversed(inner))
    return problems[:MOST_PROBLEMS]


def _at(path: tuple[Any, ...], complaint: str) -> Problem:
    """Return a problem at a path below the list that holds the document."""
    return Problem(pointer_to(*(str(name).encode(errors="replace").decode() for name in path[1:])), complaint)


def _complaint(value: Any) -> str | None:
    if isinstance(value, float):
        if math.isnan(value):
            return "NaN is not a number in JSON: numbers must be finite"
        return None if math.isfinite(value) else "the number is infinite or too large: numbers must be finite"
    if isinstance(value, str):
        return _text_complaint(value)
    if isinstance(value, int):
        return None if value.bit_length() < 1024 else "the number is too large: numbers must stay below 1.8e308"
    return "this name is given twice in one object" if isinstance(value, _Duplicate) else None


def _text_complaint(value: str) -> str | None:
    if value.isascii():
        return None
    try:
        value.encode()
    except UnicodeEncodeError:
        return "the text holds half of a surrogate pair, which is not Unicode"
    return None
