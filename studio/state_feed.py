"""Owns sending the State to pages: after a change it is built once, in the session's thread, for all that listen."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from studio.listeners import Listeners
from studio.session import Session
from studio.state import state_json


@dataclass(frozen=True)
class Snapshot:
    """The State as JSON; one of a higher number tells no less."""

    number: int
    content: bytes


class StateFeed:
    """The State of a session as JSON, at once or after each change; `saved_at` tells when its file was written."""

    def __init__(self, session: Session, saved_at: Callable[[], str | None]) -> None:
        self._session, self._saved_at = session, saved_at
        self._lock = threading.Lock()
        self._number = 0
        self._listeners: Listeners[Callable[[Snapshot], None]] = Listeners()
        session.subscribe(lambda _change: self._tell())

    def now(self) -> Snapshot:
        """Return the State as it is."""
        with self._lock:  # one at a time, so that numbers rise as the states do
            self._number += 1
            return Snapshot(self._number, state_json(self._session, saved_at=self._saved_at()))

    def subscribe(self, listener: Callable[[Snapshot], None]) -> Callable[[], None]:
        """Have `listener` called after each change, in the session's own thread; returns how to stop that."""
        return self._listeners.add(listener)

    def _tell(self) -> None:
        if not self._listeners:
            return
        snapshot = self.now()
        for listener in self._listeners:
            listener(snapshot)
