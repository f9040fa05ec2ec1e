"""The same jobs on a Dask cluster: a scheduler and two workers on the loopback, killed in mid-batch."""

from __future__ import annotations

import gc
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import psutil
import pytest

from server.jobs.dask_executor import DaskExecutor
from server.jobs.engines import DaskEngine, EngineLostError
from tests.server.job_support import assert_whole, finished, open_at, running, slow_sweep, wait_for
from tests.server.server_process import ROOT, server_of

CASES = 96


class Cluster:
    """A scheduler and its workers, each a process of its own."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
        self.scheduler: subprocess.Popen[bytes] | None = None
        self.workers: list[subprocess.Popen[bytes]] = []

    def start(self, workers: int = 2) -> Cluster:
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
        return self

    def kill_scheduler(self) -> None:
        """Kill the scheduler; its workers are left alone."""
        assert self.scheduler is not None
        kill(self.scheduler)

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


@pytest.fixture(scope="module")
def standing() -> Iterator[Cluster]:
    """A cluster of one worker that no test breaks."""
    cluster = Cluster()
    try:
        yield cluster.start(workers=1)
    finally:
        cluster.stop()


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
        for worker in cluster.workers:
            assert worker.wait(60) == 0, "Dask's workers never connect again: they end by themselves"
        counted = jobs.store.get(job.id).chunks_done
        assert jobs.store.get(job.id).state == "running"
        cluster.start()
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.chunks_done == job.chunks > counted
        assert assert_whole(jobs, job).equals(serial)


def test_a_killed_server_goes_on_after_its_restart(tmp_path, cluster, serial):
    """Workers outlive their server: what it had sent them counts for nobody, and is computed again for the next one."""
    submitting = open_at(tmp_path)
    job, _ = submitting.submit(slow_sweep(CASES))
    with server_of(tmp_path, cluster.address):
        wait_for(lambda: submitting.store.get(job.id).chunks_done >= 3, what="three chunks")
    left = submitting.store.get(job.id)
    assert left.state == "running" and 3 <= left.chunks_done < left.chunks
    counted = submitting.store.written(job.id)
    written = {chunk: submitting.files(job).path(chunk).read_bytes() for chunk in counted}
    assert len(counted) == left.chunks_done and all(worker.poll() is None for worker in cluster.workers)
    with server_of(tmp_path, cluster.address):
        job = finished(submitting, job)
    assert job.state == "succeeded" and job.failed == 0
    assert assert_whole(submitting, job).equals(serial)
    assert submitting.store.written(job.id) == set(range(job.chunks))
    assert all(submitting.files(job).path(chunk).read_bytes() == written[chunk] for chunk in counted)


def test_a_scheduler_that_is_not_there_is_told(tmp_path):
    engine = DaskEngine("tcp://127.0.0.1:9", within=1.0)
    with pytest.raises(EngineLostError, match=r"127\.0\.0\.1:9"):
        engine.check()
    engine.stop()


def test_an_error_of_the_work_comes_back_as_it_is(standing):
    engine = DaskEngine(standing.address)
    error = engine.submit(os.stat, "/not/there").exception(60)
    assert isinstance(error, OSError) and "/not/there" in str(error) and not engine.lost(error)
    assert engine.submit(len, "x").result(60) == 1
    engine.stop()


def test_cancelling_cancels_in_the_cluster_too(standing):
    executor = DaskExecutor(standing.address, within=5.0)
    running, waiting = executor.submit(time.sleep, 1.0), executor.submit(os.stat, "/never/run")
    assert waiting.cancel() and waiting.cancelled()
    wait_for(lambda: len(executor._client.futures) == 1, what="the end of the cancelled work")
    assert running.result(60) is None and not executor._pending
    executor.shutdown()


def test_work_that_someone_else_cancels_is_lost(standing):
    executor = DaskExecutor(standing.address, within=5.0)
    sent = executor.submit(time.sleep, 1.0)
    [key] = executor._client.futures
    executor._client.loop.add_callback(executor._client._handle_cancelled_keys, [key], reason="x", msg="someone else")
    assert isinstance(sent.exception(60), EngineLostError)
    executor.shutdown()


def test_a_restart_ends_what_was_sent(standing):
    engine = DaskEngine(standing.address)
    sent = [engine.submit(time.sleep, 0.3) for _ in range(3)]
    engine.restart()
    assert all(isinstance(future.exception(0), EngineLostError) for future in sent)
    assert engine.submit(len, "x").result(60) == 1
    engine.stop()


def test_restarts_leave_nothing_behind(standing):
    process = psutil.Process()

    def once(address: str) -> None:
        engine = DaskEngine(address, within=0.1 if address.endswith(":9") else 5.0)
        try:
            engine.submit(len, "x").result(60)
        except EngineLostError:
            assert address.endswith(":9")
        engine.restart()

    once(standing.address)
    threads, files = threading.active_count(), process.num_fds()
    for address in (standing.address, "tcp://127.0.0.1:9") * 5:
        once(address)

    def settled() -> bool:
        gc.collect()
        return threading.active_count() <= threads and process.num_fds() <= files

    wait_for(settled, what="the end of the former connections", seconds=30.0)


def test_a_scheduler_that_does_not_answer_holds_nobody_up(standing, monkeypatch):
    monkeypatch.setattr("server.jobs.engines.ANSWER_WITHIN", 0.5)
    monkeypatch.setattr("server.jobs.engines.ASK_EVERY", 0.0)
    engine = DaskEngine(standing.address)
    assert engine.workers == 1 and engine.submit(len, "x").result(60) == 1
    assert standing.scheduler is not None
    standing.scheduler.send_signal(signal.SIGSTOP)
    try:
        begun = time.monotonic()
        assert engine.workers == 1
        with pytest.raises(EngineLostError, match=f"{standing.address} is not reachable: .*"):
            engine.check()
        engine.restart()
        assert time.monotonic() - begun < 10.0
    finally:
        standing.scheduler.send_signal(signal.SIGCONT)
    engine.check()
    engine.stop()


def test_a_scheduler_that_dies_while_a_result_is_fetched_loses_it(cluster):
    def slow() -> object:  # within the test, so that a worker need not import it
        class Slow:
            def __reduce__(self) -> tuple[type[int], tuple[()]]:
                time.sleep(120.0)  # longer to fetch than the test waits
                return int, ()

        return Slow()

    engine = DaskEngine(cluster.address, within=3.0)
    sent = engine.submit(slow)
    client = engine._ready()._client
    wait_for(lambda: [state.status for state in client.futures.values()] == ["finished"], what="the end of the work")
    assert not sent.done()
    cluster.kill_scheduler()
    error = sent.exception(60)
    assert engine.lost(error), error
    wait_for(lambda: client.status != "running", what="the loss of the connection")
    assert engine.workers == 1
    with pytest.raises(EngineLostError, match="connection to the Dask scheduler broke"):
        engine.submit(len, "x")
    engine.stop()
