"""Sine, cosine and arctangent of the kernel against the C library."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from models.kernel.scalar import atan2, sincos

QUARTERS = [k * math.pi / 4 for k in range(-17, 18)]
SPREAD = np.concatenate([
    np.linspace(-10.0, 10.0, 20_001), np.geomspace(1e-300, 1e5, 4_001), -np.geomspace(1e-300, 1e5, 4_001),
    *[np.nextafter(QUARTERS, side) for side in (-10.0, 0.0, 10.0)],
])  # fmt: skip


def test_sincos_matches_the_library_to_rounding():
    mine = np.array([sincos(float(x)) for x in SPREAD])
    theirs = np.array([(math.sin(x), math.cos(x)) for x in SPREAD])
    assert np.abs(mine - theirs).max() <= 3e-16  # about one unit in the last place of 1


def test_sincos_is_relatively_exact_near_zero():
    for x in np.geomspace(1e-300, 1e-3, 400):
        assert sincos(float(x))[0] == pytest.approx(math.sin(x), rel=3e-16)


@given(st.floats(-1e5, 1e5))
@example(0.0)
@example(-0.0)
def test_sincos_lies_on_the_unit_circle_and_is_odd_and_even(x):
    s, c = sincos(x)
    assert abs(s * s + c * c - 1.0) <= 6e-16
    assert sincos(-x) == (-s, c)


def test_sincos_at_the_origin_is_exact():
    assert sincos(0.0) == (0.0, 1.0)


def test_sincos_does_not_hide_nan():
    assert all(math.isnan(value) for value in sincos(math.nan))


SIZES = [0.0, 1e-200, 1e-12, 0.3, 0.41421356237309503, 1.0, math.nextafter(1.0, 2.0), 2.0, 1e6, 1e200]


@pytest.mark.parametrize("x", [sign * size for size in SIZES for sign in (1, -1)])
def test_atan2_matches_the_library_on_every_axis_and_sign(x):
    for size in SIZES:
        for y in (size, -size):
            expected = math.atan2(y + 0.0, x + 0.0)  # no negative zeros: the kernel has one angle for each direction
            assert abs(atan2(y, x) - expected) <= 1e-15


def test_atan2_matches_the_library_all_around():
    for angle in np.linspace(-math.pi, math.pi, 20_001)[1:]:
        for r in (1e-9, 1.0, 1e7):
            x, y = r * math.cos(angle), r * math.sin(angle)
            assert abs(atan2(y, x) - math.atan2(y, x)) <= 1e-15


@given(st.floats(-1e150, 1e150), st.floats(-1e150, 1e150))
def test_atan2_is_odd_in_y(y, x):
    if y != 0.0:
        assert atan2(-y, x) == -atan2(y, x)


def test_atan2_of_the_origin_is_zero_and_backward_is_pi():
    assert atan2(0.0, 0.0) == 0.0
    assert atan2(0.0, -1.0) == math.pi
    assert atan2(-0.0, -1.0) == math.pi  # the range is (-pi, pi]


def test_atan2_does_not_hide_nan():
    assert math.isnan(atan2(math.nan, 1.0))
    assert math.isnan(atan2(1.0, math.nan))
