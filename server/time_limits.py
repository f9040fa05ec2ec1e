"""Owns the time limit of quick runs: one thread that stops those that compute too long. It knows no HTTP.

A timer for each run would be a thread for each, which on a busy machine takes longer to start than a run.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class TimeLimits:
    """Calls `stop` of whatever takes longer than it may; its thread begins at the first use and sleeps in between."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._due: dict[object, tuple[float, Callable[[], None]]] = {}
        self._thread: threading.Thread | None = None
        self._wakes = math.inf

    @contextmanager
    def within(self, seconds: float, stop: Callable[[], None]) -> Iterator[None]:
        """Have `stop` called, in another thread, once what is done within has taken so long."""
        key, deadline = object(), time.monotonic() + seconds
        with self._changed:
            self._due[key] = deadline, stop
            if self._thread is None:
                self._thread = threading.Thread(target=self._watch, name="time-limits", daemon=True)
                self._thread.start()
            elif deadline < self._wakes:
                self._changed.notify()
        try:
            yield
        finally:
            with self._changed:
                self._due.pop(key, None)

    def _watch(self) -> None:
        while True:
            for stop in self._overdue():
                stop()

    def _overdue(self) -> list[Callable[[], None]]:
        """Wait for the next deadline, or for an earlier one; return what is overdue then, and forget it."""
        with self._changed:
            self._wakes = min((deadline for deadline, _ in self._due.values()), default=math.inf)
            left = self._wakes - time.monotonic()
            if left > 0.0:
                self._changed.wait(None if math.isinf(left) else left)
            now = time.monotonic()
            late = [key for key, (deadline, _) in self._due.items() if deadline <= now]
            return [self._due.pop(key)[1] for key in late]
