"""Owns /designs: checking, editing and trimming a design that the request brings."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from models.assemble import assemble
from models.design import Design
from models.mass_properties import trim_ballast
from server.answers import json_answer
from server.dependencies import Document, SettingsNow
from server.documents import design_sent_at, read_design, read_request
from server.editing import apply_patch
from server.openapi import operation
from server.schemas import DESIGN_REF, Change, Edited, EditRequest, Trimmed, TrimRequest, ValidateRequest, Validity
from server.weighing import as_items, weigh

router = APIRouter(tags=["designs"])


@router.post(
    "/designs:validate", response_model=Validity, summary="Check a design",
    **operation("validate_design", body=ValidateRequest, bare=DESIGN_REF),
)  # fmt: skip
def validate_design(document: Document, settings: SettingsNow) -> Response:
    """Say whether a design can be simulated: its identity and warnings, or 422 with all that is wrong, by place."""
    design, _, prefix = read_request(document, ValidateRequest, settings.limits)
    with design_sent_at(prefix):
        warnings = assemble(design, settings.limits).warnings
    return json_answer(Validity(valid=True, identity=design.identity, warnings=as_items(warnings)))


@router.post(
    "/designs:edit", response_model=Edited, summary="Edit a design",
    **operation("edit_design", body=EditRequest),
)  # fmt: skip
def edit_design(document: Document, settings: SettingsNow) -> Response:
    """Apply a JSON Patch (RFC 6902) to a design: add, move, change or remove cells, schedules, anything.

    Pointers of errors that begin with /patch lead into the patch; those that begin with /design, into the design that
    the patch would have made. A cell needs only kind, name, mass, volume, volume_range and position.
    """
    design, request, prefix = read_request(document, EditRequest, settings.limits)
    with design_sent_at(prefix, beside="/patch"):
        edited = apply_patch(design, request.patch)
        warnings = assemble(edited, settings.limits).warnings
    return json_answer(Edited(design=edited, mass_properties=weigh(edited), warnings=as_items(warnings)))


@router.post(
    "/designs:trim-ballast", response_model=Trimmed, summary="Trim a design's ballast",
    **operation("trim_ballast", body=TrimRequest, bare=DESIGN_REF),
)  # fmt: skip
def trim(document: Document, settings: SettingsNow) -> Response:
    """Set one rigid component's volume so that the glider is neutral with every cell at its neutral extension."""
    design, request, prefix = read_request(document, TrimRequest, settings.limits)
    with design_sent_at(prefix):
        trimmed, change = trim_ballast(design, request.component)
        trimmed = _within_limits(trimmed, settings)
    told = Change(
        component=change.component, pointer=change.pointer, before=change.before, after=change.after,
        message=str(change),
    )  # fmt: skip
    return json_answer(Trimmed(design=trimmed, change=told, mass_properties=weigh(trimmed)))


def _within_limits(design: Design, settings: SettingsNow) -> Design:
    """Read a computed design again: a volume may have come out beyond its limits."""
    return read_design(design.model_dump(mode="json"), settings.limits)
