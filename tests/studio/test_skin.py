from __future__ import annotations

import pytest

from models.problems import Problem
from studio.panel.skin import problem_box


@pytest.mark.parametrize(
    ("message", "limit"),
    [
        ("extension 200 mm of 'Front' lies outside its stops [0, 100] mm", 0.1),
        ("angle 100 deg of 'Battery' lies outside its stops [-90, 90] deg", -1.5707963267948966),
        ("Input should be greater than or equal to 0, not -5", 0.0),
        ("9e+06 samples of the result exceed the limit of 4e+06", 4_000_000),
    ],
)
def test_a_bound_in_the_message_is_not_said_again_without_its_unit(message: str, limit: float) -> None:
    assert "Limit" not in problem_box([Problem("/mission", message, limit)], [])


def test_a_bound_that_the_message_leaves_out_is_told() -> None:
    assert "Limit: glider." in problem_box([Problem("/format", "this is no such design", "glider")], [])
    assert "Limit: 0.1." in problem_box([Problem("/mission", "there are 3 too many", 0.1)], [])
