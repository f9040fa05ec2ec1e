"""Owns the runs that a designer keeps to compare with: drawn over the present one in plots, path and scene."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from models.problems import DesignError, Problem
from models.run import Run

MOST_KEPT = 4
"""Runs that can be kept; each holds all its samples in memory."""
LONGEST_NAME = 60


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A run that stays while the design goes on changing; `place` (0 to 3) chooses its colour."""

    id: str
    name: str
    place: int
    run: Run

    def document(self) -> dict[str, Any]:
        """Return what the page shows of it in a list."""
        run = self.run
        return {
            "id": self.id, "name": self.name, "place": self.place, "model": run.model, "end": float(run.times[-1]),
            "design": run.design.name,
        }  # fmt: skip


class KeptRuns:
    """The kept runs of one session, in the order in which they were kept. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._runs: dict[str, KeptRun] = {}

    def __iter__(self) -> Iterator[KeptRun]:
        with self._lock:
            return iter(list(self._runs.values()))

    def keep(self, run: Run, name: str | None = None) -> KeptRun:
        """Keep a run; raises `DesignError` where `MOST_KEPT` are kept already."""
        with self._lock:
            if len(self._runs) >= MOST_KEPT:
                message = f"{len(self._runs)} runs are kept, the most is {MOST_KEPT}"
                raise DesignError([Problem("", message, limit=MOST_KEPT, hint="delete one of them first")])
            number = next(self._numbers)
            place = min(set(range(MOST_KEPT)) - {kept.place for kept in self._runs.values()})
            kept = KeptRun(f"run-{number}", _checked(name or f"Run {number}"), place, run)
            self._runs[kept.id] = kept
            return kept

    def get(self, run_id: str) -> KeptRun | None:
        """Return a kept run, or None where there is none of that id."""
        with self._lock:
            return self._runs.get(run_id)

    def rename(self, run_id: str, name: str) -> bool:
        """Give a kept run another name; False where there is none of that id."""
        checked = _checked(name)
        with self._lock:
            if run_id not in self._runs:
                return False
            self._runs[run_id] = replace(self._runs[run_id], name=checked)
            return True

    def forget(self, run_id: str) -> bool:
        """Keep a run no longer; False where there is none of that id."""
        with self._lock:
            return self._runs.pop(run_id, None) is not None


def _checked(name: str) -> str:
    stripped = " ".join(name.split())
    if not 0 < len(stripped) <= LONGEST_NAME:
        message = f"the name of a kept run has {len(stripped)} characters, from 1 to {LONGEST_NAME} are possible"
        raise DesignError([Problem("/name", message, limit=LONGEST_NAME, hint="choose a short name")])
    return stripped
