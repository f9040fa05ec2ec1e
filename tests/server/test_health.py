"""The probes: alive at once, ready only where every part can be reached, within a time limit."""

from __future__ import annotations

import asyncio
import json
import threading
import time

import pytest

from server.app import create_app
from server.jobs import engines
from server.jobs.engines import EngineLostError, SerialEngine, UnreachableError
from server.readiness import NotReadyError, Readiness
from server.settings import Settings
from tests.server.job_support import open_at
from tests.server.support import Stopwatch, ask, assert_problem, local_app


def fine() -> None:
    """A check that passes."""


def unreachable() -> None:
    raise ConnectionError("postgresql://user:secret@db/glider cannot be reached")


def paused() -> None:
    raise NotReadyError("the disk is full: 3 MB are left, 100 MB are needed")


def ready_app(**checks):
    app = local_app()
    app.state.readiness = Readiness(limit=0.3)
    for name, check in checks.items():
        app.state.readiness.add(name, check)
    return app


def test_ready_where_every_check_passes():
    answer = ask("GET", "/readyz", app=ready_app(store=fine, engine=fine))
    assert answer.status_code == 200
    assert answer.json() == {"status": "ready", "checks": {"store": "ok", "engine": "ok"}}


def test_what_fails_is_named_and_its_secrets_are_not_told():
    answer = ask("GET", "/readyz", app=ready_app(store=unreachable, engine=fine, disk=paused))
    problem = assert_problem(answer, 503)
    assert problem["detail"] == "not ready: store, disk"
    assert [item["message"] for item in problem["errors"]] == [
        "store: not reachable; the log says more",
        "disk: the disk is full: 3 MB are left, 100 MB are needed",
    ]
    assert "secret" not in answer.text
    assert answer.headers["retry-after"] == "5"


class Lame(SerialEngine):
    """An engine whose check fails."""

    def __init__(self, error):
        super().__init__()
        self.error = error

    def check(self):
        raise self.error


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (EngineLostError("workers cannot be started: no memory"), "engine: workers cannot be started: no memory"),
        (UnreachableError("tcp://10.0.0.1:8786 is not reachable"), "engine: not reachable; the log says more"),
    ],
)
def test_an_engine_that_is_lost_is_told_but_no_address(tmp_path, error, says):
    jobs = open_at(tmp_path, Lame(error))
    app = create_app(Settings(data=tmp_path), jobs=jobs)
    problem = assert_problem(ask("GET", "/readyz", app=app), 503, says="")
    assert [item["message"] for item in problem["errors"]] == [says]
    assert "10.0.0.1" not in json.dumps(problem)
    jobs.stop()


def test_a_pool_that_cannot_start_is_not_ready(tmp_path, monkeypatch):
    def fails():
        raise OSError("no kernel")

    monkeypatch.setattr(engines, "warm_batch", fails)
    jobs = open_at(tmp_path, engines.ProcessEngine(1))
    app = create_app(Settings(data=tmp_path), jobs=jobs)
    assert ask("GET", "/readyz", app=app).status_code == 200, "it starts with the first job"
    with pytest.raises(EngineLostError):
        jobs.manager.engine.submit(len, "x")
    assert_problem(ask("GET", "/readyz", app=app), 503, says="engine: OSError: no kernel")
    jobs.stop()


def test_alive_is_another_question():
    assert ask("GET", "/healthz", app=ready_app(store=unreachable)).json()["status"] == "ok"


def test_a_check_that_hangs_is_told_and_costs_one_thread():
    released, begun = threading.Event(), []

    def hangs() -> None:
        begun.append(time.monotonic())
        released.wait(30.0)

    app = ready_app(store=hangs, engine=fine)
    with Stopwatch(5.0):
        for _ in range(4):
            problem = assert_problem(ask("GET", "/readyz", app=app), 503, says="store: no answer within 0.3 s")
            assert problem["detail"] == "not ready: store"
    assert len(begun) == 1
    assert ask("GET", "/healthz", app=app).status_code == 200
    released.set()
    time.sleep(0.05)
    assert ask("GET", "/readyz", app=app).status_code == 200
    assert len(begun) == 2


def test_many_who_ask_at_once_share_one_check():
    begun = []

    def slow() -> None:
        begun.append(1)
        time.sleep(0.1)

    readiness = Readiness()
    readiness.add("store", slow)

    async def all_at_once():
        return await asyncio.gather(*(readiness.ask() for _ in range(50)))

    assert asyncio.run(all_at_once()) == [{"store": "ok"}] * 50
    assert len(begun) == 1


@pytest.mark.parametrize("path", ["/healthz", "/readyz"])
def test_probes_are_never_kept(path):
    assert ask("GET", path).headers["cache-control"] == "no-store"
