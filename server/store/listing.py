"""Owns lists of designs: search over name, notes and tags, filters, orders and pages.

Every word of a search must occur, anywhere in a word and in either case. Words of three letters or more are sought in
name, notes and tags, in SQLite through an index of trigrams; shorter ones, which it does not help, in name and tags.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    String,
    bindparam,
    func,
    literal_column,
    select,
    text,
    union_all,
)

from server.store.paging import DEFAULT_A_PAGE, Page, after, page_of, read_cursor, write_cursor
from server.store.records import ListedDesign, ListedRevision, fold, read_tags
from server.store.tables import design_tags, design_texts, designs, revisions, thumbnails

ORDERS = {"updated": designs.c.updated, "created": designs.c.created, "name": designs.c.name_folded}
MOST_WORDS = 10
TRIGRAM = 3


@dataclass(frozen=True, slots=True)
class DesignQuery:
    """Which designs to list, in which order, and which page of them."""

    search: str = ""
    tags: tuple[str, ...] = ()
    deleted: bool = False
    order: str = "-updated"
    """A name of `ORDERS`; with a minus before it, the other way round."""
    cursor: str | None = None
    limit: int = DEFAULT_A_PAGE


def list_designs(connection: Connection, query: DesignQuery) -> Page[ListedDesign]:
    """Return one page of designs; raises `CursorError`."""
    name, descending = query.order.removeprefix("-"), query.order.startswith("-")
    column, number = ORDERS[name], designs.c.number
    statement = (
        select(designs, thumbnails.c.digest)
        .outerjoin(thumbnails, thumbnails.c.design_id == designs.c.id)
        .where(designs.c.deleted.is_not(None) if query.deleted else designs.c.deleted.is_(None))
        .order_by(*((column.desc(), number.desc()) if descending else (column, number)))
        .limit(query.limit + 1)
    )
    sqlite = connection.dialect.name == "sqlite"
    # the sum keeps SQLite on the index of the order, where it stops at the page's end, whatever is sought
    for found in _sought(query, sqlite=sqlite):
        statement = statement.where((number + 0 if sqlite else number).in_(found))
    if query.cursor is not None:
        values = read_cursor(query.cursor, query.order, str if name == "name" else float, int)
        statement = statement.where(after(column, number, values, descending=descending))

    def cursor(row: Row[Any]) -> str:
        return write_cursor(query.order, row._mapping[column], row.number)

    return page_of(connection.execute(statement).all(), query.limit, _listed, cursor)


def _sought(query: DesignQuery, *, sqlite: bool) -> Iterator[Select[Any]]:
    """Yield sets of designs that a query asks for; its answer is in all of them."""
    words = fold(query.search).split()[:MOST_WORDS]
    long, short = [w for w in words if len(w) >= TRIGRAM], [w for w in words if len(w) < TRIGRAM]
    for tag in query.tags:
        yield select(design_tags.c.design).where(design_tags.c.tag == fold(tag))
    for word in short:
        named = select(designs.c.number).where(_holds(designs.c.name_folded, word, sqlite=sqlite))
        tagged = select(design_tags.c.design).where(_holds(design_tags.c.tag, word, sqlite=sqlite))
        yield select(union_all(named, tagged).subquery())
    if long and sqlite:
        quoted = " AND ".join('"' + word.replace('"', '""') + '"' for word in long)
        matching = text("design_search MATCH :words").bindparams(bindparam("words", quoted, String))
        yield select(literal_column("rowid")).select_from(text("design_search")).where(matching)
    elif long:
        holds = (_holds(design_texts.c.folded, word, sqlite=sqlite) for word in long)
        yield select(design_texts.c.design).where(*holds)


def _holds(column: ColumnElement[str], word: str, *, sqlite: bool) -> ColumnElement[bool]:
    return func.instr(column, word) > 0 if sqlite else column.contains(word, autoescape=True)


def _listed(row: Row[Any]) -> ListedDesign:
    return ListedDesign(
        id=row.id, name=row.name, summary=row.summary, tags=read_tags(row.tags), revision=row.revision,
        identity=row.identity, created=row.created, updated=row.updated, deleted=row.deleted, thumbnail=row.digest,
    )  # fmt: skip


def list_revisions(connection: Connection, design_id: str, cursor: str | None, limit: int) -> Page[ListedRevision]:
    """Return one page of a design's revisions, the newest first; raises `CursorError`."""
    statement = select(revisions).where(revisions.c.design_id == design_id)
    if cursor is not None:
        (before,) = read_cursor(cursor, design_id, int)
        statement = statement.where(revisions.c.number < min(before, 2**31 - 1))
    rows = connection.execute(statement.order_by(revisions.c.number.desc()).limit(limit + 1)).all()
    return page_of(rows, limit, _listed_revision, lambda row: write_cursor(design_id, row.number))


def _listed_revision(row: Row[Any]) -> ListedRevision:
    return ListedRevision(
        revision=row.number, identity=row.identity, name=row.name, tags=read_tags(row.tags), comment=row.comment,
        created=row.created,
    )  # fmt: skip
