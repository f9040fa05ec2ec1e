"""Owns what the tests of jobs share: small batch documents, jobs on a store of their own, and waiting with a bound."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa

from models.presets import load_preset
from server.jobs.case_table import read_table
from server.jobs.engines import Engine, SerialEngine
from server.jobs.service import Jobs
from server.store.database import Database, sqlite_url
from server.store.job_records import Job

PRESET = "canete-dual-bellows"
POSITION = "/vehicle/components/1/position/0"
LONGEST = 300.0
"""Longest that a test waits, s: many times what the slowest machine takes."""


def glider(**mission: Any) -> dict[str, Any]:
    """Return a short planar glide, quick to simulate."""
    document = load_preset(PRESET).model_dump(mode="json")
    document["mission"] |= {"duration": 4.0} | mission
    schedules = document["mission"]["control"]["schedules"]
    for schedule in schedules:
        schedule["points"] = [p for p in schedule["points"] if p["time"] <= document["mission"]["duration"]]
    document["mission"]["control"]["schedules"] = [s for s in schedules if s["points"]]
    return document


def sweep(count: int = 12, **more: Any) -> dict[str, Any]:
    """Return a batch document: the front bellows moved along the hull."""
    place = {"name": "place", "pointer": POSITION, "low": 0.05, "high": 0.3, "count": count}
    method = {"kind": "full_factorial", "parameters": [place]}
    return {"format": "glider-batch", "version": 1, "kind": "sweep", "design": glider(), "method": method} | more


def slow_sweep(count: int) -> dict[str, Any]:
    """Return cases that take some ten milliseconds each, so that there is a middle of the batch to kill things in."""
    design = glider()
    design["mission"]["solver"] |= {"method": "rk4", "step": 2e-4}
    return sweep(count, design=design)


def spiral_sweep(count: int) -> dict[str, Any]:
    """Return spatial cases by the adaptive pair: some minutes of a spiral, the first cell moved along the hull."""
    design = load_preset("quad-bellows-spiral").model_dump(mode="json")
    design["mission"] |= {"duration": 240.0}
    design["mission"]["solver"] |= {"method": "adaptive", "output_interval": 1.0}
    x = design["vehicle"]["components"][1]["position"][0]
    place = {"name": "place", "pointer": POSITION, "low": x - 0.2 * abs(x), "high": x + 0.2 * abs(x), "count": count}
    return sweep(design=design, method={"kind": "full_factorial", "parameters": [place]})


def listed(pointer: str, values: list[Any], **more: Any) -> dict[str, Any]:
    """Return a batch document: one field, its values listed."""
    method = {"kind": "cases", "parameters": [{"name": "value", "pointer": pointer}], "rows": [[v] for v in values]}
    return sweep() | {"method": method} | more


def open_at(folder: Path, engine: Engine | None = None, **options: Any) -> Jobs:
    """Return jobs with a store and results in a folder."""
    database = Database(sqlite_url(folder / "studio.sqlite"))
    return Jobs(database, engine or SerialEngine(), folder / "jobs", **options)


@contextmanager
def running(jobs: Jobs):
    jobs.start()
    try:
        yield jobs
    finally:
        jobs.stop()


def wait_for(condition: Callable[[], Any], *, what: str, seconds: float = LONGEST) -> Any:
    """Return the first true answer of `condition`."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if answer := condition():
            return answer
        time.sleep(0.02)
    raise AssertionError(f"{what} did not happen within {seconds:g} s")


def finished(jobs: Jobs, job: Job) -> Job:
    """Wait until a job is over and return it."""

    def over() -> Job | None:
        now = jobs.store.get(job.id)
        return now if now.over else None

    return wait_for(over, what=f"the end of the job ({jobs.store.get(job.id)})")


def table_of(jobs: Jobs, job: Job) -> pa.Table:
    """Return the whole case table, as its files are."""
    return pa.concat_tables([read_table(path.read_bytes()) for path in jobs.files(job).written()])


def assert_whole(jobs: Jobs, job: Job) -> pa.Table:
    """Check that every case is there once and that the counts say so; return the case table."""
    job = jobs.store.get(job.id)
    table = table_of(jobs, job)
    assert table.column("case").to_pylist() == list(range(job.cases))
    assert (job.done, job.chunks_done) == (job.cases, job.chunks)
    assert not list(jobs.files(job).folder.glob("*.part"))
    return table
