"""Owns designs as files, one or a zip of many, in and out; and the thumbnails of stored designs."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response
from pydantic import TypeAdapter, ValidationError
from starlette.exceptions import HTTPException

from models.design import Design
from models.problems import DesignError, Problem, echo, problems_from_validation
from server.answers import json_answer
from server.body import json_body, loads, media_type
from server.dependencies import SettingsNow, Store
from server.documents import read_design
from server.errors import design_problem
from server.openapi import operation
from server.preconditions import IfNoneMatch, etag, is_unchanged
from server.routes.stored_designs import ONE, READS, TagFilter, simulable
from server.schemas import DESIGN_REF, ProblemDocument
from server.schemas_store import ARCHIVE_SCHEMA, PNG_SCHEMA, SVG_SCHEMA, ImportItem, ImportReport, Tags
from server.settings import Settings
from server.store.archive import MOST_ENTRIES, Entry, file_name, read_archive, write_archive
from server.store.designs import LONGEST_COMMENT, DesignStore
from server.store.listing import DesignQuery
from server.store.paging import MOST_A_PAGE
from server.store.records import Content
from server.store.thumbnails import LARGEST_THUMBNAIL, PNG, SVG

router = APIRouter(tags=["design files"])
ZIP = "application/zip"
DRAWN_ONLY = "default-src 'none'; style-src 'unsafe-inline'; sandbox"
"""Policy of thumbnails: whatever is in one, it only draws."""
ZIP_ANSWER: dict[int | str, dict[str, Any]] = {200: {"content": {ZIP: {"schema": ARCHIVE_SCHEMA}}}}
PICTURES: dict[int | str, dict[str, Any]] = {
    200: {"content": {PNG: {"schema": PNG_SCHEMA}, SVG: {"schema": SVG_SCHEMA}}}
}
_TAGS = TypeAdapter(Tags)


async def _design_or_archive(request: Request) -> tuple[bytes, bool]:
    """Return a body and whether it is a zip; answers 415 where it says neither."""
    if _kind(request) == ZIP:
        return await request.body(), True
    return await json_body(request), False


async def _picture(request: Request) -> tuple[str, bytes]:
    kind = _kind(request)
    if kind not in (PNG, SVG):
        raise HTTPException(415, f"the body must be {PNG} or {SVG}, not {echo(kind)}")
    return kind, await request.body()


def _kind(request: Request) -> str:
    return media_type(request.headers)


Sent = Annotated[tuple[bytes, bool], Depends(_design_or_archive)]
Picture = Annotated[tuple[str, bytes], Depends(_picture)]


def _attached(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"'}


@router.get(f"{ONE}:export", response_model=Design, summary="Get a design's file", **operation("export_design", *READS))
def export_design(design_id: str, store: Store) -> Response:
    """Answer the newest revision as the file that the studio and the command line open."""
    stored = store.get(design_id)
    design = stored.design
    headers = _attached(file_name(stored, design.name)) | {"ETag": etag(stored.identity)}
    return Response(design.to_json(), media_type="application/json", headers=headers)


@router.get(
    "/designs:export", response_class=Response, responses=ZIP_ANSWER, summary="Get many designs in a zip",
    **operation("export_designs", 404, 410, 422, 503),
)  # fmt: skip
def export_designs(
    store: Store,
    settings: SettingsNow,
    ids: Annotated[
        str,
        Query(max_length=30_000, pattern="^[0-9A-Za-z, ]*$", description="Identifiers, with commas; else all."),
    ] = "",
    tag: TagFilter = None,
) -> Response:
    """Answer a zip with a file for each design, and a manifest of their tags and revisions; `:import` takes it back."""
    named = dict.fromkeys(part.strip() for part in ids.split(",") if part.strip())
    chosen = list(named) or _all_ids(store, tuple(tag or ()))
    if len(chosen) > MOST_ENTRIES:
        message = f"there are more than {MOST_ENTRIES} designs to export"
        raise DesignError([Problem("", message, MOST_ENTRIES, "choose fewer, by ids or by tag")])
    designs = (store.get(design_id) for design_id in chosen)
    content = write_archive(designs, now=time.time(), largest_entry=settings.max_body_bytes)
    return Response(content, media_type=ZIP, headers=_attached("designs.zip"))


def _all_ids(store: DesignStore, tags: tuple[str, ...]) -> list[str]:
    found: list[str] = []
    cursor = None
    while len(found) <= MOST_ENTRIES:
        page = store.find(DesignQuery(tags=tags, order="name", cursor=cursor, limit=MOST_A_PAGE))
        found += [listed.id for listed in page.items]
        cursor = page.next
        if cursor is None:
            break
    return found


@router.post(
    "/designs:import", response_model=ImportReport, summary="Store designs from files",
    **operation("import_designs", 503, files={"application/json": DESIGN_REF, ZIP: ARCHIVE_SCHEMA}),
)  # fmt: skip
def import_designs(sent: Sent, settings: SettingsNow, store: Store) -> Response:
    """Keep every design of a zip, or the one document sent, as a new design; the answer says what became of each file.

    A file that is wrong stops no other. An archive that may do harm is refused whole: encrypted, with paths that
    lead elsewhere, links, archives inside, too many files, or too much in them.
    """
    content, is_zip = sent
    if is_zip:
        entries = read_archive(content, largest_entry=settings.max_body_bytes)
        items = [_imported(entry, settings, store) for entry in entries]
    else:
        design = read_design(loads(content, max_values=settings.max_body_values), settings.limits)
        items = [_kept("", Content(simulable(design, settings)), store)]
    done = sum(item.id is not None for item in items)
    return json_answer(ImportReport(imported=done, refused=len(items) - done, items=items))


def _imported(entry: Entry, settings: Settings, store: DesignStore) -> ImportItem:
    name = None
    try:
        document = loads(entry.content, max_values=settings.max_body_values)
        design = read_design(document, settings.limits)
        name = simulable(design, settings).name
        return _kept(entry.name, Content(design, _tags(entry.tags)), store)
    except DesignError as error:
        problem = ProblemDocument.model_validate_json(bytes(design_problem(error).body))
        return ImportItem(entry=entry.name, name=name, id=None, problem=problem)


def _kept(entry: str, content: Content, store: DesignStore) -> ImportItem:
    stored = store.create(content, comment=f"Imported from {entry}"[:LONGEST_COMMENT] if entry else "Imported")
    return ImportItem(entry=entry, name=content.design.name, id=stored.id, problem=None)


def _tags(tags: Any) -> tuple[str, ...]:
    try:
        return tuple(_TAGS.validate_python(list(tags) if isinstance(tags, list | tuple) else tags))
    except ValidationError as error:
        problems = problems_from_validation(error, tags)
        raise DesignError(replace(p, message=f"the manifest's tags: {p.message}") for p in problems) from None


@router.put(
    f"{ONE}/thumbnail", status_code=204, summary="Set a design's thumbnail",
    **operation("set_thumbnail", 404, 410, 503, files={SVG: SVG_SCHEMA, PNG: PNG_SCHEMA}),
)  # fmt: skip
def set_thumbnail(design_id: str, picture: Picture, store: Store) -> Response:
    """Keep a small picture of a design, PNG or SVG, in place of an earlier one."""
    kind, content = picture
    if len(content) > LARGEST_THUMBNAIL:
        raise HTTPException(413, f"the thumbnail exceeds the limit of {LARGEST_THUMBNAIL} bytes: send a smaller one")
    thumbnail = store.set_thumbnail(design_id, kind, content)
    return Response(status_code=204, headers={"ETag": etag(thumbnail.digest)})


@router.get(
    f"{ONE}/thumbnail", response_class=Response, responses=PICTURES, summary="Get a design's thumbnail",
    **operation("get_thumbnail", 304, *READS),
)  # fmt: skip
def get_thumbnail(design_id: str, store: Store, known: IfNoneMatch = None) -> Response:
    """Answer a design's picture as it was sent, with a policy under which it can do nothing but draw."""
    thumbnail = store.thumbnail(design_id)
    headers = {
        "ETag": etag(thumbnail.digest), "Content-Security-Policy": DRAWN_ONLY, "X-Content-Type-Options": "nosniff",
    }  # fmt: skip
    if is_unchanged(known, thumbnail.digest):
        return Response(status_code=304, headers=headers)
    return Response(thumbnail.content, media_type=thumbnail.media_type, headers=headers)
