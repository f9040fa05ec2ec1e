"""Owns what the pages of a session chose to see in the scene that only the server can draw."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from models.problems import DesignError, Problem
from studio.path_colors import QUANTITIES

PLAIN = "none"
"""The name by which a page asks for a path in one colour."""
LONGEST_ID = 40
"""Characters of a kept run's id at most: the session's file holds whatever is asked for."""


@dataclass(frozen=True, slots=True)
class Display:
    """The quantity that colours the path, None for one colour, and the kept run whose ghost flies along."""

    color_by: str | None = "speed"
    ghost: str | None = None

    def document(self) -> dict[str, str | None]:
        """Return it as pages ask for it, and the session's file holds it."""
        return {"color_by": self.color_by or PLAIN, "ghost": self.ghost}


FIRST_DISPLAY = Display()


def changed(display: Display, document: Any) -> Display:
    """Return a display with the members of a document: `color_by`, the name of a quantity, and `ghost`, a kept run's.

    Raises `DesignError` where it asks for anything else. A run that is no longer kept is merely not shown.
    """
    if not isinstance(document, dict) or not document or not set(document) <= {"color_by", "ghost"}:
        message = "send an object with color_by, ghost, or both"
        raise DesignError([Problem("", message, hint='for example {"color_by": "speed"} or {"ghost": "run-1"}')])
    if "color_by" in document:
        display = replace(display, color_by=_quantity(document["color_by"]))
    if "ghost" in document:
        ghost = document["ghost"]
        if ghost is not None and not (isinstance(ghost, str) and len(ghost) <= LONGEST_ID):
            raise DesignError(
                [Problem("/ghost", "ghost is neither the id of a kept run nor null", hint="null hides it")]
            )
        display = replace(display, ghost=ghost)
    return display


def read_display(document: Any) -> Display:
    """Return the display of a session's file; the first one where there is none that this version knows."""
    try:
        return changed(FIRST_DISPLAY, document)
    except DesignError:
        return FIRST_DISPLAY


def _quantity(name: Any) -> str | None:
    if name == PLAIN:
        return None
    if not isinstance(name, str) or name not in QUANTITIES:
        known = ", ".join((PLAIN, *QUANTITIES))
        raise DesignError([Problem("/color_by", f"a path cannot be coloured by {name!r}", hint=f"use one of {known}")])
    return name
