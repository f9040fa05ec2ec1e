"""Owns who wants to hear of something: listeners come and go from any thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

ListenerT = TypeVar("ListenerT", bound=Callable[..., Any])


class Listeners(Generic[ListenerT]):
    """Callables to call, in the order in which they came."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: list[ListenerT] = []

    def add(self, listener: ListenerT) -> Callable[[], None]:
        """Have `listener` called from now on; returns how to stop that."""
        with self._lock:
            self._listeners.append(listener)

        def leave() -> None:
            with self._lock:
                if listener in self._listeners:
                    self._listeners.remove(listener)

        return leave

    def __iter__(self) -> Iterator[ListenerT]:
        with self._lock:
            return iter(tuple(self._listeners))

    def __len__(self) -> int:
        return len(self._listeners)
