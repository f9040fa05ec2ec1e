"""Whatever raises in the middle of a job, no job succeeds with a hole in it, and no other job is held up."""

from __future__ import annotations

import errno
import json
import time
from concurrent.futures import Future

import pytest

from models.kernel import KERNEL_HASH
from server.jobs import chunk as chunks
from server.jobs.engines import EngineLostError, SerialEngine
from server.jobs.files import JobFiles
from server.store.errors import UnavailableError
from server.store.jobs import JobStore
from tests.server.job_support import assert_whole, finished, listed, open_at, running, sweep, table_of, wait_for

STROKE = "/mission/control/schedules/0/points/0/extension"


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: 4)
    monkeypatch.setattr("server.jobs.manager.BACKOFF", 0.1)


class Slipping(SerialEngine):
    """An engine that raises once in a while instead of sending."""

    def __init__(self, error: Exception, when: set[int]) -> None:
        super().__init__()
        self.error, self.when, self.asked = error, when, 0

    def submit(self, function, /, *arguments):
        self.asked += 1
        if self.asked in self.when:
            raise self.error
        return super().submit(function, *arguments)


@pytest.mark.parametrize(
    "error", [EngineLostError("away"), RuntimeError("a slip"), OSError(errno.EAGAIN, "no process")]
)
def test_a_chunk_that_could_not_be_sent_is_sent_again(tmp_path, error):
    with running(open_at(tmp_path, Slipping(error, {1, 3, 4}))) as jobs:
        job = finished(jobs, jobs.submit(sweep(20))[0])
        assert job.state == "succeeded"
        assert_whole(jobs, job)


def test_a_result_that_cannot_be_written_pauses_its_job(tmp_path, monkeypatch):
    real, broken = JobFiles.write, {2}

    def write(self, chunk, result):
        if chunk in broken:
            raise OSError(errno.EIO, "an input or output error")
        real(self, chunk, result)

    monkeypatch.setattr(JobFiles, "write", write)
    with running(open_at(tmp_path)) as jobs:
        job, _ = jobs.submit(sweep(20))
        paused = wait_for(lambda: (j := jobs.store.get(job.id)).state == "paused" and j, what="the pause")
        assert "input or output error" in paused.reason
        broken.clear()
        jobs.resume(job.id)
        assert finished(jobs, job).state == "succeeded"
        assert_whole(jobs, job)


def test_what_was_lost_on_the_way_is_noticed_at_the_end(tmp_path, monkeypatch):
    """A chunk that the thread forgot, however that came about, is computed after all."""
    real, dropped = JobStore.count_chunk, {1}

    def count(self, job_id, owner, chunk, **more):
        if chunk in dropped:
            dropped.discard(chunk)
            return False
        return real(self, job_id, owner, chunk, **more)

    monkeypatch.setattr(JobStore, "count_chunk", count)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(sweep(20))[0])
        assert job.state == "succeeded" and not dropped
        assert_whole(jobs, job)


def test_a_damaged_job_stops_no_other(tmp_path, monkeypatch):
    def lost(files, case, chunk_size):
        raise FileNotFoundError("chunk-000000000.parquet")

    monkeypatch.setattr("server.jobs.manager.failures_before", lost)
    drawn = {"pointer": "/mission/initial/pitch", "distribution": {"kind": "uniform", "low": -0.1, "high": 0.1}}
    document = sweep() | {"kind": "monte_carlo", "parameters": [drawn], "count": 40, "stop": {
        "metric": "maximum_depth", "width": 1e3, "least": 4, "every": 4}}  # fmt: skip
    del document["method"]
    with running(open_at(tmp_path)) as jobs:
        damaged, _ = jobs.submit(document)
        paused = wait_for(lambda: (j := jobs.store.get(damaged.id)).state == "paused" and j, what="the pause")
        assert "chunk-000000000" in paused.reason
        assert finished(jobs, jobs.submit(sweep(8))[0]).state == "succeeded"


def test_an_error_of_the_chunk_itself_is_not_tried_for_ever(tmp_path, monkeypatch):
    def broken(task):
        raise OSError(errno.ENOENT, "a file that is not there")

    monkeypatch.setattr("server.jobs.manager.run_chunk", broken)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(sweep(8))[0])
        assert job.state == "failed" and job.failed == 8
        assert all("not there" in row["reason"] for row in assert_whole(jobs, job).to_pylist())


