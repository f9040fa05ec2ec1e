"""Owns the running of simulations beside the event loop: few at a time, and stopped when nobody waits any more."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from typing import TypeVar

import anyio.to_thread
from fastapi import Request

from models.simulate import Control

AnswerT = TypeVar("AnswerT")


class Runner:
    """Runs at most one simulation a processor, and knows those that are under way."""

    def __init__(self) -> None:
        self._limiter = anyio.CapacityLimiter(max(2, os.cpu_count() or 1))
        self._controls: set[Control] = set()

    @property
    def under_way(self) -> int:
        """How many runs compute, or wait for a processor."""
        return len(self._controls)

    def cancel_all(self) -> None:
        """Stop every run that is under way."""
        for control in tuple(self._controls):
            control.cancel()

    async def run(self, request: Request, work: Callable[[Control], AnswerT]) -> AnswerT:
        """Return `work(control)`, done in a thread; the control is cancelled when the client leaves."""
        control = Control()
        self._controls.add(control)
        watcher = asyncio.create_task(_cancel_when_gone(request, control))
        try:
            return await anyio.to_thread.run_sync(work, control, abandon_on_cancel=True, limiter=self._limiter)
        finally:
            control.cancel()
            watcher.cancel()
            self._controls.discard(control)


async def _cancel_when_gone(request: Request, control: Control) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
    control.cancel()
