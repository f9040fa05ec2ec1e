"""Owns the stream of server-sent events by which a page hears of its session: the state, and the consequences."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from starlette.concurrency import run_in_threadpool

from server.answers import series_json
from studio.registry import OpenSession
from studio.state_feed import Snapshot

KEEP_ALIVE = 15.0
"""Pause after which the stream sends a comment, s: proxies close silent connections."""


class News:
    """What a page has not been sent yet: of states only the newest."""

    def __init__(self) -> None:
        self._loop, self._changed = asyncio.get_running_loop(), asyncio.Event()
        self._newest: Snapshot | None = None
        self._state_waits = self._consequences_wait = False

    def state(self, snapshot: Snapshot) -> None:
        """Hear of a state, in any thread."""
        self._loop.call_soon_threadsafe(self._hear_state, snapshot)

    def consequences(self) -> None:
        """Hear of new consequences, in any thread."""
        self._loop.call_soon_threadsafe(self._hear_consequences)

    async def wait(self, within: float) -> bool:
        """Wait for news; False where there were none within so many seconds."""
        try:
            await asyncio.wait_for(self._changed.wait(), within)
        except TimeoutError:
            return False
        self._changed.clear()
        return True

    def take_state(self) -> bytes | None:
        """Return the newest state, once."""
        waits, self._state_waits = self._state_waits, False
        return self._newest.content if waits and self._newest is not None else None

    def take_consequences(self) -> bool:
        """Return whether there are newer consequences, once."""
        wait, self._consequences_wait = self._consequences_wait, False
        return wait

    def _hear_state(self, snapshot: Snapshot) -> None:
        if self._newest is None or snapshot.number > self._newest.number:
            self._newest, self._state_waits = snapshot, True
            self._changed.set()

    def _hear_consequences(self) -> None:
        self._consequences_wait = True
        self._changed.set()


async def events_of(opened: OpenSession) -> AsyncIterator[bytes]:
    """Send the state at once and after each change, and new consequences; a slow page gets the newest alone."""
    news, live = News(), opened.session.consequences
    leave = opened.feed.subscribe(news.state), live.subscribe(news.consequences)
    opened.connections += 1
    try:
        news.state(await run_in_threadpool(opened.feed.now))
        while not opened.closed:
            if not await news.wait(KEEP_ALIVE):
                yield b": still here\n\n"
                continue
            if (state := news.take_state()) is not None:
                yield _event(b"state", state)
            if news.take_consequences():
                yield _event(b"consequences", series_json(live.document))
    finally:
        opened.connections -= 1
        opened.touch()
        for stop in leave:
            stop()


def _event(name: bytes, content: bytes) -> bytes:
    return b"event: %s\ndata: %s\n\n" % (name, content)
