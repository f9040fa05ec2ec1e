"""Owns the server's start and stop: settings, the API with the studio on it, one port, the kernel's compilation."""

from __future__ import annotations

import gc
import logging
import os
import signal
import socket
import sys
import threading
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn
from pydantic import ValidationError

from models.warm import SIMULATION_DONE, kernel_is_ready, warm_analyses, warm_kernel
from server.app import create_app, open_store
from server.jobs.opening import open_jobs
from server.logs import configure_logging
from server.settings import Settings, unknown_settings
from server.stopping import Stopping
from studio.exit_codes import DONE, UNUSABLE
from studio.thumbnail import draw_all_presets
from studio.web import create_studio, running

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from types import FrameType

    from fastapi import FastAPI


_log = logging.getLogger(__name__)
GRACE = 3
"""Longest that answers under way may take once the server stops, s."""


def make_app(settings: Settings) -> FastAPI:
    """Return the API with the studio on it."""
    store = open_store(settings)
    jobs = open_jobs(settings, store)
    router, sessions = create_studio(settings, store=store, jobs=jobs)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with running(sessions):
            yield

    app = create_app(settings, live=sessions, store=store, jobs=jobs, lifespan=lifespan)
    app.include_router(router)
    return app


def uvicorn_config(app: FastAPI) -> uvicorn.Config:
    """Return how the app is served: one worker, and websockets without compression, which costs more than it saves."""
    return uvicorn.Config(
        app, log_config=None, log_level="warning", access_log=False, ws="websockets-sansio",
        ws_per_message_deflate=False, timeout_graceful_shutdown=GRACE,
    )  # fmt: skip


class Server(uvicorn.Server):
    """A server that first ends what has no end of its own, then waits a little for the rest."""

    def __init__(self, config: uvicorn.Config, stopping: Stopping) -> None:
        super().__init__(config)
        self._stopping = stopping
        self._asked_by = "itself"

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Stop on the first signal, at once on Ctrl-C after it; being asked to stop is no failure."""
        self.force_exit = self.should_exit and sig == signal.SIGINT
        self.should_exit = True
        self._asked_by = signal.Signals(sig).name

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End event streams and previews, and close what remains."""
        _log.info("stopping, asked by %s; answers under way have %d s", self._asked_by, GRACE)
        self._stopping.begin()
        await super().shutdown(sockets)


def _settings(**given: Any) -> Settings | None:
    try:
        return Settings(**{name: value for name, value in given.items() if value is not None})
    except ValidationError as error:
        for item in error.errors(include_url=False):
            field = (
                "GLIDER_STUDIO_" + "_".join(str(part).upper() for part in item["loc"]) if item["loc"] else "settings"
            )
            print(f"{field}: {item['msg'].removeprefix('Value error, ')}", file=sys.stderr)
        return None


def bind(settings: Settings) -> socket.socket | None:
    """Return the socket that listens where the settings say; None, told on stderr, where that cannot be."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # with the protocol named, else asyncio leaves Nagle's algorithm on, and small answers wait 40 ms for an ACK
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((settings.host.strip("[]"), settings.port))
        listener.listen(128)  # from now on a browser waits instead of being refused
    except OSError as error:
        listener.close()
        print(
            f"cannot listen on {settings.host}:{settings.port}: {error.strerror or error}; "
            "choose another with --port or GLIDER_STUDIO_PORT",
            file=sys.stderr,
        )
        return None
    return listener


def _prepare(app: FastAPI) -> None:
    """Compile the kernel, which is told, or load what an earlier start has compiled, which takes a moment.

    Then what else the first who asks would wait for: pictures of the presets, the document of all operations, and what
    finds trims and modes, which is as long to compile.
    """
    if not SIMULATION_DONE.exists():
        print("Preparing the physics: the first start on a machine compiles it, which takes a while.", flush=True)
    warm_kernel()
    _settle()
    print("The physics is ready.", flush=True)
    draw_all_presets()
    app.openapi()
    warm_analyses()
    print("Trims and modes are ready.", flush=True)


def _settle() -> None:
    """Take all that is loaded by now, which stays, out of the garbage collector's sight.

    It would look through these hundreds of thousands of objects again and again, and stop the whole program meanwhile,
    for a third of a second each time.
    """
    gc.collect()
    gc.freeze()


def serve(*, host: str | None = None, port: int | None = None, data: Path | None = None) -> int:
    """Serve the studio until interrupted; return the exit code."""
    settings = _settings(host=host, port=port, data=data)
    listener = bind(settings) if settings is not None else None
    if settings is None or listener is None:
        return UNUSABLE
    configure_logging(settings.log_format, settings.log_level)
    for warning in unknown_settings(os.environ):
        _log.warning("%s", warning)
    app = make_app(settings)
    shown = f"[{settings.host}]" if ":" in settings.host else settings.host
    print(f"Glider studio is at http://{shown}:{listener.getsockname()[1]}/ (Ctrl-C stops it)", flush=True)
    if kernel_is_ready():
        _settle()
    else:
        threading.Thread(target=_prepare, args=[app], name="warm-up", daemon=True).start()
    Server(uvicorn_config(app), app.state.stopping).run(sockets=[listener])
    return DONE
