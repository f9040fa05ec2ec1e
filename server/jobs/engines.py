"""Owns who computes: this process, spawned processes, or a Dask cluster, all as `concurrent.futures.Executor`."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
import weakref
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, cast

from models.warm import warm_batch
from server.jobs.dask_executor import DaskExecutor, EngineLostError
from server.jobs.worker import THREADS, begin_worker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = [
    "DaskEngine", "Engine", "EngineLostError", "ProcessEngine", "SerialEngine", "UnreachableError", "make_engine",
]  # fmt: skip
START_WITHIN = 60.0
"""How long the first worker process may take to start, s."""
CONNECT_WITHIN = 10.0
"""How long a connection to a Dask scheduler may take, s."""
ANSWER_WITHIN = 2.0
"""How long whoever only asks waits for a scheduler's answer, or for a connection that is being made, s."""
ASK_EVERY = 3.0
"""How often a scheduler is asked how many workers it has, s."""
HELD_AGAINST = 90.0
"""How long a failure of workers counts, s: longer than from one start that fails to the end of the next."""
MOST_DEATHS = 4
"""So many pools that broke one after the other, without a result between, are told: one deadly chunk takes three."""


class UnreachableError(EngineLostError):
    """A scheduler does not answer; the words may hold its address, which is not for everybody."""


class Engine(Protocol):
    """Computes chunks.

    `workers` is how many at once; `blames` says whether an error means that a worker died with a chunk, `lost` whether
    it means that nobody could be reached, and `repeats_by_itself` that a chunk has already been tried elsewhere.
    """

    name: str
    repeats_by_itself: bool

    @property
    def workers(self) -> int:
        """How many chunks are computed at once."""
        ...

    @property
    def known_workers(self) -> int | None:
        """How many chunks could be computed at once a moment ago, None where that is not known; asks nobody."""
        ...

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Send work; raises `EngineLostError`, and nothing else, where it cannot be sent."""
        ...

    def restart(self) -> None:
        """Forget a broken executor; the next `submit` makes a new one."""
        ...

    def blames(self, error: BaseException) -> bool:
        """Whether an error says that the chunk's worker died."""
        ...

    def lost(self, error: BaseException) -> bool:
        """Whether an error is of the way to the workers, not of the chunk, which is to be sent again."""
        ...

    def check(self) -> None:
        """Raise `EngineLostError` where nobody can be reached, or could be lately."""
        ...

    def stop(self) -> None:
        """End the workers that this engine started."""
        ...


class _ExecutorEngine:
    """What all engines share: an executor made when first needed, by the first who asks; others wait for the same."""

    name = ""
    repeats_by_itself = False
    known_workers: int | None = None

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._start: Future[Executor] | None = None
        self._trouble: tuple[float, str] | None = None
        self._deaths = 0
        self._broken: weakref.ref[Executor] | None = None

    def _make(self) -> Executor:
        raise NotImplementedError

    def _ready(self, within: float | None = None) -> Executor:
        """Return the executor, made where there is none; raises `EngineLostError`, also after `within` seconds."""
        with self._lock:
            ours = self._start is None
            start = self._start = self._start or Future()
        if ours:
            try:
                start.set_result(self._make())
                if self._deaths < MOST_DEATHS:
                    self._trouble = None
            except BaseException as error:
                with self._lock:
                    if self._start is start:
                        self._start = None
                lost = _as_lost(error)
                self._trouble = time.monotonic(), str(lost)
                start.set_exception(lost)
                if not isinstance(error, Exception):
                    raise
        try:
            return start.result(within)
        except TimeoutError:
            raise EngineLostError(f"whoever computes is still being started, after {within:g} s more") from None

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Send work."""
        executor = self._ready()
        try:
            sent = executor.submit(function, *arguments)
        except Exception as error:  # broken, shut down by a `restart` meanwhile, no process to be had ...
            raise _as_lost(error) from error
        sent.add_done_callback(lambda done: self._note(executor, done))
        return sent

    def _note(self, executor: Executor, done: Future[Any]) -> None:
        """Count executors that broke, each once though all that was sent there ends; a result begins the count anew."""
        if done.cancelled():
            return
        error = done.exception()
        with self._lock:
            if error is None or not self.blames(error):
                self._trouble, self._deaths = None, 0
            elif self._broken is None or self._broken() is not executor:
                self._broken, self._deaths = weakref.ref(executor), self._deaths + 1
                if self._deaths >= MOST_DEATHS:
                    words = f"workers keep dying, {self._deaths} times in a row; they may need more memory"
                    self._trouble = time.monotonic(), words

    def restart(self) -> None:
        """Forget the executor, also one that is being made."""
        self._forget(_end)

    def _forget(self, end: Callable[[Executor], None]) -> None:
        with self._lock:
            start, self._start = self._start, None
        if start is not None:
            start.add_done_callback(lambda made: end(made.result()) if made.exception() is None else None)

    def blames(self, error: BaseException) -> bool:
        """Whether a worker died."""
        return isinstance(error, BrokenProcessPool)

    def lost(self, error: BaseException) -> bool:
        """Whether nobody could be reached; an `OSError` is the chunk's own."""
        return isinstance(error, EngineLostError)

    def check(self) -> None:
        """Raise `EngineLostError` where workers could lately not be started, or keep dying; tries nothing."""
        trouble = self._trouble
        if trouble is not None and time.monotonic() - trouble[0] < HELD_AGAINST:
            raise EngineLostError(trouble[1])

    def stop(self) -> None:
        """End the workers; what they compute is lost."""
        self.restart()


