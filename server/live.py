"""Owns what the API needs of a studio that is open in a browser: a session's design, and a way to edit it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from models.design import Design


class LiveSession(Protocol):
    """One designer's open document. The API calls it from worker threads."""

    @property
    def design(self) -> Design:
        """The document as it is now."""
        ...

    def edit(self, patch: Sequence[Mapping[str, Any]]) -> Design:
        """Apply a JSON Patch as one undoable step and return the new design.

        Raises
        ------
        DesignError
            Where the patch or its result is wrong; the document then stays as it was.

        """
        ...


class LiveSessions(Protocol):
    """The sessions that are open."""

    def get(self, session_id: str) -> LiveSession | None:
        """Return the session of this name, or None."""
        ...
