"""Owns /designs/{id}/components: the parts of a stored design, each by its name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import quote

from fastapi import APIRouter, Request
from fastapi.responses import Response

from models.components import Component
from models.design import Design
from server.answers import json_answer
from server.dependencies import Document, SettingsNow, Store
from server.openapi import operation
from server.preconditions import IfMatch, IfNoneMatch, etag, is_unchanged
from server.routes.stored_designs import ONE, READS, WRITES
from server.schemas_store import COMPONENT_SCHEMA, MERGE_SCHEMA, ComponentList
from server.store.components import find_component, with_component, with_merged, without_component
from server.store.designs import Change
from server.store.records import Content, StoredDesign

router = APIRouter(tags=["components"])
ALL = f"{ONE}/components"
NAMED = f"{ALL}/{{name}}"


def _answer(stored: StoredDesign, content: Any, status: int = 200) -> Response:
    answer = json_answer(content, status)
    answer.headers["ETag"] = etag(stored.revision)
    return answer


def _unchanged(stored: StoredDesign) -> Response:
    return Response(status_code=304, headers={"ETag": etag(stored.revision)})


def _to(change: Callable[[Design], Design]) -> Change:
    """Return a change of the design alone."""
    return lambda before: Content(change(before.design), before.tags)


@router.get(
    ALL, response_model=ComponentList, summary="List the components of a design",
    **operation("list_components", 304, *READS),
)  # fmt: skip
def list_components(design_id: str, store: Store, known: IfNoneMatch = None) -> Response:
    """List all components of a stored design's newest revision, whose ETag a change needs."""
    stored = store.get(design_id)
    if is_unchanged(known, stored.revision):
        return _unchanged(stored)
    items = list(stored.design.vehicle.components)
    return _answer(stored, ComponentList(revision=stored.revision, items=items))


@router.post(
    ALL, status_code=201, response_model=Component, summary="Add a component",
    **operation("add_component", *WRITES, files={"application/json": COMPONENT_SCHEMA}),
)  # fmt: skip
def add_component(
    request: Request, design_id: str, if_match: IfMatch, document: Document, settings: SettingsNow, store: Store
) -> Response:
    """Add a part to a stored design. A cell needs only kind, name, mass, volume, volume_range and position."""
    change = _to(lambda design: with_component(design, document, settings.limits))
    stored = store.change(design_id, change, expected=if_match)
    component = stored.design.vehicle.components[-1]
    answer = _answer(stored, component, 201)
    answer.headers["Location"] = f"{request.url.path}/{quote(component.name, safe='')}"
    return answer


@router.get(NAMED, response_model=Component, summary="Get a component", **operation("get_component", 304, *READS))
def get_component(design_id: str, name: str, store: Store, known: IfNoneMatch = None) -> Response:
    """Answer one component of a stored design, by its name, URL-encoded."""
    stored = store.get(design_id)
    _, component = find_component(stored.design, name)
    return _unchanged(stored) if is_unchanged(known, stored.revision) else _answer(stored, component)


@router.patch(
    NAMED, response_model=Component, summary="Change a component",
    **operation(
        "change_component", *WRITES,
        files={"application/json": MERGE_SCHEMA, "application/merge-patch+json": MERGE_SCHEMA},
    ),
)  # fmt: skip
def change_component(
    design_id: str, name: str, if_match: IfMatch, document: Document, settings: SettingsNow, store: Store
) -> Response:
    """Merge fields into a component (RFC 7386): null takes a field back to its default, others replace what was.

    A new name does not reach schedules or controllers that use the old one: then PATCH the design, all at once.
    """
    stored = store.change(
        design_id, _to(lambda design: with_merged(design, name, document, settings.limits)), expected=if_match
    )
    renamed = document.get("name", name)
    return _answer(stored, find_component(stored.design, renamed)[1])


@router.delete(NAMED, status_code=204, summary="Remove a component", **operation("remove_component", *WRITES))
def remove_component(design_id: str, name: str, if_match: IfMatch, settings: SettingsNow, store: Store) -> Response:
    """Remove a component; refused while a schedule or controller needs it. Earlier revisions still have it."""
    change = _to(lambda design: without_component(design, name, settings.limits))
    stored = store.change(design_id, change, expected=if_match)
    return Response(status_code=204, headers={"ETag": etag(stored.revision)})
