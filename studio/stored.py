"""Owns the HTTP between the studio and the store: links that open a design or a case, saving, and pictures.

A link is safe to ask for: it answers a page whose form, sent at once, opens the session as that of a preset does.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, BackgroundTasks, Depends, HTTPException, Request
from fastapi.responses import RedirectResponse, Response
from pydantic_core import to_json
from starlette.requests import HTTPConnection

from models.design import Design
from models.problems import DesignError, echo
from server.access import is_known_host, is_same_origin
from server.answers import json_answer
from server.errors import PROBLEM_JSON, STORE_STATUS
from server.jobs.service import Jobs
from server.preconditions import IfNoneMatch, etag, is_unchanged
from server.store.designs import DesignStore
from server.store.errors import DeletedError, NotFoundError, RevisionError, StoreError, UnavailableError
from server.store.thumbnails import SVG
from server.trajectory import case_design, planned
from studio.access import Admitted, AnySessions, SettingsNow, has_token, set_session_cookie
from studio.open_page import again_link, job_link, opening_page, problem_page, restore_form
from studio.operations import Document
from studio.origin import CaseOrigin, Origin
from studio.saving import keep_picture, origin_of, read_save, save
from studio.thumbnail import draw

router = APIRouter(include_in_schema=False)
RUN = re.compile(r"([0-9a-z]{26})\.(\d{1,15})")
WHOLE = re.compile(r"[1-9]\d{0,8}")
DRAWN_ONLY = "default-src 'none'; style-src 'unsafe-inline'; sandbox"
TITLES = {
    404: "There is nothing at this link", 410: "This design was deleted", 503: "The stored designs cannot be read now",
}  # fmt: skip


class LinkError(Exception):
    """A link cannot be opened as it is written; the message says why."""


@dataclass(frozen=True)
class Opening:
    """What a link leads to: a document, where it came from, both in words, and the moment to show, s."""

    design: Design
    origin: Origin
    detail: str
    moment: float | None = None


def provide(store: DesignStore | None, jobs: Jobs | None) -> Callable[[HTTPConnection], None]:
    """Return the router's dependency that gives its routes the stored designs and the jobs."""

    def provide_to(connection: HTTPConnection) -> None:
        connection.state.store, connection.state.jobs = store, jobs

    return provide_to


def _store(request: Request) -> DesignStore:
    store: DesignStore | None = request.state.store
    if store is None:
        raise UnavailableError("this studio keeps no designs: start it as glider-studio does")
    return store


StoreNow = Annotated[DesignStore, Depends(_store)]


@router.get("/d")
@router.get("/d/{design_id}")
def get_link(request: Request, settings: SettingsNow, design_id: str | None = None) -> Response:
    """Answer the page that opens a stored design (`?revision=`), or a case of a job (`?run=JOB.CASE`), at `?t=`.

    A run decides by itself what is opened: equal jobs are one, so it need not name the design that the link does.
    """
    if not has_token(request, settings):
        return _no_token(request)
    try:
        found = _find(request, design_id)
    except (LinkError, StoreError, DesignError) as error:
        return _refusal(request, error, design_id)
    return opening_page(request, found.design.name, found.detail)


@router.post("/d")
@router.post("/d/{design_id}")
def open_link(request: Request, sessions: AnySessions, settings: SettingsNow, design_id: str | None = None) -> Response:
    """Open a session on what a link leads to."""
    if not is_same_origin(request, required=False) or not is_known_host(request, settings):
        return problem_page(
            request, 403, "Not opened", "Designs are opened from this studio's own pages only.",
            action=again_link(request),
        )  # fmt: skip
    if not has_token(request, settings):
        return _no_token(request)
    try:
        found = _find(request, design_id)
        opened, secret = sessions.create(found.design, found.origin)
    except (LinkError, StoreError, DesignError) as error:
        return _refusal(request, error, design_id)
    session_id = opened.session.id
    query = "" if found.moment is None else f"?{urlencode({'t': f'{found.moment:.10g}'})}"
    answer = RedirectResponse(f"/s/{session_id}/{query}", 303)
    set_session_cookie(answer, session_id, secret, secure=request.url.scheme == "https")
    return answer


@router.post("/d/{design_id}/restore")
def restore(request: Request, design_id: str, sessions: AnySessions, settings: SettingsNow) -> Response:
    """Bring a deleted design back, and open it."""
    if is_same_origin(request, required=False) and is_known_host(request, settings) and has_token(request, settings):
        try:
            _store(request).restore(design_id)
        except StoreError as error:
            return _refusal(request, error, design_id)
    return open_link(request, sessions, settings, design_id)


@router.get("/d/{design_id}/picture")
def get_picture(
    request: Request, design_id: str, settings: SettingsNow, store: StoreNow, known: IfNoneMatch = None
) -> Response:
    """Answer a design's thumbnail; where it has none, its silhouette."""
    if not has_token(request, settings):
        raise HTTPException(401)
    try:
        kept = store.thumbnail(design_id)
        media_type, version = kept.media_type, kept.digest
    except NotFoundError:
        stored, kept = store.get(design_id), None
        media_type, version = SVG, stored.identity
    headers = {"Cache-Control": "private, no-cache", "ETag": etag(version), "Content-Security-Policy": DRAWN_ONLY}
    if is_unchanged(known, version):
        return Response(status_code=304, headers=headers)
    content = kept.content if kept is not None else draw(stored.design, None).encode()
    return Response(content, media_type=media_type, headers=headers | {"X-Content-Type-Options": "nosniff"})


