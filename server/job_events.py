"""Owns the telling of jobs' news: one poller for all listeners of this process, however many they are.

It asks the store four times a second how often each watched job has changed, so it also sees what other processes do.
All of it lives in the event loop's thread; only the store is asked in another. It knows no HTTP.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import anyio.to_thread
from pydantic_core import to_json

from server.jobs.service import Jobs
from server.store.errors import NotFoundError, StoreError

EVERY = 0.25
"""How often the store is asked, s."""
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class News:
    """A job as it was told: its record as JSON, and whether that is the last there is to tell."""

    sequence: int
    record: str
    over: bool


@dataclass(eq=False, slots=True)
class _Topic:
    """What is known of one watched job; `changed` is set, and replaced, whenever that changes."""

    news: News | None = None
    gone: bool = False
    listeners: int = 0
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    def tell(self, news: News | None) -> None:
        """Tell all listeners; None says that there is no such job any more."""
        if news is None:
            self.gone = True
        else:
            self.news = news
        changed, self.changed = self.changed, asyncio.Event()
        changed.set()


class Listener:
    """One who is told what becomes of a job; `seen` is the sequence of what was seen before."""

    def __init__(self, topic: _Topic, seen: int | None) -> None:
        self._topic, self._seen = topic, seen

    async def next(self) -> News | None:
        """Wait for what was not seen yet; None once the job is over or gone."""
        while True:
            changed, news = self._topic.changed, self._topic.news
            if news is not None and news.sequence != self._seen:
                self._seen = news.sequence
                return news
            if self._topic.gone or (news is not None and news.over):
                return None
            await changed.wait()


def events_of(jobs: Jobs) -> JobEvents:
    """Return what tells the news of a program's jobs."""

    def read(job_id: str) -> News:
        job = jobs.store.get(job_id)
        return News(job.sequence, to_json(jobs.record(job), inf_nan_mode="null").decode(), job.over)

    return JobEvents(jobs.store.sequences, read)


class JobEvents:
    """Tells listeners what becomes of jobs.

    Parameters
    ----------
    sequences
        Returns how often each of some jobs has changed; those that are not there are left out.
    read
        Returns a job as it is now; raises `NotFoundError`.

    """

    def __init__(self, sequences: Callable[[Sequence[str]], Mapping[str, int]], read: Callable[[str], News]) -> None:
        self._sequences, self._read = sequences, read
        self._topics: dict[str, _Topic] = {}
        self._poller: asyncio.Task[None] | None = None
        self._wanted = asyncio.Event()

    @property
    def listeners(self) -> int:
        """How many listen now."""
        return sum(topic.listeners for topic in self._topics.values())

    @contextmanager
    def listening(self, job_id: str, seen: int | None = None) -> Iterator[Listener]:
        """Enter a listener, who is forgotten where this ends."""
        topic = self._topics.setdefault(job_id, _Topic())
        topic.listeners += 1
        if self._poller is None or self._poller.done():
            self._wanted = asyncio.Event()
            self._poller = asyncio.create_task(self._poll(self._wanted))
        if topic.news is None:
            self._wanted.set()  # the first listener of a job does not wait for the next round
        try:
            yield Listener(topic, seen)
        finally:
            self._leave(job_id, topic)

    def _leave(self, job_id: str, topic: _Topic) -> None:
        topic.listeners -= 1
        if topic.listeners == 0 and self._topics.get(job_id) is topic:
            del self._topics[job_id]
        if not self._topics and self._poller is not None:
            self._poller.cancel()
            self._poller = None

    async def _poll(self, wanted: asyncio.Event) -> None:
        while True:
            wanted.clear()
            try:
                await self._look()
            except StoreError as error:
                _log.warning("what becomes of jobs cannot be seen now: %s", error)
            except Exception:
                _log.exception("the look at the jobs failed; it goes on")
            with suppress(TimeoutError):
                await asyncio.wait_for(wanted.wait(), EVERY)

    async def _look(self) -> None:
        watched = dict(self._topics)
        sequences = await anyio.to_thread.run_sync(self._sequences, list(watched))
        for job_id, topic in watched.items():
            if topic.news is None or sequences.get(job_id) != topic.news.sequence:
                topic.tell(await anyio.to_thread.run_sync(self._found, job_id))

    def _found(self, job_id: str) -> News | None:
        try:
            return self._read(job_id)
        except NotFoundError:
            return None
