"""Owns who may use the program: on any address but loopback only those who bring the token."""

from __future__ import annotations

import hashlib
import secrets

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from server.errors import problem_response

GUARDED = "/api/"
TOKEN_COOKIE = "gs_token"


def token_proof(token: str) -> str:
    """Return what a browser keeps in a cookie in place of the token."""
    return hashlib.sha256(f"glider-studio browser {token}".encode()).hexdigest()


def brings_token(connection: HTTPConnection, token: str) -> bool:
    """Whether a request carries the token in its Authorization header, or the proof of it in its cookie."""
    scheme, _, given = connection.headers.get("authorization", "").partition(" ")
    # compared even where the scheme is wrong, so that the time taken tells nothing
    matches = secrets.compare_digest(given.strip().encode(errors="replace"), token.encode())
    cookie = connection.cookies.get(TOKEN_COOKIE, "").encode(errors="replace")
    proves = secrets.compare_digest(cookie, token_proof(token).encode())
    return (matches and scheme.lower() == "bearer") or proves


class TokenGate:
    """ASGI middleware that answers 401 to a request for the API without `Authorization: Bearer <token>`."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self.app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it before its body is read."""
        guarded = scope["type"] == "http" and scope["path"].startswith(GUARDED)
        if not guarded or brings_token(HTTPConnection(scope), self._token):
            await self.app(scope, receive, send)
            return
        refusal = problem_response(
            401,
            "Unauthorized",
            detail="this server demands its token: send the header Authorization: Bearer <token>",
            headers={"WWW-Authenticate": "Bearer"},
        )
        await refusal(scope, receive, send)
