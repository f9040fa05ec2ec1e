"""Owns the proof that a process lives: its leases are prolonged from a thread of its own, whatever else it does."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Mapping

from server.store.errors import UnavailableError
from server.store.jobs import JobStore

log = logging.getLogger(__name__)


class Heartbeat:
    """Renews the leases of one owner; `held` tells which jobs it has, as of the last time, and which are to end."""

    def __init__(self, store: JobStore, owner: str, lease: float) -> None:
        self.held: Mapping[str, bool] = {}
        self._store, self._owner, self._lease = store, owner, lease
        self._at = -lease
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def period(self) -> float:
        """How often leases are renewed, s: often enough that two failures cost none."""
        return self._lease / 3.0

    def start(self) -> None:
        """Begin."""
        self._stopping.clear()
        self._thread = threading.Thread(target=self._run, name="job-heartbeat", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End; leases run out unless they are given back."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join(self._lease)

    def renew(self) -> Mapping[str, bool]:
        """Renew now and return what is held; raises `UnavailableError`."""
        with self._lock:
            began = time.monotonic()
            self.held = self._store.renew(self._owner, self._lease)
            self._at = began
            return self.held

    def holds(self, job_id: str) -> bool:
        """Whether a job is surely ours for a while; asks where the last renewal does not say so, or is long ago."""
        if job_id not in self.held or time.monotonic() - self._at > self.period:
            self.renew()
        return job_id in self.held

    def _run(self) -> None:
        while not self._stopping.wait(self.period):
            try:
                self.renew()
            except UnavailableError as error:
                log.warning("leases cannot be renewed now: %s", error)
            except Exception:
                log.exception("leases could not be renewed; the next try follows")
