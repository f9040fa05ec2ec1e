"""Owns the runs that a designer keeps to compare with: drawn over the present one in plots, path and scene.

A session's file holds what they are computed from, not their samples: the kernel gives the same numbers again.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from orjson import Fragment
from pydantic_core import to_json

from models.problems import DesignError, Problem
from models.run import Run

MOST_KEPT = 4
"""Runs that can be kept; each holds all its samples in memory."""
LONGEST_NAME = 60
OTHERWISE = "Computed anew by another version of the program or within other limits: it may differ from what was kept."


@dataclass(frozen=True, slots=True)
class Keepsake:
    """What outlasts a run's samples: what the page lists of it, the kernel that made it, and its design.

    `content` is that design as JSON, written once and not at each save; perhaps one that this version of the program
    cannot read.
    """

    model: str
    end: float
    design_name: str
    kernel: str
    content: bytes


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A run that stays while the design goes on changing; `place` (0 to 3) chooses its colour.

    After a restart `run` is None until it is computed anew; `problem` says why that failed, where it did.
    """

    id: str
    name: str
    place: int
    keepsake: Keepsake
    run: Run | None
    problem: str | None = None

    @property
    def state(self) -> str:
        """Whether its samples are `ready`, still `computing`, or `failed` to be computed anew."""
        if self.run is not None:
            return "ready"
        return "computing" if self.problem is None else "failed"

    @property
    def note(self) -> str | None:
        """What there is to say of a run that was computed anew; None where it is what was kept."""
        kept, run = self.keepsake, self.run
        if run is not None and (run.kernel, float(run.times[-1])) != (kept.kernel, kept.end):
            return OTHERWISE
        return self.problem

    def document(self) -> dict[str, Any]:
        """Return what the page shows of it in a list."""
        kept = self.keepsake
        return {
            "id": self.id, "name": self.name, "place": self.place, "model": kept.model, "end": kept.end,
            "design": kept.design_name, "state": self.state, "note": self.note,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class SavedRuns:
    """What a session's file holds of kept runs; `numbered` counts all there ever were, so that no id comes back."""

    numbered: int = 0
    runs: tuple[KeptRun, ...] = ()


NO_RUNS = SavedRuns()


class KeptRuns:
    """The kept runs of one session, in the order in which they were kept. Safe to use from several threads."""

    def __init__(self, saved: SavedRuns = NO_RUNS) -> None:
        self._lock = threading.Lock()
        self._numbered, self._changes = saved.numbered, 0
        self._runs = {kept.id: kept for kept in saved.runs}

    def __iter__(self) -> Iterator[KeptRun]:
        with self._lock:
            return iter(list(self._runs.values()))

    @property
    def changes(self) -> int:
        """How many times a run was kept, renamed or forgotten: after each there is something to save."""
        return self._changes

    def saved(self) -> SavedRuns:
        """Return what the session's file is to hold."""
        with self._lock:
            return SavedRuns(self._numbered, tuple(self._runs.values()))

    def keep(self, run: Run, name: str | None = None) -> KeptRun:
        """Keep a run; raises `DesignError` where `MOST_KEPT` are kept already."""
        with self._lock:
            if len(self._runs) >= MOST_KEPT:
                message = f"{len(self._runs)} runs are kept, the most is {MOST_KEPT}"
                raise DesignError([Problem("", message, limit=MOST_KEPT, hint="delete one of them first")])
            number = self._numbered + 1
            place = min(set(range(MOST_KEPT)) - {kept.place for kept in self._runs.values()})
            kept = KeptRun(f"run-{number}", _checked(name or f"Run {number}"), place, _keepsake(run), run)
            self._numbered = number
            self._put(kept)
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
            self._put(replace(self._runs[run_id], name=checked))
            return True

    def forget(self, run_id: str) -> bool:
        """Keep a run no longer; False where there is none of that id."""
        with self._lock:
            self._changes += 1
            return self._runs.pop(run_id, None) is not None

    def computed(self, run_id: str, run: Run) -> None:
        """Take the run that was computed anew, unless it was forgotten meanwhile."""
        with self._lock:
            if kept := self._runs.get(run_id):
                self._runs[run_id] = replace(kept, run=run)

    def failed(self, run_id: str, problem: str) -> None:
        """Hear why a run cannot be computed anew; what it would be computed from stays."""
        with self._lock:
            if kept := self._runs.get(run_id):
                self._runs[run_id] = replace(kept, problem=problem)

    def _put(self, kept: KeptRun) -> None:
        self._runs[kept.id] = kept
        self._changes += 1


def saved_document(saved: SavedRuns) -> dict[str, Any]:
    """Return kept runs as the session's file holds them, for `orjson`."""
    return {"numbered": saved.numbered, "runs": [_saved_run(kept) for kept in saved.runs]}


def _saved_run(kept: KeptRun) -> dict[str, Any]:
    keepsake = kept.keepsake
    return {
        "id": kept.id, "name": kept.name, "place": kept.place, "model": keepsake.model, "end": keepsake.end,
        "design_name": keepsake.design_name, "kernel": keepsake.kernel,
        "design": Fragment(keepsake.content),
    }  # fmt: skip


def read_saved(document: Any) -> SavedRuns:
    """Return the kept runs of a session's file, all yet to be computed; none where it is older than they are.

    Raises `KeyError`, `TypeError` or `ValueError` for what this program never wrote. A design that cannot be used any
    more is none of that: its run is told as failed.
    """
    if document is None:
        return NO_RUNS
    runs = tuple(_read_run(one) for one in document["runs"])
    if not {kept.place for kept in runs} <= set(range(MOST_KEPT)):
        raise ValueError(f"a kept run has a place beyond {MOST_KEPT - 1}")
    return SavedRuns(int(document["numbered"]), runs[:MOST_KEPT])


def _read_run(one: Any) -> KeptRun:
    content = to_json(one["design"])
    keepsake = Keepsake(str(one["model"]), float(one["end"]), str(one["design_name"]), str(one["kernel"]), content)
    return KeptRun(str(one["id"]), str(one["name"]), int(one["place"]), keepsake, None)


def _keepsake(run: Run) -> Keepsake:
    content = run.design.model_dump_json().encode()
    return Keepsake(run.model, float(run.times[-1]), run.design.name, run.kernel, content)


def _checked(name: str) -> str:
    stripped = " ".join(name.split())
    if not 0 < len(stripped) <= LONGEST_NAME:
        message = f"the name of a kept run has {len(stripped)} characters, from 1 to {LONGEST_NAME} are possible"
        raise DesignError([Problem("/name", message, limit=LONGEST_NAME, hint="choose a short name")])
    return stripped
