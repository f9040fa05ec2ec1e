"""Owns who computes: this process, spawned processes, or a Dask cluster, all as `concurrent.futures.Executor`.

A task sent to Dask is pickled by distributed and run by its workers with this program installed: that link is trusted,
and secured by Dask's own TLS settings.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import threading
from collections.abc import Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from models.warm import warm_batch
from server.jobs.worker import THREADS, begin_worker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

log = logging.getLogger(__name__)
CONNECT_WITHIN = 10.0
"""How long a connection to a Dask scheduler may take, s."""


class EngineLostError(Exception):
    """Whoever computes cannot be reached; what was sent is to be sent again."""


class Engine(Protocol):
    """Computes chunks.

    `workers` is how many at once; `blames` says whether an error means that a worker died with a chunk, and
    `repeats_by_itself` that it has already been tried elsewhere.
    """

    name: str
    repeats_by_itself: bool

    @property
    def workers(self) -> int:
        """How many chunks are computed at once."""
        ...

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Send work; raises `EngineLostError` where nobody can be reached."""
        ...

    def restart(self) -> None:
        """Forget a broken executor; the next `submit` makes a new one."""
        ...

    def blames(self, error: BaseException) -> bool:
        """Whether an error says that the chunk's worker died."""
        ...

    def check(self) -> None:
        """Raise `EngineLostError` where nobody can be reached."""
        ...

    def stop(self) -> None:
        """End the workers that this engine started."""
        ...


class _ExecutorEngine:
    """What all engines share: an executor made when first needed."""

    name = ""
    repeats_by_itself = False

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._executor: Executor | None = None

    def _make(self) -> Executor:
        raise NotImplementedError

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Send work."""
        with self._lock:
            if self._executor is None:
                self._executor = self._make()
            try:
                return self._executor.submit(function, *arguments)
            except (RuntimeError, OSError) as error:
                raise EngineLostError(str(error)) from error

    def restart(self) -> None:
        """Forget the executor."""
        with self._lock:
            executor, self._executor = self._executor, None
        if executor is not None:
            executor.shutdown(wait=False, cancel_futures=True)

    def blames(self, error: BaseException) -> bool:
        """Whether a worker died."""
        return isinstance(error, BrokenProcessPool)

    def check(self) -> None:
        """Nothing that could be out of reach."""

    def stop(self) -> None:
        """End the workers; what they compute is lost."""
        self.restart()


class SerialEngine(_ExecutorEngine):
    """One chunk after another in a thread of this process."""

    name = "serial"
    workers = 1

    def _make(self) -> Executor:
        warm_batch()
        return ThreadPoolExecutor(1, thread_name_prefix="chunk")


class ProcessEngine(_ExecutorEngine):
    """A pool of spawned processes, started once the kernel is compiled; each runs one thread."""

    name = "processes"

    def __init__(self, workers: int | None = None) -> None:
        super().__init__()
        self.workers = workers or os.cpu_count() or 1

    def _make(self) -> Executor:
        warm_batch()
        context = multiprocessing.get_context("spawn")
        with _environment(dict.fromkeys(THREADS, "1")):
            pool = ProcessPoolExecutor(self.workers, context, begin_worker, (os.getpid(),))
            for _ in range(self.workers):  # each starts a process, while the environment is set
                pool.submit(os.getpid)
        return pool

    def stop(self) -> None:
        """End the processes, also in the middle of their work."""
        with self._lock:
            executor, self._executor = self._executor, None
        if isinstance(executor, ProcessPoolExecutor):
            processes = list((executor._processes or {}).values())
            executor.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()


class DaskEngine(_ExecutorEngine):
    """A Dask cluster by the address of its scheduler, as in `tcp://host:8786`."""

    name = "dask"
    repeats_by_itself = True

    def __init__(self, address: str, *, within: float = CONNECT_WITHIN) -> None:
        super().__init__()
        self.address, self._within = address, within
        self._client: Any = None

    def _make(self) -> Executor:
        self._client = self._connected()
        executor: Executor = self._client.get_executor(pure=False, retries=0)
        return executor

    def _connected(self) -> Any:
        try:
            from distributed import Client
        except ImportError:
            message = "Dask is not installed: install glider-studio[dask], or unset GLIDER_STUDIO_SCHEDULER"
            raise EngineLostError(message) from None
        try:
            client: Any = Client
            return client(self.address, timeout=self._within, set_as_default=False)
        except (OSError, TimeoutError) as error:
            raise EngineLostError(f"the Dask scheduler at {self.address} does not answer: {error}") from error

    @property
    def workers(self) -> int:
        """How many threads the cluster's workers have now, at least 1."""
        try:
            client = self._client
            return max(1, sum(client.nthreads().values())) if client is not None else 1
        except Exception:  # whatever distributed raises while its connection comes and goes
            return 1

    def restart(self) -> None:
        """Close the connection."""
        with self._lock:
            client, self._client, self._executor = self._client, None, None
        if client is not None:
            try:
                client.close(timeout=1.0)
            except Exception as error:  # it is gone already
                log.info("closing the connection to the Dask scheduler: %s", error)

    def blames(self, error: BaseException) -> bool:
        """Whether the scheduler gave a chunk up because its workers died."""
        return type(error).__name__ == "KilledWorker"

    def check(self) -> None:
        """Raise `EngineLostError` where the scheduler cannot be reached or has no worker."""
        with self._lock:
            if self._executor is None:
                self._executor = self._make()
            client = self._client
        if client.status != "running" or not client.scheduler_info()["workers"]:
            raise EngineLostError(f"the Dask scheduler at {self.address} is not reachable or has no workers")


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
