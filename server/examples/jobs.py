"""Owns the worked examples of jobs, and the jobs that each is asked of: one that is done, others on their way.

The one that is done has run, on the engine that runs one chunk after another; all are as at the start for each example.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import update

from models.limits import DEFAULT_LIMITS
from server.jobs.engines import SerialEngine
from server.jobs.service import MOST_CASES, Jobs
from server.jobs.submission import Request, no_store, prepare
from server.store import job_tables as tables
from server.store.database import Database, sqlite_url
from server.store.job_records import NewJob

BEGIN = 1_767_268_800.0
"""2026-01-01 12:00 UTC, s since 1970: the examples' time, so that they stay as they are."""
MINUTE = 60.0
DONE, WAITING, RUNNING, PAUSED, CANCELLED = (f"01jjbs{number:020d}" for number in range(5))
KEY = "monday-1"
JOB_HEADERS = frozenset({"Idempotency-Key", "Last-Event-ID"})
PATIENCE = 120.0
"""How long the example may take to run, on a busy machine, s."""


def _sweep(design: Mapping[str, Any], name: str = "Mass of the example glider") -> dict[str, Any]:
    """Return a batch of six cases, of which the first keeps its trajectory."""
    mass = {"pointer": "/vehicle/components/0/mass", "name": "body mass", "low": 0.73, "high": 0.78, "count": 6}
    return {
        "format": "glider-batch", "version": 1, "kind": "sweep", "name": name, "design": design,
        "metrics": ["range", "maximum_depth"], "trajectories": [0],
        "method": {"kind": "full_factorial", "parameters": [mass]},
    }  # fmt: skip


def _draws(design: Mapping[str, Any]) -> dict[str, Any]:
    """Return a batch of cases drawn at random until the mean range is known to 2 mm."""
    scatter = {"kind": "truncated_normal", "mean": 0.75, "sd": 0.005, "low": 0.73, "high": 0.77}
    return {
        "format": "glider-batch", "version": 1, "kind": "monte_carlo", "name": "Scatter of the body's mass",
        "design": design, "metrics": ["range", "maximum_depth"], "seed": 7,
        "parameters": [{"pointer": "/vehicle/components/0/mass", "name": "body mass", "distribution": scatter}],
        "count": 1000, "stop": {"metric": "range", "width": 0.002},
    }  # fmt: skip


def _new(document: dict[str, Any], job_id: str, **values: Any) -> NewJob:
    digest = hashlib.sha256(json.dumps(document).encode()).hexdigest()
    asked = Request(key=KEY if job_id == WAITING else None, digest=digest)
    new = prepare(document, asked, find_design=no_store, limits=DEFAULT_LIMITS, max_cases=MOST_CASES, workers=1)
    return replace(new, id=job_id, **values)  # the size of chunks follows from what a case takes here


@contextmanager
def _open(folder: Path) -> Iterator[tuple[Jobs, Database]]:
    database = Database(sqlite_url(folder / "jobs.sqlite"))
    try:
        yield Jobs(database, SerialEngine(), folder / "jobs"), database
    finally:
        database.close()


@cache
def _seeded(design: str) -> Mapping[str, bytes]:
    """Return the files of a program with the examples' jobs, by their paths."""
    document = json.loads(design)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        with _open(root) as (jobs, database):
            jobs.store.add(_new(_sweep(document), DONE, chunk_size=3))
            _run(jobs)
            jobs.store.add(_new(_draws(document), WAITING, chunk_size=250))
            for job_id in (RUNNING, PAUSED, CANCELLED):
                jobs.store.add(_new(_sweep(document, "The same again"), job_id, chunk_size=3), reuse=False)
            _set_states(database)
        return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def _set_states(database: Database) -> None:
    began = BEGIN + 10.0 * MINUTE
    another = {"owner": "another", "lease_until": time.time() + 1e9}
    states: Mapping[str, dict[str, Any]] = {
        DONE: {"started": began, "finished": began + 2.0},
        WAITING: {},
        RUNNING: {"state": "running", "started": began} | another,
        PAUSED: {"state": "paused", "started": began, "reason": "the disk is full: free some space, and resume"},
        CANCELLED: {"state": "cancelled", "finished": began, "cancel_requested": True},
    }
    with database.write() as connection:
        for number, (job_id, values) in enumerate(states.items()):
            row = {"created": BEGIN + number * MINUTE} | values
            connection.execute(update(tables.jobs).where(tables.jobs.c.id == job_id).values(row))


def _run(jobs: Jobs) -> None:
    jobs.start()
    deadline = time.monotonic() + PATIENCE
    while not jobs.store.get(DONE).over and time.monotonic() < deadline:
        time.sleep(0.05)
    jobs.stop()
    job = jobs.store.get(DONE)
    if job.state != "succeeded":
        raise RuntimeError(f"the example's job is {job.state}: {job.reason}")


@contextmanager
def demo_jobs(design: Mapping[str, Any]) -> Iterator[Jobs]:
    """Enter jobs of their own for one example, as all of them begin; nothing runs."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in _seeded(json.dumps(design)).items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        with _open(Path(folder)) as (jobs, _):
            yield jobs


def job_requests(api: str, design: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the examples by operation: method and path, the parameters and the body."""
    one, done = f"{api}/jobs/{{job_id}}", {"job_id": DONE}
    case = f"{one}/cases/{{case}}"
    first = done | {"case": 0}
    return {
        "get_batch_schema": {"at": ("GET", f"{api}/schemas/batch")},
        "create_job": {
            "at": ("POST", f"{api}/jobs"), "parameters": {"Idempotency-Key": KEY}, "request": _draws(design),
        },
        "list_jobs": {"at": ("GET", f"{api}/jobs"), "parameters": {"state": "succeeded", "limit": 10}},
        "get_job": {"at": ("GET", one), "parameters": done},
        "delete_job": {"at": ("DELETE", one), "parameters": done},
        "get_job_spec": {"at": ("GET", f"{one}/spec"), "parameters": done},
        "watch_job": {"at": ("GET", f"{one}/events"), "parameters": done | {"Last-Event-ID": "3"}},
        "cancel_job": {"at": ("POST", f"{one}:cancel"), "parameters": {"job_id": RUNNING}},
        "retry_job": {"at": ("POST", f"{one}:retry"), "parameters": {"job_id": CANCELLED}},
        "resume_job": {"at": ("POST", f"{one}:resume"), "parameters": {"job_id": PAUSED}},
        "list_cases": {"at": ("GET", f"{one}/cases"), "parameters": done | {"limit": 2}},
        "get_case": {"at": ("GET", case), "parameters": first},
        "get_case_design": {"at": ("GET", f"{case}/design"), "parameters": first},
        "get_trajectory": {
            "at": ("GET", f"{case}/trajectory"), "parameters": first | {"columns": "x,z,theta", "max_points": 5},
        },
        "get_results": {"at": ("GET", f"{one}/results"), "parameters": done},
        "get_summary": {"at": ("GET", f"{one}/summary"), "parameters": done},
    }  # fmt: skip
