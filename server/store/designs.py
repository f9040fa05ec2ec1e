"""Owns the stored designs: made, read, changed by new revisions, deleted so that they can be restored.

Every change of a document or its tags is a revision, which is never altered or removed. Of two writers who start from
the same revision one succeeds; the other is told. What a change computes, it computes before the database is locked.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, select, update

from server.store.database import Database, insert_once
from server.store.errors import DeletedError, NotFoundError, RevisionError
from server.store.identifiers import is_id, new_id
from server.store.listing import DesignQuery, list_designs, list_revisions
from server.store.paging import DEFAULT_A_PAGE, Page
from server.store.records import (
    Content,
    ListedDesign,
    ListedRevision,
    StoredDesign,
    Thumbnail,
    distinct,
    fold,
    read_tags,
    write_tags,
)
from server.store.tables import design_tags, design_texts, designs, documents, revisions, thumbnails
from server.store.thumbnails import check_thumbnail
from server.summaries import summarize

Change = Callable[[Content], Content]
TRIES = 20
"""How often a change that names no revision starts anew where others were quicker."""
LONGEST_COMMENT = 500


class DesignStore:
    """The designs in a database. Threads and processes may share it."""

    def __init__(
        self, database: Database, *, clock: Callable[[], float] = time.time, make_id: Callable[[], str] = new_id
    ) -> None:
        self.database = database
        self._clock = clock
        self._make_id = make_id

    def check(self) -> None:
        """Ask the database for nothing; raises `UnavailableError` where it does not answer."""
        with self.database.read() as connection:
            connection.execute(select(1))

    def create(self, content: Content, *, comment: str = "") -> StoredDesign:
        """Keep a new design, at its revision 1."""
        content = Content(content.design, distinct(content.tags))
        design_id, now = self._make_id(), self._clock()
        with self.database.write() as connection:
            _keep_document(connection, content)
            row = _head_columns(content) | {"id": design_id, "revision": 1, "created": now, "updated": now}
            number = connection.execute(insert(designs).values(row).returning(designs.c.number)).scalar_one()
            connection.execute(insert(design_texts).values(design=number, folded=_searchable(content)))
            _keep_revision(connection, design_id, 1, content, comment, now)
            _file_under(connection, number, content.tags)
        return _stored(design_id, 1, content, comment, created=now, updated=now)

    def get(self, design_id: str) -> StoredDesign:
        """Return a design at its newest revision; raises `NotFoundError`, `DeletedError`."""
        with self.database.read() as connection:
            return _read(connection, _require(connection, design_id))

    def revision(self, design_id: str, number: int) -> StoredDesign:
        """Return a design as it was at a revision; raises `NotFoundError`, `DeletedError`."""
        with self.database.read() as connection:
            return _read(connection, _require(connection, design_id), number)

    def find(self, query: DesignQuery) -> Page[ListedDesign]:
        """Return one page of designs; raises `CursorError`."""
        with self.database.read() as connection:
            return list_designs(connection, query)

    def revisions(
        self, design_id: str, *, cursor: str | None = None, limit: int = DEFAULT_A_PAGE
    ) -> Page[ListedRevision]:
        """Return one page of revisions, the newest first; raises `NotFoundError`, `DeletedError`, `CursorError`."""
        with self.database.read() as connection:
            _require(connection, design_id)
            return list_revisions(connection, design_id, cursor, limit)

    def change(
        self, design_id: str, make: Change, *, expected: Collection[int] | None = None, comment: str = ""
    ) -> StoredDesign:
        """Make a new revision of what `make` returns for the newest one; where that is the same, there is no new one.

        Parameters
        ----------
        design_id
            The design.
        make
            Called with the content as it is now, again where another writer was quicker and `expected` allows it.
        expected
            The revisions that the change may start from; any, if not given.
        comment
            What the change is, in words.

        Raises
        ------
        NotFoundError, DeletedError, RevisionError
            Where the design is not there, or not at an expected revision.

        """
        for _ in range(TRIES):
            head = self.get(design_id)
            _require_revision(design_id, head.revision, expected)
            made = make(Content(head.design, head.tags))
            made = Content(made.design, distinct(made.tags))
            if made.identity == head.identity and made.tags == head.tags:
                return head
            with suppress(_OvertakenError):
                return self._append(head, made, comment)
        raise RevisionError(f"design {design_id} is being changed by many others: try again", current=head.revision)

    def _append(self, head: StoredDesign, content: Content, comment: str) -> StoredDesign:
        number, now = head.revision + 1, self._clock()
        with self.database.write() as connection:
            _keep_document(connection, content)
            still_head = (designs.c.id == head.id) & (designs.c.revision == head.revision) & designs.c.deleted.is_(None)
            row = _head_columns(content) | {"revision": number, "updated": now}
            if connection.execute(update(designs).where(still_head).values(row)).rowcount != 1:
                raise _OvertakenError
            _keep_revision(connection, head.id, number, content, comment, now)
            design = connection.execute(select(designs.c.number).where(designs.c.id == head.id)).scalar_one()
            connection.execute(
                update(design_texts).where(design_texts.c.design == design).values(folded=_searchable(content))
            )
            if content.tags != head.tags:
                connection.execute(delete(design_tags).where(design_tags.c.design == design))
                _file_under(connection, design, content.tags)
        return _stored(head.id, number, content, comment, created=head.created, updated=now)

    def revert(
        self, design_id: str, number: int, *, expected: Collection[int] | None = None, comment: str = ""
    ) -> StoredDesign:
        """Make a new revision equal to an old one, tags included; raises as `change` does."""
        old = self.revision(design_id, number)
        back = Content(old.design, old.tags)
        comment = comment or f"Back to revision {number}"
        return self.change(design_id, lambda _: back, expected=expected, comment=comment)

    def delete(self, design_id: str, *, expected: Collection[int] | None = None) -> None:
        """Put a design away, so that it can be restored; raises as `change` does."""
        with self.database.write() as connection:
            row = _require(connection, design_id, lock=True)
            _require_revision(design_id, row.revision, expected)
            connection.execute(update(designs).where(designs.c.id == design_id).values(deleted=self._clock()))

    def restore(self, design_id: str) -> StoredDesign:
        """Bring a deleted design back as it was; one that is not deleted stays as it is. Raises `NotFoundError`."""
        with self.database.write() as connection:
            row = _require(connection, design_id, lock=True, deleted_too=True)
            connection.execute(update(designs).where(designs.c.id == design_id).values(deleted=None))
            return _read(connection, row)

    def set_thumbnail(self, design_id: str, media_type: str, content: bytes) -> Thumbnail:
        """Keep a design's picture in place of an earlier one; raises `DesignError` where it is none that is safe."""
        thumbnail = check_thumbnail(media_type, content)
        with self.database.write() as connection:
            _require(connection, design_id, lock=True)
            connection.execute(delete(thumbnails).where(thumbnails.c.design_id == design_id))
            connection.execute(
                insert(thumbnails).values(
                    design_id=design_id, media_type=media_type, content=content, digest=thumbnail.digest,
                    created=self._clock(),
                )
            )  # fmt: skip
        return thumbnail

    def thumbnail(self, design_id: str) -> Thumbnail:
        """Return a design's picture; raises `NotFoundError`, `DeletedError`."""
        with self.database.read() as connection:
            _require(connection, design_id)
            row = connection.execute(select(thumbnails).where(thumbnails.c.design_id == design_id)).one_or_none()
        if row is None:
            raise NotFoundError(f"design {design_id} has no thumbnail")
        return Thumbnail(row.media_type, bytes(row.content), row.digest)


