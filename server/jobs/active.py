"""Owns one job under way in this process: which chunks are left, sent and suspected, and how fast it goes."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future

from models.limits import Limits
from server.jobs.files import JobFiles
from server.jobs.plan import Plan
from server.jobs.task import ChunkResult, ChunkTask
from server.jobs.tasks import TaskMaker
from server.jobs.watch import Watch, watch_of
from server.store.job_records import Job

WINDOW = 30.0
"""Over how long the rate is taken, s."""


class ActiveJob:
    """A claimed job. Chunks are given out in order; those given back come first."""

    def __init__(self, job: Job, plan: Plan, files: JobFiles, *, written: set[int], limits: Limits) -> None:
        self.job, self.files, self.written = job, files, written
        self.sent: dict[Future[ChunkResult], int] = {}
        self.deaths: dict[int, int] = {}
        self.suspects: list[int] = []
        self.cancelling = job.cancel_requested
        self.watch: Watch | None = watch_of(plan)
        self._maker = TaskMaker(plan, limits)
        self._fresh = self._left()
        self._again: deque[int] = deque()
        self._ahead: int | None = next(self._fresh, None)
        self._lately: deque[tuple[float, int]] = deque([(time.monotonic(), 0)])

    def _left(self) -> Iterator[int]:
        return (chunk for chunk in range(self.job.chunks) if chunk not in self.written)

    @property
    def has_work(self) -> bool:
        """Whether a chunk waits to be sent; suspects are sent alone, and apart."""
        return not self.cancelling and (bool(self._again) or self._ahead is not None)

    @property
    def finished(self) -> bool:
        """Whether nothing is left to send or to wait for."""
        return not self.sent and not self.has_work and (self.cancelling or not self.suspects)

    def next_chunk(self) -> int:
        """Take the next chunk; there must be one."""
        if self._again:
            return self._again.popleft()
        chunk, self._ahead = self._ahead, next(self._fresh, None)
        assert chunk is not None
        return chunk

    def give_back(self, chunk: int) -> None:
        """Have a chunk sent again, before new ones."""
        self._again.appendleft(chunk)

    def suspect(self, chunk: int) -> None:
        """Have a chunk that was with a worker that died sent again alone."""
        if chunk not in self.suspects:
            self.suspects.append(chunk)

    def drop_rest(self) -> None:
        """Send nothing more; what waits in a queue is called back."""
        self.cancelling = True
        for future in list(self.sent):
            future.cancel()

    def refill_watch(self) -> None:
        """Have the watch know what was written before."""
        if self.watch is not None:
            for chunk in sorted(self.written):
                self.watch.add(chunk * self.job.chunk_size, self.files.path(chunk).read_bytes())

    def heed_watch(self) -> None:
        """Send nothing more where the watch knows enough."""
        if self.watch is not None and self.watch.stop is not None:
            self.drop_rest()

    def task(self, chunk: int) -> ChunkTask:
        """Return the work of a chunk."""
        first = chunk * self.job.chunk_size
        last = min(first + self.job.chunk_size, self.job.cases)
        return self._maker.task(self.job.id, chunk, first, last)

    def note(self, cases: int) -> float | None:
        """Note that cases were finished; return the rate lately, cases a second."""
        now = time.monotonic()
        self._lately.append((now, cases))
        while len(self._lately) > 2 and self._lately[1][0] < now - WINDOW:
            self._lately.popleft()
        span = now - self._lately[0][0]
        return sum(count for _, count in list(self._lately)[1:]) / span if span > 0.0 else None
