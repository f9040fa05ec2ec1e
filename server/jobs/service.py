"""Owns jobs as a service: what routes, the command line and tests call. It knows no HTTP."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from models.limits import DEFAULT_LIMITS, Limits
from server.jobs.engines import Engine
from server.jobs.files import JobFiles
from server.jobs.manager import Manager
from server.jobs.record import record_of
from server.jobs.submission import FindDesign, Request, no_store, prepare
from server.store.database import Database
from server.store.job_records import Job
from server.store.jobs import JobStore

MOST_CASES = 10_000_000
HOLD = 15.0
"""How long a job that is retried waits at most for a process that died as it deleted old results, s."""


class Jobs:
    """All jobs of one program: kept in a database, computed by an engine, their results in a folder."""

    def __init__(
        self, database: Database, engine: Engine, folder: Path, *, find_design: FindDesign = no_store,
        limits: Limits = DEFAULT_LIMITS, max_cases: int = MOST_CASES, reserve: int = 0, lease: float = 15.0,
    ) -> None:  # fmt: skip
        self.store = JobStore(database)
        self.manager = Manager(self.store, engine, folder, limits=limits, reserve=reserve, lease=lease)
        self.folder, self.limits, self.max_cases = folder, limits, max_cases
        self._find_design = find_design

    def start(self) -> None:
        """Begin to work on jobs, those that an earlier program left first."""
        self.manager.start()

    def stop(self) -> None:
        """End; jobs under way are kept and go on later."""
        self.manager.stop()

    def submit(
        self, document: Any, request: Request | None = None, *,
        fresh: bool = False, admit: Callable[[int], None] | None = None,
    ) -> tuple[Job, bool]:  # fmt: skip
        """Queue the job that a batch document asks for; return it, and whether it is new.

        An equal job that has succeeded or is under way is returned instead, unless `fresh`. Of a job that is new
        `admit` is told the number of cases before it is kept, and may raise.

        Raises
        ------
        DesignError
            With everything that is wrong; pointers lead into the batch document.
        KeyReusedError
            Where the request's key came before with another request.

        """
        asked = request or Request()
        new = prepare(
            document, asked, find_design=self._find_design, limits=self.limits, max_cases=self.max_cases,
            workers=self.manager.engine.workers,
        )  # fmt: skip
        job, is_new = self.store.add(new, reuse=not fresh, admit=admit)
        self.manager.wake()
        return job, is_new

    def record(self, job: Job) -> dict[str, Any]:
        """Return a job's record, ready for JSON."""
        [record] = self.records([job])
        return record

    def records(self, jobs: Sequence[Job]) -> list[dict[str, Any]]:
        """Return the records of some jobs; however many, the store is asked once."""
        failures = self.store.failures([job.id for job in jobs if job.failed])
        return [record_of(self._explained(job), failures=failures.get(job.id, ())) for job in jobs]

    def _explained(self, job: Job) -> Job:
        """Return a job with what it waits for, where only its manager knows."""
        waits = self.manager.waits_for(job.id)
        return job if waits is None or job.over else replace(job, reason=waits)

    def files(self, job: Job) -> JobFiles:
        """Return the files of a job."""
        return self.manager.files(job.id)

    def cancel(self, job_id: str) -> Job:
        """Ask for a job to end; what is done is kept. Raises `NotFoundError` or `JobStateError`."""
        return self._told(self.store.cancel(job_id))

    def resume(self, job_id: str) -> Job:
        """Queue a paused job again; raises as `cancel` does."""
        return self._told(self.store.resume(job_id))

    def retry(self, job_id: str) -> Job:
        """Compute the chunks with failed cases, and those missing, again; raises as `cancel` does."""
        holder = uuid.uuid4().hex
        job, dropped = self.store.retry(job_id, holder=holder, lease=HOLD)
        renewed = time.monotonic()
        try:
            # before anybody computes them again: a file that counts is never deleted, however slow the disk
            for chunk in dropped:
                self.files(job).forget(chunk)
                if time.monotonic() - renewed > HOLD / 3.0:
                    self.store.renew(holder, HOLD)
                    renewed = time.monotonic()
        finally:
            self.store.release(holder)
        return self._told(job)

    def remove(self, job_id: str) -> None:
        """Delete a job that is over, with its results; raises as `cancel` does."""
        self.store.remove(job_id)
        self.manager.files(job_id).remove()

    def _told(self, job: Job) -> Job:
        self.manager.wake()
        return job
