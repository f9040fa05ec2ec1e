from __future__ import annotations

import numpy as np
import pytest

from studio import grid

TURN = np.linspace(0.0, 4.0 * np.pi, 400)
SPIRAL = np.column_stack([50.0 * np.sin(TURN), 50.0 * (1.0 - np.cos(TURN)), 2.0 + 10.0 * TURN])


def test_a_rung_is_level_across_the_path_at_a_round_depth() -> None:
    drawn = grid.rungs(SPIRAL, 2.0)
    assert 0 < len(drawn.lines) <= grid.MAX_RUNGS
    assert len(drawn.labels) <= grid.MAX_RUNG_LABELS
    middle, across = drawn.lines.mean(axis=1), drawn.lines[:, 1] - drawn.lines[:, 0]
    assert across[:, 2] == pytest.approx(0.0, abs=1e-5)  # single precision at a hundred metres
    assert middle[:, 2] % 2.0 == pytest.approx(0.0, abs=1e-4)
    # from the axis of the spiral the middle of each rung is a radius away: it lies on the path
    from_axis = middle[:, :2] - [0.0, 50.0]
    assert np.hypot(*from_axis.T) == pytest.approx(50.0, abs=0.01)
    assert np.abs(np.sum(across[:, :2] * from_axis, axis=1)) == pytest.approx(50.0 * 2.4, rel=1e-2)  # along the radius


def test_a_long_sawtooth_has_no_more_rungs_than_can_be_read() -> None:
    t = np.linspace(0.0, 3600.0, 2000)
    path = np.column_stack([0.3 * t, 0.05 * t, 25.0 - 20.0 * np.cos(t / 40.0)])
    drawn = grid.rungs(path, 1.0)
    assert 0 < len(drawn.lines) <= 2 * grid.MAX_RUNGS
    assert len(drawn.labels) <= grid.MAX_RUNG_LABELS


def test_a_path_without_depth_has_no_rungs() -> None:
    assert grid.rungs(np.array([[0.0, 0.0, 1.3], [5.0, 3.0, 1.3]]), 1.0).lines.shape == (0, 2, 3)
    assert grid.rungs(np.array([[0.0, 0.0, 1.3]]), 1.0).lines.shape == (0, 2, 3)


@pytest.mark.parametrize("bed", [None, 130.0])
def test_the_room_holds_the_path_between_surface_and_bed(bed: float | None) -> None:
    low, high = grid.room_box(SPIRAL, 2.0, bed)
    assert (low <= SPIRAL.min(axis=0)).all()
    assert (high >= SPIRAL.max(axis=0) - (0.0 if bed is None else 1e9)).all()
    assert low[2] == 0.0
    assert bed is None or high[2] == bed
    drawn = grid.room(low, high)
    corners = drawn.lines.reshape(-1, 3)
    assert (corners >= low - 1e-4).all() and (corners <= high + 1e-4).all()
    assert {text[-2:] for text, _ in drawn.labels} <= {" m", " N", " S", " E", " W", "0"}
