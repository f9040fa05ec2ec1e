"""Owns what is known of a job: as it is submitted, as it is now, its failures, and what cannot be asked of it."""

from __future__ import annotations

import time
from dataclasses import dataclass

from server.store.errors import StoreError

ACTIVE = ("queued", "running", "cancelling")
OVER = ("cancelled", "succeeded", "partial", "failed")
STATES = ("queued", "running", "paused", "cancelling", *OVER)
LONGEST_REASON = 400
"""Most letters that are kept of why a case failed."""


@dataclass(frozen=True, slots=True)
class NewJob:
    """What is kept of a job when it is submitted; `spec` and `about` are JSON."""

    id: str
    kind: str
    name: str
    spec: str
    about: str
    checksum: str
    principal: str
    idempotency_key: str | None
    request_digest: str
    cases: int
    chunk_size: int


@dataclass(frozen=True, slots=True)
class Job(NewJob):
    """A job as it is now: what was kept of it then, and what has become of it; the fields are those of the table."""

    state: str
    reason: str | None
    chunks: int
    done: int
    failed: int
    chunks_done: int
    rate: float | None
    processors: str
    stopped_at: int | None
    created: float
    started: float | None
    finished: float | None
    cancel_requested: bool
    owner: str | None
    lease_until: float
    sequence: int

    @property
    def over(self) -> bool:
        """Whether nothing more will happen to it by itself."""
        return self.state in OVER

    @property
    def counted(self) -> int:
        """How many cases count: all, or those up to where enough was known."""
        return self.cases if self.stopped_at is None else self.stopped_at

    @property
    def rate_now(self) -> float | None:
        """Cases a second, lately; None where none is computed, as while it waits for another process to take it."""
        return self.rate if self.state == "running" and self.lease_until > time.time() else None

    @property
    def seconds_left(self) -> float | None:
        """Seconds until its end at this rate; None where that is not known."""
        rate = self.rate_now
        return (self.counted - self.done) / rate if rate else None


@dataclass(frozen=True, slots=True)
class Failure:
    """Failures of one kind: why, how many, and the first case."""

    reason: str
    count: int
    case: int


class JobStateError(StoreError):
    """What was asked is not possible in the job's state."""

    def __init__(self, state: str, message: str) -> None:
        self.state = state
        super().__init__(message)


class KeyReusedError(StoreError):
    """An idempotency key came again with another request."""
