"""Owns the work on one chunk of a job: designs are varied, assembled and simulated, their metrics computed.

Runs in a worker. A case's numbers depend on its own values alone, never on the chunk it is in or on who computes it.
"""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from models.assemble import Assembly, assemble
from models.batch import run_batch
from models.design import parse_design
from models.kernel import KERNEL_HASH
from models.metrics import Metric, evaluate, metrics_for
from models.problems import DesignError
from models.run import Run
from models.variation import Target, Varied
from server.jobs.case_table import CaseRow, write_table
from server.jobs.task import CRASHED, FINE, REFUSED, ChunkResult, ChunkTask
from server.jobs.trajectories import write_trajectories
from server.jobs.worker import processor
from server.store.job_records import LONGEST_REASON

log = logging.getLogger(__name__)
AT_ONCE = 128
"""Most cases assembled at once, a multiple of the kernel's lanes; their runs are made one by one, and few are kept."""
PREPARED = 8
"""Jobs whose shared part is remembered: as many as take turns."""


@dataclass(frozen=True)
class _Prepared:
    """What all chunks of a job share."""

    varied: Varied
    metrics: tuple[Metric, ...]


@lru_cache(maxsize=PREPARED)
def _prepare(design: str, targets: tuple[tuple[Target, ...], ...], *, metrics: str) -> _Prepared:
    base = parse_design(json.loads(design))
    return _Prepared(Varied(base, targets), metrics_for(base, json.loads(metrics)))


def run_chunk(task: ChunkTask) -> ChunkResult:
    """Compute a chunk."""
    began = time.perf_counter()
    shared = _prepare(task.design, task.targets, metrics=task.metrics)
    rows: list[CaseRow] = []
    kept: list[tuple[int, Run]] = []
    for begin in range(0, len(task.rows), AT_ONCE):
        part = task.rows[begin : begin + AT_ONCE]
        for row, run in _run_part(task, shared, first=task.first + begin, values=part):
            rows.append(row)
            if run is not None and task.keeps(row.case):
                kept.append((row.case, run))
    return ChunkResult(
        table=write_table(rows, task.columns),
        trajectories=write_trajectories(kept) if kept else None,
        cases=len(rows),
        seconds=time.perf_counter() - began,
        kernel=KERNEL_HASH,
        processor=processor(),
        failures=_failures(rows),
    )


def lost_chunk(task: ChunkTask, reason: str) -> ChunkResult:
    """Return a chunk that nobody could compute: every case failed, for that reason."""
    nothing = [math.nan] * sum(column.role == "metric" for column in task.columns)
    why = reason[:LONGEST_REASON]
    rows = [CaseRow(case, CRASHED, why, row, nothing) for case, row in enumerate(task.rows, task.first)]
    table = write_table(rows, task.columns)
    return ChunkResult(table, None, len(rows), 0.0, KERNEL_HASH, processor(), _failures(rows))


def _run_part(
    task: ChunkTask, shared: _Prepared, *, first: int, values: Sequence[tuple[object, ...]]
) -> Iterator[tuple[CaseRow, Run | None]]:
    prepared = [_assembled(shared, row, task) for row in values]
    ready = [item for item in prepared if isinstance(item, Assembly)]
    runs = _runs(ready, task)
    for case, (row, item) in enumerate(zip(values, prepared, strict=True), first):
        if isinstance(item, Assembly):
            yield _judged(row, next(runs), case=case, shared=shared)
        else:
            yield _refused(row, item, case=case, status=REFUSED, shared=shared), None


def _assembled(shared: _Prepared, row: Sequence[object], task: ChunkTask) -> Assembly | str:
    """Return the case ready for the kernel, or why it cannot be."""
    try:
        return assemble(shared.varied.design(row), task.limits)
    except DesignError as error:
        return "; ".join(str(problem) for problem in error.problems[:3])


def _runs(ready: Sequence[Assembly], task: ChunkTask) -> Iterator[Run | str]:
    """Yield the runs; where they fail together, the rest one by one, so that one case cannot take others with it."""
    flown = 0
    try:
        for run in run_batch(ready, limits=task.limits):
            yield run
            flown += 1
    except Exception:
        log.exception("a part of job %s, chunk %d failed; its cases are run one by one", task.job, task.chunk)
        yield from (_run_alone(assembly, task) for assembly in ready[flown:])


def _run_alone(assembly: Assembly, task: ChunkTask) -> Run | str:
    try:
        return next(iter(run_batch([assembly], limits=task.limits)))
    except Exception as error:
        return f"a fault of the program: {type(error).__name__}: {error}"


def _judged(row: Sequence[object], run: Run | str, *, case: int, shared: _Prepared) -> tuple[CaseRow, Run | None]:
    if isinstance(run, str):
        return _refused(row, run, case=case, status=CRASHED, shared=shared), None
    status = run.status.name
    reason = None if status in FINE else run.message[:LONGEST_REASON]
    try:
        return CaseRow(case, status, reason, row, evaluate(run, shared.metrics)), run
    except Exception as error:
        log.exception("the metrics of case %d failed", case)
        reason = f"its metrics failed: {type(error).__name__}: {error}"
        return _refused(row, reason, case=case, status=CRASHED, shared=shared), run


def _refused(row: Sequence[object], reason: str, *, case: int, status: str, shared: _Prepared) -> CaseRow:
    return CaseRow(case, status, reason[:LONGEST_REASON], row, [math.nan] * len(shared.metrics))


def _failures(rows: Sequence[CaseRow]) -> dict[str, tuple[int, int]]:
    """Count the failed cases by the group of their reason, each with its first case."""
    groups: dict[str, tuple[int, int]] = {}
    for row in rows:
        if row.status not in FINE:
            group = row.group
            count, first = groups.get(group, (0, row.case))
            groups[group] = (count + 1, first)
    return groups
