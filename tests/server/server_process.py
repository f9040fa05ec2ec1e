"""Runs jobs in a process of its own until it is killed: `python -m tests.server.server_process FOLDER [SCHEDULER]`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from server.jobs.engines import DaskEngine, ProcessEngine
from tests.server.job_support import open_at


def main() -> None:
    folder, scheduler = Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None
    jobs = open_at(folder, DaskEngine(scheduler) if scheduler else ProcessEngine(2), lease=2.0)
    jobs.start()
    print("running", flush=True)
    time.sleep(300.0)


if __name__ == "__main__":
    main()
