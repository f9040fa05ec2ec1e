"""Workers and servers are killed in mid-batch: nothing is lost or counted twice, and no number changes by a bit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path

import psutil
import pytest

from server.jobs import chunk
from server.jobs.engines import ProcessEngine
from server.jobs.task import ChunkTask
from tests.server.job_support import assert_whole, finished, open_at, running, slow_sweep, wait_for

ROOT = Path(__file__).parents[2]
CASES = 96


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 8)


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """The case table of one process and one thread."""
    with pytest.MonkeyPatch.context() as patch, running(open_at(tmp_path_factory.mktemp("serial"))) as jobs:
        patch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 8)
        job = finished(jobs, jobs.submit(slow_sweep(CASES))[0])
        return assert_whole(jobs, job)


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_any_number_of_workers_gives_the_same_bits(tmp_path, serial, workers):
    with running(open_at(tmp_path, ProcessEngine(workers))) as jobs:
        job = finished(jobs, jobs.submit(slow_sweep(CASES))[0])
        assert job.state == "succeeded"
        assert assert_whole(jobs, job).equals(serial)
    assert not psutil.Process().children(recursive=True) or no_workers_left()


def workers_of(process_id):
    """Return the pool's processes: those that Python's spawn began."""
    found = psutil.Process(process_id).children(recursive=True)
    return [child for child in found if "spawn_main" in " ".join(command_of(child))]


def command_of(process):
    try:
        return process.cmdline()
    except psutil.NoSuchProcess:
        return []


def no_workers_left():
    return wait_for(lambda: not workers_of(os.getpid()), what="the end of the workers", seconds=10.0)


def test_killed_workers_cost_their_chunks_only(tmp_path, serial):
    with running(open_at(tmp_path, ProcessEngine(2))) as jobs:
        job, _ = jobs.submit(slow_sweep(CASES))
        for done in (2, 6):
            wait_for(lambda done=done: jobs.store.get(job.id).chunks_done >= done, what=f"{done} chunks")
            wait_for(lambda: workers_of(os.getpid()), what="workers")[0].kill()
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.failed == 0
        assert assert_whole(jobs, job).equals(serial)


def die(task: ChunkTask) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class Deadly(ProcessEngine):
    """A pool in which one chunk kills whoever computes it."""

    def submit(self, function, /, *arguments) -> Future:
        deadly = bool(arguments) and getattr(arguments[0], "chunk", None) == 5
        return super().submit(die if deadly else function, *arguments)


def test_a_chunk_that_kills_its_workers_is_given_up_and_no_other(tmp_path, serial):
    with running(open_at(tmp_path, Deadly(2))) as jobs:
        job = finished(jobs, jobs.submit(slow_sweep(CASES))[0])
        assert job.state == "partial" and job.failed == 8
        table = assert_whole(jobs, job)
        lost = table.slice(40, 8).to_pylist()
        assert all(row["status"] == "crashed" and "workers died" in row["reason"] for row in lost)
        assert table.slice(0, 40).equals(serial.slice(0, 40)) and table.slice(48).equals(serial.slice(48))
        [failure] = jobs.record(job)["failures"]
        assert failure["count"] == 8 and failure["case"] == 40


def begin_server(folder, *more):
    return subprocess.Popen(
        [sys.executable, "-m", "tests.server.server_process", str(folder), *more],
        cwd=ROOT, stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip


def end(server):
    server.kill()
    server.wait(10)
    server.stdout.close()


def test_a_killed_server_goes_on_after_its_restart(tmp_path, serial):
    submitting = open_at(tmp_path)
    job, _ = submitting.submit(slow_sweep(CASES))
    server = begin_server(tmp_path)
    try:
        wait_for(lambda: submitting.store.get(job.id).chunks_done >= 3, what="three chunks")
        orphans = workers_of(server.pid)
        assert len(orphans) == 2
    finally:
        end(server)
    wait_for(lambda: not any(orphan.is_running() for orphan in orphans), what="the end of the workers", seconds=10.0)
    left = submitting.store.get(job.id)
    assert left.state == "running" and 3 <= left.chunks_done < left.chunks
    written = {path: path.read_bytes() for path in submitting.files(job).written()}
    server = begin_server(tmp_path)
    try:
        job = finished(submitting, job)
    finally:
        end(server)
    assert job.state == "succeeded"
    assert assert_whole(submitting, job).equals(serial)
    counted = [path for path in written if int(path.stem.split("-")[1]) in range(left.chunks_done)]
    assert all(path.read_bytes() == written[path] for path in counted)


def test_two_servers_share_the_work_and_count_nothing_twice(tmp_path, serial):
    submitting = open_at(tmp_path)
    servers = [begin_server(tmp_path) for _ in range(2)]
    try:
        jobs = [submitting.submit(slow_sweep(CASES), fresh=True)[0] for _ in range(2)]
        for job in jobs:
            assert finished(submitting, job).state == "succeeded"
            assert assert_whole(submitting, job).equals(serial)
    finally:
        for server in servers:
            end(server)


def test_a_server_that_lost_its_job_counts_nothing(tmp_path):
    """A chunk of someone whose lease has run out comes too late: the other's counts."""
    jobs = open_at(tmp_path)
    job, _ = jobs.submit(slow_sweep(8))
    [held] = jobs.store.claim("first", 0.0, most=1)
    [taken] = jobs.store.claim("second", 60.0, most=1)
    assert held.id == taken.id == job.id
    count = {"cases": 8, "failures": {}, "seconds": 1.0, "processor": "x", "rate": None}
    assert not jobs.store.count_chunk(job.id, "first", 0, **count)
    assert jobs.store.count_chunk(job.id, "second", 0, **count)
    assert not jobs.store.count_chunk(job.id, "second", 0, **count)
    now = jobs.store.get(job.id)
    assert (now.done, now.chunks_done) == (8, 1)
    jobs.stop()


def test_a_chunk_is_the_same_alone(serial, tmp_path):
    """What a worker computes for one chunk needs no other: the middle of the batch by itself."""
    from server.jobs.case_table import read_table
    from server.jobs.tasks import TaskMaker, plan_of

    jobs = open_at(tmp_path)
    job, _ = jobs.submit(slow_sweep(CASES))
    maker = TaskMaker(plan_of(jobs.store.get(job.id).spec), jobs.limits)
    result = chunk.run_chunk(maker.task(job.id, 7, 56, 61))
    assert read_table(result.table).equals(serial.slice(56, 5))
    jobs.stop()