def test_two_versions_never_share_a_job(tmp_path, monkeypatch):
    """What another kernel began, this one does not finish; what none has begun is stamped anew."""
    jobs = open_at(tmp_path)
    begun, _ = jobs.submit(sweep(20))
    fresh, _ = jobs.submit(sweep(12))
    with monkeypatch.context() as patch:
        patch.setattr(jobs.store, "written", lambda job_id: {0} if job_id == begun.id else set())
        with jobs.store._database.write() as connection:
            for job in (begun, fresh):
                about = json.loads(job.about)
                about["engine"]["kernel"] = "another"
                connection.exec_driver_sql(f"UPDATE jobs SET about = '{json.dumps(about)}' WHERE id = '{job.id}'")
        with running(jobs):
            paused = wait_for(lambda: (j := jobs.store.get(begun.id)).state == "paused" and j, what="the pause")
            assert "kernel another" in paused.reason
            done = finished(jobs, fresh)
    assert done.state == "succeeded" and jobs.record(done)["engine"]["kernel"] == KERNEL_HASH


def test_a_job_is_never_claimed_from_oneself(tmp_path):
    jobs = open_at(tmp_path)
    job, _ = jobs.submit(sweep(4))
    [held] = jobs.store.claim("one", -5.0, most=1)  # a clock that was set forward makes a lease look over
    assert held.id == job.id
    assert jobs.store.claim("one", 15.0, most=1) == []
    assert [taken.id for taken in jobs.store.claim("other", 15.0, most=1)] == [job.id]
    jobs.stop()


def test_leases_are_kept_while_the_thread_is_busy(tmp_path, monkeypatch):
    """A job whose beginning takes longer than the lease is not taken by another process meanwhile."""
    from server.jobs import manager

    real = manager.plan_of

    def slow(document):
        time.sleep(2.0)
        return real(document)

    monkeypatch.setattr(manager, "plan_of", slow)
    one, other = open_at(tmp_path, lease=0.9), open_at(tmp_path, lease=0.9)
    job, _ = one.submit(sweep(8))
    with running(one), running(other):
        done = finished(one, job)
    assert done.state == "succeeded"
    assert_whole(one, job)


def drawn_until(width):
    place = {"pointer": "/mission/initial/pitch", "distribution": {"kind": "uniform", "low": -0.1, "high": 0.1}}
    document = sweep() | {"kind": "monte_carlo", "parameters": [place], "count": 80, "stop": {
        "metric": "maximum_depth", "width": width, "least": 8, "every": 8}}  # fmt: skip
    del document["method"]
    return document


def test_a_job_that_stopped_early_can_be_retried(tmp_path, monkeypatch):
    """Counts are those of the chunks that are left, and the groups of failures those of the cases that count."""
    real = chunks.evaluate

    def faulty(run, metrics):
        if run.design.mission.initial.pitch > 0.05:
            raise ZeroDivisionError("a slip")
        return real(run, metrics)

    monkeypatch.setattr(chunks, "evaluate", faulty)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(drawn_until(1e3))[0])
        assert job.stopped_at is not None and job.state == "partial" and job.done == job.stopped_at
        rows = table_of(jobs, job).slice(0, job.stopped_at).to_pylist()
        failed = sum(row["status"] == "crashed" for row in rows)
        assert job.failed == failed == sum(f["count"] for f in jobs.record(job)["failures"])
        monkeypatch.setattr(chunks, "evaluate", real)
        jobs.retry(job.id)
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.failed == 0 and job.done == job.stopped_at


def test_a_chunk_that_was_counted_before_still_counts_for_the_stop(tmp_path, monkeypatch):
    """The connection breaks after the commit: the same chunk is counted again, which changes nothing, stop included."""
    real, broken = JobStore.count_chunk, {1}

    def count(self, job_id, owner, chunk, **more):
        counted = real(self, job_id, owner, chunk, **more)
        if chunk in broken:
            broken.discard(chunk)
            raise UnavailableError("the connection broke")
        return counted

    monkeypatch.setattr(JobStore, "count_chunk", count)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(drawn_until(1e3))[0])
        assert job.stopped_at == 8 and not broken


