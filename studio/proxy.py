"""Owns the way from a browser to its session's Viser server: the client's page and the websocket behind it."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from pathlib import Path

import viser
import websockets
from fastapi import APIRouter, HTTPException, Request, Response, WebSocket
from fastapi.responses import FileResponse
from starlette.concurrency import run_in_threadpool
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

from server.access import is_same_origin
from studio import guard
from studio.access import Admitted, find_session, open_sessions, viewer_headers
from studio.registry import OpenSession

log = logging.getLogger(__name__)
router = APIRouter(include_in_schema=False)

CLIENT_PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
REFUSED_PARAMETERS = frozenset({"websocket", "playbackPath"})
"""These would let a foreign server run its scripts on our origin."""
GONE = (WebSocketDisconnect, websockets.ConnectionClosed, RuntimeError)


@router.get("/s/{session_id}/view/")
def viewer_page(opened: Admitted, request: Request) -> Response:
    """Answer Viser's own client; it finds its websocket by its own address."""
    refused = REFUSED_PARAMETERS & set(request.query_params)
    if refused:
        raise HTTPException(400, f"the parameter '{min(refused)}' is not allowed here")
    headers = viewer_headers(request.headers.get("host", ""))
    return FileResponse(CLIENT_PAGE, media_type="text/html", headers=headers)


@router.websocket("/s/{session_id}/view")
async def viewer_socket(browser: WebSocket, session_id: str) -> None:
    """Pass messages between a browser and its session's Viser server; to anybody else answer 403."""
    opened = None
    if is_same_origin(browser, required=True):
        opened = await run_in_threadpool(find_session, open_sessions(browser), browser, session_id)
    if opened is None:
        await browser.close(1008)  # before it is accepted: the browser sees 403
        return
    opened.connections += 1
    try:
        await _serve(browser, opened)
    finally:
        opened.connections -= 1
        opened.touch()


async def _serve(browser: WebSocket, opened: OpenSession) -> None:
    view = await run_in_threadpool(opened.view)
    protocols = [Subprotocol(p) for p in browser.scope.get("subprotocols", []) if p.startswith("viser-v")]
    try:
        upstream = await connect(
            f"ws://127.0.0.1:{view.server.get_port()}/", subprotocols=protocols or None, compression=None,
            max_size=None, max_queue=64, ping_interval=None, open_timeout=5, proxy=None,
            additional_headers={guard.HEADER: guard.KEY},
        )  # fmt: skip
    except (OSError, websockets.InvalidHandshake, TimeoutError) as error:
        log.warning("the viewer of session %s cannot be reached: %s", opened.session.id, error)
        await browser.close(1011)
        return
    try:
        await browser.accept(subprotocol=upstream.subprotocol)
        await _relay(browser, upstream)
    finally:
        await upstream.close()
        code = upstream.close_code if upstream.close_code in (1002, 1008) else 1000
        with contextlib.suppress(*GONE):
            await browser.close(code, (upstream.close_reason or "")[:120])


async def _relay(browser: WebSocket, upstream: ClientConnection) -> None:
    tasks = [asyncio.create_task(_to_viewer(browser, upstream)), asyncio.create_task(_to_browser(browser, upstream))]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _to_viewer(browser: WebSocket, upstream: ClientConnection) -> None:
    with contextlib.suppress(*GONE):
        while True:
            message = await browser.receive()
            if message["type"] == "websocket.disconnect":
                return
            content = message.get("bytes")
            await upstream.send(content if content is not None else message["text"])


async def _to_browser(browser: WebSocket, upstream: ClientConnection) -> None:
    with contextlib.suppress(*GONE):
        async for message in upstream:
            await (browser.send_bytes(message) if isinstance(message, bytes) else browser.send_text(message))
