"""Owns one connection to a Dask scheduler, as an executor each of whose futures ends, whatever becomes of it.

Distributed's own executor leaves a future pending for ever where the scheduler dies while a result is fetched. A task
is pickled by distributed and run by its workers with this program installed: that link is trusted, and secured by
Dask's own TLS settings.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from concurrent.futures import Executor, Future, InvalidStateError
from contextlib import suppress
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

log = logging.getLogger(__name__)
CLOSE_WITHIN = 1.0
"""How long a connection may take to close, s."""


class EngineLostError(Exception):
    """Whoever computes cannot be reached; what was sent is to be sent again."""


class DaskExecutor(Executor):
    """Sends work to a cluster. Thread-safe."""

    def __init__(self, address: str, *, within: float) -> None:
        try:
            from distributed import Client
        except ImportError:
            message = "Dask is not installed: install glider-studio[dask], or unset GLIDER_STUDIO_SCHEDULER"
            raise EngineLostError(message) from None
        self._lock = threading.Lock()
        self._pending: set[Future[Any]] = set()
        self._closed = False
        self._loop = _Loop()  # a client leaves a loop that it made itself running where it cannot connect
        client: Any = Client
        try:
            self._client = client(address, timeout=within, set_as_default=False, loop=self._loop.loop)
        except OSError as error:
            self._loop.stop()
            raise EngineLostError(f"the Dask scheduler at {address} does not answer: {error}") from error
        except BaseException:
            self._loop.stop()
            raise

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send work; its future ends with what the work gave or raised, or with `EngineLostError`."""
        self._require_connection()
        sent = self._client.submit(fn, *args, **kwargs, pure=False, retries=0)
        ours: Future[Any] = Future()
        with self._lock:
            if self._closed:
                raise RuntimeError("the connection to the Dask scheduler has been closed")
            self._pending.add(ours)
        ours.add_done_callback(lambda done: self._ended(done, sent))
        self._client.loop.add_callback(self._follow, sent, ours)
        return ours

    async def _follow(self, sent: Any, ours: Future[Any]) -> None:
        """Pass on what becomes of work, in the client's loop: errors but the work's own are of the connection."""
        try:
            [result] = await self._client.gather([sent], asynchronous=True)
        except BaseException as error:
            ended = error if sent.status == "error" else EngineLostError(f"{type(error).__name__}: {error}")
            with suppress(InvalidStateError):  # cancelled, or given up by `_lose`
                ours.set_exception(ended)
        else:
            with suppress(InvalidStateError):
                ours.set_result(result)

    def _ended(self, ours: Future[Any], sent: Any) -> None:
        with self._lock:
            self._pending.discard(ours)
        if ours.cancelled():
            self._client.loop.add_callback(self._client.cancel, [sent], asynchronous=True)

    def _lose(self, why: str) -> None:
        with self._lock:
            pending = list(self._pending)
        for ours in pending:
            with suppress(InvalidStateError):  # it has ended meanwhile
                ours.set_exception(EngineLostError(why))

    def _require_connection(self) -> None:
        """Raise where the connection has broken: the client connects again, but forgets what was sent."""
        if self._client.status != "running":
            self._lose("the connection to the Dask scheduler broke")
            raise EngineLostError(f"the connection to the Dask scheduler broke: the client is {self._client.status}")

    def threads(self, within: float) -> int:
        """Return how many threads the cluster's workers have; raises after `within` seconds without an answer."""
        self._require_connection()
        return sum(self._client.nthreads(callback_timeout=within).values())

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Close the connection; every future that has not ended does so with `EngineLostError`."""
        with self._lock:
            closed, self._closed = self._closed, True
        self._lose("the connection to the Dask scheduler has been closed")
        if closed:
            return
        try:
            self._client.close(timeout=CLOSE_WITHIN)
        except Exception as error:  # it is gone already
            log.info("closing the connection to the Dask scheduler: %s", error)
            self._client.status = "closed"  # else its finalizer tries again, on a loop that has ended
        self._loop.stop()


class _Loop:
    """An event loop in a thread."""

    def __init__(self) -> None:
        self.loop: Any = None
        self._running = threading.Event()
        self._end = asyncio.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._main()), name="dask", daemon=True)
        self._thread.start()
        self._running.wait()

    async def _main(self) -> None:
        from tornado.ioloop import IOLoop

        self.loop = IOLoop.current()
        self._running.set()
        await self._end.wait()

    def stop(self) -> None:
        """End the loop and whatever waits in it."""
        self.loop.add_callback(self._end.set)
        self._thread.join(2 * CLOSE_WITHIN)
