"""Time and memory of a job's results for 100,000 cases of 10 columns, each format in a process of its own.

`python -m benchmarks.results`; memory is the peak of the process, and what it is above that of the imports alone.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from server.jobs import formats
from server.jobs.case_table import CaseRow, write_table
from server.jobs.files import JobFiles
from server.jobs.results import Results
from server.jobs.summary import summarize
from server.jobs.task import ChunkResult, ColumnInfo

CASES, CHUNK = 100_000, 1024
COLUMNS = [ColumnInfo(f"parameter {k}", "m", "what varies", "parameter") for k in range(4)] + [
    ColumnInfo(f"metric {k}", "m/s", "what is measured", "metric") for k in range(6)
]
LIMIT_MB, LIMIT_SUMMARY_S, LIMIT_PAGE_MS = 600.0, 1.0, 20.0
Work = Callable[[Results], object]
WORKS: dict[str, Work] = {
    "nothing": lambda results: None,
    "json": lambda results: sum(map(len, formats.stream_json(results))),
    "csv": lambda results: sum(map(len, formats.stream_csv(results))),
    "parquet": lambda results: _sent(formats.parquet_file(results, {})),
    "netcdf": lambda results: _sent(formats.netcdf_file(results, {})),
    "mat": lambda results: _sent(formats.mat_file(results, {})),
    "summary": lambda results: summarize(results),
    "page": lambda results: results.page(50_000, 100),
    "page of failures": lambda results: results.page(-1, 100, {"refused"}),
}


def _sent(path: Path) -> int:
    return sum(map(len, formats.file_blocks(path)))


def results_in(folder: Path) -> Results:
    return Results(JobFiles(folder, "job"), cases=CASES, chunk_size=CHUNK)


def write_cases(folder: Path) -> None:
    """Write the cases, of which every thousandth was refused."""
    files, generator = JobFiles(folder, "job"), np.random.default_rng(1)
    for chunk, first in enumerate(range(0, CASES, CHUNK)):
        values = generator.lognormal(size=(min(CHUNK, CASES - first), len(COLUMNS))).tolist()
        rows = [
            CaseRow(k, "refused", f"mass is {k}", row[:4], [np.nan] * 6) if k % 1000 == 999
            else CaseRow(k, "completed", None, row[:4], row[4:])
            for k, row in enumerate(values, first)
        ]  # fmt: skip
        files.write(chunk, ChunkResult(write_table(rows, COLUMNS), None, len(rows), 0.0, "", ""))


def measured(name: str, folder: Path) -> tuple[float, float]:
    """Return the time (s) and the peak memory (MB) of one piece of work, in this process."""
    results = results_in(folder)
    began = time.perf_counter()
    WORKS[name](results)
    took = time.perf_counter() - began
    return took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def in_its_own_process(name: str, folder: Path) -> tuple[float, float]:
    command = [sys.executable, "-m", "benchmarks.results", name, str(folder)]
    took, memory = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return float(took), float(memory)


def main() -> None:
    if len(sys.argv) == 3:
        print(*measured(sys.argv[1], Path(sys.argv[2])))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_cases(folder)
        _, base = in_its_own_process("nothing", folder)
        print(f"{CASES} cases of {len(COLUMNS)} columns; imports alone {base:.0f} MB, at most {LIMIT_MB:g} MB in all")
        for work in list(WORKS)[1:]:
            took, memory = in_its_own_process(work, folder)
            print(f"  {work:<18} {took:7.3f} s   {memory:6.0f} MB   {memory - base:+6.0f} MB")
        print(f"to reach: summary {LIMIT_SUMMARY_S:g} s, a page {LIMIT_PAGE_MS:g} ms")


if __name__ == "__main__":
    main()
