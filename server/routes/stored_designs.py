"""Owns /designs and /designs/{id}: stored designs, their revisions, and what is done to them."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import ValidationError

from models.assemble import assemble
from models.design import Design
from models.problems import DesignError, problems_from_validation
from server.answers import json_answer
from server.dependencies import Document, SettingsNow, Store
from server.documents import design_sent_at, read_design, read_request
from server.editing import apply_patch
from server.openapi import operation
from server.preconditions import IfMatch, IfMatchGiven, IfNoneMatch, etag, is_unchanged
from server.routes import segments  # noqa: F401
from server.schemas import DESIGN_REF, PATCH_SCHEMA
from server.schemas_store import (
    ChangeRequest,
    CreateRequest,
    DesignItem,
    DesignPage,
    DesignResource,
    Order,
    ReplaceRequest,
    RevertRequest,
    RevisionItem,
    RevisionPage,
)
from server.settings import Settings
from server.store.listing import DesignQuery
from server.store.paging import DEFAULT_A_PAGE, LONGEST_CURSOR, MOST_A_PAGE
from server.store.records import Content, ListedDesign, ListedRevision, StoredDesign

router = APIRouter(tags=["stored designs"])
ONE = "/designs/{design_id:segment}"
READS = (404, 410, 422, 503)
WRITES = (403, 404, 410, 412, 422, 428, 503)
JSON_PATCH = {"application/json-patch+json": PATCH_SCHEMA}
Cursor = Annotated[str | None, Query(max_length=LONGEST_CURSOR, description="`next` of the page before.")]
Limit = Annotated[int, Query(ge=1, le=MOST_A_PAGE, description="Most entries in the answer.")]
TagFilter = Annotated[list[str] | None, Query(description="A tag that it must have; several: all of them.")]


def moment(seconds: float) -> datetime:
    """Return a time of the store as answers write it."""
    return datetime.fromtimestamp(seconds, UTC)


def resource(stored: StoredDesign, status: int = 200) -> Response:
    """Return the answer that shows a design, with its ETag."""
    design = stored.design
    shown = DesignResource(
        id=stored.id, name=design.name, notes=design.notes, tags=list(stored.tags), revision=stored.revision,
        identity=stored.identity, created=moment(stored.created), updated=moment(stored.updated),
        comment=stored.comment, design=design,
    )  # fmt: skip
    answer = json_answer(shown, status)
    answer.headers["ETag"] = etag(stored.revision)
    return answer


def renamed(design: Design, settings: Settings, **texts: str | None) -> Design:
    """Return a design with another name or notes; checked, for they come from a user."""
    given = {name: text for name, text in texts.items() if text is not None}
    return read_design(design.model_dump(mode="json") | given, settings.limits) if given else design


def simulable(design: Design, settings: Settings) -> Design:
    """Return the design; raises `DesignError` where it cannot be simulated: what is stored can be run, or was once."""
    assemble(design, settings.limits)
    return design


@router.get(
    "/designs", response_model=DesignPage, summary="List the stored designs",
    **operation("list_designs", 422, 503),
)  # fmt: skip
def list_designs(
    store: Store,
    search: Annotated[str, Query(max_length=200, description="Words that name, notes or tags must hold.")] = "",
    tag: TagFilter = None,
    deleted: Annotated[bool, Query(description="Whether to list the deleted ones instead.")] = False,
    sort: Annotated[Order, Query(description="Order; with a minus, backwards.")] = "-updated",
    cursor: Cursor = None,
    limit: Limit = DEFAULT_A_PAGE,
) -> Response:
    """List designs, a page at a time; what is added meanwhile neither repeats nor hides an entry.

    Each word of `search` must occur in name, notes or tags, anywhere in a word and in either case; words of one or two
    letters, in name or tags.
    """
    query = DesignQuery(search, tuple(tag or ()), deleted, sort, cursor, limit)
    page = store.find(query)
    return json_answer(DesignPage(items=[_item(listed) for listed in page.items], next=page.next))


def _item(listed: ListedDesign) -> DesignItem:
    return DesignItem(
        id=listed.id, name=listed.name, summary=listed.summary, tags=list(listed.tags), revision=listed.revision,
        identity=listed.identity, created=moment(listed.created), updated=moment(listed.updated),
        deleted=None if listed.deleted is None else moment(listed.deleted), thumbnail=listed.thumbnail,
    )  # fmt: skip


@router.post(
    "/designs", status_code=201, response_model=DesignResource, summary="Store a design",
    **operation("create_design", 503, body=CreateRequest, bare=DESIGN_REF),
)  # fmt: skip
def create_design(request: Request, document: Document, settings: SettingsNow, store: Store) -> Response:
    """Keep a design as a new one, at its revision 1; Location says where it is."""
    design, sent, prefix = read_request(document, CreateRequest, settings.limits)
    with design_sent_at("" if sent.name is not None else prefix):
        design = renamed(design, settings, name=sent.name)
    with design_sent_at(prefix):
        simulable(design, settings)
    stored = store.create(Content(design, tuple(sent.tags)), comment=sent.comment)
    answer = resource(stored, 201)
    answer.headers["Location"] = f"{request.url.path}/{stored.id}"
    return answer


@router.get(
    ONE, response_model=DesignResource, summary="Get a stored design",
    **operation("get_design", 304, *READS),
)  # fmt: skip
def get_design(design_id: str, store: Store, known: IfNoneMatch = None) -> Response:
    """Answer a design at its newest revision; with If-None-Match, 304 where the client has that already."""
    stored = store.get(design_id)
    if is_unchanged(known, stored.revision):
        return Response(status_code=304, headers={"ETag": etag(stored.revision)})
    return resource(stored)


@router.put(
    ONE, response_model=DesignResource, summary="Replace a stored design",
    **operation("replace_design", *WRITES, body=ReplaceRequest, bare=DESIGN_REF),
)  # fmt: skip
def replace_design(
    design_id: str, if_match: IfMatch, document: Document, settings: SettingsNow, store: Store
) -> Response:
    """Make a new revision of the whole document; where it is the same as before, there is no new one."""
    design, sent, prefix = read_request(document, ReplaceRequest, settings.limits)
    with design_sent_at(prefix):
        simulable(design, settings)

    def change(before: Content) -> Content:
        return Content(design, before.tags if sent.tags is None else tuple(sent.tags))

    return resource(store.change(design_id, change, expected=if_match, comment=sent.comment))


@router.patch(
    ONE, response_model=DesignResource, summary="Change a stored design",
    **operation("change_design", *WRITES, body=ChangeRequest, bare=PATCH_SCHEMA, files=JSON_PATCH),
)  # fmt: skip
def change_design(
    design_id: str, if_match: IfMatch, document: Document, settings: SettingsNow, store: Store
) -> Response:
    """Make a new revision by a JSON Patch (RFC 6902), bare or as {patch}, or by a new name, notes or tags.

    Pointers of errors that begin with /patch lead into the patch, all others into the design it would have made.
    """
    sent = _read(ChangeRequest, document if isinstance(document, dict) else {"patch": document})

    def change(before: Content) -> Content:
        design = before.design if sent.patch is None else apply_patch(before.design, sent.patch)
        design = renamed(design, settings, name=sent.name, notes=sent.notes)
        return Content(simulable(design, settings), before.tags if sent.tags is None else tuple(sent.tags))

    return resource(store.change(design_id, change, expected=if_match, comment=sent.comment))


@router.delete(ONE, status_code=204, summary="Delete a stored design", **operation("delete_design", *WRITES[:-2], 503))
def delete_design(design_id: str, if_match: IfMatchGiven, store: Store) -> Response:
    """Put a design away: lists of deleted designs still show it, and it can be restored, revisions and all."""
    store.delete(design_id, expected=if_match)
    return Response(status_code=204)


@router.post(
    f"{ONE}:restore", response_model=DesignResource, summary="Restore a deleted design",
    **operation("restore_design", 403, 404, 422, 503),
)  # fmt: skip
def restore_design(design_id: str, store: Store) -> Response:
    """Bring a deleted design back as it was; one that is not deleted stays as it is."""
    return resource(store.restore(design_id))


@router.get(
    f"{ONE}/revisions", response_model=RevisionPage, summary="List the revisions of a design",
    **operation("list_revisions", *READS),
)  # fmt: skip
def list_revisions(design_id: str, store: Store, cursor: Cursor = None, limit: Limit = DEFAULT_A_PAGE) -> Response:
    """List a design's history, the newest first."""
    page = store.revisions(design_id, cursor=cursor, limit=limit)
    return json_answer(RevisionPage(items=[_revision(listed) for listed in page.items], next=page.next))


def _revision(listed: ListedRevision) -> RevisionItem:
    return RevisionItem(
        revision=listed.revision, identity=listed.identity, name=listed.name, tags=list(listed.tags),
        comment=listed.comment, created=moment(listed.created),
    )  # fmt: skip


@router.get(
    f"{ONE}/revisions/{{number}}", response_model=DesignResource, summary="Get a revision of a design",
    **operation("get_revision", *READS),
)  # fmt: skip
def get_revision(design_id: str, number: int, store: Store) -> Response:
    """Answer a design as it was at a revision; revisions never change."""
    return resource(store.revision(design_id, number))


@router.post(
    f"{ONE}:revert", response_model=DesignResource, summary="Go back to a revision",
    **operation("revert_design", *WRITES, body=RevertRequest),
)  # fmt: skip
def revert_design(design_id: str, if_match: IfMatch, document: Document, store: Store) -> Response:
    """Make a new revision that equals an old one, tags included; those between stay in the history."""
    sent = _read(RevertRequest, document)
    return resource(store.revert(design_id, sent.revision, expected=if_match, comment=sent.comment))


def _read(model: type[Any], document: Any) -> Any:
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None
