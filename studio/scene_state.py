"""Owns what the State says of the scene: its choices, the legend of the path, and how cells are drawn to grow."""

from __future__ import annotations

from typing import Any

from models.run import Run
from studio.palette import PATH_SCALE
from studio.path_colors import quantities_of, scale_of
from studio.scene_display import PLAIN
from studio.session import Session


def scene_document(session: Session, run: Run | None) -> dict[str, Any]:
    """Return the member `scene` of the State.

    `path` is the legend of the path's colours, null where it has one colour.
    """
    display = session.display
    scale = None if run is None else scale_of(run, display.color_by)
    ghost = session.ghost
    return {
        "color_by": display.color_by or PLAIN,
        "quantities": [] if run is None else quantities_of(run),
        "path": None if scale is None else scale.document(),
        "path_colors": PATH_SCALE,
        "ghost": None if ghost is None else ghost.id,
    }
