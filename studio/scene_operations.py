"""Owns the HTTP of the scene: what is drawn beside the glider, and how a page shows it turned."""

from __future__ import annotations

import math
from typing import Any

from fastapi import APIRouter

from models.problems import DesignError, Problem
from studio.access import Admitted
from studio.attitude import Quaternion
from studio.operations import Document
from studio.scene_display import changed

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)

UNIT = 1e-3
"""How far the length of an attitude may be from 1."""


@router.post("/display", status_code=204)
def set_display(opened: Admitted, document: Document) -> None:
    """Colour the path by another quantity, or show another kept run's ghost: {"color_by": …, "ghost": …}."""
    opened.session.show(changed(opened.session.display, document))


@router.post("/shown", status_code=204)
def set_shown(opened: Admitted, document: Document) -> None:
    """Hear how a page shows the glider turned, {"wxyz": [w, x, y, z]}: along those axes it drags a part next."""
    opened.view().shown_at(_attitude(document))


def _attitude(document: Any) -> Quaternion:
    given = document.get("wxyz") if isinstance(document, dict) else None
    if not isinstance(given, list) or len(given) != 4 or not all(_is_number(v) for v in given):
        raise DesignError([Problem("/wxyz", "wxyz must be four numbers", hint="for example [1, 0, 0, 0]")])
    w, x, y, z = (float(v) for v in given)
    length = math.hypot(w, x, y, z)
    if abs(length - 1.0) > UNIT:
        message = f"the attitude has length {length:g}, not 1"
        raise DesignError([Problem("/wxyz", message, limit=1.0, hint="divide it by its length")])
    return w, x, y, z


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
