"""Owns who may use the API: on any address but loopback only those who bring the token."""

from __future__ import annotations

import secrets

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from server.errors import problem_response

GUARDED = "/api/"


class TokenGate:
    """ASGI middleware that answers 401 to a request for the API without `Authorization: Bearer <token>`."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self.app = app
        self._token = token.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it before its body is read."""
        if scope["type"] != "http" or not scope["path"].startswith(GUARDED) or self._is_allowed(Headers(scope=scope)):
            await self.app(scope, receive, send)
            return
        refusal = problem_response(
            401,
            "Unauthorized",
            detail="this server demands its token: send the header Authorization: Bearer <token>",
            headers={"WWW-Authenticate": "Bearer"},
        )
        await refusal(scope, receive, send)

    def _is_allowed(self, headers: Headers) -> bool:
        scheme, _, given = headers.get("authorization", "").partition(" ")
        # compared even where the scheme is wrong, so that the time taken tells nothing
        matches = secrets.compare_digest(given.strip().encode(errors="replace"), self._token)
        return matches and scheme.lower() == "bearer"
