"""Owns who may come in: same-origin checks, the cookie of each session, and the headers of the studio's pages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from fastapi import Depends, HTTPException, Request
from starlette.requests import HTTPConnection
from starlette.responses import Response

from server.access import KnownTokens, is_same_origin
from server.settings import Settings
from studio.registry import OpenSession, Sessions

PAGE_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self'; font-src 'self'; frame-src 'self'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'",
    "Cache-Control": "no-cache",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


def viewer_headers(host: str) -> dict[str, str]:
    """Return the headers of Viser's client: no script from elsewhere, no other server, framed by our page alone."""
    policy = (
        "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; "
        "style-src 'unsafe-inline' blob: data:; "
        f"connect-src 'self' ws://{host} wss://{host} blob: data:; worker-src blob:; img-src 'self' blob: data:; "
        "font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
    )
    return {
        "Content-Security-Policy": policy,
        "Cache-Control": "no-cache",
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "same-origin",
    }


def cookie_name(session_id: str) -> str:
    """Return the name of a session's cookie."""
    return f"gs_{session_id}"


def set_session_cookie(response: Response, session_id: str, secret: str, *, secure: bool) -> None:
    """Give the browser the secret of a session, for that session's addresses only.

    SameSite=Lax, not Strict: the first click on a link in a mail must work.
    """
    response.set_cookie(
        cookie_name(session_id), secret, path=f"/s/{session_id}/", httponly=True, samesite="lax", secure=secure,
        max_age=90 * 86_400,
    )  # fmt: skip


def has_token(connection: HTTPConnection, settings: Settings) -> bool:
    """Whether a request may open sessions: where the server has tokens, only with one."""
    return not settings.demands_token or KnownTokens(settings.tokens).name_of(connection) is not None


def find_session(sessions: Sessions, connection: HTTPConnection, session_id: str) -> OpenSession | None:
    """Return the session of a request whose cookie belongs to it, else None."""
    secret = connection.cookies.get(cookie_name(session_id))
    opened = sessions.find(session_id) if secret else None
    return opened if opened is not None and opened.admits(secret or "") else None


def provide(sessions: Sessions, settings: Settings) -> Callable[[HTTPConnection], None]:
    """Return the router's dependency that gives its routes the open sessions and the settings."""

    def provide_to(connection: HTTPConnection) -> None:
        connection.state.sessions, connection.state.settings = sessions, settings

    return provide_to


def open_sessions(connection: HTTPConnection) -> Sessions:
    """Return the open sessions."""
    sessions: Sessions = connection.state.sessions
    return sessions


def settings_of(connection: HTTPConnection) -> Settings:
    """Return the settings."""
    settings: Settings = connection.state.settings
    return settings


def admitted(request: Request, session_id: str) -> OpenSession:
    """Return the session that a request may use; answers 403 to any other, so that nobody learns which exist."""
    if request.method not in ("GET", "HEAD") and not is_same_origin(request, required=False):
        raise HTTPException(403, "this request comes from another site")
    opened = find_session(open_sessions(request), request, session_id)
    if opened is None:
        raise HTTPException(403, "this session is not yours, or it is gone: open a preset, or your saved file")
    opened.touch()
    return opened


AnySessions = Annotated[Sessions, Depends(open_sessions)]
SettingsNow = Annotated[Settings, Depends(settings_of)]
Admitted = Annotated[OpenSession, Depends(admitted)]
