"""The page of all operations fits the screen of a telephone, whatever of it is opened."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from tests.browser.conftest import Program

NARROW = {"width": 390, "height": 800}


def test_nothing_of_it_lies_beside_a_narrow_screen(program: Program, page: Page):
    page.set_viewport_size(NARROW)
    page.goto(f"{program.url}/docs")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    for opened in (False, True):
        page.evaluate("opened => document.querySelectorAll('details').forEach(part => part.open = opened)", opened)
        assert page.evaluate("document.documentElement.scrollWidth") <= NARROW["width"]
    # an example is wider than that, and is scrolled by itself
    assert page.evaluate("Math.max(...[...document.querySelectorAll('pre')].map(example => example.scrollWidth))") > 390
