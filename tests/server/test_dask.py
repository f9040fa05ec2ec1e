"""The same jobs on a Dask cluster: a scheduler and two workers on the loopback, killed in mid-batch."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.jobs.engines import DaskEngine, EngineLostError
from tests.server.job_support import assert_whole, finished, open_at, running, slow_sweep, wait_for

ROOT = Path(__file__).parents[2]
CASES = 96


class Cluster:
    """A scheduler and its workers, each a process of its own."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
        self.scheduler: subprocess.Popen[bytes] | None = None
        self.workers: list[subprocess.Popen[bytes]] = []

    def start(self, workers: int = 2) -> None:
        """Start the scheduler and its workers, and wait for them."""
        port = self.address.rpartition(":")[2]
        self.scheduler = begin("scheduler", "--host", "tcp://127.0.0.1", "--port", port, "--no-dashboard")
        self.workers = [
            begin("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
            for _ in range(workers)
        ]
        engine = DaskEngine(self.address)

        def there() -> bool:
            try:
                engine.check()
            except EngineLostError:
                engine.restart()
                return False
            return engine.workers == workers

        wait_for(there, what="the cluster")
        engine.stop()

    def kill_scheduler(self) -> None:
        """Kill the scheduler; its workers end by themselves, or are ended."""
        assert self.scheduler is not None
        kill(self.scheduler)
        for worker in self.workers:
            kill(worker)

    def stop(self) -> None:
        """End everything."""
        for process in (*self.workers, self.scheduler):
            if process is not None:
                kill(process)


def begin(what: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments],
        cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "PYTHONWARNINGS": "ignore"},
    )  # fmt: skip


def kill(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait(10)


@pytest.fixture(scope="module", autouse=True)
def small_chunks() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 8)
        yield


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    with running(open_at(tmp_path_factory.mktemp("serial"))) as jobs:
        job = finished(jobs, jobs.submit(slow_sweep(CASES))[0])
        return assert_whole(jobs, job)


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    cluster = Cluster()
    cluster.start()
    try:
        yield cluster
    finally:
        cluster.stop()


def test_a_killed_worker_costs_nothing_but_time(tmp_path, cluster, serial):
    with running(open_at(tmp_path, DaskEngine(cluster.address))) as jobs:
        job, _ = jobs.submit(slow_sweep(CASES))
        wait_for(lambda: jobs.store.get(job.id).chunks_done >= 2, what="two chunks")
        kill(cluster.workers[0])
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.failed == 0
        assert assert_whole(jobs, job).equals(serial)


def test_a_killed_scheduler_is_waited_for(tmp_path, cluster, serial):
    with running(open_at(tmp_path, DaskEngine(cluster.address))) as jobs:
        job, _ = jobs.submit(slow_sweep(CASES))
        wait_for(lambda: jobs.store.get(job.id).chunks_done >= 2, what="two chunks")
        cluster.kill_scheduler()
        counted = jobs.store.get(job.id).chunks_done
        assert jobs.store.get(job.id).state == "running"
        cluster.start()
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.chunks_done == job.chunks > counted
        assert assert_whole(jobs, job).equals(serial)


def test_a_scheduler_that_is_not_there_is_told(tmp_path):
    engine = DaskEngine("tcp://127.0.0.1:9", within=1.0)
    with pytest.raises(EngineLostError, match=r"127\.0\.0\.1:9"):
        engine.check()
    engine.stop()
