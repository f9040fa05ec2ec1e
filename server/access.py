"""Owns who may use the API: requests for this host, from no other site, with a token if one is set, within quotas."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Sequence
from functools import lru_cache
from urllib.parse import urlsplit

from starlette.middleware.cors import CORSMiddleware
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from models.problems import echo
from server.errors import problem_response, quota_problem
from server.quotas import LOCAL, Principal, QuotaError, Quotas
from server.request_context import name_principal
from server.settings import Settings, is_loopback
from server.tokens import NamedToken

API = "/api/"
METRICS = "/metrics"
PROBES = frozenset({"/healthz", "/readyz"})
TOKEN_COOKIE = "gs_token"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


def token_proof(token: str) -> str:
    """Return what a browser keeps in a cookie in place of the token."""
    return hashlib.sha256(f"glider-studio browser {token}".encode()).hexdigest()


def _digest(text: str) -> bytes:
    return hashlib.sha256(text.encode(errors="replace")).digest()


class KnownTokens:
    """Tells whose token a request brings, in a time that depends neither on which it is nor on how near it is."""

    def __init__(self, tokens: Sequence[NamedToken]) -> None:
        self._known = [(token.name, _digest(token.secret), _digest(token_proof(token.secret))) for token in tokens]

    def name_of(self, connection: HTTPConnection) -> str | None:
        """Return the name of the token in the Authorization header, or of that proved by the cookie; None without."""
        scheme, _, given = connection.headers.get("authorization", "").partition(" ")
        bearer = scheme.lower() == "bearer"
        header, cookie = _digest(given.strip()), _digest(connection.cookies.get(TOKEN_COOKIE, ""))
        found = None
        for name, secret, proof in self._known:
            matches, proves = secrets.compare_digest(header, secret), secrets.compare_digest(cookie, proof)
            if (matches and bearer) or proves:
                found = name
        return found

    def knows(self, token: str) -> bool:
        """Whether a text is the secret of a token."""
        given, found = _digest(token), False
        for _name, secret, _proof in self._known:
            found |= secrets.compare_digest(given, secret)
        return found


@lru_cache(maxsize=256)
def _named_in(host: str) -> str | None:
    """Return the name in a Host header, `localhost` for any of loopback's; None where there is none."""
    try:
        name = urlsplit(f"//{host}").hostname
    except ValueError:
        return None
    return "localhost" if name is not None and is_loopback(name) else name


def is_known_host(connection: HTTPConnection, settings: Settings) -> bool:
    """Whether the Host is one of ours: a server on loopback is never addressed by a foreign name (DNS rebinding).

    Elsewhere any name will do unless `allowed_hosts` says which: there the token guards, which a foreign page lacks.
    """
    name = _named_in(connection.headers.get("host", ""))
    if name == "localhost" or (not settings.allowed_hosts and not is_loopback(settings.host)):
        return True
    return name in {host.strip("[]").lower() for host in (settings.host, *settings.allowed_hosts)}


def _authority_of(origin: str) -> str | None:
    """Return the host and port of an origin; None where it is not one."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None


def is_same_origin(connection: HTTPConnection, *, required: bool) -> bool:
    """Whether a request comes from our own pages: its Origin is its Host.

    Browsers send Origin with every POST and websocket; scripts send none, and may only where it is not `required`.
    """
    origin = connection.headers.get("origin")
    if origin is None:
        return not required and connection.headers.get("sec-fetch-site", "none") in ("none", "same-origin")
    host = connection.headers.get("host", "")
    return host != "" and _authority_of(origin) == host


class SiteGate:
    """ASGI middleware that refuses foreign host names, and changes through the API that other sites ask for."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self._settings = settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it before its body is read."""
        refusal = None
        if scope["type"] == "http" and scope["path"] not in PROBES:
            refusal = self._refusal(HTTPConnection(scope), scope)
        await (refusal or self.app)(scope, receive, send)

    def _refusal(self, connection: HTTPConnection, scope: Scope) -> ASGIApp | None:
        host = connection.headers.get("host", "")
        if not is_known_host(connection, self._settings):
            detail = (
                f"this server is not {echo(host)}: use the address it was started with, or have whoever runs it "
                "name this one in GLIDER_STUDIO_ALLOWED_HOSTS"
            )
            return problem_response(421, "Misdirected Request", detail=detail)
        if scope["method"] in SAFE_METHODS or not scope["path"].startswith(API):
            return None
        origin = connection.headers.get("origin")
        if is_same_origin(connection, required=False) or origin in self._settings.cors_origins:
            return None
        detail = (
            f"this request comes from {echo(origin or 'another site')}, not from {echo(host)}: whoever runs the server "
            "can let other sites in by GLIDER_STUDIO_CORS_ORIGINS"
        )
        return problem_response(403, "Forbidden", detail=detail)


