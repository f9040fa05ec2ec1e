"""docs/equations.md is what `python -m docs.make_equations` writes."""

from docs.make_equations import DOCS, page
from tests.docs.pages import assert_same_page


def test_the_page_is_what_its_generator_writes():
    committed = (DOCS / "equations.md").read_text(encoding="utf-8")
    assert_same_page(page(), committed, "python -m docs.make_equations")
