"""Owns Viser servers that answer only this process's proxy: on loopback, on a port of their own, with a secret header.

Viser offers no hook for that, so the websocket library's `serve` is exchanged while a server starts: one place, one
lock, one test that fails should a new version start its servers otherwise.
"""

from __future__ import annotations

import hmac
import http
import inspect
import logging
import secrets
import threading
from typing import Any

import rich
import viser
import websockets.asyncio.server as websocket_server

HEADER = "X-Studio-Key"
KEY = secrets.token_urlsafe(32)
"""Secret of this process, sent by its proxy alone."""

_lock = threading.Lock()
_serve = websocket_server.serve


class GuardedServer(viser.ViserServer):
    """A Viser server that never opens a public tunnel, whichever client asks for one."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: a session is reached through the studio's own address only."""
        return None


def make_server() -> GuardedServer:
    """Start a server on a free loopback port that refuses every request without this process's key."""
    with _lock:
        rich.get_console().quiet = True  # its banner prints whatever `verbose` says
        logging.getLogger("websockets.server").setLevel(logging.WARNING)
        websocket_server.serve = _guarded_serve  # type: ignore[assignment,misc]
        try:
            return GuardedServer("127.0.0.1", 0, verbose=False)
        finally:
            websocket_server.serve = _serve  # type: ignore[misc]


def _guarded_serve(handler: Any, *args: Any, process_request: Any = None, **options: Any) -> Any:
    async def demand_key(connection: Any, request: Any) -> Any:
        if not hmac.compare_digest(request.headers.get(HEADER, "").encode(), KEY.encode()):
            return connection.respond(http.HTTPStatus.FORBIDDEN, "forbidden\n")
        if process_request is None:
            return None
        answer = process_request(connection, request)
        return await answer if inspect.isawaitable(answer) else answer

    return _serve(handler, *args, process_request=demand_key, **options)
