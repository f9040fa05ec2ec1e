"""Owns why the jobs of this process get nowhere for a while: told in their records, and taken back once they go on."""

from __future__ import annotations

import logging

from server.store.errors import UnavailableError
from server.store.jobs import JobStore

log = logging.getLogger(__name__)
NO_WORKERS = "waiting for workers: {why}; it goes on by itself once there are some"
NOT_COUNTED = "what is computed cannot be counted: {why}; it goes on by itself once it can"


class Waiting:
    """Tells what jobs of one owner wait for; the database keeps it for all to see, but for its own failures.

    A reason that cannot be kept now is no reason to stop: nothing here raises.
    """

    def __init__(self, store: JobStore, owner: str) -> None:
        self._store, self._owner = store, owner
        self._told = False
        self.for_database: str | None = None
        """Why nothing can be counted; it is told from memory, since the database can take no words either."""

    def for_workers(self, why: object) -> None:
        """Note that nobody computes, also for jobs that have come since it was first noted."""
        self._told = True
        self._explain(NO_WORKERS.format(why=why))

    def database_fails(self, why: object) -> None:
        """Note that the database cannot be written."""
        self.for_database = NOT_COUNTED.format(why=why)

    def database_works(self) -> None:
        """Take that back."""
        self.for_database = None

    def workers_work(self) -> None:
        """Take back that nobody computes."""
        if self._told and self._explain(None):
            self._told = False

    def _explain(self, reason: str | None) -> bool:
        try:
            self._store.explain(self._owner, reason)
        except UnavailableError as error:
            log.warning("what jobs wait for cannot be told now: %s", error)
            return False
        return True
