"""Owns the HTTP of replays: made one at a time, off the event loop, and not at all for who has gone meanwhile."""

from __future__ import annotations

import asyncio
import threading
import time

from fastapi import APIRouter, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from server.errors import problem_response
from studio.access import Admitted
from studio.operations import download, file_name
from studio.replay import replay_html

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)

PATIENCE = 20.0
"""How long a request waits for the replays of others, s."""
LOOK_EVERY = 0.1
GONE = 499
"""The status for logs when nobody is left to read an answer."""
_making = threading.Lock()


@router.get("/replay.html")
async def get_replay(opened: Admitted, request: Request) -> Response:
    """Answer the glide as one HTML file that opens without a network."""
    deadline = time.monotonic() + PATIENCE
    while not _making.acquire(blocking=False):
        if await request.is_disconnected():
            return Response(status_code=GONE)
        if time.monotonic() > deadline:
            detail = f"other replays have been made for {PATIENCE:g} s; export again in a moment"
            return problem_response(429, "Too many replays at once", detail=detail, headers={"Retry-After": "5"})
        await asyncio.sleep(LOOK_EVERY)
    try:
        page = await run_in_threadpool(replay_html, opened.session)
    finally:
        _making.release()
    answer = download(page, f"{file_name(opened.session.design.name)}.html", "text/html; charset=utf-8")
    # should a browser show it all the same, then not as a page of this studio
    answer.headers["Content-Security-Policy"] = "sandbox allow-scripts"
    answer.headers["X-Content-Type-Options"] = "nosniff"
    return answer
