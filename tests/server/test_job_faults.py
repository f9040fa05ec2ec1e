"""Workers and servers are killed in mid-batch: nothing is lost or counted twice, and no number changes by a bit."""

from __future__ import annotations

import os
import signal
from concurrent.futures import Future

import psutil
import pytest

from server.jobs import chunk
from server.jobs.engines import ProcessEngine
from server.jobs.task import ChunkTask
from tests.server.job_support import assert_whole, finished, open_at, running, slow_sweep, spiral_sweep, wait_for
from tests.server.server_process import server_of

CASES, SPIRALS = 96, 32


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 8)


def table_of_one_thread(folder, document):
    with pytest.MonkeyPatch.context() as patch, running(open_at(folder)) as jobs:
        patch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 8)
        return assert_whole(jobs, finished(jobs, jobs.submit(document)[0]))


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """The case table of planar glides of a fixed step."""
    return table_of_one_thread(tmp_path_factory.mktemp("serial"), slow_sweep(CASES))


@pytest.fixture(scope="module")
def serial_spirals(tmp_path_factory):
    """The case table of spatial glides of adaptive steps."""
    return table_of_one_thread(tmp_path_factory.mktemp("spirals"), spiral_sweep(SPIRALS))


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_any_number_of_workers_gives_the_same_bits(tmp_path, serial, serial_spirals, workers):
    """Two jobs at once, whose chunks take turns in the same workers."""
    with running(open_at(tmp_path, ProcessEngine(workers))) as jobs:
        both = [jobs.submit(document)[0] for document in (slow_sweep(CASES), spiral_sweep(SPIRALS))]
        for job, expected in zip(both, (serial, serial_spirals), strict=True):
            assert finished(jobs, job).state == "succeeded"
            assert assert_whole(jobs, job).equals(expected)
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


def test_a_killed_server_goes_on_after_its_restart(tmp_path, serial):
    submitting = open_at(tmp_path)
    job, _ = submitting.submit(slow_sweep(CASES))
    with server_of(tmp_path) as server:
        wait_for(lambda: submitting.store.get(job.id).chunks_done >= 3, what="three chunks")
        orphans = workers_of(server.pid)
        assert len(orphans) == 2
    wait_for(lambda: not any(orphan.is_running() for orphan in orphans), what="the end of the workers", seconds=10.0)
    left = submitting.store.get(job.id)
    assert left.state == "running" and 3 <= left.chunks_done < left.chunks
    written = {path: path.read_bytes() for path in submitting.files(job).written()}
    with server_of(tmp_path):
        job = finished(submitting, job)
    assert job.state == "succeeded"
    assert assert_whole(submitting, job).equals(serial)
    counted = [path for path in written if int(path.stem.split("-")[1]) in range(left.chunks_done)]
    assert all(path.read_bytes() == written[path] for path in counted)


def test_two_servers_share_the_work_and_count_nothing_twice(tmp_path, serial):
    submitting = open_at(tmp_path)
    with server_of(tmp_path), server_of(tmp_path):
        jobs = [submitting.submit(slow_sweep(CASES), fresh=True)[0] for _ in range(2)]
        for job in jobs:
            assert finished(submitting, job).state == "succeeded"
            assert assert_whole(submitting, job).equals(serial)


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
