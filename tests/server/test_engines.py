"""Whoever computes may fail to start, break, or be restarted at any moment: it is told, and the next try works."""

from __future__ import annotations

import errno
import gc
import importlib
import multiprocessing.context
import os
import threading
import time
from concurrent.futures import Executor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import psutil
import pytest

from server.jobs import engines
from server.jobs.engines import DaskEngine, EngineLostError, ProcessEngine, SerialEngine
from tests.server.job_support import wait_for


@pytest.fixture(autouse=True)
def warm(monkeypatch):
    monkeypatch.setattr(engines, "warm_batch", lambda: None)


def nothing_left() -> None:
    """Wait until no worker process is left."""

    def workers() -> list[psutil.Process]:
        children = psutil.Process().children(recursive=True)
        return [c for c in children if c.is_running() and "spawn_main" in " ".join(c.cmdline())]

    def none() -> bool:
        try:
            return not workers()
        except psutil.Error:  # it ended between the two looks
            return False

    wait_for(none, what="the end of the workers", seconds=30.0)


class Stumbling(SerialEngine):
    """An engine whose first start, or first executor, fails."""

    def __init__(self, *, start: Exception | None = None, sending: Exception | None = None) -> None:
        super().__init__()
        self.start, self.sending = start, sending

    def _make(self) -> Executor:
        error, self.start = self.start, None
        if error is not None:
            raise error
        executor = super()._make()
        if self.sending is not None:
            sending, self.sending = self.sending, None
            executor.submit = lambda *_, **__: (_ for _ in ()).throw(sending)
        return executor


ERRORS = [
    (ValueError("no"), "ValueError: no"),
    (OSError(errno.EAGAIN, "no processes"), "BlockingIOError: [Errno 11] no processes"),
    (RuntimeError("can't start new thread"), "RuntimeError: can't start new thread"),
    (BrokenProcessPool("a child died"), "BrokenProcessPool: a child died"),
    (EngineLostError("as it is"), "as it is"),
]


@pytest.mark.parametrize(("error", "says"), ERRORS)
@pytest.mark.parametrize("where", ["start", "sending"])
def test_whatever_fails_before_work_is_sent_is_of_the_engine(where, error, says):
    engine = Stumbling(**{where: error})
    with pytest.raises(EngineLostError) as told:
        engine.submit(len, "x")
    assert str(told.value) == says and engine.lost(told.value)
    engine.restart()
    assert engine.submit(len, "x").result(60) == 1
    engine.stop()


def fail(error):
    raise error


def test_an_error_of_the_work_is_not_the_engine_s():
    engine = SerialEngine()
    for error in (OSError("full"), TimeoutError(), ConnectionError(), BrokenProcessPool("x")):
        assert engine.submit(fail, error).exception(60) is error
        assert not engine.lost(error) and not DaskEngine("tcp://127.0.0.1:9").lost(error)
    engine.stop()


def test_lost_connections_of_a_cluster_are_known():
    from distributed.comm.core import CommClosedError, FatalCommClosedError

    engine = DaskEngine("tcp://127.0.0.1:9")
    for error in (EngineLostError("x"), CommClosedError("x"), FatalCommClosedError("x")):
        assert engine.lost(error)
    assert not ProcessEngine(1).lost(CommClosedError("x"))


class Missing:
    """Cannot be read by a worker: what it is made of is not there."""

    def __call__(self, parent: int) -> None: ...

    def __reduce__(self):
        return importlib.import_module, ("a_module_that_is_not_there",)


def test_workers_that_cannot_start_are_told(monkeypatch, capfd):
    engine = ProcessEngine(2)
    with monkeypatch.context() as patch:
        patch.setattr(engines, "begin_worker", Missing())
        engine.check()
        with pytest.raises(EngineLostError, match=r"^workers cannot be started: BrokenProcessPool: "):
            engine.submit(len, "x")
        nothing_left()
        with pytest.raises(EngineLostError, match=r"^workers cannot be started: BrokenProcessPool: "):
            engine.check()
        patch.setattr(engines, "HELD_AGAINST", 0.0)
        engine.check()  # long ago, and nothing has been tried since
    assert "a_module_that_is_not_there" in capfd.readouterr().err
    assert engine.submit(len, "x").result(60) == 1, "once they can, they do"
    engine.check()
    engine.stop()
    nothing_left()


def test_workers_that_never_start_are_ended(monkeypatch):
    monkeypatch.setattr(engines, "begin_worker", time.sleep)
    monkeypatch.setattr(engines, "START_WITHIN", 0.5)
    engine = ProcessEngine(2)
    with pytest.raises(EngineLostError, match=r"^workers cannot be started: TimeoutError"):
        engine.submit(len, "x")
    nothing_left()


