"""The news of jobs: told at once and after every change, to many at little cost, until all is told."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from contextlib import ExitStack, suppress

import httpx
import pytest

from server.app import create_app
from server.job_events import JobEvents, News
from server.settings import Settings
from server.store.errors import NotFoundError, UnavailableError
from tests.server.job_support import open_at, running, sweep, wait_for
from tests.server.serving import Served, served
from tests.server.support import ask, assert_problem

SOON = 5.0
"""Seconds within which what happens several times a second is seen, on a busy machine."""


class Source:
    """A store of jobs that counts how often it is asked."""

    def __init__(self, **sequences: int) -> None:
        self.now, self.asked, self.read = dict(sequences), 0, 0
        self.over: set[str] = set()
        self.down = False

    def sequences(self, job_ids):
        self.asked += 1
        if self.down:
            raise UnavailableError("it does not answer")
        return {job_id: self.now[job_id] for job_id in job_ids if job_id in self.now}

    def news(self, job_id):
        self.read += 1
        if job_id not in self.now:
            raise NotFoundError(f"there is no job {job_id}")
        return News(self.now[job_id], json.dumps({"n": self.now[job_id]}), job_id in self.over)

    def end(self, job_id):
        self.over.add(job_id)
        self.now[job_id] += 1

    def events(self) -> JobEvents:
        return JobEvents(self.sequences, self.news)


async def heard(events, job_id, seen=None):
    with events.listening(job_id, seen) as listener:
        return [news.sequence async for news in until_none(listener)]


async def until_none(listener):
    while (news := await listener.next()) is not None:
        yield news


def within(seconds, coroutine):
    return asyncio.run(asyncio.wait_for(coroutine, seconds))


def test_the_first_news_come_at_once_and_the_last_ends_it():
    source = Source(a=3)
    events = source.events()

    async def scenario():
        with events.listening("a") as listener:
            began = time.perf_counter()
            first = await listener.next()
            assert time.perf_counter() - began < 0.2  # less than a round
            source.now["a"] = 4
            second = await listener.next()
            source.end("a")
            last = await listener.next()
            return [first, second, last, await listener.next()]

    told = within(SOON, scenario())
    assert [news and news.sequence for news in told] == [3, 4, 5, None]
    assert events.listeners == 0 and events._poller is None


def test_what_was_seen_is_not_told_again():
    source = Source(a=3)
    events = source.events()

    async def scenario():
        task = asyncio.create_task(heard(events, "a", seen=3))
        await asyncio.sleep(0.6)
        assert not task.done()
        source.end("a")
        return await task

    assert within(SOON, scenario()) == [4]
    assert within(SOON, heard(events, "a", seen=4)) == []


def test_a_job_that_goes_away_ends_the_listening():
    source = Source(a=1)
    events = source.events()

    async def scenario():
        task = asyncio.create_task(heard(events, "a"))
        await asyncio.sleep(0.1)
        del source.now["a"]
        return await task

    assert within(SOON, scenario()) == [1]
    assert within(SOON, heard(events, "never")) == []


def test_a_store_that_is_down_is_asked_again(caplog):
    source = Source(a=1)
    source.down = True
    events = source.events()

    async def scenario():
        task = asyncio.create_task(heard(events, "a"))
        await asyncio.sleep(0.1)
        source.down = False
        source.over.add("a")
        return await task

    assert within(SOON, scenario()) == [1]
    assert "cannot be seen now" in caplog.text


def test_two_hundred_listeners_cost_what_one_does():
    """The store is asked by one poller, and a record is written once for all."""
    source = Source(a=1, b=1)
    events = source.events()

    async def scenario():
        tasks = [asyncio.create_task(heard(events, "ab"[k % 2])) for k in range(200)]
        await asyncio.sleep(0.1)
        assert events.listeners == 200
        spent, began = time.process_time(), time.perf_counter()
        await asyncio.sleep(1.0)
        rounds = (time.perf_counter() - began) / 0.25
        idle = time.process_time() - spent
        asked = source.asked
        source.end("a")
        source.end("b")
        return await asyncio.gather(*tasks), rounds, asked, idle

    told, rounds, asked, idle = within(30.0, scenario())
    assert told == [[1, 2]] * 200
    assert asked <= rounds + 3 and source.read == 4
    # waiting listeners take no processor time: four looks a second take some milliseconds
    assert idle < 0.2
    assert events.listeners == 0


def test_who_leaves_is_forgotten():
    source = Source(a=1)
    events = source.events()

    async def scenario():
        task = asyncio.create_task(heard(events, "a"))
        await asyncio.sleep(0.1)
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
        assert events.listeners == 0
        asked = source.asked
        await asyncio.sleep(0.6)
        return source.asked - asked

    assert within(SOON, scenario()) == 0


# over a socket


@pytest.fixture
def jobs(tmp_path):
    return open_at(tmp_path)


def make_app(jobs):
    return create_app(Settings(host="127.0.0.1", token=None), jobs=jobs)


def read_events(answer):
    """Yield each event of a stream as a dict of its fields; comments as `comment`."""
    fields = {}
    for line in answer.iter_lines():
        if line:
            name, _, value = line.partition(":")
            fields[name or "comment"] = value.removeprefix(" ")
        elif fields:
            yield fields
            fields = {}


def test_a_job_is_followed_to_its_end_and_from_where_one_was(jobs):
    job, _ = jobs.submit(sweep(8))
    path = f"/api/v1/jobs/{job.id}/events"
    with served(make_app(jobs)) as server:
        with httpx.stream("GET", server.url + path, timeout=60.0) as answer:
            assert answer.headers["content-type"].startswith("text/event-stream")
            events = list(read_events(answer))
        ids = [int(event["id"]) for event in events]
        records = [json.loads(event["data"]) for event in events]
        assert {event["event"] for event in events} == {"job"} and ids == sorted(set(ids))
        assert records[-1]["state"] == "succeeded" and records[-1]["progress"]["done"] == 8
        assert all(record["state"] != "succeeded" for record in records[:-1])
        answer = httpx.get(server.url + path, headers={"Last-Event-ID": str(jobs.store.get(job.id).sequence)})
        assert answer.status_code == 200 and answer.text == ""
        for odd in ("x", "9" * 30, "-1", "²"):
            answer = httpx.get(server.url + path, headers={"Last-Event-ID": odd.encode()})
            assert answer.text.count("event: job") == 1


def test_a_stream_says_something_while_nothing_happens(jobs, monkeypatch):
    monkeypatch.setattr("fastapi.routing._PING_INTERVAL", 0.1)
    job, _ = jobs.submit(sweep(2))
    jobs.start = lambda: None  # nobody works on it
    with served(make_app(jobs)) as server:
        with httpx.stream("GET", f"{server.url}/api/v1/jobs/{job.id}/events", timeout=10.0) as answer:
            events = read_events(answer)
            assert "data" in next(events) and "comment" in next(events) and "comment" in next(events)


def test_listeners_that_leave_are_forgotten_and_a_stop_ends_the_rest(jobs):
    job, _ = jobs.submit(sweep(2))
    jobs.start = lambda: None
    app = make_app(jobs)
    server = Served(app)
    url = f"{server.url}/api/v1/jobs/{job.id}/events"
    rest: list[str] = []
    with ExitStack() as stack:
        with httpx.Client(timeout=30.0, limits=httpx.Limits(max_connections=None)) as client:
            answers = [stack.enter_context(client.stream("GET", url)) for _ in range(20)]
            streams = [read_events(answer) for answer in answers]
            assert all("data" in next(stream) for stream in streams)
            assert app.state.job_events.listeners == 20
            for answer in answers[1:]:
                answer.close()
            wait_for(lambda: app.state.job_events.listeners == 1, what="the leaving", seconds=SOON)
            reader = threading.Thread(target=lambda: rest.extend(streams[0]))
            reader.start()
            server.stop()  # the server's own loop calls those who wait for the stop
            reader.join(SOON)
            assert not reader.is_alive() and rest == []
    assert app.state.job_events.listeners == 0


def test_jobs_of_another_process_are_seen_too(jobs, tmp_path):
    job, _ = jobs.submit(sweep(4))
    jobs.start = lambda: None
    with served(make_app(jobs)) as server:
        with httpx.stream("GET", f"{server.url}/api/v1/jobs/{job.id}/events", timeout=60.0) as answer:
            states = (json.loads(event["data"])["state"] for event in read_events(answer))
            assert next(states) == "queued"
            with running(open_at(tmp_path)):
                assert list(states)[-1] == "succeeded"


def test_no_stream_begins_for_a_job_that_is_not_there(jobs):
    answer = ask("GET", f"/api/v1/jobs/{'0' * 26}/events", app=make_app(jobs))
    assert_problem(answer, 404, says="there is no job")
