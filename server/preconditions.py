"""Owns ETag, If-Match and If-None-Match (RFC 9110, section 13): nobody overwrites what they have not seen."""

from __future__ import annotations

import re
from typing import Annotated

from fastapi import Depends, Header
from starlette.exceptions import HTTPException

from models.problems import Problem, echo
from server.errors import RequestError

ENTITY_TAG = re.compile(r'(W/)?"([^"]*)"')
TAGS = re.compile(r'\s*(W/)?"[^"]*"\s*(,\s*(W/)?"[^"]*"\s*)*')
_IF_MATCH = "ETag of the revision that the change starts from, as GET answered it."
GivenIfMatch = Annotated[str | None, Header(alias="If-Match", description=_IF_MATCH)]
IfNoneMatch = Annotated[
    str | None, Header(alias="If-None-Match", description="ETag of what the client has; 304 where it is still so.")
]


def etag(version: int | str) -> str:
    """Return the ETag of a revision, or of content by its hash."""
    return f'"{version}"'


def is_unchanged(if_none_match: str | None, version: int | str) -> bool:
    """Whether a client has this version already."""
    if if_none_match is None:
        return False
    return if_none_match.strip() == "*" or str(version) in (tag for _, tag in ENTITY_TAG.findall(if_none_match))


async def _allowed(if_match: GivenIfMatch = None) -> frozenset[int] | None:
    if if_match is None or if_match.strip() == "*":
        return None
    if TAGS.fullmatch(if_match) is None:
        raise RequestError([_unreadable(if_match)])
    # a weak tag never matches here, nor does one that was never given
    tags = [tag for weak, tag in ENTITY_TAG.findall(if_match) if not weak]
    return frozenset(int(tag) for tag in tags if tag.isascii() and tag.isdecimal() and len(tag) < 10)


def _unreadable(if_match: str) -> Problem:
    revision = if_match.strip(" '\"")
    example = revision if revision.isascii() and revision.isdecimal() and len(revision) < 10 else "3"
    return Problem(
        "", f"header parameter 'If-Match': {echo(if_match)} is no ETag, whose quotes belong to it",
        hint=f'write If-Match: "{example}", in a shell -H \'If-Match: "{example}"\'; or If-Match: * for any revision',
    )  # fmt: skip


async def _demanded(if_match: GivenIfMatch = None) -> frozenset[int] | None:
    if if_match is None:
        raise HTTPException(
            428,
            "this changes a design that others may be changing too: send If-Match with the ETag that GET answered, "
            'such as If-Match: "3", or If-Match: * to change it whatever it is now',
        )
    return await _allowed(if_match)


IfMatch = Annotated[frozenset[int] | None, Depends(_demanded)]
"""The revisions that a change may start from, None for any; answers 428 where the client does not say."""
IfMatchGiven = Annotated[frozenset[int] | None, Depends(_allowed)]
"""The same, where the client may leave it out."""
