"""Owns the jobs of this process: claims them, sends their chunks, keeps what comes back, goes on after any death.

One thread does all of it. A chunk counts once its file is written whole and the database says so; until then it is sent
again, so whatever dies costs at most the chunks in flight.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
import uuid
from concurrent.futures import CancelledError, Future
from pathlib import Path

from models.kernel import KERNEL_HASH
from models.limits import DEFAULT_LIMITS, Limits
from models.problems import DesignError
from server.jobs.active import ActiveJob
from server.jobs.chunk import lost_chunk, run_chunk
from server.jobs.engines import Engine, EngineLostError
from server.jobs.files import DiskFullError, JobFiles
from server.jobs.task import ChunkResult
from server.jobs.tasks import plan_of
from server.jobs.watch import failed_before
from server.store.errors import UnavailableError
from server.store.jobs import Job, JobStore

log = logging.getLogger(__name__)
TICK = 0.25
"""How often the thread looks around when nothing comes in, s."""
MOST_ACTIVE = 8
"""Most jobs under way at once; their chunks take turns."""
AHEAD = 2
"""Chunks sent for each worker, so that none waits for the next."""
FATAL_DEATHS = 2
"""A chunk that took this many workers with it, alone each time, is given up."""
BACKOFF = 2.0
"""How long to wait for an engine or a database that cannot be reached, s."""
Sent = tuple[ActiveJob, int, Future[ChunkResult]]


class Manager:
    """Works on jobs until it is stopped. Thread-safe from outside: `start`, `wake`, `stop`."""

    def __init__(
        self, store: JobStore, engine: Engine, root: Path, *,
        limits: Limits = DEFAULT_LIMITS, reserve: int = 0, lease: float = 15.0,
    ) -> None:  # fmt: skip
        self.store, self.engine, self.root = store, engine, root
        self.owner = uuid.uuid4().hex
        self._limits, self._reserve, self._lease = limits, reserve, lease
        self._active: dict[str, ActiveJob] = {}
        self._came: queue.SimpleQueue[Sent | None] = queue.SimpleQueue()
        self._unsaved: list[tuple[ActiveJob, int, ChunkResult]] = []
        self._alone: tuple[ActiveJob, int] | None = None
        self._renewed = self._rest_until = 0.0
        self._turn = 0
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin to work."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)
            self._thread.start()

    def wake(self) -> None:
        """Look for new jobs and requests at once."""
        self._came.put(None)

    def stop(self, *, wait: float = 5.0) -> None:
        """End: chunks in flight get `wait` seconds to finish; jobs stay as they are, free for whoever comes next."""
        self._stopping.set()
        self.wake()
        if self._thread is not None:
            self._thread.join(wait + 10.0)
        self.engine.stop()

    def files(self, job_id: str) -> JobFiles:
        """Return the files of a job."""
        return JobFiles(self.root, job_id, reserve=self._reserve)

    @property
    def in_flight(self) -> int:
        """How many chunks are with the engine."""
        return sum(len(active.sent) for active in list(self._active.values()))

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._look_around()
                self._send()
                self._take(TICK)
            except UnavailableError as error:
                log.warning("the database cannot be used now: %s", error)
                self._stopping.wait(BACKOFF)
            except Exception:
                log.exception("the job thread stumbled; it goes on")
                self._stopping.wait(BACKOFF)
        self._hand_over()

    def _hand_over(self) -> None:
        """Keep what comes in within a few seconds, then give all jobs back."""
        for active in self._active.values():
            active.drop_rest()
        until = time.monotonic() + 5.0
        while self.in_flight and time.monotonic() < until:
            self._take(TICK)
        try:
            self.store.release(self.owner)
        except UnavailableError as error:
            log.warning("jobs could not be given back; their lease runs out by itself: %s", error)

    # what others want of us

    def _look_around(self) -> None:
        now = time.monotonic()
        if now - self._renewed >= min(1.0, self._lease / 3.0):
            self._renewed = now
            held = self.store.renew(self.owner, self._lease)
            for job_id in [job_id for job_id in self._active if job_id not in held]:
                self._drop(job_id)  # paused, or taken by another process
            for job_id, cancelled in held.items():
                if cancelled and job_id in self._active:
                    self._active[job_id].drop_rest()
        if len(self._active) < MOST_ACTIVE:
            for job in self.store.claim(self.owner, self._lease, most=MOST_ACTIVE - len(self._active)):
                self._begin(job)
        for active in list(self._active.values()):
            if active.finished and not any(held is active for held, _, _ in self._unsaved):
                self._end(active)

    def _begin(self, job: Job) -> None:
        written = self.store.written(job.id)
        try:
            active = ActiveJob(job, plan_of(job.spec), self.files(job.id), written=written, limits=self._limits)
        except DesignError as error:  # written by another version of the program
            self._settle(job.id, state="failed", reason=f"its document cannot be read any more: {error}")
            return
        except Exception as error:
            log.exception("job %s cannot begin", job.id)
            reason = f"a fault of the program as it began: {type(error).__name__}: {error}"
            self._settle(job.id, state="failed", reason=reason)
            return
        self._active[job.id] = active
        if job.state == "queued":
            self.store.change(job.id, self.owner, state="running", started=job.started or time.time())
        if active.watch is not None:
            for chunk in sorted(active.written):
                active.watch.add(chunk * job.chunk_size, active.files.path(chunk).read_bytes())
            self._check_watch(active)

    def _end(self, active: ActiveJob) -> None:
        job = self.store.get(active.job.id)
        if active.watch is not None and active.watch.stop is not None:
            self._settle(job.id, reason=active.watch.words, **self._counted_until(active, active.watch.stop))
        elif job.cancel_requested:
            self._settle(job.id, state="cancelled")
        else:
            self._settle(job.id, state=_outcome(job.failed, job.cases))

    def _counted_until(self, active: ActiveJob, stop: int) -> dict[str, object]:
        failed = failed_before(active.files, stop, active.job.chunk_size)
        return {"state": _outcome(failed, stop), "stopped_at": stop, "done": stop, "failed": failed}

    def _settle(self, job_id: str, **values: object) -> None:
        self.store.let_go(job_id, self.owner, finished=time.time(), **values)
        self._active.pop(job_id, None)

    def _drop(self, job_id: str) -> None:
        active = self._active.pop(job_id)
        active.drop_rest()
        self._unsaved = [held for held in self._unsaved if held[0] is not active]

    # sending

    def _send(self) -> None:
        if time.monotonic() < self._rest_until or self._alone is not None:
            return
        suspected = next(((a, a.suspects[0]) for a in self._active.values() if a.suspects and not a.cancelling), None)
        try:
            if suspected is not None:
                if self.in_flight == 0:
                    active, chunk = suspected
                    self._alone = suspected
                    active.suspects.remove(chunk)
                    self._submit(active, chunk)
                return
            room = AHEAD * self.engine.workers - self.in_flight - len(self._unsaved)
            while room > 0 and (ready := self._next_in_turn()) is not None:
                self._submit(ready, ready.next_chunk())
                room -= 1
        except EngineLostError as error:
            self._wait_for_engine(error)

    def _next_in_turn(self) -> ActiveJob | None:
        ready = [active for active in self._active.values() if active.has_work]
        self._turn += 1
        return ready[self._turn % len(ready)] if ready else None

    def _submit(self, active: ActiveJob, chunk: int) -> None:
        try:
            future = self.engine.submit(run_chunk, active.task(chunk))
        except EngineLostError:
            self._alone = None
            active.give_back(chunk)
            raise
        active.sent[future] = chunk
        future.add_done_callback(lambda done: self._came.put((active, chunk, done)))

    def _wait_for_engine(self, error: BaseException) -> None:
        log.warning("whoever computes cannot be reached, trying again in %g s: %s", BACKOFF, error)
        self.engine.restart()
        self._rest_until = time.monotonic() + BACKOFF

    # what comes back

    def _take(self, timeout: float) -> None:
        self._save_again()
        try:
            item = self._came.get(timeout=timeout)
            while True:
                if item is not None:
                    self._receive(*item)
                item = self._came.get_nowait()
        except queue.Empty:
            pass

    def _receive(self, active: ActiveJob, chunk: int, future: Future[ChunkResult]) -> None:
        active.sent.pop(future, None)
        alone, self._alone = self._alone == (active, chunk), None if self._alone == (active, chunk) else self._alone
        if active.job.id not in self._active:
            return
        try:
            result = future.result()
        except CancelledError:
            if not active.cancelling:  # not called back by us: the engine has lost it
                active.give_back(chunk)
                self._wait_for_engine(EngineLostError("work that was sent is gone"))
        except BaseException as error:
            self._failed(active, chunk, error, alone=alone)
        else:
            self._save(active, chunk, result)

    def _failed(self, active: ActiveJob, chunk: int, error: BaseException, *, alone: bool) -> None:
        if isinstance(error, OSError | TimeoutError):  # a connection, not the chunk
            active.give_back(chunk)
            self._wait_for_engine(error)
            return
        if not self.engine.blames(error):
            reason = f"a fault of the program: {type(error).__name__}: {error}"
            log.error("job %s, chunk %d failed", active.job.id, chunk, exc_info=error)
            self._save(active, chunk, lost_chunk(active.task(chunk), reason))
            return
        deaths = active.deaths[chunk] = active.deaths.get(chunk, 0) + (1 if alone else 0)
        log.warning("a worker died with chunk %d of job %s", chunk, active.job.id)
        if self.engine.repeats_by_itself or deaths >= FATAL_DEATHS:
            reason = "its workers died with it, each time it was tried; it may need more memory than there is"
            self._save(active, chunk, lost_chunk(active.task(chunk), reason))
        else:
            active.suspect(chunk)
        if not self.engine.repeats_by_itself:
            self.engine.restart()

    def _save(self, active: ActiveJob, chunk: int, result: ChunkResult) -> None:
        if result.kernel != KERNEL_HASH:
            versions = f"its kernel is {result.kernel}, this server's {KERNEL_HASH}"
            self._pause(active, f"a worker runs another version of the program: {versions}; update it and resume")
            return
        try:
            active.files.write(chunk, result)
            rate = active.note(result.cases)
            counted = self.store.count_chunk(
                active.job.id, self.owner, chunk, cases=result.cases, failures=result.failures,
                seconds=result.seconds, processor=result.processor, rate=rate,
            )  # fmt: skip
        except DiskFullError as error:
            self._unsaved.append((active, chunk, result))
            self._pause(active, str(error))
        except UnavailableError as error:
            log.warning("chunk %d of job %s cannot be counted yet: %s", chunk, active.job.id, error)
            self._unsaved.append((active, chunk, result))
            self._rest_until = time.monotonic() + BACKOFF
        else:
            if counted and active.watch is not None:
                active.watch.add(chunk * active.job.chunk_size, result.table)
                self._check_watch(active)

    def _save_again(self) -> None:
        if self._unsaved and time.monotonic() >= self._rest_until:
            waiting, self._unsaved = self._unsaved, []
            for active, chunk, result in waiting:
                if active.job.id in self._active:
                    self._save(active, chunk, result)

    def _check_watch(self, active: ActiveJob) -> None:
        if active.watch is not None and active.watch.stop is not None:
            active.drop_rest()

    def _pause(self, active: ActiveJob, reason: str) -> None:
        """Stop a job until someone resumes it; what is in flight is computed again then."""
        log.error("job %s pauses: %s", active.job.id, reason)
        self.store.let_go(active.job.id, self.owner, state="paused", reason=reason)
        self._drop(active.job.id)


def _outcome(failed: int, cases: int) -> str:
    return "succeeded" if failed == 0 else ("failed" if failed == cases else "partial")
