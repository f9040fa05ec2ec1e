"""Owns a process that runs jobs until it is killed: `python -m tests.server.server_process FOLDER [SCHEDULER]`."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from server.jobs.engines import DaskEngine, ProcessEngine
from tests.server.job_support import open_at

ROOT = Path(__file__).parents[2]


@contextmanager
def server_of(folder: Path, scheduler: str | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """Run jobs in a process of its own, killed at the end."""
    command = [sys.executable, "-m", "tests.server.server_process", str(folder), *([scheduler] if scheduler else [])]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, cwd=ROOT, env=environment) as server:
        try:
            yield server
        finally:
            server.kill()


def main() -> None:
    folder, scheduler = Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None
    jobs = open_at(folder, DaskEngine(scheduler) if scheduler else ProcessEngine(2), lease=2.0)
    jobs.start()
    time.sleep(300.0)


if __name__ == "__main__":
    main()
