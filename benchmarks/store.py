"""Lists, searches and pages of a full store, against 20 ms at the 95th percentile: `python -m benchmarks.store [URL]`.

SQLite in a temporary folder, or the empty database that the URL names. Notes are as long as those of the presets; of
the jobs one in five has failed cases. The times are those of the store; benchmarks.service asks it through HTTP.
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import insert, update

from models.design import parse_design
from models.limits import DEFAULT_LIMITS
from models.presets import load_preset
from server.jobs.record import record_of
from server.jobs.submission import Request, no_store, prepare
from server.store import job_tables
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.identifiers import new_id
from server.store.jobs import JobStore
from server.store.listing import DesignQuery
from server.store.records import Content

DESIGNS, JOBS = 10_000, 1_000
REPEATS = 100
TARGET = 20.0  # ms at the 95th percentile
WORDS = 3000


def fill(store: DesignStore) -> float:
    """Store the designs; return the milliseconds that one took."""
    dice = random.Random(7)
    words = ["".join(dice.choices("abcdefghilmnoprstu", k=dice.randint(3, 10))) for _ in range(WORDS)]
    document = load_preset("seawing-spiral").model_dump(mode="json")
    begin = time.perf_counter()
    for k in range(DESIGNS):
        named = document | {"name": f"Glider {k} {dice.choice(words)}", "notes": " ".join(dice.choices(words, k=150))}
        store.create(Content(parse_design(named), tuple(dice.sample(words[:50], 3))))
    return 1e3 * (time.perf_counter() - begin) / DESIGNS


def batch_document(cases: int = 1000) -> dict[str, Any]:
    """Return a batch of a planar glide."""
    design = load_preset("canete-dual-bellows").model_dump(mode="json")
    parameters = [{"pointer": "/vehicle/components/1/position/0", "low": 0.1, "high": 0.3}]
    method = {"kind": "latin_hypercube", "parameters": parameters, "count": cases}
    return {"format": "glider-batch", "version": 1, "kind": "sweep", "design": design, "method": method}


def fill_jobs(database: Database) -> None:
    """Store the jobs, all of them over."""
    store, dice = JobStore(database), random.Random(7)
    new = prepare(
        batch_document(), Request(), find_design=no_store, limits=DEFAULT_LIMITS, max_cases=10_000, workers=2
    )  # fmt: skip
    for k in range(JOBS):
        store.add(
            replace(new, id=new_id(), name=f"Sweep {k} of {dice.choice(('hulls', 'wings', 'cells'))}"), reuse=False
        )
    jobs, failures = job_tables.jobs, job_tables.job_failures
    with database.write() as connection:
        connection.execute(update(jobs).values(state="succeeded", done=new.cases, finished=time.time()))
        for job in store.page(limit=JOBS)[::5]:
            values = [
                {"job_id": job.id, "reason": f"mass is too large by {n}", "cases": 3, "first_case": n}
                for n in range(10)
            ]
            connection.execute(insert(failures), values)
            connection.execute(update(jobs).where(jobs.c.id == job.id).values(state="partial", failed=30))


def job_queries(store: JobStore) -> dict[str, Callable[[], object]]:
    """Return what is asked of the jobs, by name, as the list of jobs asks it."""

    def records(**asked: Any) -> list[dict[str, Any]]:
        found = store.page(limit=51, **asked)
        failures = store.failures([job.id for job in found if job.failed])
        return [record_of(job, failures=failures.get(job.id, ())) for job in found]

    middle = store.page(limit=JOBS // 2)[-1]
    return {
        "jobs": records,
        "jobs, page within": lambda: records(before=(middle.created, middle.id)),
        "jobs by state": lambda: records(states=("partial",)),
        "jobs, search": lambda: records(search="wings"),
        "jobs, search none": lambda: records(search="zzz"),
        "get a job": lambda: store.get(middle.id),
    }


def percentiles(action: Callable[[], object]) -> tuple[float, float]:
    """Return the 50th and 95th percentile of the time an action takes, ms."""
    taken = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        action()
        taken.append(1e3 * (time.perf_counter() - begin))
    median, high = np.percentile(taken, [50, 95])
    return float(median), float(high)


def queries(store: DesignStore) -> dict[str, DesignQuery]:
    """Return what is asked, by name; the page in the middle of a list has a cursor."""
    listed = store.find(DesignQuery(limit=1)).items[0]
    middle = store.find(DesignQuery(order="name", limit=200)).next
    return {
        "list": DesignQuery(),
        "list by name": DesignQuery(order="name"),
        "page within": DesignQuery(order="name", cursor=middle),
        "by tag": DesignQuery(tags=(listed.tags[0],)),
        "search one": DesignQuery(f"{listed.name}"),
        "search all": DesignQuery("glider"),
        "search none": DesignQuery("zzzyyyxxx"),
        "search a part": DesignQuery("ati"),
        "search two parts": DesignQuery("ati ero"),
        "search two letters": DesignQuery("qx"),
        "search and tag": DesignQuery("ati", (listed.tags[0],), order="name"),
    }


def main(store: DesignStore) -> None:
    """Fill, ask and print."""
    print(f"{DESIGNS} designs, {fill(store):.2f} ms to store one; then {JOBS} jobs")
    print(f"{'':20} p50, ms  p95, ms  (target {TARGET:g} ms at p95)")
    design_id = store.find(DesignQuery(limit=1)).items[0].id
    asked: dict[str, Callable[[], object]] = {
        name: lambda query=query: store.find(query) for name, query in queries(store).items()
    }
    fill_jobs(store.database)
    asked |= {"get one": lambda: store.get(design_id).design} | job_queries(JobStore(store.database))
    for name, action in asked.items():
        median, high = percentiles(action)
        print(f"{name:20} {median:7.2f}  {high:7.2f}  {'' if high < TARGET else 'above the target'}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        database = Database(sys.argv[1] if len(sys.argv) > 1 else sqlite_url(Path(folder) / "studio.sqlite"))
        main(DesignStore(database))
        database.close()
