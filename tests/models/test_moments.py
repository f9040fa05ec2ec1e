"""Moments of a run in words: seconds of a short one, a clock of minutes or hours of a longer one."""

import pytest

from models.moments import moment_in_words, stretch_in_words

MOMENTS = (
    (16.2, 20.0, "16.2 s"),
    (180.0, 180.0, "180 s"),
    (95.3, 960.0, "1:35 min"),
    (-30.5, 960.0, "-0:30 min"),
    (-0.1, 960.0, "0:00 min"),
    (9600.0, 9600.0, "160:00 min"),
    (3723.9, 20000.0, "1:02:03 h"),
)
"""A moment and the end of its run, s, and how it is told; the page's rule is held against these as well."""


@pytest.mark.parametrize(("t", "end", "told"), MOMENTS)
def test_a_moment_is_told_as_the_axis_of_its_run_tells_it(t, end, told):
    assert moment_in_words(t, end) == told
    assert moment_in_words(t, end, unit=False) == told.split()[0]


def test_a_stretch_says_its_unit_once():
    assert stretch_in_words(0.0, 10.0, 20.0) == "0 to 10 s"
    assert stretch_in_words(16.4, 32.6, 960.0) == "0:16 to 0:32 min"
