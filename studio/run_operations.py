"""Owns the HTTP of a session's runs: keeping them, and any output of the present or a kept one as a curve."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query
from fastapi.responses import Response

from models.problems import DesignError, Problem
from models.run import Run
from server.answers import json_answer, series_answer
from studio.access import Admitted
from studio.operations import Document
from studio.outputs import curves_of, outputs_of
from studio.registry import OpenSession
from studio.session import Session

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)

CURRENT = "current"
NO_RUN = "there is no run yet: the physics is still being compiled"


@router.get("/outputs")
def get_outputs(opened: Admitted) -> Response:
    """Answer what can be plotted of the present run."""
    return _fresh({"items": outputs_of(_present(opened))})


@router.post("/runs", status_code=201)
def keep_run(opened: Admitted, document: Document) -> Response:
    """Keep the present run, under {"name": …} or a name made for it."""
    name = document.get("name") if isinstance(document, dict) else None
    if name is not None and not isinstance(name, str):
        raise DesignError([Problem("/name", "the name of a kept run is no text", hint='send {"name": "Before"} or {}')])
    _present(opened)
    return json_answer({"id": opened.session.keep_run(name).id}, 201)


@router.patch("/runs/{run_id}", status_code=204)
def rename_run(opened: Admitted, run_id: str, document: Document) -> None:
    """Give a kept run another name."""
    name = document.get("name") if isinstance(document, dict) else None
    if not isinstance(name, str):
        raise DesignError([Problem("/name", "send the new name as text", hint='{"name": "Before"}')])
    if not opened.session.rename_run(run_id, name):
        raise HTTPException(404, _missing(run_id))


@router.delete("/runs/{run_id}", status_code=204)
def forget_run(opened: Admitted, run_id: str) -> None:
    """Keep a run no longer."""
    if not opened.session.forget_run(run_id):
        raise HTTPException(404, _missing(run_id))


@router.get("/runs/{run_id}/columns")
def get_columns(opened: Admitted, run_id: str, name: Annotated[list[str], Query(max_length=100)]) -> Response:
    """Answer some outputs of a run, each asked for as a `name`, over time; `current` is the present run."""
    run = _present(opened) if run_id == CURRENT else run_kept_as(run_id, opened.session)
    return _fresh(curves_of(run, [wanted for wanted in name if wanted]))


def run_kept_as(run_id: str, session: Session) -> Run:
    """Return a kept run; raises `HTTPException` where there is none, or it is not computed."""
    kept = session.kept.get(run_id)
    if kept is None:
        raise HTTPException(404, _missing(run_id))
    if kept.run is None:
        raise HTTPException(409, kept.problem or f"'{kept.name}' is still computed anew: ask again in a moment")
    return kept.run


def _present(opened: OpenSession) -> Run:
    run = opened.session.run
    if run is None:
        raise HTTPException(409, NO_RUN)
    return run


def _missing(run_id: str) -> str:
    return f"no run is kept as '{run_id}'; it may have been deleted in another tab"


def _fresh(document: dict[str, Any]) -> Response:
    answer = series_answer(document)
    answer.headers["Cache-Control"] = "no-store"
    return answer
