"""The comparison of pages sees a changed number."""

import pytest

from tests.docs.pages import assert_same_page


@pytest.mark.parametrize(("committed", "same"), [
    ("depth 1.20 m, error 10⁻⁸", True),
    ("depth 1.21 m, error 10⁻⁹", True),
    ("depth 1.22 m, error 10⁻⁸", False),
    ("depth 1.20 m, error 10⁻⁶", False),
    ("depth −1.20 m, error 10⁻⁸", False),
    ("height 1.20 m, error 10⁻⁸", False),
])  # fmt: skip
def test_a_changed_number_is_seen(committed, same):
    if same:
        assert_same_page("depth 1.20 m, error 10⁻⁸", committed, "make it")
        return
    with pytest.raises(AssertionError):
        assert_same_page("depth 1.20 m, error 10⁻⁸", committed, "make it")
