"""Owns the watch over a job that stops when enough is known: the metric's values in the order of the cases.

Only the unbroken beginning counts, and it is looked at after fixed numbers of cases, so that the end depends neither on
chunks nor on who was faster.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from server.jobs.case_table import group_of, read_table
from server.jobs.files import JobFiles
from server.jobs.plan import Plan
from server.jobs.spec import MonteCarlo, Stop
from server.jobs.stopping import stop_at
from server.jobs.task import FINE


class Watch:
    """Collects chunks in any order. `stop` is how many cases are enough, once that is known."""

    def __init__(self, request: Stop, cases: int) -> None:
        self._request = request
        self._waiting: dict[int, NDArray[np.float64]] = {}
        self._values: NDArray[np.float64] = np.zeros(0)
        self._cases = cases
        self.stop: int | None = None

    def add(self, first: int, table: bytes) -> None:
        """Add the chunk whose cases begin with `first`; one that is known already changes nothing."""
        if first < len(self._values):
            return
        rows = read_table(table)
        values = np.array(rows.column(self._request.metric).to_numpy(zero_copy_only=False), dtype=np.float64)
        values[[status not in FINE for status in rows.column("status").to_pylist()]] = np.nan  # as in the summary
        self._waiting[first] = values
        while self.stop is None and len(self._values) in self._waiting:
            known = len(self._values)
            self._values = np.concatenate([self._values, self._waiting.pop(known)])
            self.stop = stop_at(self._values, self._request, after=known)

    @property
    def words(self) -> str:
        """Why the job stopped."""
        r = self._request
        return (
            f"stopped after {self.stop} of {self._cases} cases: the {r.statistic} of {r.metric} is known within "
            f"{r.width:g} at {100.0 * r.confidence:g} % confidence"
        )


def watch_of(plan: Plan) -> Watch | None:
    """Return the watch that a plan asks for, if it does."""
    spec = plan.spec
    return Watch(spec.stop, plan.count) if isinstance(spec, MonteCarlo) and spec.stop is not None else None


def failures_before(files: JobFiles, case: int, chunk_size: int) -> dict[str, tuple[int, int]]:
    """Return the failures among the cases before a case by the group of their reason: how many, and the first."""
    groups: dict[str, tuple[int, int]] = {}
    for chunk in range(-(-case // chunk_size)):
        table = read_table(files.path(chunk).read_bytes()).slice(0, case - chunk * chunk_size)
        for row in table.select(["case", "status", "reason"]).to_pylist():
            if row["status"] not in FINE:
                group = group_of(row["status"], row["reason"])
                count, first = groups.get(group, (0, row["case"]))
                groups[group] = (count + 1, first)
    return groups