@pytest.mark.parametrize("starts", [0, 1])
def test_too_few_processes_are_told_and_those_there_are_ended(monkeypatch, starts):
    left, start = [starts], multiprocessing.context.SpawnProcess.start

    def begin(process):
        if not left[0]:
            raise OSError(errno.EAGAIN, "no processes")
        left[0] -= 1
        start(process)

    monkeypatch.setattr(multiprocessing.context.SpawnProcess, "start", begin)
    engine = ProcessEngine(2)
    with pytest.raises(EngineLostError, match=r"^workers cannot be started: .*no processes"):
        engine.submit(len, "x")
    nothing_left()


class Dying(SerialEngine):
    """An engine whose executors break with whatever is sent to them, while `die` is set."""

    die = True

    def submit(self, function, /, *arguments):
        return super().submit(fail, BrokenProcessPool("died")) if self.die else super().submit(function, *arguments)


def work_off(engine, count=1):
    """Have one executor do some work, and wait until the engine, too, has heard what became of it."""
    executor = engine._ready()
    for _ in range(count):
        engine.submit(len, "x")
    executor.shutdown(wait=True)
    engine.restart()


def test_workers_that_keep_dying_are_told_until_one_works():
    engine = Dying()
    work_off(engine, count=10)  # all of one executor's work ends with it
    engine.check()
    for _ in range(engines.MOST_DEATHS - 2):
        work_off(engine)
    engine.check()
    work_off(engine)
    with pytest.raises(EngineLostError, match=r"^workers keep dying, 4 times in a row"):
        engine.check()
    engine.die = False
    work_off(engine)
    engine.check()
    engine.stop()


class Slow(SerialEngine):
    """An engine that takes until `go` to start."""

    def __init__(self) -> None:
        super().__init__()
        self.go, self.starting = threading.Event(), threading.Event()
        self.made: list[Executor] = []

    def _make(self) -> Executor:
        self.starting.set()
        assert self.go.wait(30)
        self.made.append(super()._make())
        return self.made[-1]


def test_those_who_come_while_it_starts_wait_for_the_same_start():
    engine = Slow()
    with ThreadPoolExecutor(3) as callers:
        sent = [callers.submit(engine.submit, len, "x") for _ in range(3)]
        assert engine.starting.wait(30)
        engine.go.set()
        assert [future.result(60).result(60) for future in sent] == [1, 1, 1]
    assert len(engine.made) == 1
    engine.stop()


@pytest.mark.parametrize("end", ["restart", "stop"])
def test_a_restart_while_it_starts_ends_what_was_started(end):
    engine = Slow()
    with ThreadPoolExecutor(1) as caller:
        sent = caller.submit(engine.submit, len, "x")
        assert engine.starting.wait(30)
        getattr(engine, end)()
        engine.go.set()
        wait_for(sent.done, what="the first submit")
    with pytest.raises(RuntimeError, match="after shutdown"):
        engine.made[0].submit(len, "x")
    assert engine.submit(len, "x").result(60) == 1 and len(engine.made) == 2
    engine.stop()


def test_a_check_does_not_wait_long_for_a_connection(monkeypatch):
    going, go = threading.Event(), threading.Event()

    def connect(address, *, within):
        going.set()
        assert go.wait(30)
        raise OSError("nobody there")

    monkeypatch.setattr(engines, "DaskExecutor", connect)
    monkeypatch.setattr(engines, "ANSWER_WITHIN", 0.2)
    engine = DaskEngine("tcp://127.0.0.1:9")
    with ThreadPoolExecutor(1) as caller:
        sent = caller.submit(engine.submit, len, "x")
        assert going.wait(30)
        begun = time.monotonic()
        with pytest.raises(EngineLostError, match="still being started"):
            engine.check()
        assert engine.workers == 1
        engine.restart()
        assert time.monotonic() - begun < 10.0
        go.set()
        assert str(sent.exception(60)) == "OSError: nobody there"


def test_restarts_leave_nothing_behind():
    engine = ProcessEngine(1)
    process = psutil.Process()
    assert engine.submit(os.getpid).result(60) != os.getpid()
    threads, files = threading.active_count(), process.num_fds()
    for _ in range(20):
        engine.restart()
        assert engine.submit(len, "x").result(60) == 1

    def settled() -> bool:
        gc.collect()
        return threading.active_count() <= threads and process.num_fds() <= files

    wait_for(settled, what="the end of the former pools", seconds=30.0)
    engine.stop()
    nothing_left()
