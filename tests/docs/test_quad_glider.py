"""docs/quad_glider.md is what `python -m docs.make_quad_glider` writes."""

from docs.make_quad_glider import DOCS, page
from tests.docs.pages import assert_same_page


def test_the_page_is_what_its_generator_writes():
    committed = (DOCS / "quad_glider.md").read_text(encoding="utf-8")
    assert_same_page(page(), committed, "python -m docs.make_quad_glider")
