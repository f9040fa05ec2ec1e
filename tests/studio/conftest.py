from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from models.design import Design
from models.presets import load_preset
from models.warm import warm_kernel
from server.errors import install_error_handlers
from server.jobs.service import Jobs
from server.running import Runner
from server.settings import Settings
from server.store.designs import DesignStore
from studio.registry import Sessions
from studio.session import Session
from studio.web import create_studio, running


def wait_until(condition: Callable[[], bool], *, timeout: float = 20.0) -> None:
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "the condition did not come true in time"
        time.sleep(0.005)


@pytest.fixture(scope="session")
def kernel() -> None:
    warm_kernel()


@pytest.fixture
def dual_bellows() -> Design:
    return load_preset("canete-dual-bellows")


@pytest.fixture
def session(kernel: None, dual_bellows: Design) -> Iterator[Session]:
    made = Session("a-session-id", dual_bellows)
    wait_until(lambda: not made.simulating)
    yield made
    made.close()


@dataclass
class Studio:
    """A studio that serves on a loopback port."""

    url: str
    sessions: Sessions

    @property
    def client(self) -> httpx.Client:
        return httpx.Client(base_url=self.url, trust_env=False)

    def open(self, preset: str = "canete-dual-bellows") -> tuple[httpx.Client, str]:
        """Return a browser's client with the cookie of a new session, and the session's id."""
        client = self.client
        answer = client.post("/sessions", data={"preset": preset}, headers={"Origin": self.url})
        assert answer.status_code == 303, answer.text
        session_id = answer.headers["location"].split("/")[2]
        client.base_url = httpx.URL(f"{self.url}/s/{session_id}/")
        return client, session_id


def make_app(
    settings: Settings, *, store: DesignStore | None = None, jobs: Jobs | None = None
) -> tuple[FastAPI, Sessions]:
    router, sessions = create_studio(settings, store=store, jobs=jobs)
    app = FastAPI(lifespan=lambda _: running(sessions))
    app.state.runner = Runner()
    install_error_handlers(app)
    app.include_router(router)
    return app, sessions


@contextmanager
def serving(app: FastAPI) -> Iterator[str]:
    """Serve an app on a loopback port; yields its address."""
    config = uvicorn.Config(
        app, port=0, log_level="warning", ws="websockets-sansio", ws_per_message_deflate=False,
        timeout_graceful_shutdown=2,
    )  # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    wait_until(lambda: server.started)
    port = server.servers[0].sockets[0].getsockname()[1]
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        server.should_exit = True
        thread.join(10.0)


@pytest.fixture(scope="module")
def studio(kernel: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    app, sessions = make_app(Settings(data=Path(tmp_path_factory.mktemp("data")), token=None))
    with serving(app) as url:
        yield Studio(url, sessions)