class SerialEngine(_ExecutorEngine):
    """One chunk after another in a thread of this process."""

    name = "serial"
    workers = known_workers = 1

    def _make(self) -> Executor:
        warm_batch()
        return ThreadPoolExecutor(1, thread_name_prefix="chunk")


class ProcessEngine(_ExecutorEngine):
    """A pool of spawned processes, started once the kernel is compiled; each runs one thread."""

    name = "processes"

    def __init__(self, workers: int | None = None) -> None:
        super().__init__()
        self.workers = self.known_workers = workers or os.cpu_count() or 1

    def _make(self) -> Executor:
        warm_batch()
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(self.workers, context, begin_worker, (os.getpid(),))
        try:
            with _environment(dict.fromkeys(THREADS, "1")):
                # each starts a process, while the environment is set
                started = [pool.submit(os.getpid) for _ in range(self.workers)]
            started[0].result(START_WITHIN)
        except BaseException as error:
            _kill(pool)
            if isinstance(error, BrokenExecutor | OSError):  # a timeout is an OSError, as is a lack of processes
                raise EngineLostError(f"workers cannot be started: {type(error).__name__}: {error}") from error
            raise
        return pool

    def stop(self) -> None:
        """End the processes, also in the middle of their work."""
        self._forget(_kill)


class DaskEngine(_ExecutorEngine):
    """A Dask cluster by the address of its scheduler, as in `tcp://host:8786`."""

    name = "dask"
    repeats_by_itself = True

    def __init__(self, address: str, *, within: float = CONNECT_WITHIN) -> None:
        super().__init__()
        self.address, self._within = address, within
        self._threads, self._ask_after = 0, 0.0

    def _make(self) -> Executor:
        return DaskExecutor(self.address, within=self._within)

    @property
    def workers(self) -> int:
        """How many threads the cluster's workers had a moment ago, at least 1; asks at most every few seconds."""
        start = self._start
        if start is not None and start.done() and time.monotonic() >= self._ask_after:
            try:
                self._ask(start.result())
            except Exception:  # it is being closed, or whatever distributed raises while its connection comes and goes
                pass
        return max(1, self._threads)

    def _ask(self, executor: Executor) -> int:
        self._ask_after = time.monotonic() + ASK_EVERY  # others do not ask meanwhile
        self._threads = self.known_workers = cast("DaskExecutor", executor).threads(ANSWER_WITHIN)
        return self._threads

    def _forget(self, end: Callable[[Executor], None]) -> None:
        self.known_workers = None
        super()._forget(end)

    def blames(self, error: BaseException) -> bool:
        """Whether the scheduler gave a chunk up because its workers died."""
        return type(error).__name__ == "KilledWorker"

    def lost(self, error: BaseException) -> bool:
        """Whether the connection broke: ours, or one within the cluster."""
        return super().lost(error) or any(kind.__name__ == "CommClosedError" for kind in type(error).__mro__)

    def check(self) -> None:
        """Raise `EngineLostError` where the scheduler cannot be reached or has no worker."""
        try:
            executor = self._ready(ANSWER_WITHIN)
        except EngineLostError as error:
            raise UnreachableError(str(error)) from error
        try:
            threads = self._ask(executor)
        except Exception as error:
            raise UnreachableError(f"the Dask scheduler at {self.address} is not reachable: {error}") from error
        if not threads:
            raise EngineLostError("the Dask scheduler has no workers: start some")


def _as_lost(error: BaseException) -> EngineLostError:
    return error if isinstance(error, EngineLostError) else EngineLostError(f"{type(error).__name__}: {error}")


def _end(executor: Executor) -> None:
    executor.shutdown(wait=False, cancel_futures=True)


def _kill(executor: Executor) -> None:
    """End a pool and its processes: one that could not start has nobody else to end them."""
    processes = list((getattr(executor, "_processes", None) or {}).values())
    _end(executor)
    for process in processes:
        process.terminate()


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set variables that new processes inherit, for a moment."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def make_engine(scheduler: str | None, *, workers: int | None = None) -> Engine:
    """Return the Dask engine where a scheduler is named, else a pool of processes."""
    return DaskEngine(scheduler) if scheduler else ProcessEngine(workers)
