"""Owns cursors: opaque text that says after which entry of a sorted list the next page begins."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from sqlalchemy import ColumnElement, and_, or_

from models.problems import echo
from server.store.errors import CursorError

MOST_A_PAGE = 200
DEFAULT_A_PAGE = 50
LONGEST_CURSOR = 2000
ItemT = TypeVar("ItemT")


@dataclass(frozen=True, slots=True)
class Page(Generic[ItemT]):
    """Some entries of a list, and the cursor of those that follow, if any do."""

    items: tuple[ItemT, ...]
    next: str | None


def write_cursor(order: str, *values: float | str) -> str:
    """Return the cursor after the entry that has these values in the columns of an order."""
    return base64.urlsafe_b64encode(json.dumps([order, *values]).encode()).decode().rstrip("=")


def read_cursor(cursor: str, order: str, *kinds: type) -> list[Any]:
    """Return the values in a cursor; raises `CursorError` where it is none, or one of another order."""
    try:
        if len(cursor) > LONGEST_CURSOR:
            raise ValueError("too long")
        values: list[Any]
        given, *values = json.loads(base64.urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4)))
        if [type(value) for value in values] != list(kinds) or any(map(_is_odd, values)):
            raise ValueError("other values")
    except (ValueError, TypeError, RecursionError):
        raise CursorError(f"the cursor {echo(cursor)} is not one that this list gave: begin without one") from None
    if given != order:
        raise CursorError(f"the cursor belongs to a list in another order, {echo(given)}: begin again without one")
    return values


def _is_odd(value: float | str) -> bool:
    """Whether a value can stand in no column: PostgreSQL refuses it."""
    return "\0" in value if isinstance(value, str) else not abs(value) < 2**31 if isinstance(value, int) else False


def after(
    column: ColumnElement[Any], tie: ColumnElement[Any], values: Sequence[Any], *, descending: bool
) -> ColumnElement[bool]:
    """Return the condition that an entry comes after the one with these values; `tie` decides between equals."""
    value, last = values
    if descending:
        return and_(column <= value, or_(column < value, tie < last))
    return and_(column >= value, or_(column > value, tie > last))


def page_of(rows: Sequence[Any], limit: int, read: Callable[[Any], ItemT], cursor: Callable[[Any], str]) -> Page[ItemT]:
    """Return a page from rows of which one more was asked for than is shown."""
    shown = rows[:limit]
    return Page(tuple(read(row) for row in shown), cursor(shown[-1]) if len(rows) > limit else None)
