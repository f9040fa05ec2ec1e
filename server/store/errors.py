"""Owns what can go wrong with the store, each a type of its own with the way out in its message."""

from __future__ import annotations


class StoreError(Exception):
    """What is asked of the store cannot be done; the message says why, and what can."""


class NotFoundError(StoreError):
    """There is nothing of this name."""


class DeletedError(StoreError):
    """The design was deleted; it can be restored."""


class RevisionError(StoreError):
    """The design has moved on from the revision that a change was made for."""

    def __init__(self, message: str, *, current: int) -> None:
        self.current = current
        super().__init__(message)


class CursorError(StoreError):
    """A cursor is not one that this list gave."""


class UnavailableError(StoreError):
    """The database does not answer, is full, or was written by a newer program."""
