from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from studio.outlook import MARGIN, outlook

FIELD_OF_VIEW = np.deg2rad(32.0)


@pytest.mark.parametrize("covered", [0.0, 0.18, 0.4])
@pytest.mark.parametrize("aspect", [0.6, 1.9])
@pytest.mark.parametrize("size", [(50.0, 40.0, 100.0), (200.0, 2.0, 10.0), (3.0, 80.0, 4.0)])
def test_the_box_fills_the_free_part_of_the_picture(size: tuple[float, ...], aspect: float, covered: float) -> None:
    half = np.array(size) / 2.0
    low, high = -half, half * 1.2
    corners = np.array(list(product(*zip(low, high, strict=True))))
    look_at, position = outlook(corners, FIELD_OF_VIEW, aspect, covered)
    forward = (look_at - position) / np.linalg.norm(look_at - position)
    right = np.cross(forward, (0.0, 0.0, -1.0))
    right /= np.linalg.norm(right)
    rays = corners - position
    depth, slope = rays @ forward, np.tan(FIELD_OF_VIEW / 2.0)
    x, y = rays @ right / (depth * slope * aspect), rays @ np.cross(right, forward) / (depth * slope)
    # at most a rounding beyond the margin, and no nearer place would do
    top = 1.0 - 2.0 * covered - MARGIN
    assert (depth > 0.0).all()
    assert np.abs(x).max() <= 1.0 - MARGIN + 1e-9
    assert y.max() <= top + 1e-9 and y.min() >= MARGIN - 1.0 - 1e-9
    fills_height = y.max() >= top - 1e-9 and y.min() <= MARGIN - 1.0 + 1e-9
    assert fills_height or np.abs(x).max() >= 1.0 - MARGIN - 1e-9
