"""Owns the jobs of this process: claims them, sends their chunks, keeps what comes back, goes on after any death.

One thread does all of it. A chunk counts once its file is written whole and the database says so; until then it is sent
again, so whatever dies costs at most the chunks in flight.
"""

from __future__ import annotations

import json
import logging
import queue
import threading
import time
import uuid
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from pathlib import Path
from typing import Any

from models.kernel import KERNEL_HASH
from models.limits import DEFAULT_LIMITS, Limits
from models.problems import DesignError
from server.jobs.active import ActiveJob
from server.jobs.chunk import lost_chunk, run_chunk
from server.jobs.engines import Engine, EngineLostError
from server.jobs.files import DiskFullError, JobFiles
from server.jobs.heartbeat import Heartbeat
from server.jobs.submission import restamped
from server.jobs.task import ChunkResult
from server.jobs.tasks import plan_of
from server.jobs.waiting import Waiting
from server.jobs.watch import failures_before
from server.store.errors import UnavailableError
from server.store.job_records import Job
from server.store.jobs import JobStore

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
LONGEST_TAKE = 1.0
"""After so long of taking results in, the thread looks around again, s."""
OTHER_VERSION = (
    "its first chunks were computed by version {version} with the kernel {kernel}, the rest would be by another: "
    "cancel it, which keeps what is done, and submit it again"
)
OTHER_WORKER = (
    "a worker runs another version of the program: its kernel is {theirs}, this server's {ours}; update it and resume"
)
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
        self._looked = self._rest_until = 0.0
        self._wait = 5.0
        self._pulse = Heartbeat(store, self.owner, lease)
        self._waiting = Waiting(store, self.owner)
        self.cases_done = self.cases_failed = 0  # counted by this process; the latter are among the former
        self._turn = 0
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin to work."""
        if self._thread is None or not self._thread.is_alive():
            self._stopping.clear()
            self._pulse.start()
            self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)
            self._thread.start()

    def wake(self) -> None:
        """Look for new jobs and requests at once."""
        self._came.put(None)

    def stop(self, *, wait: float = 5.0) -> None:
        """End: chunks in flight get `wait` seconds to finish; jobs stay as they are, free for whoever comes next."""
        self._wait = wait
        self._stopping.set()
        self.wake()
        if self._thread is not None:
            self._thread.join(wait + 10.0)
            self._pulse.stop()
        self.engine.stop()

    def files(self, job_id: str) -> JobFiles:
        """Return the files of a job."""
        return JobFiles(self.root, job_id, reserve=self._reserve)

    @property
    def in_flight(self) -> int:
        """How many chunks are with the engine."""
        return sum(len(active.sent) for active in list(self._active.values()))

    def waits_for(self, job_id: str) -> str | None:
        """Return why a job that this process works on gets nowhere, where its record cannot be told."""
        return self._waiting.for_database if job_id in self._active else None

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._look_around()
                self._send()
                self._take(TICK)
                if not self._unsaved:
                    self._waiting.database_works()
            except UnavailableError as error:
                log.warning("the database cannot be used now: %s", error)
                self._waiting.database_fails(error)
                self._stopping.wait(BACKOFF)
            except Exception:
                log.exception("the job thread stumbled; it goes on")
                self._stopping.wait(BACKOFF)
        try:
            self._hand_over()
        finally:
            self._active.clear()
            try:
                self.store.release(self.owner)
            except UnavailableError as error:
                log.warning("jobs could not be given back; their lease runs out by itself: %s", error)

    def _hand_over(self) -> None:
        """Keep what comes in within a few seconds."""
        for active in self._active.values():
            active.drop_rest()
        until = time.monotonic() + self._wait
        while self.in_flight and time.monotonic() < until:
            self._take(TICK)
        for active in list(self._active.values()):
            job = self.store.get(active.job.id)
            if job.chunks_done == job.chunks:  # what came in was the last of it
                self._guarded(active, self._end)

    # what others want of us

    def _look_around(self) -> None:
        now = time.monotonic()
        if now - self._looked >= min(1.0, self._pulse.period):
            self._looked = now
            held = self._pulse.renew()
            for job_id in [job_id for job_id in self._active if job_id not in held]:
                self._drop(job_id)  # paused, or taken by another process
            for job_id, cancelled in held.items():
                if job_id not in self._active:  # the database failed as it was to begin
                    self._begin(self.store.get(job_id))
                elif cancelled:
                    self._active[job_id].drop_rest()
            if self._active and self.engine.known_workers == 0:
                self._waiting.for_workers("there are none")
        if len(self._active) < MOST_ACTIVE:
            for job in self.store.claim(self.owner, self._lease, most=MOST_ACTIVE - len(self._active)):
                self._begin(job)
        for active in list(self._active.values()):
            if active.finished and not any(held is active for held, _, _ in self._unsaved):
                self._guarded(active, self._end)

    def _guarded(self, active: ActiveJob, work: Callable[[ActiveJob], None]) -> None:
        """Do something for one job; what is wrong with it pauses it and stops no other."""
        try:
            work(active)
        except UnavailableError:
            raise
        except Exception as error:
            log.exception("job %s cannot go on", active.job.id)
            self._pause(active, f"it cannot go on: {type(error).__name__}: {error}; put that right and resume it")

    def _begin(self, job: Job) -> None:
        written = self.store.written(job.id)
        try:
            plan = plan_of(job.spec)
            active = ActiveJob(job, plan, self.files(job.id), written=written, limits=self._limits)
            active.files.sweep()
            stamp = restamped(job, plan)
            active.refill_watch()
        except DesignError as error:  # written by another version of the program
            self._settle(job.id, state="failed", reason=f"its document cannot be read any more: {error}")
        except Exception as error:
            log.exception("job %s cannot begin", job.id)
            reason = f"a fault of the program as it began: {type(error).__name__}: {error}"
            self._settle(job.id, state="failed", reason=reason)
        else:
            if stamp is not None and written:
                begun = json.loads(job.about)["engine"]
                self._active[job.id] = active
                self._pause(active, OTHER_VERSION.format(**begun))
                return
            self.store.begin(job.id, self.owner, **(stamp or {}))
            self._active[job.id] = active
            active.heed_watch()

    def _end(self, active: ActiveJob) -> None:
        job = self.store.get(active.job.id)
        if active.watch is not None and active.watch.stop is not None:
            stop = active.watch.stop
            failures = failures_before(active.files, stop, job.chunk_size)
            failed = sum(count for count, _ in failures.values())
            self._settle(
                job.id, state=_outcome(failed, stop), reason=active.watch.words, stopped_at=stop, done=stop,
                failed=failed, failures=failures,
            )  # fmt: skip
        elif job.cancel_requested:
            self._settle(job.id, state="cancelled")
        elif job.chunks_done < job.chunks:  # a chunk was lost on the way: what is missing is sent again
            log.error("job %s lacks %d chunks; they are sent again", job.id, job.chunks - job.chunks_done)
            self._drop(job.id)
            self._begin(job)
        else:
            self._settle(job.id, state=_outcome(job.failed, job.cases))

    def _settle(self, job_id: str, **values: Any) -> None:
        self.store.settle(job_id, self.owner, **values)
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
                    self._submit_alone(*suspected)
                return
            room = AHEAD * self.engine.workers - self.in_flight - len(self._unsaved)
            while room > 0 and (ready := self._next_in_turn()) is not None:
                chunk = ready.next_chunk()
                try:
                    self._submit(ready, chunk)
                except BaseException:
                    ready.give_back(chunk)
                    raise
                room -= 1
        except EngineLostError as error:
            self._wait_for_engine(error)

    def _next_in_turn(self) -> ActiveJob | None:
        ready = [active for active in self._active.values() if active.has_work]
        self._turn += 1
        return ready[self._turn % len(ready)] if ready else None

    def _submit_alone(self, active: ActiveJob, chunk: int) -> None:
        active.suspects.remove(chunk)
        self._alone = (active, chunk)
        try:
            self._submit(active, chunk)
        finally:
            if chunk not in active.sent.values():
                self._alone = None
                active.suspect(chunk)

    def _submit(self, active: ActiveJob, chunk: int) -> None:
        try:
            task = active.task(chunk)
        except Exception as error:
            log.exception("job %s, chunk %d cannot be laid out", active.job.id, chunk)
            self._pause(active, f"its cases cannot be laid out: {type(error).__name__}: {error}")
            return
        future = self.engine.submit(run_chunk, task)
        active.sent[future] = chunk
        future.add_done_callback(lambda done: self._came.put((active, chunk, done)))

    def _wait_for_engine(self, error: BaseException) -> None:
        log.warning("whoever computes cannot be reached, trying again in %g s: %s", BACKOFF, error)
        self.engine.restart()
        self._rest_until = time.monotonic() + BACKOFF
        self._waiting.for_workers(error)

    # what comes back

    def _take(self, timeout: float) -> None:
        self._save_again()
        until = time.monotonic() + LONGEST_TAKE
        try:
            item = self._came.get(timeout=timeout)
            while True:
                if item is not None:
                    self._receive(*item)
                if time.monotonic() > until:
                    return
                item = self._came.get_nowait()
        except queue.Empty:
            pass

    def _receive(self, active: ActiveJob, chunk: int, future: Future[ChunkResult]) -> None:
        active.sent.pop(future, None)
        alone = self._alone == (active, chunk)
        if alone:
            self._alone = None
        if self._active.get(active.job.id) is not active:
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
        if self.engine.lost(error):  # the connection, not the chunk
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
        """Write and count a chunk; until that is done it is held, and sent again where the job goes to another."""
        self._waiting.workers_work()
        if result.kernel != KERNEL_HASH:
            self._pause(active, OTHER_WORKER.format(theirs=result.kernel, ours=KERNEL_HASH))
            return
        try:
            if not self._pulse.holds(active.job.id):
                self._drop(active.job.id)
                return
            active.files.write(chunk, result)
            counted = self.store.count_chunk(
                active.job.id, self.owner, chunk, cases=result.cases, failures=result.failures,
                seconds=result.seconds, processor=result.processor, rate=active.note(result.cases),
            )  # fmt: skip
        except UnavailableError as error:
            log.warning("chunk %d of job %s cannot be counted yet: %s", chunk, active.job.id, error)
            self._waiting.database_fails(error)
            self._unsaved.append((active, chunk, result))
            self._rest_until = time.monotonic() + BACKOFF
        except DiskFullError as error:
            self._unsaved.append((active, chunk, result))
            self._pause(active, str(error))
        except Exception as error:
            log.exception("chunk %d of job %s cannot be kept", chunk, active.job.id)
            self._unsaved.append((active, chunk, result))
            self._pause(active, f"a result cannot be kept: {type(error).__name__}: {error}; put that right and resume")
        else:
            if counted:
                self.cases_done += result.cases
                self.cases_failed += sum(count for count, _ in result.failures.values())
            if active.watch is not None:
                active.watch.add(chunk * active.job.chunk_size, result.table)
                active.heed_watch()

    def _save_again(self) -> None:
        for _ in range(len(self._unsaved)):
            if not self._unsaved or time.monotonic() < self._rest_until:
                return
            active, chunk, result = self._unsaved.pop(0)
            if self._active.get(active.job.id) is active:
                self._save(active, chunk, result)

    def _pause(self, active: ActiveJob, reason: str) -> None:
        """Stop a job until someone resumes it; what is in flight is computed again then."""
        log.error("job %s pauses: %s", active.job.id, reason)
        self.store.pause(active.job.id, self.owner, reason)
        if self._active.get(active.job.id) is active:
            self._drop(active.job.id)


def _outcome(failed: int, cases: int) -> str:
    return "succeeded" if failed == 0 else ("failed" if failed == cases else "partial")
