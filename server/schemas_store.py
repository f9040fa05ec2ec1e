"""Owns the wire types of stored designs: what is sent and answered under /designs and /designs/{id}/components."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, model_validator

from models.components import Component
from models.design import Design
from server.schemas import DesignDocument, Patch, ProblemDocument, Wire
from server.store.designs import LONGEST_COMMENT

MOST_TAGS = 20
TAG_PATTERN = r"^[^\x00-\x20\x7f,]([^\x00-\x1f\x7f,]*[^\x00-\x20\x7f,])?$"
Tag = Annotated[str, Field(min_length=1, max_length=40, pattern=TAG_PATTERN)]
Tags = Annotated[list[Tag], Field(max_length=MOST_TAGS)]
Comment = Annotated[str, Field(max_length=LONGEST_COMMENT, pattern=r"^[^\x00]*$")]
Order = Literal["updated", "-updated", "created", "-created", "name", "-name"]
COMPONENT_SCHEMA = {
    "oneOf": [
        {"$ref": f"#/components/schemas/{kind}"}
        for kind in ("Rigid", "Bellows", "Piston", "Bladder", "MovableMass", "RollingMass")
    ]
}
MERGE_SCHEMA = {"type": "object", "description": "Fields of the component to change; null takes one to its default."}
ARCHIVE_SCHEMA = {"type": "string", "format": "binary", "description": "A zip archive of design files."}
PNG_SCHEMA = {"type": "string", "format": "binary"}
SVG_SCHEMA = {"type": "string", "description": "An SVG picture that only draws: no scripts, links or fonts."}


class CreateRequest(Wire):
    """A design to keep; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    name: str | None = Field(default=None, description="A name in place of the document's own.")
    tags: Tags = Field(default=[], description="Words to file it under; case does not tell them apart.")
    comment: Comment = Field(default="", description="What this revision is, in words.")


class ReplaceRequest(Wire):
    """The whole design anew; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    tags: Tags | None = Field(default=None, description="All its tags; if not given they stay.")
    comment: Comment = Field(default="", description="What the change is, in words.")


class ChangeRequest(Wire):
    """Parts of a design to change, in this order: patch, name, notes, tags; also the JSON Patch itself."""

    patch: Patch = Field(default=None, description="JSON Patch (RFC 6902) on the document.")
    name: str | None = Field(default=None, description="The document's name.")
    notes: str | None = Field(default=None, description="The document's notes.")
    tags: Tags | None = Field(default=None, description="All its tags.")
    comment: Comment = Field(default="", description="What the change is, in words.")

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if self.patch is None and self.name is None and self.notes is None and self.tags is None:
            raise ValueError("there is nothing to change: give patch, name, notes or tags")
        return self


class RevertRequest(Wire):
    """Which revision to go back to."""

    revision: int = Field(ge=1, description="Its number, from the list of revisions.")
    comment: Comment = Field(default="", description="What the change is, in words.")


class DesignResource(Wire):
    """A stored design at one of its revisions."""

    id: str = Field(description="Identifier, for /designs/{id}.")
    name: str = Field(description="The document's name.")
    notes: str = Field(description="The document's notes.")
    tags: list[str] = Field(description="Words that it is filed under.")
    revision: int = Field(description="Number of this revision; in quotes, its ETag.")
    identity: str = Field(description="SHA-256 of the canonical JSON: equal for equal designs.")
    created: datetime = Field(description="When the design was made.")
    updated: datetime = Field(description="When this revision was made.")
    comment: str = Field(description="What this revision is, in words.")
    design: Design = Field(description="The document.")


class DesignItem(Wire):
    """A stored design in a list."""

    id: str = Field(description="Identifier, for /designs/{id}.")
    name: str = Field(description="The document's name.")
    summary: str = Field(description="The beginning of its notes.")
    tags: list[str] = Field(description="Words that it is filed under.")
    revision: int = Field(description="Number of its newest revision.")
    identity: str = Field(description="SHA-256 of the newest revision's canonical JSON.")
    created: datetime = Field(description="When the design was made.")
    updated: datetime = Field(description="When the newest revision was made.")
    deleted: datetime | None = Field(description="When it was deleted; null where it is not.")
    thumbnail: str | None = Field(description="SHA-256 of its thumbnail; null where it has none.")


class DesignPage(Wire):
    """Some of the stored designs."""

    items: list[DesignItem] = Field(description="In the order that was asked for.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class RevisionItem(Wire):
    """A revision in a design's history."""

    revision: int = Field(description="Its number.")
    identity: str = Field(description="SHA-256 of its canonical JSON.")
    name: str = Field(description="The document's name then.")
    tags: list[str] = Field(description="Words that it was filed under.")
    comment: str = Field(description="What it is, in words.")
    created: datetime = Field(description="When it was made.")


class RevisionPage(Wire):
    """Some of a design's revisions."""

    items: list[RevisionItem] = Field(description="The newest first.")
    next: str | None = Field(description="Cursor of the next page; null at the end.")


class ComponentList(Wire):
    """The components of a stored design."""

    revision: int = Field(description="The revision that they are of; in quotes, the ETag.")
    items: list[Component] = Field(description="In the design's order.")


class ImportItem(Wire):
    """What became of one file."""

    entry: str = Field(description="Its name in the archive; empty where one document was sent.")
    name: str | None = Field(description="The design's name, if it could be read.")
    id: str | None = Field(description="Identifier of the new design; null where it was refused.")
    problem: ProblemDocument | None = Field(description="Why it was refused; null where it was not.")


class ImportReport(Wire):
    """What became of each file: those that are right are kept, whatever is wrong with others."""

    imported: int = Field(description="Number of new designs.")
    refused: int = Field(description="Number of files that are none.")
    items: list[ImportItem] = Field(description="Each file, in the archive's order.")


STORE_REQUESTS: tuple[type[BaseModel], ...] = (CreateRequest, ReplaceRequest, ChangeRequest, RevertRequest)
"""Types that OpenAPI must hold though no route declares them to FastAPI."""