@router.post("/s/{session_id}/save")
def save_design(opened: Admitted, store: StoreNow, document: Document, tasks: BackgroundTasks) -> Response:
    """Store the session's document; 412 with the newest revision where others have saved meanwhile."""
    try:
        stored = save(opened, store, read_save(document))
    except RevisionError as error:
        return _overtaken(opened, store, error)
    tasks.add_task(keep_picture, opened.session, store, stored)
    return json_answer({"design_id": stored.id, "revision": stored.revision, "name": stored.design.name})


def _overtaken(opened: Admitted, store: DesignStore, error: RevisionError) -> Response:
    origin = opened.session.origin
    assert origin is not None and not isinstance(origin, CaseOrigin)
    newest = store.get(origin.design_id)
    content = {
        "type": "about:blank", "title": "A newer revision was saved", "status": 412, "detail": str(error), "errors": [],
        "newest": {
            "design_id": newest.id, "revision": newest.revision, "name": newest.design.name, "updated": newest.updated,
            "comment": newest.comment,
        },
    }  # fmt: skip
    return Response(to_json(content), 412, {"ETag": etag(newest.revision)}, media_type=PROBLEM_JSON)


def _find(request: Request, design_id: str | None) -> Opening:
    """Return what a link leads to; raises `LinkError`, `StoreError` or `DesignError`."""
    query = request.query_params
    moment = _moment(query.get("t"))
    if (run := query.get("run")) is not None:
        return _find_case(request, run, moment)
    if design_id is None:
        raise LinkError("It names no design and no run: /d/DESIGN opens a design, /d?run=JOB.CASE a case of a job.")
    number, store = query.get("revision"), _store(request)
    if number is not None and WHOLE.fullmatch(number) is None:
        raise LinkError(f"The revision {echo(number)} is not a whole number from 1.")
    stored = store.get(design_id) if number is None else store.revision(design_id, int(number))
    return Opening(stored.design, origin_of(stored), f"Revision {stored.revision}", moment)


def _find_case(request: Request, run: str, moment: float | None) -> Opening:
    jobs: Jobs | None = request.state.jobs
    if jobs is None:
        raise UnavailableError("this studio keeps no jobs: start it as glider-studio does")
    named = RUN.fullmatch(run)
    if named is None:
        raise LinkError(f"The run {echo(run)} is not the name of a job and the number of a case, as JOB.CASE.")
    job, case = jobs.store.get(named[1]), int(named[2])
    if case >= job.counted:
        raise NotFoundError(f"there is no case {case}: the job has cases 0 to {job.counted - 1}")
    design = case_design(planned(job.spec), case)
    origin = CaseOrigin(job.id, job.name, case, design.identity)
    return Opening(design, origin, f"Case {case} of the job {job.name}", moment)


def _moment(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        moment = float(text)
    except ValueError:
        moment = math.nan
    if not (math.isfinite(moment) and moment >= 0.0):
        raise LinkError(f"The time {echo(text)} is not a number of seconds from 0.")
    return moment


def _refusal(request: Request, error: LinkError | StoreError | DesignError, design_id: str | None) -> Response:
    back = _way_back(request)
    if isinstance(error, LinkError):
        return problem_page(request, 422, "This link cannot be opened", str(error), action=back)
    if isinstance(error, DesignError):
        return _no_glider(request, error, back)
    status = STORE_STATUS[type(error)]
    said = str(error)
    action = again_link(request) if status == 503 else back
    if isinstance(error, DeletedError) and design_id is not None:
        said, action = "It is kept, with all its revisions, and can be brought back.", restore_form(request, design_id)
    detail = said[:1].upper() + said[1:].removesuffix(".") + "."
    return problem_page(request, status, TITLES.get(status, HTTPStatus(status).phrase), detail, action=action)


def _no_glider(request: Request, error: DesignError, back: str) -> Response:
    title, detail = "This document cannot be opened as it is", "Its values make no glider that can be simulated."
    if (named := RUN.fullmatch(request.query_params.get("run", ""))) is not None:
        title = f"Case {int(named[2])} cannot be opened"
        detail = f"{detail} The page of its job shows the values of all cases, and opens those that went well."
    errors = [str(problem) for problem in error.problems[:10]]
    return problem_page(request, 422, title, detail, errors=errors, action=back)


def _way_back(request: Request) -> str:
    """Return the link back for who followed the link of a case: to its job, or to all jobs where it has none."""
    if (run := request.query_params.get("run")) is None:
        return ""
    named, jobs, known = RUN.fullmatch(run), request.state.jobs, None
    if named is not None and jobs is not None:
        with suppress(StoreError):
            known = jobs.store.get(named[1]).id
    return job_link(request, known)


def _no_token(request: Request) -> Response:
    detail = "Open the studio's address with ?token= and its token first; then this link works in the same browser."
    return problem_page(request, 401, "This studio needs its token", detail, action=again_link(request))
