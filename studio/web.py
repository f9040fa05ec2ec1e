"""Owns the studio's own pages: the list of presets, the page of a session, static files, and opening sessions."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from urllib.parse import parse_qs

from fastapi import APIRouter, Depends, HTTPException, Request
from fastapi.responses import RedirectResponse, Response
from starlette.concurrency import run_in_threadpool

from models.design import Design, parse_design
from models.presets import load_preset
from server.access import TOKEN_COOKIE, KnownTokens, is_known_host, is_same_origin, token_proof
from server.answers import json_answer
from server.body import loads
from server.errors import problem_response
from server.jobs.service import Jobs
from server.settings import Settings
from server.store.designs import DesignStore
from studio import (
    analysis_operations,
    job_pages,
    operations,
    part_operations,
    proxy,
    replay_operations,
    run_operations,
    scene_operations,
    stored,
)
from studio.access import (
    PAGE_HEADERS,
    AnySessions,
    SettingsNow,
    find_session,
    has_token,
    provide,
    set_session_cookie,
)
from studio.open_page import problem_page
from studio.page_files import file_page, static_file
from studio.registry import Sessions
from studio.thumbnail import preset_svg

REAP_EVERY = 60.0
TOKEN_UNKNOWN = (
    "Ask whoever runs this studio for its address with your token, and open that: http://…/?token=… as it is."
)
NOT_YOURS = (
    "A session opens only in the browser that began it. Ask for a link to a saved design, or for the design as a file, "
    "and open that; or begin with a preset."
)
pages = APIRouter(include_in_schema=False)


def create_studio(
    settings: Settings, *, store: DesignStore | None = None, jobs: Jobs | None = None
) -> tuple[APIRouter, Sessions]:
    """Return the studio's routes, and the open sessions, which the API takes as its live sessions.

    Without `store` nothing is saved there, and without it or `jobs` their links say so.
    """
    sessions = Sessions(settings.data / "sessions", limits=settings.limits)
    router = APIRouter(dependencies=[Depends(provide(sessions, settings)), Depends(stored.provide(store, jobs))])
    for part in (
        job_pages,
        stored,
        operations,
        part_operations,
        replay_operations,
        run_operations,
        analysis_operations,
        scene_operations,
        proxy,
    ):
        router.include_router(part.router)
    router.include_router(pages)
    return router, sessions


@contextlib.asynccontextmanager
async def running(sessions: Sessions) -> AsyncIterator[None]:
    """Close idle sessions while the program runs, and all of them when it stops."""

    async def reap() -> None:
        while True:
            await asyncio.sleep(REAP_EVERY)
            await asyncio.to_thread(sessions.reap)

    task = asyncio.create_task(reap())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.to_thread(sessions.close)


@pages.get("/")
def get_index(request: Request, settings: SettingsNow) -> Response:
    """Answer the list of presets; `?token=` lets a browser on another machine in."""
    given = request.query_params.get("token")
    if given is not None and settings.demands_token:
        if not KnownTokens(settings.tokens).knows(given):
            return problem_page(request, 401, "This token is not known here", TOKEN_UNKNOWN)
        answer: Response = RedirectResponse("./", 303)
        proof = token_proof(given)
        secure = request.url.scheme == "https"
        answer.set_cookie(TOKEN_COOKIE, proof, httponly=True, samesite="lax", secure=secure, max_age=90 * 86_400)
        return answer
    return file_page("index.html", PAGE_HEADERS)


@pages.get("/static/{name}")
@pages.get("/static/{release}/{name}")
async def get_static(name: str, request: Request, release: str | None = None) -> Response:
    """Answer one of the page's files; under the release that pages name it may be kept for good."""
    try:
        return static_file(name, request.headers.get("if-none-match"), release)
    except KeyError:
        raise HTTPException(404) from None


@pages.get("/presets/{preset_id}.svg")
def get_preset_picture(preset_id: str) -> Response:
    """Answer a preset's picture."""
    try:
        picture, complete = preset_svg(preset_id)
    except KeyError:
        raise HTTPException(404) from None
    headers = {
        "Cache-Control": "max-age=3600" if complete else "no-store",
        "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'",
        "X-Content-Type-Options": "nosniff",
    }
    return Response(picture, media_type="image/svg+xml", headers=headers)


@pages.post("/sessions")
async def open_session(request: Request, sessions: AnySessions, settings: SettingsNow) -> Response:
    """Open a session on a preset (a form with the field preset) or on a document (JSON)."""
    if not is_same_origin(request, required=False) or not is_known_host(request, settings):
        return problem_response(403, "Forbidden", detail="sessions are opened from this studio's own pages only")
    if not has_token(request, settings):
        return problem_response(401, "Unauthorized", detail="open the studio's address with ?token= and its token")
    body = await request.body()
    kind = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if kind == "application/json":
        design = await run_in_threadpool(_design_of_document, body, settings)
    elif kind == "application/x-www-form-urlencoded":
        design = _design_of_form(body)
    else:
        return problem_response(415, "Unsupported Media Type", detail="send the form, or a design as application/json")
    opened, secret = await run_in_threadpool(sessions.create, design)
    session_id = opened.session.id
    answer: Response
    if kind == "application/json":
        answer = json_answer({"url": f"/s/{session_id}/"}, 201)
    else:
        answer = RedirectResponse(f"/s/{session_id}/", 303)
    set_session_cookie(answer, session_id, secret, secure=request.url.scheme == "https")
    return answer


def _design_of_document(body: bytes, settings: Settings) -> Design:
    return parse_design(loads(body, max_values=settings.max_body_values))


def _design_of_form(body: bytes) -> Design:
    wanted = parse_qs(body.decode("utf-8", errors="replace")).get("preset", [""])[0]
    try:
        return load_preset(wanted)
    except KeyError:
        raise HTTPException(404, "there is no such preset") from None


@pages.get("/s/{session_id}/")
def get_page(session_id: str, request: Request, sessions: AnySessions) -> Response:
    """Answer the page of a session; to anybody else one that says why not, and how to go on."""
    opened = find_session(sessions, request, session_id)
    if opened is None:
        return problem_page(request, 403, "This session is not yours, or it is over", NOT_YOURS)
    opened.touch()
    return file_page("studio.html", PAGE_HEADERS)
