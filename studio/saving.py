"""Owns how a session's document becomes a stored design: a new one, or the next revision of where it came from.

A revision is only added to the one that the document started from, or to one that the designer has seen since.
"""

from __future__ import annotations

import logging
import time
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from models.design import Design
from models.problems import DesignError, Problem, problems_from_validation
from server.store.designs import DesignStore
from server.store.errors import StoreError
from server.store.records import Content, StoredDesign
from server.store.thumbnails import SVG
from studio.origin import Origin, StoredOrigin
from studio.registry import OpenSession
from studio.session import Session
from studio.thumbnail import draw

log = logging.getLogger(__name__)
PATIENCE = 10.0
"""How long a picture waits for the glide that it shows, s."""


class SaveRequest(BaseModel):
    """How to save: `next` to where the document came from, as a `new` design, `over` a newer revision, or `restore`."""

    model_config = ConfigDict(extra="forbid", frozen=True, hide_input_in_errors=True)

    how: Literal["next", "new", "over", "restore"] = "next"
    name: str | None = None
    """Name of a new design, where it is to have another."""
    revision: Annotated[int, Field(ge=1)] | None = None
    """The newer revision that was seen; whatever comes after it is not overwritten."""

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if (self.how == "over") != (self.revision is not None):
            raise ValueError("'over' needs the revision that was seen, and only 'over' takes one")
        if self.name is not None and self.how != "new":
            raise ValueError("only a 'new' design takes a name")
        return self


def read_save(document: Any) -> SaveRequest:
    """Return what was asked for; raises `DesignError`."""
    try:
        return SaveRequest.model_validate(document)
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None


def save(opened: OpenSession, store: DesignStore, asked: SaveRequest) -> StoredDesign:
    """Store the session's document, and have the session come from there.

    Raises
    ------
    RevisionError
        Where another writer made a newer revision.
    NotFoundError, DeletedError
        Where the design that the document came from is gone.
    DesignError
        Where the new name cannot be one, or there is no design to add to.

    """
    session = opened.session
    with opened.saving:  # two tabs that save at once make two revisions, not a conflict with each other
        if asked.name is not None:
            session.set_field("/name", asked.name)
        design = session.design
        stored = _keep(store, session.origin, design, asked)
        session.come_from(origin_of(stored))
    return stored


def origin_of(stored: StoredDesign) -> StoredOrigin:
    """Return the origin of a document that was opened from a stored design, or saved as one."""
    return StoredOrigin(stored.id, stored.revision, stored.identity)


def _keep(store: DesignStore, origin: Origin | None, design: Design, asked: SaveRequest) -> StoredDesign:
    if asked.how == "new" or (asked.how == "next" and not isinstance(origin, StoredOrigin)):
        return store.create(Content(design), comment="Saved in the studio")
    if not isinstance(origin, StoredOrigin):
        raise DesignError([Problem("/how", "this document was never saved", hint="save it as a new design")])
    if asked.how == "restore":
        store.restore(origin.design_id)
    expected = {origin.revision if asked.revision is None else asked.revision}
    return store.change(
        origin.design_id, lambda before: Content(design, before.tags), expected=expected, comment="Saved in the studio"
    )


def keep_picture(session: Session, store: DesignStore, stored: StoredDesign) -> None:
    """Draw a design that was just saved, with its glide once that is there, and keep the picture with it."""
    until = time.monotonic() + PATIENCE
    while session.simulating and time.monotonic() < until:
        time.sleep(0.02)
    design, run = stored.design, session.run
    picture = draw(design, run if run is not None and run.design == design else None)
    try:
        store.set_thumbnail(stored.id, SVG, picture.encode())
    except (StoreError, DesignError) as error:  # the design itself is safe
        log.warning("the picture of design %s could not be kept: %s", stored.id, error)
