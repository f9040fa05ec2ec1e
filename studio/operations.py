"""Owns the HTTP of one session: its state, its edits, its files, and the stream that tells its changes."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import APIRouter, Depends, HTTPException
from fastapi.responses import Response, StreamingResponse
from starlette.concurrency import run_in_threadpool

from models.design import parse_design
from models.problems import DesignError, Problem
from models.run import Run
from server.answers import json_answer
from server.body import JsonBody, loads
from server.errors import problem_response
from studio.access import Admitted, SettingsNow
from studio.events import events_of
from studio.polar import polar_document
from studio.registry import OpenSession
from studio.view import VIEWS

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)


def _document(body: JsonBody, settings: SettingsNow) -> Any:
    return loads(body, max_values=settings.max_body_values)


Document = Annotated[Any, Depends(_document)]

MOST_COVERED = 0.5  # of the scene's height: more would leave no picture


@router.get("/state")
def get_state(opened: Admitted) -> Response:
    """Answer what the page draws."""
    return Response(opened.feed.now().content, media_type="application/json", headers={"Cache-Control": "no-store"})


@router.get("/polar")
def get_polar(opened: Admitted) -> Response:
    """Answer the design's force data beside the law made from them."""
    answer = json_answer(polar_document(opened.session.design.vehicle.hydrodynamics))
    answer.headers["Cache-Control"] = "no-store"
    return answer


@router.get("/events")
async def get_events(opened: Admitted) -> Response:
    """Answer server-sent events: the state at once and after each change, the consequences once they are known."""
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(events_of(opened), media_type="text/event-stream", headers=headers)


@router.post("/edit")
def edit(opened: Admitted, document: Document) -> Response:
    """Apply {"patch": [...]} to the design; edits of the same "gesture" (a drag) are one step of undo.

    With "paired" mirror images go along, unless the session has them stay.
    """
    if not isinstance(document, dict) or not {"patch"} <= set(document) <= {"patch", "gesture", "paired"}:
        message = "send an object with a patch, a gesture if any, and whether it is paired"
        raise DesignError([Problem("", message, hint='{"patch": [...]}')])
    gesture = document.get("gesture")
    if not isinstance(gesture, str | None):
        raise DesignError(
            [Problem("/gesture", "the name of a gesture is no text", hint="leave it out for a single edit")]
        )
    paired = document.get("paired", False)
    if not isinstance(paired, bool):
        raise DesignError([Problem("/paired", "whether it is paired is true or false", hint="leave it out for false")])
    opened.session.edit(document["patch"], gesture=gesture, paired=paired)
    return _revision(opened)


@router.post("/undo")
def undo(opened: Admitted) -> Response:
    """Take back the last change."""
    return _revision(opened) if opened.session.undo() else problem_response(409, "There is nothing to undo")


@router.post("/redo")
def redo(opened: Admitted) -> Response:
    """Make the last undone change again."""
    return _revision(opened) if opened.session.redo() else problem_response(409, "There is nothing to redo")


@router.put("/design")
def put_design(opened: Admitted, document: Document) -> Response:
    """Open another document in this session."""
    try:
        design = parse_design(document)
    except DesignError as error:
        opened.session.refuse(error)
        raise
    opened.session.replace(design)
    return _revision(opened)


@router.post("/trim-ballast")
def trim_ballast(opened: Admitted) -> Response:
    """Make the glider neutral with all cells neutral."""
    return json_answer({"message": opened.session.trim_ballast(), "revision": opened.session.revision})


@router.post("/camera", status_code=204)
def set_camera(opened: Admitted, document: Document) -> None:
    """Look from the side, the top, behind, freely, or at the whole path."""
    view = _member(document, "view")
    if not isinstance(view, str) or view not in VIEWS:
        raise DesignError([Problem("/view", f"there is no view '{view}'", hint=f"use one of {', '.join(VIEWS)}")])
    covered = document.get("covered", 0.0)
    if isinstance(covered, bool) or not isinstance(covered, int | float) or not 0.0 <= covered <= MOST_COVERED:
        message = f"the covered share of the scene is {covered!r}, not a number from 0 to {MOST_COVERED:g}"
        raise DesignError(
            [Problem("/covered", message, limit=MOST_COVERED, hint="leave it out where nothing covers it")]
        )
    opened.view().camera(view, float(covered))


@router.post("/clock", status_code=204)
def set_clock(opened: Admitted, document: Document) -> None:
    """Move the 3D nodes to a time of the run."""
    t = _member(document, "t")
    if isinstance(t, bool) or not isinstance(t, int | float):
        raise DesignError([Problem("/t", "t must be a number of seconds")])
    opened.view().set_clock(float(t))


@router.post("/select", status_code=204)
def select(opened: Admitted, document: Document) -> None:
    """Choose the component that the panel shows."""
    index = _member(document, "component")
    if isinstance(index, bool) or not isinstance(index, int):
        raise DesignError([Problem("/component", "component must be an index")])
    opened.session.select(index)


@router.get("/design.json")
def get_design(opened: Admitted) -> Response:
    """Answer the document as a file."""
    design = opened.session.design
    return download(design.to_json(), f"{file_name(design.name)}.json", "application/json")


@router.get("/run.csv")
async def get_csv(opened: Admitted) -> Response:
    """Answer the last run as CSV."""
    run = _run(opened)
    return download(await run_in_threadpool(run.to_csv), f"{file_name(run.design.name)}.csv", "text/csv")


@router.get("/run.nc")
async def get_netcdf(opened: Admitted) -> Response:
    """Answer the last run as NetCDF."""
    run = _run(opened)
    content = await run_in_threadpool(run.to_netcdf)
    return download(content, f"{file_name(run.design.name)}.nc", "application/x-netcdf")


def _run(opened: OpenSession) -> Run:
    run = opened.session.run
    if run is None:
        raise HTTPException(409, "there is no run yet: the physics is still being compiled")
    return run


def _member(document: Any, name: str) -> Any:
    if not isinstance(document, dict) or name not in document:
        raise DesignError([Problem(f"/{name}", f"send an object with the member {name}", hint="add this field")])
    return document[name]


def _revision(opened: OpenSession) -> Response:
    return json_answer({"revision": opened.session.revision})


def file_name(name: str) -> str:
    """Return a name for a download in plain letters, digits and hyphens."""
    return re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-").lower()[:60] or "design"


def download(content: str | bytes, name: str, media_type: str) -> Response:
    """Answer a file to keep under a name."""
    headers = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-store"}
    return Response(content, media_type=media_type, headers=headers)
