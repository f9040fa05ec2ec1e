"""Owns what the store gives and takes: a design at one of its revisions, entries of lists, and thumbnails."""

from __future__ import annotations

import hashlib
import json
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import rfc8785

from models.design import Design, parse_design


@dataclass(frozen=True)
class Content:
    """What a revision holds: a document, and the tags that it is filed under."""

    design: Design
    tags: tuple[str, ...] = ()

    @cached_property
    def document(self) -> str:
        """The document as canonical JSON (RFC 8785)."""
        return rfc8785.dumps(self.design.model_dump(mode="json")).decode()

    @cached_property
    def identity(self) -> str:
        """The design's identity, which is the hash of what is stored."""
        return hashlib.sha256(self.document.encode()).hexdigest()


@dataclass(frozen=True)
class StoredDesign:
    """A design at one of its revisions."""

    id: str
    revision: int
    identity: str
    tags: tuple[str, ...]
    comment: str
    created: float
    updated: float
    """When this revision was made."""
    document: str

    @cached_property
    def design(self) -> Design:
        """The document, checked again as it is read."""
        return parse_design(json.loads(self.document))


@dataclass(frozen=True, slots=True)
class ListedDesign:
    """A design as lists show it."""

    id: str
    name: str
    summary: str
    tags: tuple[str, ...]
    revision: int
    identity: str
    created: float
    updated: float
    deleted: float | None
    thumbnail: str | None
    """Digest of its thumbnail, if it has one."""


@dataclass(frozen=True, slots=True)
class ListedRevision:
    """One revision in a design's history."""

    revision: int
    identity: str
    name: str
    tags: tuple[str, ...]
    comment: str
    created: float


@dataclass(frozen=True, slots=True)
class Thumbnail:
    """A small picture of a design."""

    media_type: str
    content: bytes
    digest: str


def fold(text: str) -> str:
    """Return text for comparing and searching: of one case, of one way of writing each letter."""
    return unicodedata.normalize("NFKC", text).casefold().replace("\0", " ")


def distinct(tags: Iterable[str]) -> tuple[str, ...]:
    """Return tags in their order, of those that differ by case alone the first."""
    seen: dict[str, str] = {}
    for tag in tags:
        seen.setdefault(fold(tag), tag)
    return tuple(seen.values())


def read_tags(stored: str) -> tuple[str, ...]:
    """Return tags from a column."""
    return tuple(json.loads(stored))


def write_tags(tags: Iterable[str]) -> str:
    """Return tags for a column."""
    return json.dumps(list(tags), ensure_ascii=False)