def test_a_job_to_be_cancelled_does_not_pause(tmp_path):
    jobs = open_at(tmp_path)
    job, _ = jobs.submit(sweep(4))
    jobs.store.claim("me", 60.0, most=1)
    jobs.store.begin(job.id, "me")
    assert jobs.store.cancel(job.id).state == "cancelling"
    jobs.store.pause(job.id, "me", "the disk is full")
    assert jobs.store.get(job.id).state == "cancelled"
    jobs.stop()


def reason_of(jobs, job):
    return jobs.record(jobs.store.get(job.id))["reason"]


def test_a_job_that_waits_for_workers_says_so_until_it_goes_on(tmp_path):
    engine = Slipping(EngineLostError("no processes are left"), set(range(1, 10_000)))
    with running(open_at(tmp_path, engine)) as jobs:
        job, _ = jobs.submit(sweep(20))
        told = wait_for(lambda: reason_of(jobs, job), what="the reason")
        assert told == "waiting for workers: no processes are left; it goes on by itself once there are some"
        later, _ = jobs.submit(sweep(8))
        wait_for(lambda: reason_of(jobs, later), what="the reason of a job that came later")
        engine.when = set()
        wait_for(lambda: jobs.store.get(job.id).chunks_done, what="the first chunk")
        assert reason_of(jobs, job) is None
        assert finished(jobs, job).state == "succeeded" and reason_of(jobs, job) is None


class Empty(SerialEngine):
    """A cluster without workers: it takes work, and nobody does it."""

    known_workers = 0

    def submit(self, function, /, *arguments):
        return Future()


def test_a_cluster_without_workers_is_told(tmp_path):
    with running(open_at(tmp_path, Empty())) as jobs:
        job, _ = jobs.submit(sweep(8))
        told = wait_for(lambda: reason_of(jobs, job), what="the reason")
        assert told.startswith("waiting for workers: there are none")
    assert reason_of(jobs, job) is None, "nobody waits any more"


def test_a_database_that_is_full_is_told_and_waited_for(tmp_path, monkeypatch, caplog):
    """Its own words go to the log; who asks this process for the record is told from memory."""
    real, full = JobStore.count_chunk, [True]

    def count(self, job_id, owner, chunk, **more):
        if full and chunk >= 2:
            raise UnavailableError("the disk is full: free some space, and try again")
        return real(self, job_id, owner, chunk, **more)

    monkeypatch.setattr(JobStore, "count_chunk", count)
    with running(open_at(tmp_path)) as jobs:
        job, _ = jobs.submit(sweep(20))
        told = wait_for(lambda: reason_of(jobs, job), what="the reason")
        assert told.startswith("what is computed cannot be counted: the disk is full: free some space")
        assert jobs.store.get(job.id).state == "running"
        assert f"chunk 2 of job {job.id} cannot be counted yet: the disk is full" in caplog.text
        full.clear()
        assert finished(jobs, job).state == "succeeded" and reason_of(jobs, job) is None
        assert_whole(jobs, job)
        other = finished(jobs, jobs.submit(sweep(8))[0])
        assert reason_of(jobs, other) is None


def partial(jobs):
    return finished(jobs, jobs.submit(listed(STROKE, [0.0] * 8 + [0.5]))[0])


def test_old_results_are_deleted_before_anybody_computes_them_again(tmp_path, monkeypatch):
    real, seen = JobFiles.forget, []

    def slowly(self, chunk):
        seen.append((chunk, jobs.store.claim("another", 60.0, most=1)))
        real(self, chunk)

    with running(open_at(tmp_path)) as jobs:
        job = partial(jobs)
        assert job.state == "partial"
    monkeypatch.setattr(JobFiles, "forget", slowly)
    assert jobs.retry(job.id).state == "queued"
    assert seen == [(2, [])]
    assert not jobs.files(job).path(2).exists() and jobs.files(job).path(0).exists()
    assert jobs.store.written(job.id) == {0, 1}
    assert [taken.id for taken in jobs.store.claim("another", 60.0, most=1)] == [job.id]


def test_old_results_that_cannot_be_deleted_hold_no_retry_up(tmp_path, monkeypatch):
    def fails(self, chunk):
        raise OSError(errno.EIO, "an input or output error")

    with running(open_at(tmp_path)) as jobs:
        job = partial(jobs)
        with monkeypatch.context() as patch, pytest.raises(OSError, match="input or output"):
            patch.setattr(JobFiles, "forget", fails)
            jobs.retry(job.id)
        job = finished(jobs, job)
        assert job.state == "partial" and job.failed == 1
        assert_whole(jobs, job)
