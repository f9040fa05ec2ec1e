"""Owns what goes to a worker and what comes back: plain data that can be pickled, no connection to anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from models.limits import Limits
from models.variation import Target

FINE = ("completed", "surface", "bed")
"""How a case may end well; anything else is a failure with a reason."""
CRASHED = "crashed"
REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class ColumnInfo:
    """A column of the case table: `role` is parameter or metric; one that is not `numeric` holds JSON."""

    name: str
    unit: str
    meaning: str
    role: str
    numeric: bool = True


@dataclass(frozen=True, slots=True)
class ChunkTask:
    """One chunk of a job: cases `first` to `first + len(rows) - 1`.

    `design` and `metrics` are JSON; `targets` says for each parameter which fields its value sets, `rows` holds the
    values. `keep` tells which cases keep their trajectories: all, none or their numbers.
    """

    job: str
    chunk: int
    first: int
    design: str
    targets: tuple[tuple[Target, ...], ...]
    rows: tuple[tuple[Any, ...], ...]
    metrics: str
    columns: tuple[ColumnInfo, ...]
    keep: str | frozenset[int]
    limits: Limits

    def keeps(self, case: int) -> bool:
        """Whether a case keeps its trajectory."""
        return self.keep == "all" if isinstance(self.keep, str) else case in self.keep


@dataclass(frozen=True, slots=True)
class ChunkResult:
    """What a chunk gave: its case table (Parquet), kept trajectories (NetCDF) or None, and its failures by reason.

    Numbers are the same to the last bit where `kernel` (a hash of its sources) and `processor` are. `failures` holds
    for each reason how many cases failed, and the first of them.
    """

    table: bytes
    trajectories: bytes | None
    cases: int
    seconds: float
    kernel: str
    processor: str
    failures: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    @property
    def failed(self) -> int:
        """How many cases failed."""
        return sum(count for count, _ in self.failures.values())
