"""Owns /sessions: the design that is open in a browser, changed through the session's own operations."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends
from fastapi.responses import Response
from pydantic import ValidationError
from starlette.exceptions import HTTPException

from models.design import Design
from models.design_warnings import warnings_for
from models.problems import DesignError, echo, problems_from_validation
from server.answers import json_answer
from server.dependencies import Document, Live
from server.live import LiveSession
from server.openapi import operation
from server.schemas import PATCH_SCHEMA, Edited, SessionPatch
from server.weighing import as_items, weigh

router = APIRouter(tags=["sessions"])


def _session(session_id: str, live: Live) -> LiveSession:
    session = live.get(session_id) if live is not None else None
    if session is None:
        raise HTTPException(404, f"there is no open session {echo(session_id)}")
    return session


OpenSession = Annotated[LiveSession, Depends(_session)]


@router.get(
    "/sessions/{session_id}/design", response_model=Design, summary="Get the design of an open session",
    **operation("get_session_design", 404),
)  # fmt: skip
def get_session_design(session: OpenSession) -> Response:
    """Answer the document as it is now in the browser."""
    return json_answer(session.design)


@router.patch(
    "/sessions/{session_id}/design", response_model=Edited, summary="Edit the design of an open session",
    **operation("edit_session_design", 404, body=SessionPatch, bare=PATCH_SCHEMA),
)  # fmt: skip
def edit_session_design(session: OpenSession, document: Document) -> Response:
    """Apply a JSON Patch (RFC 6902), bare or as {patch}, as one undoable step that the browser shows at once.

    Pointers of errors that begin with /patch lead into the patch, all others into the design it would have made.
    """
    try:
        patch = SessionPatch.model_validate(document if isinstance(document, dict) else {"patch": document}).patch
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None
    design = session.edit(patch)
    return json_answer(Edited(design=design, mass_properties=weigh(design), warnings=as_items(warnings_for(design))))
