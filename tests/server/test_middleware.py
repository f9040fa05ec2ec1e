"""The layers around every route: what they cost, and what they say of a client that leaves."""

from __future__ import annotations

import asyncio
import logging
import time

import pytest
from fastapi import FastAPI
from starlette.responses import Response

from server.middleware import install_middleware
from server.quotas import Quotas
from server.settings import Settings
from server.stopping import Stopping
from server.telemetry import Telemetry
from tests.server.job_api_support import idle_api

TOKENS = "anna:the-token-of-anna-1,bert:the-token-of-bert-2"
MOST = 300e-6
"""Seconds that the layers may add to a request; some 150e-6 of a processor were measured."""


def bare() -> FastAPI:
    app = FastAPI()

    @app.get("/api/v1/x")
    async def x() -> Response:
        return Response(b"{}", media_type="application/json")

    return app


async def seconds_each(app: FastAPI, count: int = 300) -> float:
    """Processor time of one request: the clock on the wall would count other work of the machine too."""
    headers = [(b"host", b"localhost"), (b"authorization", b"Bearer the-token-of-anna-1"), (b"accept", b"*/*")]
    statuses = []

    async def receive():
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message):
        statuses.append(message.get("status"))

    began = time.thread_time()
    for _ in range(count):
        scope = {"type": "http", "method": "GET", "path": "/api/v1/x", "query_string": b"", "root_path": ""}
        await app(scope | {"headers": headers, "client": ("127.0.0.1", 1)}, receive, send)
    took = (time.thread_time() - began) / count
    assert set(statuses) == {200, None}
    return took


def test_they_cost_little():
    settings = Settings(host="0.0.0.0", token=TOKENS, quota_burst=10**9, cors_origins="https://lab.example")
    inside, around = bare(), bare()
    quotas, telemetry = Quotas(settings.quotas), Telemetry()
    install_middleware(around, settings, quotas=quotas, telemetry=telemetry, stopping=Stopping())

    async def best() -> float:
        return min([await seconds_each(around) - await seconds_each(inside) for _ in range(5)])

    assert asyncio.run(best()) < MOST


@pytest.mark.parametrize("path", ["/api/v1/jobs", "/api/v1/simulations:preview", "/api/v1/designs"])
@pytest.mark.parametrize("sent", [b"", b'{"format": '], ids=["nothing sent", "half sent"])
def test_who_leaves_before_all_is_sent_leaves_a_line_and_no_fault(tmp_path, caplog, path, sent):
    parts = iter([{"type": "http.request", "body": sent, "more_body": True}, {"type": "http.disconnect"}])
    answered = []

    async def receive():
        return next(parts)

    async def send(message):
        answered.append(message)

    headers = [(b"host", b"localhost"), (b"content-type", b"application/json"), (b"content-length", b"9000")]
    scope = {"type": "http", "method": "POST", "path": path, "query_string": b"", "root_path": "", "headers": headers}
    with idle_api(tmp_path) as api, caplog.at_level(logging.INFO):
        asyncio.run(api.app(scope | {"client": ("127.0.0.1", 1)}, receive, send))
    assert answered == []
    lines = [record for record in caplog.records if record.name.startswith("server.")]
    assert [(line.name, line.levelname, line.status, line.route) for line in lines] == [
        ("server.requests", "INFO", 499, path)
    ]
