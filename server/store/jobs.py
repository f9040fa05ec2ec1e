"""Owns the keeping of jobs: submitting, claiming, counting chunks, cancelling; every change is one transaction.

A job belongs to the process that holds its lease. A lease that has run out may be taken by another process, so a job
whose server was killed goes on elsewhere or after a restart.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

from sqlalchemy import Connection, and_, case, delete, func, insert, or_, select, update
from sqlalchemy.exc import IntegrityError

from models.problems import echo
from server.store.database import Database, hold_word
from server.store.errors import NotFoundError
from server.store.job_records import (
    ACTIVE,
    LONGEST_REASON,
    OVER,
    STATES,
    Failure,
    Job,
    JobStateError,
    KeyReusedError,
    NewJob,
)
from server.store.job_tables import job_chunks, job_failures, jobs

MOST_GROUPS = 50
"""Most groups of failures that a record shows."""
COLUMNS = [jobs.c[field.name] for field in fields(Job)]
LIGHT = [column for column in COLUMNS if column.name != "spec"]
"""All but the document, which is large."""


class JobStore:
    """The jobs in a database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, new: NewJob, *, reuse: bool = True, admit: Callable[[int], None] | None = None) -> tuple[Job, bool]:
        """Keep a new job; return it, and whether it is new.

        With the key of an earlier request that one's job is returned, and with `reuse` an equal job that is not over
        or has succeeded. Of a job that is new `admit` is told the number of cases before it is kept, and may raise.

        Raises
        ------
        KeyReusedError
            Where the key came before with another request.

        """
        with self._database.read() as connection:
            known = _known(connection, new, reuse=reuse)
        if known is not None:
            return known, False  # so no other writer need wait
        chunks = -(-new.cases // new.chunk_size)
        row = {field.name: getattr(new, field.name) for field in fields(NewJob)}
        row |= {"state": "queued", "chunks": chunks, "created": time.time(), "sequence": 1, "lease_until": 0.0}
        row |= dict.fromkeys(("done", "failed", "chunks_done"), 0) | {"cancel_requested": False, "processors": ""}
        try:
            with self._database.write() as connection:
                hold_word(connection, new.checksum)  # of equal requests at once the second finds the first one's job
                known = _known(connection, new, reuse=reuse)
                if known is not None:
                    return known, False
                if admit is not None:
                    admit(new.cases)
                connection.execute(insert(jobs).values(row))
                return _get(connection, new.id), True
        except IntegrityError:  # another request with the same key was faster
            with self._database.read() as connection:
                known = _known(connection, new, reuse=False)
            if known is None:
                raise
            return known, False

    def get(self, job_id: str) -> Job:
        """Return a job; raises `NotFoundError`."""
        with self._database.read() as connection:
            return _get(connection, job_id)

    def sequences(self, job_ids: Sequence[str]) -> dict[str, int]:
        """Return how often each of some jobs has changed: what a listener compares with what it has seen."""
        with self._database.read() as connection:
            rows = connection.execute(select(jobs.c.id, jobs.c.sequence).where(jobs.c.id.in_(job_ids)))
            return {row.id: row.sequence for row in rows}

    def page(
        self, *, states: Sequence[str] = (), kinds: Sequence[str] = (), search: str | None = None,
        before: tuple[float, str] | None = None, limit: int = 50,
    ) -> list[Job]:  # fmt: skip
        """Return jobs without their `spec`, the newest first; `before` is creation time and id of the last one seen."""
        query = select(*LIGHT).order_by(jobs.c.created.desc(), jobs.c.id.desc()).limit(limit)
        if states:
            query = query.where(jobs.c.state.in_(states))
        if kinds:
            query = query.where(jobs.c.kind.in_(kinds))
        if search:
            # both are lowered by the database: in the letters that it knows, it and Python need not agree
            literally = re.sub("([/%_])", r"/\1", search)
            query = query.where(func.lower(jobs.c.name).contains(func.lower(literally), escape="/"))
        if before is not None:
            created, job_id = before
            older = and_(jobs.c.created == created, jobs.c.id < job_id)
            query = query.where(or_(jobs.c.created < created, older))
        with self._database.read() as connection:
            return [Job(spec="", **row._mapping) for row in connection.execute(query)]

    def unfinished(self, principal: str) -> list[Job]:
        """Return the jobs of a principal that are not over, without their `spec`."""
        query = select(*LIGHT).where(and_(jobs.c.principal == principal, jobs.c.state.not_in(OVER)))
        with self._database.read() as connection:
            return [Job(spec="", **row._mapping) for row in connection.execute(query)]

    def count_unfinished(self) -> int:
        """Return how many jobs are not over, whoever's they are."""
        counts = self.counts()
        return sum(counts[state] for state in STATES if state not in OVER)

    def counts(self) -> dict[str, int]:
        """Return how many jobs there are in each state."""
        with self._database.read() as connection:
            rows = connection.execute(select(jobs.c.state, func.count().label("n")).group_by(jobs.c.state))
            found = {row.state: row.n for row in rows}
        return {state: found.get(state, 0) for state in STATES}

    def failures(self, job_ids: Sequence[str]) -> dict[str, list[Failure]]:
        """Return the failures of each of some jobs by reason, the most frequent first."""
        c = job_failures.c
        query = select(c.job_id, c.reason, c.cases, c.first_case).where(c.job_id.in_(job_ids))
        found: dict[str, list[Failure]] = {job_id: [] for job_id in job_ids}
        with self._database.read() as connection:
            for job_id, reason, count, case in connection.execute(query.order_by(c.cases.desc(), c.first_case)):
                if len(found[job_id]) < MOST_GROUPS:
                    found[job_id].append(Failure(reason, count, case))
        return found

    def written(self, job_id: str) -> set[int]:
        """Return the chunks that count."""
        with self._database.read() as connection:
            return set(connection.execute(select(job_chunks.c.chunk).where(job_chunks.c.job_id == job_id)).scalars())

    def claim(self, owner: str, lease: float, *, most: int) -> list[Job]:
        """Take up to `most` jobs that nobody works on, the oldest first; a lease lasts `lease` seconds."""
        now = time.time()
        lapsed = and_(jobs.c.lease_until < now, jobs.c.owner != owner)  # one's own is never taken again
        free = and_(jobs.c.state.in_(ACTIVE), or_(jobs.c.owner.is_(None), lapsed))
        with self._database.read() as connection:
            if connection.execute(select(jobs.c.id).where(free).limit(1)).first() is None:
                return []  # nothing to do, so no other writer need wait
        taken = []
        with self._database.write() as connection:
            found = list(
                connection.execute(select(jobs.c.id).where(free).order_by(jobs.c.created).limit(most)).scalars()
            )
            for job_id in found:
                mine = update(jobs).where(and_(jobs.c.id == job_id, free))
                done = connection.execute(mine.values(owner=owner, lease_until=now + lease, reason=None))
                if done.rowcount == 1:
                    taken.append(_get(connection, job_id))
        return taken

    def renew(self, owner: str, lease: float) -> dict[str, bool]:
        """Prolong all leases of an owner; return the ids that it still holds, and whether each is to be cancelled."""
        with self._database.write() as connection:
            connection.execute(update(jobs).where(jobs.c.owner == owner).values(lease_until=time.time() + lease))
            rows = connection.execute(select(jobs.c.id, jobs.c.cancel_requested).where(jobs.c.owner == owner))
            return {row.id: row.cancel_requested for row in rows}

    def count_chunk(
        self, job_id: str, owner: str, chunk: int, *, cases: int, failures: Mapping[str, tuple[int, int]],
        seconds: float, processor: str, rate: float | None,
    ) -> bool:  # fmt: skip
        """Count a chunk whose file is written; return False where it counted before or the job is another's now."""
        failed = sum(count for count, _ in failures.values())
        row = {"job_id": job_id, "chunk": chunk, "cases": cases, "failed": failed}
        try:
            with self._database.write() as connection:
                own = and_(jobs.c.id == job_id, jobs.c.owner == owner)
                known = connection.execute(select(jobs.c.processors).where(own).with_for_update()).scalar()
                if known is None:
                    return False
                connection.execute(insert(job_chunks).values(row | {"seconds": seconds, "written": time.time()}))
                for reason, (count, first) in failures.items():
                    _add_failures(connection, job_id, reason, count=count, first=first)
                lines = sorted({*known.splitlines(), processor})
                counted = {
                    "done": jobs.c.done + cases, "failed": jobs.c.failed + failed, "rate": rate,
                    "chunks_done": jobs.c.chunks_done + 1, "processors": "\n".join(lines),
                    "sequence": jobs.c.sequence + 1,
                }  # fmt: skip
                return connection.execute(update(jobs).where(own).values(counted)).rowcount == 1
        except IntegrityError:
            return False

    def explain(self, owner: str, reason: str | None) -> None:
        """Note why all jobs of an owner get nowhere, None once they do."""
        other = and_(jobs.c.owner == owner, jobs.c.reason.is_distinct_from(reason))
        with self._database.write() as connection:
            connection.execute(update(jobs).where(other).values(reason=reason, sequence=jobs.c.sequence + 1))

    def begin(self, job_id: str, owner: str, **stamp: Any) -> None:
        """Note that a queued job that an owner holds is under way; `stamp` are columns to set with it."""
        queued = and_(jobs.c.id == job_id, jobs.c.owner == owner, jobs.c.state == "queued")
        running = {"state": "running", "started": func.coalesce(jobs.c.started, time.time())}
        with self._database.write() as connection:
            changed = stamp | running | {"sequence": jobs.c.sequence + 1}
            connection.execute(update(jobs).where(queued).values(changed))

    def settle(
        self, job_id: str, owner: str, *, failures: Mapping[str, tuple[int, int]] | None = None, **values: Any
    ) -> None:
        """Let go of a job that is over; `failures` replaces the groups where fewer cases count than were computed."""
        with self._database.write() as connection:
            if not _let_go(connection, job_id, owner, finished=time.time(), **values) or failures is None:
                return
            connection.execute(delete(job_failures).where(job_failures.c.job_id == job_id))
            for reason, (count, first) in failures.items():
                _add_failures(connection, job_id, reason, count=count, first=first)

    def pause(self, job_id: str, owner: str, reason: str) -> None:
        """Let go of a job until someone resumes it; one that is to be cancelled is over instead."""
        asked = jobs.c.cancel_requested
        with self._database.write() as connection:
            _let_go(
                connection, job_id, owner, reason=reason, state=case((asked, "cancelled"), else_="paused"),
                finished=case((asked, time.time()), else_=None),
            )  # fmt: skip

    def release(self, owner: str) -> None:
        """Give all jobs of an owner back, so that another process may go on at once."""
        with self._database.write() as connection:
            free = {"owner": None, "lease_until": 0.0, "reason": None}
            connection.execute(update(jobs).where(jobs.c.owner == owner).values(free))

    def cancel(self, job_id: str) -> Job:
        """Ask for a job to end; what is done is kept.

        Raises
        ------
        NotFoundError, JobStateError
            Where there is none, or it is over.

        """
        with self._database.write() as connection:
            job = _locked(connection, job_id)
            if job.over:
                raise JobStateError(job.state, f"the job is over: it {_ended(job.state)}")
            idle = job.state == "paused" or (job.state == "queued" and job.owner is None)
            now = {"state": "cancelled", "finished": time.time()} if idle else {"state": "cancelling"}
            _set(connection, job_id, cancel_requested=True, **now)
            return _get(connection, job_id)

    def resume(self, job_id: str) -> Job:
        """Queue a paused job again; raises as `cancel` does."""
        with self._database.write() as connection:
            job = _locked(connection, job_id)
            if job.state != "paused":
                what = f"only a paused job can be resumed; this one is {job.state}"
                raise JobStateError(job.state, f"{what}: retry it to go on" if job.over else what)
            _set(connection, job_id, state="queued", reason=None, owner=None, lease_until=0.0, cancel_requested=False)
            return _get(connection, job_id)

    def retry(self, job_id: str, *, holder: str | None = None, lease: float = 0.0) -> tuple[Job, list[int]]:
        """Queue a job that is over again: chunks with failed cases are computed anew, and those that are missing.

        Return it, and the chunks that no longer count. Nobody takes it before `holder` releases it, or dies.
        """
        with self._database.write() as connection:
            job = _locked(connection, job_id)
            if not job.over:
                raise JobStateError(job.state, f"only a job that is over can be retried; this one is {job.state}")
            if job.failed == 0 and job.state != "cancelled":
                raise JobStateError(job.state, "no case has failed: there is nothing to retry")
            bad = and_(job_chunks.c.job_id == job_id, job_chunks.c.failed > 0)
            dropped = list(connection.execute(select(job_chunks.c.chunk).where(bad)).scalars())
            connection.execute(delete(job_chunks).where(bad))
            left = select(func.count(), func.coalesce(func.sum(job_chunks.c.cases), 0))
            chunks, cases = connection.execute(left.where(job_chunks.c.job_id == job_id)).one()
            connection.execute(delete(job_failures).where(job_failures.c.job_id == job_id))
            _set(
                connection, job_id, state="queued", reason=None, owner=holder, lease_until=time.time() + lease,
                cancel_requested=False, finished=None, stopped_at=None, failed=0, done=int(cases),
                chunks_done=int(chunks),
            )  # fmt: skip
            return _get(connection, job_id), dropped

    def remove(self, job_id: str) -> None:
        """Forget a job that is over; raises as `cancel` does."""
        with self._database.write() as connection:
            job = _locked(connection, job_id)
            if not job.over:
                raise JobStateError(job.state, f"the job is {job.state}: cancel it first")
            for table in (job_failures, job_chunks):
                connection.execute(delete(table).where(table.c.job_id == job_id))
            connection.execute(delete(jobs).where(jobs.c.id == job_id))


def _known(connection: Connection, new: NewJob, *, reuse: bool) -> Job | None:
    """Return the job of an earlier request with the key of this one, or with `reuse` an equal one."""
    if new.idempotency_key is not None:
        same = and_(jobs.c.principal == new.principal, jobs.c.idempotency_key == new.idempotency_key)
        row = connection.execute(select(*COLUMNS).where(same)).first()
        if row is not None:
            if row.request_digest != new.request_digest:
                raise KeyReusedError(f"the key {new.idempotency_key!r} came before with another request")
            return Job(*row)
    if not reuse:
        return None
    equal = and_(jobs.c.checksum == new.checksum, jobs.c.state.in_((*ACTIVE[:2], "paused", "succeeded")))
    row = connection.execute(select(*COLUMNS).where(equal).order_by(jobs.c.created.desc())).first()
    return None if row is None else Job(*row)


def _get(connection: Connection, job_id: str) -> Job:
    row = connection.execute(select(*COLUMNS).where(jobs.c.id == job_id)).first()
    if row is None:
        raise NotFoundError(f"there is no job {echo(job_id)}")
    return Job(*row)


def _locked(connection: Connection, job_id: str) -> Job:
    """Return a job, held against other writers until the transaction ends (PostgreSQL; SQLite has one writer)."""
    row = connection.execute(select(*COLUMNS).where(jobs.c.id == job_id).with_for_update()).first()
    if row is None:
        raise NotFoundError(f"there is no job {echo(job_id)}")
    return Job(*row)


def _set(connection: Connection, job_id: str, **values: Any) -> None:
    connection.execute(update(jobs).where(jobs.c.id == job_id).values(values | {"sequence": jobs.c.sequence + 1}))


def _let_go(connection: Connection, job_id: str, owner: str, **values: Any) -> bool:
    """Set columns of a job that an owner holds, and its lease free; return whether that was so."""
    own = and_(jobs.c.id == job_id, jobs.c.owner == owner)
    free = {"owner": None, "lease_until": 0.0, "rate": None, "sequence": jobs.c.sequence + 1}
    changed = {"reason": None} | values | free
    return connection.execute(update(jobs).where(own).values(changed)).rowcount == 1


def _add_failures(connection: Connection, job_id: str, reason: str, *, count: int, first: int) -> None:
    c, reason = job_failures.c, reason[:LONGEST_REASON]
    same = and_(c.job_id == job_id, c.reason == reason)
    earlier = case((c.first_case < first, c.first_case), else_=first)
    known = update(job_failures).where(same).values(cases=c.cases + count, first_case=earlier)
    if connection.execute(known).rowcount == 0:
        row = {"job_id": job_id, "reason": reason, "cases": count, "first_case": first}
        connection.execute(insert(job_failures).values(row))


def _ended(state: str) -> str:
    return {"cancelled": "was cancelled", "failed": "failed"}.get(state, f"ended {state}")
