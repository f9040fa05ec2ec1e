"""Run a batch document from Python, without a server: `python examples/batch_sweep.py`."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from models.presets import load_preset
from server.jobs.engines import ProcessEngine
from server.jobs.results import Results
from server.jobs.service import Jobs
from server.store.database import Database, sqlite_url

POSITION = {
    "name": "front bellows",
    "pointer": "/vehicle/components/1/position/0",
    "low": 0.17,
    "high": 0.19,
    "count": 9,
}
BATCH = {
    "format": "glider-batch", "version": 1, "kind": "sweep",
    "design": load_preset("canete-dual-bellows").model_dump(mode="json"),
    "metrics": ["range", "maximum_depth"],
    "method": {"kind": "full_factorial", "parameters": [POSITION]},
}  # fmt: skip


def main(folder: Path) -> None:
    """Compute the cases by two processes, and print them."""
    database = Database(sqlite_url(folder / "studio.sqlite"))
    jobs = Jobs(database, ProcessEngine(2), folder / "jobs")
    jobs.start()
    job, _ = jobs.submit(BATCH)
    while not (job := jobs.store.get(job.id)).over:
        time.sleep(0.1)
    jobs.stop()
    results = Results(jobs.files(job), cases=job.counted, chunk_size=job.chunk_size)
    print(f"{job.state}: {job.done} cases, {job.failed} of them failed")
    for batch in results.batches(["front bellows", "range", "maximum_depth"]):
        for row in batch.to_pylist():
            print(", ".join(f"{name} {value:.4f} m" for name, value in row.items()))
    database.close()


if __name__ == "__main__":  # the processes import this file too
    with tempfile.TemporaryDirectory() as name:
        main(Path(name))
