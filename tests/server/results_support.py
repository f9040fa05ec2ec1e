"""Owns made-up results: chunk files as workers write them, with failures, gaps, odd names and odd values."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from models.presets import load_preset
from models.run import Run
from models.simulate import simulate
from server.jobs.case_table import CaseRow, write_table
from server.jobs.files import JobFiles
from server.jobs.results import Results
from server.jobs.task import ChunkResult, ColumnInfo
from server.jobs.trajectories import write_trajectories

COLUMNS = (
    ColumnInfo("Front bellows position x", "m", "where it is", "parameter"),
    ColumnInfo("=cmd|'/c calc'!A1", "kg", "a name that is a formula", "parameter"),
    ColumnInfo('odd, "quoted"', "1", "", "parameter"),
    ColumnInfo("method", "", "how it is solved", "parameter", numeric=False),
    ColumnInfo("Länge ☃", "m", "größte Länge", "parameter"),
    ColumnInfo("range", "m", "distance", "metric"),
    ColumnInfo("x", "m/s", "like a variable of trajectories", "metric"),
    ColumnInfo("end", "", "like a word of MATLAB", "metric"),
)
PARAMETERS = [column.name for column in COLUMNS if column.role == "parameter"]
METRICS = [column.name for column in COLUMNS if column.role == "metric"]
METHODS = ("planar", True, None, [1, 'a, "b"'], "=1+1", "Länge\n☃", {"kind": "own"})
REASON = 'Refused: at "/vehicle", mass is -1,\nnot positive ü'


def case_row(case: int) -> CaseRow:
    """Return one case; every seventh was refused, every eleventh lacks a metric, case 5 ran away."""
    generator = np.random.default_rng(case)
    values = [*generator.normal(size=3), METHODS[case % len(METHODS)], generator.normal() * 1e-300]
    metrics = [generator.lognormal(), np.nan if case % 11 == 3 else 1.0 / (case + 1), float(case)]
    if case % 7 == 6:
        return CaseRow(case, "refused", REASON, values, [np.nan] * 3)
    return CaseRow(case, "diverged" if case == 5 else "completed", None, values, metrics)


def write_chunks(
    folder: Path, rows: Sequence[CaseRow], *, size: int, columns: Sequence[ColumnInfo] = COLUMNS,
    without: Collection[int] = (), counted: int | None = None,
) -> Results:  # fmt: skip
    """Write rows in chunks but for those left out, and return the results."""
    files = JobFiles(folder, "job")
    for chunk in range(-(-len(rows) // size)):
        if chunk not in without:
            part = rows[chunk * size : (chunk + 1) * size]
            table = write_table(part, columns)
            files.write(chunk, ChunkResult(table, None, len(part), 0.0, "kernel", "processor"))
    return Results(files, cases=len(rows) if counted is None else counted, chunk_size=size)


def add_trajectories(results: Results, lengths: dict[int, int], run: Run) -> None:
    """Keep the first so many samples of a run as the trajectories of cases."""
    for chunk in results.chunks():
        first = chunk * results.chunk_size
        kept = [
            (case, run.select(np.arange(lengths[case])))
            for case in range(first, first + results.chunk_size)
            if case in lengths
        ]
        if kept:
            results.files.path(chunk, "nc").write_bytes(write_trajectories(kept))


def made_up(folder: Path, cases: int = 100, **options: object) -> Results:
    """Return the results of the cases of `case_row`, in chunks of 8."""
    return write_chunks(folder, [case_row(k) for k in range(cases)], size=8, **options)  # type: ignore[arg-type]


def example_run(preset_id: str = "three-cell-glider") -> Run:
    return simulate(load_preset(preset_id))
