"""Owns a server on a socket of its own for the tests that need one: streams, and clients that know nothing of ASGI."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from fastapi import FastAPI

from studio.serve import Server, uvicorn_config


class Served:
    """A server on loopback, as the program runs it, in a thread."""

    def __init__(self, app: FastAPI, port: int = 0) -> None:
        config = uvicorn_config(app)
        config.port = port
        self._server = Server(config, app.state.stopping)
        self._thread = threading.Thread(target=self._server.run, daemon=True)
        self._thread.start()
        until = time.monotonic() + 30.0
        while not self._server.started:
            assert time.monotonic() < until, "the server did not start"
            time.sleep(0.01)
        self.port = self._server.servers[0].sockets[0].getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"

    def stop(self) -> None:
        """Stop as on the first signal: streams end, then the rest."""
        self._server.should_exit = True
        self._thread.join(30.0)
        assert not self._thread.is_alive()


@contextmanager
def served(app: FastAPI) -> Iterator[Served]:
    server = Served(app)
    try:
        yield server
    finally:
        server.stop()
