"""Owns the beginning of the end: whatever would keep the server waiting is told that it stops."""

from __future__ import annotations

import logging
from collections.abc import Callable

import anyio
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_log = logging.getLogger(__name__)


class Stopping:
    """Calls, once, those who want to know that the server stops. Used in the event loop's thread."""

    def __init__(self) -> None:
        self.begun = False
        self._listeners: dict[object, Callable[[], None]] = {}

    def on_stop(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Have `listener` called when the stop begins, at once where it has; returns how to withdraw it."""
        if self.begun:
            listener()
            return lambda: None
        key = object()
        self._listeners[key] = listener

        def withdraw() -> None:
            self._listeners.pop(key, None)

        return withdraw

    def begin(self) -> None:
        """Tell all; a listener that fails stops nobody else."""
        self.begun = True
        listeners, self._listeners = self._listeners, {}
        for listener in listeners.values():
            try:
                listener()
            except Exception:
                _log.exception("a listener failed while the server stops")


class StreamEnder:
    """ASGI middleware that ends server-sent event streams cleanly when the server stops; they have no end else."""

    def __init__(self, app: ASGIApp, stopping: Stopping) -> None:
        self.app = app
        self._stopping = stopping

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; an event stream among the answers is ended by a stop."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        withdraw: Callable[[], None] | None = None
        with anyio.CancelScope() as stream:

            async def watched(message: Message) -> None:
                nonlocal withdraw
                await send(message)
                if message["type"] == "http.response.start" and is_event_stream(message):
                    withdraw = self._stopping.on_stop(stream.cancel)

            try:
                await self.app(scope, receive, watched)
            finally:
                if withdraw is not None:
                    withdraw()
        if stream.cancelled_caught:
            await send({"type": "http.response.body", "body": b"", "more_body": False})


def is_event_stream(start: Message) -> bool:
    """Whether an answer that begins is a stream of server-sent events."""
    return any(
        name == b"content-type" and value.startswith(b"text/event-stream") for name, value in start.get("headers", ())
    )
