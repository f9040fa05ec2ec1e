"""Owns the HTTP of a session's left panel: the list of parts and its marks, and what the fields are made from."""

from __future__ import annotations

import hashlib
from typing import Any, Literal, get_args

from fastapi import APIRouter, Request
from fastapi.responses import Response

from models.problems import DesignError, Problem
from server.answers import json_answer
from studio import part_patches
from studio.access import Admitted
from studio.operations import Document
from studio.part_fields import fields_of, schema_json
from studio.part_kinds import NAMES
from studio.part_marks import FLAGS
from studio.registry import OpenSession

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)

MassKind = Literal["composite", "declared"]


@router.get("/schema")
def get_schema(opened: Admitted, request: Request) -> Response:
    """Answer the JSON Schema of the design, from which the fields are made."""
    content = schema_json()
    tag = f'"{hashlib.sha256(content).hexdigest()[:16]}"'
    headers = {"ETag": tag, "Cache-Control": "private, no-cache"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, media_type="application/json", headers=headers)


@router.get("/fields")
def get_fields(opened: Admitted) -> Response:
    """Answer the document's fields, and what follows from them."""
    session = opened.session
    revision, design = session.revision, session.design
    answer = json_answer({"revision": revision} | fields_of(design))
    answer.headers["Cache-Control"] = "no-store"
    return answer


@router.post("/parts", status_code=201)
def add_part(opened: Admitted, document: Document) -> Response:
    """Add a part: {"kind": one of the palette's}."""
    opened.session.add_component(_choice(document, "kind", tuple(NAMES)))
    return _answer(opened, 201)


@router.post("/parts/{index}/copy", status_code=201)
def copy_part(opened: Admitted, index: int) -> Response:
    """Add a copy of a part beside it."""
    opened.session.duplicate_component(index)
    return _answer(opened, 201)


@router.post("/parts/{index}/mirror", status_code=201)
def mirror_part(opened: Admitted, index: int, document: Document) -> Response:
    """Add a part's mirror image: {"schedule": null, "same" or "opposite"}."""
    given = document.get("schedule") if isinstance(document, dict) else None
    sense: Any = None if given is None else _choice(document, "schedule", get_args(part_patches.Sense))
    opened.session.arrange(lambda design: part_patches.mirror(design, index, sense), select=index + 1)
    return _answer(opened, 201)


@router.post("/parts/{index}/move")
def move_part(opened: Admitted, index: int, document: Document) -> Response:
    """Put a part at another place of the list: {"to": index}."""
    to = document.get("to") if isinstance(document, dict) else None
    if isinstance(to, bool) or not isinstance(to, int):
        raise DesignError([Problem("/to", "to must be the index of a part", hint='such as {"to": 0}')])
    opened.session.arrange(lambda design: part_patches.moved(design, index, to), select=to)
    return _answer(opened)


@router.delete("/parts/{index}")
def remove_part(opened: Admitted, index: int) -> Response:
    """Remove a part, its schedule and what else names it."""
    opened.session.edit([{"op": "remove", "path": f"/vehicle/components/{index}"}])
    return _answer(opened)


@router.post("/parts/{index}/marks")
def mark_part(opened: Admitted, index: int, document: Document) -> Response:
    """Lock, unlock, hide or show a part: {"locked": true}, {"hidden": false}."""
    flags = document if isinstance(document, dict) else {}
    if not flags or any(name not in FLAGS or not isinstance(on, bool) for name, on in flags.items()):
        raise DesignError([Problem("", "a part is marked by locked and hidden", hint='such as {"locked": true}')])
    opened.session.mark(index, **flags)
    return _answer(opened)


@router.post("/pairs")
def link_pairs(opened: Admitted, document: Document) -> Response:
    """Have mirror images go along with parts that are edited or dragged, or stay: {"linked": true}."""
    linked = document.get("linked") if isinstance(document, dict) else None
    if not isinstance(linked, bool):
        raise DesignError([Problem("/linked", "linked must be true or false", hint='such as {"linked": false}')])
    opened.session.link(linked)
    return _answer(opened)


@router.post("/mass-properties")
def set_mass_properties(opened: Admitted, document: Document) -> Response:
    """Declare the mass properties as they are now, or compose them again: {"kind": "declared" or "composite"}."""
    kind = _choice(document, "kind", get_args(MassKind))
    opened.session.arrange(lambda design: part_patches.mass_properties(design, kind))
    return _answer(opened)


def _choice(document: Any, member: str, choices: tuple[str, ...]) -> str:
    given = document.get(member) if isinstance(document, dict) else None
    if not isinstance(given, str) or given not in choices:
        said = "is missing" if given is None else f"cannot be {given!r}"
        raise DesignError([Problem(f"/{member}", f"{member} {said}", hint=f"use one of {', '.join(choices)}")])
    return given


def _answer(opened: OpenSession, status: int = 200) -> Response:
    return json_answer({"revision": opened.session.revision, "selected": opened.session.selected}, status)
