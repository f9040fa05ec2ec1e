"""Owns where the camera stands to see a whole path: as near as it fits the free part of the picture.

World axes (z down), metres, from the middle of the path; angles in radians.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOWARD = np.array((0.6, 0.85, -0.4)) / np.linalg.norm((0.6, 0.85, -0.4))
"""From the path to the camera: ahead, to starboard and above."""
MARGIN = 0.12
"""Share of half the picture that stays free at each edge: labels hang below and beside the box."""


def outlook(points: Array, field_of_view: float, aspect: float, covered: float) -> tuple[Array, Array]:
    """Return the point (3,) to look at and the camera's place (3,) that show points (n, 3).

    `field_of_view` is the picture's height, `covered` the share of it, from the top, that lies under something.
    """
    right, up = _picture_axes()
    across, above, toward = points @ right, points @ up, points @ TOWARD
    slope = np.tan(field_of_view / 2.0)
    top, bottom, side = (
        slope * share for share in (1.0 - 2.0 * covered - MARGIN, 1.0 - MARGIN, aspect * (1.0 - MARGIN))
    )
    # a point is in the picture where -bottom depth <= above - shift <= top depth, with depth = distance - toward
    highest, lowest = np.max(above + top * toward), np.min(above - bottom * toward)
    distance = max((highest - lowest) / (top + bottom), float(np.max(np.abs(across) / side + toward)))
    shift = (highest - top * distance + lowest + bottom * distance) / 2.0
    return shift * up, shift * up + distance * TOWARD


def _picture_axes() -> tuple[Array, Array]:
    right = np.cross(-TOWARD, (0.0, 0.0, -1.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, -TOWARD)