class _OvertakenError(Exception):
    """Another writer made a revision, or deleted the design, since it was read."""


def _require(connection: Connection, design_id: str, *, lock: bool = False, deleted_too: bool = False) -> Row[Any]:
    statement = select(designs).where(designs.c.id == design_id)
    # what cannot be an identifier is not asked for: PostgreSQL refuses some characters
    found = connection.execute(statement.with_for_update() if lock else statement) if is_id(design_id) else None
    row = found.one_or_none() if found is not None else None
    if row is None:
        raise NotFoundError(f"there is no design {design_id!r:.60}")
    if row.deleted is not None and not deleted_too:
        raise DeletedError(f"design {design_id} was deleted: restore it to use it again")
    return row


def _require_revision(design_id: str, current: int, expected: Collection[int] | None) -> None:
    if expected is not None and current not in expected:
        started = " or ".join(map(str, sorted(expected))) or "none that it ever had"
        raise RevisionError(
            f"design {design_id} is at revision {current}, and the change is for {started}: "
            "get the design again, make the change again, and send that",
            current=current,
        )


def _read(connection: Connection, row: Row[Any], number: int | None = None) -> StoredDesign:
    number = row.revision if number is None else number
    # numbers beyond the column's range are refused by PostgreSQL
    statement = (
        select(revisions, documents.c.content)
        .join(documents, documents.c.identity == revisions.c.identity)
        .where(revisions.c.design_id == row.id, revisions.c.number == min(number, 2**31 - 1))
    )
    found = connection.execute(statement).one_or_none()
    if found is None:
        raise NotFoundError(f"design {row.id} has no revision {number}: its newest is {row.revision}")
    return StoredDesign(
        id=row.id, revision=found.number, identity=found.identity, tags=read_tags(found.tags), comment=found.comment,
        created=row.created, updated=found.created, document=found.content,
    )  # fmt: skip


def _stored(
    design_id: str, number: int, content: Content, comment: str, *, created: float, updated: float
) -> StoredDesign:
    return StoredDesign(
        id=design_id, revision=number, identity=content.identity, tags=content.tags, comment=comment, created=created,
        updated=updated, document=content.document,
    )  # fmt: skip


def _head_columns(content: Content) -> dict[str, Any]:
    design = content.design
    return {
        "name": design.name,
        "name_folded": fold(design.name)[:400],
        "summary": summarize(design.notes.replace("\0", " ")),
        "tags": write_tags(content.tags),
        "identity": content.identity,
    }


def _searchable(content: Content) -> str:
    return fold("\n".join([content.design.name, *content.tags, content.design.notes]))


def _keep_document(connection: Connection, content: Content) -> None:
    statement = insert_once(connection, documents)
    connection.execute(statement.values(identity=content.identity, content=content.document))


def _keep_revision(
    connection: Connection, design_id: str, number: int, content: Content, comment: str, now: float
) -> None:
    connection.execute(
        insert(revisions).values(
            design_id=design_id, number=number, identity=content.identity, name=content.design.name,
            tags=write_tags(content.tags), comment=comment, created=now,
        )
    )  # fmt: skip


def _file_under(connection: Connection, design: int, tags: tuple[str, ...]) -> None:
    if tags:
        connection.execute(insert(design_tags), [{"design": design, "tag": fold(tag)} for tag in tags])
