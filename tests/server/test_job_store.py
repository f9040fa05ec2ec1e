"""The keeping of jobs says the same on SQLite and on PostgreSQL, whoever asks at once."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from server.jobs.engines import SerialEngine
from server.jobs.service import Jobs
from server.store.errors import NotFoundError
from server.store.identifiers import new_id
from server.store.job_records import JobStateError, KeyReusedError, NewJob
from server.store.jobs import JobStore
from tests.server.job_support import assert_whole, finished, running, sweep

CHUNK = {"cases": 4, "failures": {}, "seconds": 1.0, "processor": "x", "rate": 2.0}


def job(name="a job", *, key=None, digest="one", checksum=None, cases=40):
    return NewJob(
        id=new_id(), kind="sweep", name=name, spec="{}", about="{}", checksum=checksum or new_id(), principal="ann",
        idempotency_key=key, request_digest=digest, cases=cases, chunk_size=4,
    )  # fmt: skip


@pytest.fixture
def kept(database) -> JobStore:
    return JobStore(database)


def test_a_whole_job_runs_on_either(database, tmp_path):
    with running(Jobs(database, SerialEngine(), tmp_path / "jobs")) as jobs:
        done = finished(jobs, jobs.submit(sweep(9))[0])
        assert done.state == "succeeded" and done.processors
        assert_whole(jobs, done)
        assert jobs.submit(sweep(9))[0].id == done.id


def test_a_chunk_counts_once_and_for_its_owner_only(kept):
    first, _ = kept.add(job())
    [mine] = kept.claim("me", 60.0, most=5)
    assert mine.id == first.id and kept.claim("you", 60.0, most=5) == []
    failures = {"diverged": (2, 5), "refused: x": (1, 7)}
    assert kept.count_chunk(first.id, "me", 1, **CHUNK | {"failures": failures})
    assert not kept.count_chunk(first.id, "me", 1, **CHUNK)
    assert not kept.count_chunk(first.id, "you", 2, **CHUNK)
    assert kept.count_chunk(first.id, "me", 0, **CHUNK | {"failures": {"diverged": (1, 3)}, "processor": "y"})
    now = kept.get(first.id)
    assert (now.done, now.failed, now.chunks_done, now.processors) == (8, 4, 2, "x\ny")
    assert kept.written(first.id) == {0, 1}
    found = kept.failures([first.id])[first.id]
    assert [(f.reason, f.count, f.case) for f in found] == [("diverged", 3, 3), ("refused: x", 1, 7)]


def test_many_claim_and_each_job_has_one_owner(kept):
    ids = {kept.add(job(str(k)))[0].id for k in range(12)}
    barrier = threading.Barrier(4)

    def claim(owner):
        barrier.wait()
        return [taken.id for _ in range(12) for taken in kept.claim(owner, 60.0, most=1)]

    with ThreadPoolExecutor(4) as pool:
        taken = [job_id for found in pool.map(claim, "abcd") for job_id in found]
    assert sorted(taken) == sorted(ids)


def test_a_key_makes_one_job_of_many_requests_at_once(kept):
    barrier = threading.Barrier(6)

    def submit(_):
        barrier.wait()
        return kept.add(job(key="k"), reuse=False)

    with ThreadPoolExecutor(6) as pool:
        answers = list(pool.map(submit, range(6)))
    assert len({found.id for found, _ in answers}) == 1 and sum(new for _, new in answers) == 1
    with pytest.raises(KeyReusedError):
        kept.add(job(key="k", digest="another"))


def test_equal_requests_at_once_make_one_job(kept):
    """Each is new, without a key, and finds nothing at first: only the one that is kept is counted by the quotas."""
    barrier, counted = threading.Barrier(8), []

    def submit(_):
        barrier.wait()
        return kept.add(job(checksum="c" * 64), admit=counted.append)

    kept.counts()  # the database is opened
    for _ in range(5):
        with ThreadPoolExecutor(8) as pool:
            answers = list(pool.map(submit, range(8)))
        assert len({found.id for found, _ in answers}) == 1 and sum(new for _, new in answers) == 1
        assert counted == [40]
        counted.clear()
        only = answers[0][0].id
        kept.cancel(only)
        kept.remove(only)


def test_a_request_that_is_not_admitted_leaves_nothing(kept):
    def refuse(cases):
        raise ValueError(f"{cases} are too many")

    with pytest.raises(ValueError, match="40 are too many"):
        kept.add(job(), admit=refuse)
    assert kept.page() == []


def test_retried_chunks_no_longer_count_and_nobody_takes_the_job_before_it_is_released(kept):
    one, _ = kept.add(job())
    kept.claim("me", 60.0, most=1)
    for chunk, failures in enumerate([{}, {"diverged": (2, 5)}, {}]):
        kept.count_chunk(one.id, "me", chunk, **CHUNK | {"failures": failures})
    kept.settle(one.id, "me", state="partial")
    now, dropped = kept.retry(one.id, holder="deletes files", lease=60.0)
    assert (now.state, now.done, now.failed, dropped) == ("queued", 8, 0, [1])
    assert kept.claim("me", 60.0, most=1) == []
    kept.release("deletes files")
    assert [taken.id for taken in kept.claim("me", 60.0, most=1)] == [one.id]


def test_why_jobs_wait_is_kept_until_they_go_on(kept):
    one, other = kept.add(job())[0], kept.add(job())[0]
    kept.claim("me", 60.0, most=1)
    before = kept.get(one.id).sequence
    for _ in range(3):
        kept.explain("me", "waiting for workers")
    told = kept.get(one.id)
    assert (told.reason, told.sequence) == ("waiting for workers", before + 1), "told once"
    assert kept.get(other.id).reason is None
    kept.explain("me", None)
    assert kept.get(one.id).reason is None
    for end in (lambda: kept.release("me"), lambda: kept.settle(one.id, "me", state="cancelled")):
        kept.explain("me", "waiting for workers")
        end()
        assert kept.get(one.id).reason is None
        kept.claim("me", 60.0, most=1)


def test_names_are_found_in_either_case_whatever_their_letters(kept):
    for name in ("Ärger", "ÅNGSTRÖM 50_%/x", "Жизнь", "plain"):
        kept.add(job(name))
    for search, name in (
        ("Ärger", "Ärger"), ("ärger", "Ärger"), ("ÄRG", "Ärger"), ("ngström", "ÅNGSTRÖM 50_%/x"),
        ("0_%/X", "ÅNGSTRÖM 50_%/x"), ("жизНЬ", "Жизнь"), ("PLAIN", "plain"),
    ):  # fmt: skip
        assert [found.name for found in kept.page(search=search)] == [name], search
    assert kept.page(search="Arger") == [] and kept.page(search="5%") == []


def test_states_follow_each_other(kept):
    one, _ = kept.add(job())
    kept.claim("me", 60.0, most=1)
    kept.begin(one.id, "me")
    assert kept.get(one.id).state == "running" and kept.renew("me", 60.0) == {one.id: False}
    assert kept.cancel(one.id).state == "cancelling" and kept.renew("me", 60.0) == {one.id: True}
    kept.settle(one.id, "me", state="cancelled")
    over = kept.get(one.id)
    assert (over.state, over.owner) == ("cancelled", None) and over.finished is not None
    with pytest.raises(JobStateError, match="over"):
        kept.cancel(one.id)
    assert kept.retry(one.id)[0].state == "queued"
    kept.claim("me", 60.0, most=1)
    kept.pause(one.id, "me", "the disk is full")
    assert (kept.get(one.id).state, kept.get(one.id).reason) == ("paused", "the disk is full")
    assert kept.resume(one.id).state == "queued"
    with pytest.raises(JobStateError, match="cancel it first"):
        kept.remove(one.id)
    kept.cancel(one.id)
    kept.remove(one.id)
    with pytest.raises(NotFoundError):
        kept.get(one.id)


def test_pages_hold_every_job_once_newest_first(kept):
    names = [f"Job {k} of 100 %" if k % 2 else f"another_{k}" for k in range(25)]
    ids = [kept.add(job(name))[0].id for name in names]
    seen, before = [], None
    while page := kept.page(before=before, limit=7):
        seen += page
        before = (page[-1].created, page[-1].id)
    assert [j.id for j in seen] == ids[::-1]
    assert len(kept.page(search="100 %", limit=100)) == 12 and len(kept.page(search="R_1", limit=100)) == 5
    assert kept.page(states=["running"]) == [] and kept.counts()["queued"] == 25
