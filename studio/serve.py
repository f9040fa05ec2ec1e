"""Owns the start of the server: settings, the API with the studio on it, one port, and the kernel's compilation."""

from __future__ import annotations

import logging
import socket
import sys
import threading
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn
from pydantic import ValidationError

from models.warm import kernel_is_ready, warm_kernel
from server.app import create_app
from server.settings import Settings
from studio.exit_codes import DONE, UNUSABLE
from studio.web import create_studio, running

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from fastapi import FastAPI


def make_app(settings: Settings) -> FastAPI:
    """Return the API with the studio on it."""
    router, sessions = create_studio(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with running(sessions):
            yield

    app = create_app(settings, live=sessions, lifespan=lifespan)
    app.include_router(router)
    return app


def uvicorn_config(app: FastAPI) -> uvicorn.Config:
    """Return how the app is served: one worker, and websockets without compression, which costs more than it saves."""
    return uvicorn.Config(
        app, log_level="warning", ws="websockets-sansio", ws_per_message_deflate=False, timeout_graceful_shutdown=3
    )


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


def _bind(settings: Settings) -> socket.socket | None:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family)
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


def _announce_kernel() -> None:
    print("Preparing the physics: the first start on a machine compiles it, which takes a while.", flush=True)
    warm_kernel()
    print("The physics is ready.", flush=True)


def serve(*, host: str | None = None, port: int | None = None, data: Path | None = None) -> int:
    """Serve the studio until interrupted; return the exit code."""
    settings = _settings(host=host, port=port, data=data)
    listener = _bind(settings) if settings is not None else None
    if settings is None or listener is None:
        return UNUSABLE
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    app = make_app(settings)
    shown = f"[{settings.host}]" if ":" in settings.host else settings.host
    print(f"Glider studio is at http://{shown}:{listener.getsockname()[1]}/ (Ctrl-C stops it)", flush=True)
    if not kernel_is_ready():
        threading.Thread(target=_announce_kernel, name="kernel-warm-up", daemon=True).start()
    uvicorn.Server(uvicorn_config(app)).run(sockets=[listener])
    return DONE
