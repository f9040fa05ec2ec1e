"""Owns the layers around every route, and their order: id, log, figures and headers outermost, the body within."""

from __future__ import annotations

import logging
import time
from typing import Any

from fastapi import FastAPI
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect, Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server import request_context
from server.access import API, METRICS, PROBES, ApiCors, QuotaGate, SiteGate, TokenGate
from server.body import BodyLimit
from server.errors import on_crash
from server.quotas import LOCAL, NOBODY, Principal, Quotas
from server.request_context import RequestContext
from server.settings import Settings
from server.stopping import Stopping, StreamEnder, is_event_stream
from server.store.archive import LARGEST_FILE
from server.telemetry import Telemetry

EVERYWHERE = ((b"x-content-type-options", b"nosniff"), (b"referrer-policy", b"same-origin"))
IN_THE_API = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"content-security-policy", b"default-src 'none'; frame-ancestors 'none'"),
    (b"x-frame-options", b"DENY"),
    (b"cross-origin-resource-policy", b"same-origin"),
)
"""Added where an answer does not say otherwise itself."""
KEPT_NOWHERE, CHECKED_EACH_TIME = b"no-store", b"private, no-cache"
IMPORTED = (f"{API}v1/designs:import", "application/zip")
LEFT = 499
"""Status in the log of a request whose client left before it was answered."""
UNKNOWN = "(none)"
_log = logging.getLogger("server.requests")


def install_middleware(
    app: FastAPI, settings: Settings, *, quotas: Quotas, telemetry: Telemetry, stopping: Stopping
) -> None:
    """Put the layers around an application; the last one added is the first that a request meets."""
    app.add_middleware(StreamEnder, stopping=stopping)
    if settings.demands_token:
        app.add_middleware(QuotaGate, quotas=quotas)
    # what never fits need not be tried again later; what an export gives fits into an import
    app.add_middleware(BodyLimit, max_bytes=settings.max_body_bytes, larger={IMPORTED: LARGEST_FILE})
    if settings.demands_token:
        app.add_middleware(TokenGate, settings=settings, quotas=quotas)
    if settings.cors_origins:
        app.add_middleware(ApiCors, settings=settings)  # before the token, which no preflight brings
    app.add_middleware(SiteGate, settings=settings)
    principal = NOBODY if settings.demands_token else LOCAL  # until a token says whose request it is
    app.add_middleware(RequestFrame, telemetry=telemetry, principal=principal)


class RequestFrame:
    """ASGI middleware that gives each request an id, its answer the safe headers, the log a line, and counts it."""

    def __init__(self, app: ASGIApp, telemetry: Telemetry, principal: Principal) -> None:
        self.app = app
        self._telemetry, self._principal = telemetry, principal

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; a crash within is answered here, so that it has id and headers too."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        given = Headers(scope=scope).get("x-request-id")
        context = RequestContext(request_context.request_id(given), self._principal.name)
        scope.setdefault("state", {})["principal"] = self._principal
        token = request_context.enter(context)
        answer = _Answer(scope, context.id, send)
        self._telemetry.in_progress.inc()
        try:
            await self.app(scope, receive, answer.send)
        except ClientDisconnect:
            pass  # who left while its body was read hears no answer: nothing failed here
        except Exception as error:
            if scope["type"] != "http" or answer.status:
                raise
            await (await on_crash(Request(scope), error))(scope, receive, answer.send)
        finally:
            self._telemetry.in_progress.dec()
            if scope["type"] == "http":
                self._tell(scope, answer)
            request_context.leave(token)

    def _tell(self, scope: Scope, answer: _Answer) -> None:
        seconds = time.perf_counter() - answer.began
        route, status = template_of(scope), answer.status or LEFT
        # a stream lasts as long as its reader likes: what it took is the time to its first byte
        took = answer.streams_after if answer.streams_after is not None else seconds
        self._telemetry.observe(scope["method"], route, status=status, seconds=took)
        _log.log(
            _level(scope["path"], status), "%s %s %d %.1f ms %d bytes", scope["method"], route, status, seconds * 1e3,
            answer.size,
            extra={
                "method": scope["method"], "route": route, "status": status, "duration_ms": round(seconds * 1e3, 3),
                "bytes": answer.size,
            },
        )  # fmt: skip


class _Answer:
    """What is sent to a client: it gets the headers, and its size is counted."""

    def __init__(self, scope: Scope, request_id: str, send: Send) -> None:
        self.began = time.perf_counter()
        self.status, self.size = 0, 0
        self.streams_after: float | None = None
        self._path, self._id, self._send = scope.get("path", ""), request_id, send

    async def send(self, message: Message) -> None:
        """Send a part of the answer at once."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            if is_event_stream(message):
                self.streams_after = time.perf_counter() - self.began
            headers = [*message.get("headers", ()), (b"x-request-id", self._id.encode())]
            message = {**message, "headers": with_safe_headers(self._path, headers)}
        elif message["type"] == "http.response.body":
            self.size += len(message.get("body", b""))
        await self._send(message)


def with_safe_headers(path: str, headers: list[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    """Return an answer's headers with those that keep it where it belongs; what the answer says itself stands."""
    present = {name.lower() for name, _ in headers}
    in_api = path.startswith(API) or path == METRICS or path in PROBES
    headers += [item for item in (IN_THE_API if in_api else EVERYWHERE) if item[0] not in present]
    if in_api and b"cache-control" not in present:
        headers.append((b"cache-control", CHECKED_EACH_TIME if b"etag" in present else KEPT_NOWHERE))
    return headers


def template_of(scope: Scope) -> str:
    """Return the template of a request's address, say /api/v1/presets/{preset_id}: no names, and few in number."""
    # where routers are nested, the route itself knows only the end of its address
    whole: Any = scope.get("fastapi", {}).get("effective_route_context")
    for route in (whole, scope.get("route")):
        template = getattr(route, "path_format", "")
        if template:
            return str(template)
    # a plain route without parameters is its own template
    return str(scope["path"]) if "endpoint" in scope and not scope.get("path_params") else UNKNOWN


def _level(path: str, status: int) -> int:
    if status >= 500:
        return logging.ERROR
    # what machines and the studio's own page ask for all the time
    often = path in PROBES or path == METRICS or path.startswith(("/s/", "/static/"))
    return logging.DEBUG if often else logging.INFO
