"""The stop of the server: whoever waits is told once, and event streams end as answers should."""

from __future__ import annotations

import asyncio

import httpx
from fastapi.responses import StreamingResponse

from server.stopping import Stopping
from tests.server.support import PREVIEW, local_app, preset


def test_listeners_are_told_once_and_one_that_fails_stops_nobody(caplog):
    stopping, told = Stopping(), []
    stopping.on_stop(lambda: told.append("first"))
    stopping.on_stop(lambda: 1 / 0)
    stopping.on_stop(lambda: told.append("last"))
    withdraw = stopping.on_stop(lambda: told.append("withdrawn"))
    withdraw()
    withdraw()
    stopping.begin()
    stopping.begin()
    assert told == ["first", "last"]
    stopping.on_stop(lambda: told.append("late"))
    assert told[-1] == "late"
    assert "ZeroDivisionError" in caplog.text


class Wire:
    """What a client hears of one request, while it is answered."""

    def __init__(self, app, path: str) -> None:
        self.heard: list[dict] = []
        headers = [(b"host", b"localhost")]
        scope = {"type": "http", "method": "GET", "path": path, "query_string": b"", "root_path": ""}
        self.task = asyncio.create_task(app(scope | {"headers": headers}, self._receive, self._send))

    async def _receive(self):
        await asyncio.Event().wait()

    async def _send(self, message) -> None:
        self.heard.append(message)

    async def wait_for(self, count: int) -> None:
        async with asyncio.timeout(5.0):
            while len(self.heard) < count:
                await asyncio.sleep(0.005)


def streaming_app(media_type: str):
    app, left = local_app(), []

    @app.get("/api/v1/stream")
    async def stream() -> StreamingResponse:
        async def events():
            try:
                yield "data: 1\n\n"
                await asyncio.sleep(0.3)
                yield "data: 2\n\n"
                await asyncio.sleep(60.0 if media_type == "text/event-stream" else 0.0)
            finally:
                left.append(1)

        return StreamingResponse(events(), media_type=media_type)

    return app, left


def bodies(wire: Wire) -> list[bytes | None]:
    return [message.get("body") for message in wire.heard]


def test_parts_of_a_stream_are_sent_as_they_come():
    app, _ = streaming_app("text/event-stream")

    async def during() -> None:
        wire = Wire(app, "/api/v1/stream")
        await wire.wait_for(2)
        assert bodies(wire) == [None, b"data: 1\n\n"]
        wire.task.cancel()
        await asyncio.gather(wire.task, return_exceptions=True)

    asyncio.run(during())


def test_an_event_stream_ends_whole():
    app, left = streaming_app("text/event-stream")

    async def during() -> Wire:
        wire = Wire(app, "/api/v1/stream")
        await wire.wait_for(3)
        app.state.stopping.begin()
        async with asyncio.timeout(2.0):
            await wire.task
        late = Wire(app, "/api/v1/stream")
        async with asyncio.timeout(2.0):
            await late.task
        assert late.heard[0]["status"] == 200 and late.heard[-1]["more_body"] is False
        return wire

    wire = asyncio.run(during())
    assert bodies(wire) == [None, b"data: 1\n\n", b"data: 2\n\n", b""]
    assert wire.heard[-1]["more_body"] is False
    assert left, "the generator was closed"


def test_a_download_is_not_cut():
    app, _ = streaming_app("text/csv")

    async def during() -> Wire:
        wire = Wire(app, "/api/v1/stream")
        await wire.wait_for(2)
        app.state.stopping.begin()
        await wire.task
        return wire

    assert bodies(asyncio.run(during())) == [None, b"data: 1\n\n", b"data: 2\n\n", b""]


def test_a_preview_is_stopped_and_answered():
    app = local_app(preview_seconds=60.0, preview_steps=10**9, max_steps=10**9)
    document = preset("canete-dual-bellows")
    document["mission"] |= {"duration": 600_000.0, "initial": {"position": [0.0, 0.0, 9000.0]}}
    document["mission"]["solver"] |= {"method": "rk4", "step": 0.002, "output_interval": 1000.0}

    async def during() -> httpx.Response:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            asked = asyncio.create_task(client.post(PREVIEW, json=document))
            async with asyncio.timeout(10.0):
                while app.state.runner.under_way == 0:
                    await asyncio.sleep(0.005)
            await asyncio.sleep(0.3)
            app.state.stopping.begin()
            async with asyncio.timeout(3.0):
                return await asked

    answer = asyncio.run(during())
    assert (answer.status_code, answer.json()["status"]) == (200, "cancelled"), answer.text[:300]
