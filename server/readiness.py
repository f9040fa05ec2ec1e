"""Owns the checks that say whether the program can work: each named, each with a time limit. It knows no HTTP."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future

from server.jobs.engines import Engine, EngineLostError, UnreachableError

LIMIT = 2.0
"""Longest that a check may take, s."""
OK = "ok"
_log = logging.getLogger(__name__)


class NotReadyError(Exception):
    """What a check raises to say, in words that anybody may read, what is missing."""


def engine_check(engine: Engine) -> Callable[[], None]:
    """Return the check of who computes; why workers are missing is told, but no address of a scheduler."""

    def check() -> None:
        try:
            engine.check()
        except UnreachableError:
            raise
        except EngineLostError as error:
            raise NotReadyError(str(error)) from error

    return check


class Readiness:
    """The checks of one application.

    A check runs in a thread of its own, one at a time: one that hangs costs a thread, however often it is asked for,
    and never holds up the server or its end.
    """

    def __init__(self, *, limit: float = LIMIT) -> None:
        self._limit = limit
        self._checks: dict[str, Callable[[], None]] = {}
        self._running: dict[str, Future[str]] = {}

    def add(self, name: str, check: Callable[[], None]) -> None:
        """Add a check that raises where its part is not ready; only a `NotReadyError` is told in its own words."""
        self._checks[name] = check

    async def ask(self) -> dict[str, str]:
        """Return `ok`, or what is wrong, by the name of each check."""
        states = await asyncio.gather(*(self._ask(name) for name in self._checks))
        return dict(zip(self._checks, states, strict=True))

    async def _ask(self, name: str) -> str:
        future = self._running.get(name)
        if future is None or future.done():
            future = self._running[name] = Future()
            future.set_running_or_notify_cancel()  # who waits may give up; the check goes on
            arguments = (name, self._checks[name], future)
            threading.Thread(target=_run, args=arguments, name=f"check-{name}", daemon=True).start()
        try:
            return await asyncio.wait_for(asyncio.wrap_future(future), self._limit)
        except TimeoutError:
            return f"no answer within {self._limit:g} s"


def _run(name: str, check: Callable[[], None], future: Future[str]) -> None:
    try:
        check()
    except NotReadyError as error:
        future.set_result(str(error))
    except Exception as error:
        # the words of a driver's error may hold addresses and passwords
        _log.warning("the check '%s' failed", name, exc_info=error)
        future.set_result("not reachable; the log says more")
    else:
        future.set_result(OK)
