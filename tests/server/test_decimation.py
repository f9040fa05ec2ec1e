"""The thinning of curves: what it promises, on random columns."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.decimation import choose_samples

VALUES = st.floats(-1e3, 1e3) | st.integers(-3, 3).map(float) | st.just(float("nan"))


@st.composite
def column_sets(draw):
    count, samples = draw(st.integers(1, 4)), draw(st.integers(1, 60))
    column = st.lists(VALUES, min_size=samples, max_size=samples).map(np.array)
    return [draw(column) for _ in range(count)]


@settings(deadline=None, derandomize=True, max_examples=200)
@given(columns=column_sets(), max_points=st.integers(2, 80))
def test_guarantees(columns, max_points):
    count, width = len(columns[0]), len(columns)
    chosen = choose_samples(columns, max_points)
    assert len(chosen) == min(count, max_points)
    assert (np.diff(chosen) > 0).all()
    assert chosen[0] == 0 and chosen[-1] == count - 1
    # as many columns as two points each leave room for, in their order
    for column in columns[: (max_points - 2) // 2]:
        _extremes_survive(column, column[chosen])
    buckets = (max_points - 2 - 2 * width) // (2 * width)
    if count > max_points and buckets >= 1:
        edges = np.linspace(0, count, buckets + 1).astype(int)
        for begin, end in pairwise(edges):
            inside = chosen[(chosen >= begin) & (chosen < end)]
            for column in columns:
                _extremes_survive(column[begin:end], column[inside])


def _extremes_survive(column, kept):
    if not np.isnan(column).all():
        assert np.nanmin(kept) == np.nanmin(column)
        assert np.nanmax(kept) == np.nanmax(column)


def test_a_spike_survives_where_every_nth_sample_would_miss_it():
    curve = np.zeros(100_001)
    curve[77_777] = 1.0
    kept = choose_samples([np.sin(np.linspace(0, 50, curve.size)), curve], 50)
    assert len(kept) == 50 and 77_777 in kept


def test_samples_beyond_the_extremes_are_spread_evenly():
    rising = np.linspace(0.0, 1.0, 10_001)
    kept = choose_samples([rising], 1000)
    # 10 samples a point: no gap may be much wider than twice that
    assert np.diff(kept).max() <= 25


def test_fewer_than_two_points_are_refused():
    with pytest.raises(ValueError, match="at least 2"):
        choose_samples([np.zeros(5)], 1)