class ApiCors(CORSMiddleware):
    """Lets named other sites use the API; they never see a session, which needs its cookie."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        super().__init__(
            app,
            allow_origins=settings.cors_origins,
            allow_methods=("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE"),
            allow_headers=(
                "Authorization", "Content-Type", "Idempotency-Key", "If-Match", "If-None-Match", "Last-Event-ID",
                "X-Request-ID",
            ),
            expose_headers=("ETag", "Link", "Location", "Retry-After", "X-Request-ID"),
        )  # fmt: skip

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Add the headers of CORS to the API's answers, and to nothing else."""
        inside = scope["type"] == "http" and scope["path"].startswith(API)
        await (super().__call__ if inside else self.app)(scope, receive, send)


class TokenGate:
    """ASGI middleware that answers 401 to a request for the API without `Authorization: Bearer <token>`.

    Figures for Prometheus are guarded too unless `metrics_open`; the probes are not, since who asks them has no token.
    """

    def __init__(self, app: ASGIApp, settings: Settings, quotas: Quotas) -> None:
        self.app = app
        self._tokens, self._quotas = KnownTokens(settings.tokens), quotas
        self._metrics_open = settings.metrics_open

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, its principal known, or refuse it before its body is read."""
        if scope["type"] != "http" or not self._guards(scope["path"]):
            await self.app(scope, receive, send)
            return
        name = self._tokens.name_of(HTTPConnection(scope))
        if name is None:
            await self._refusal(scope)(scope, receive, send)
            return
        scope.setdefault("state", {})["principal"] = Principal(name)
        name_principal(name)
        await self.app(scope, receive, send)

    def _guards(self, path: str) -> bool:
        return path.startswith(API) or (path == METRICS and not self._metrics_open)

    def _refusal(self, scope: Scope) -> ASGIApp:
        client = scope.get("client")
        try:
            self._quotas.admit_stranger(client[0] if client else "unknown")
        except QuotaError as error:
            return quota_problem(error)
        return problem_response(
            401,
            "Unauthorized",
            detail="this server demands its token: send the header Authorization: Bearer <token>, or open its "
            "first page once in the browser with ?token=<token>",
            headers={"WWW-Authenticate": "Bearer"},
        )


class QuotaGate:
    """ASGI middleware that answers 429 to a token that has used up its requests or bytes, and counts both."""

    def __init__(self, app: ASGIApp, quotas: Quotas) -> None:
        self.app = app
        self._quotas = quotas

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, its body counted, or refuse it before its body is read."""
        principal = principal_of(scope)
        if scope["type"] != "http" or not principal.limited:
            await self.app(scope, receive, send)
            return
        try:
            self._quotas.admit(principal)
        except QuotaError as error:
            await quota_problem(error)(scope, receive, send)
            return

        async def counted() -> Message:
            message = await receive()
            self._quotas.spend_bytes(principal, len(message.get("body", b"")))
            return message

        await self.app(scope, counted, send)


def principal_of(scope: Scope) -> Principal:
    """Return who asks."""
    principal: Principal = scope.get("state", {}).get("principal", LOCAL)
    return principal
