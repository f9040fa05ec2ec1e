"""What the pointer does on the timeline and in the polars, done by keys; and the list that tells of all of them."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from tests.browser.timeline_page import Timeline

pytestmark = pytest.mark.browser

SPOKEN = re.compile(r"^(\d+\.\d\d) s, Depth ")


@pytest.fixture
def lake(program, page) -> Timeline:
    return Timeline.open_preset(page, program.url, "canete-dual-bellows")


def test_points_are_chosen_by_keys(program, page):
    spiral = Timeline.open_preset(page, program.url, "quad-bellows-spiral")
    page, port, starboard = page, "Front port cell", "Front starboard cell"
    before = {cell: spiral.times(cell) for cell in (port, starboard)}
    spiral.point(port, 1).focus()
    page.keyboard.press("Control+Space")
    page.keyboard.press("Control+ArrowRight")
    expect(spiral.point(port, 2)).to_be_focused()
    assert spiral.chosen() == 2
    expect(page.get_by_test_id("point-editor")).to_be_hidden()
    page.keyboard.press("Control+ArrowLeft")
    page.keyboard.press("Shift+Space")
    expect(spiral.point(port, 1)).to_have_attribute("aria-pressed", "false")
    spiral.point(starboard, 2).focus()
    page.keyboard.press("Control+Space")
    assert spiral.chosen() == 2
    page.keyboard.press("ArrowLeft")
    for cell in (port, starboard):
        spiral.wait_until(lambda cell=cell: spiral.times(cell)[2] < before[cell][2])
        assert [spiral.times(cell)[k] for k in (1, 3)] == [before[cell][k] for k in (1, 3)]
    page.keyboard.press("Control+a")
    assert spiral.chosen() == len(spiral.points(starboard))
    page.keyboard.press("Control+a")
    assert spiral.chosen() == sum(len(s["points"]) for s in spiral.state("s.schedules"))


def test_the_cursor_of_the_plots_is_moved_by_keys(lake):
    page = lake.page
    plot = page.get_by_test_id("plot-0")
    page.evaluate("() => window.__studio.clock.seek(5)")
    plot.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowRight")
    t = 5.0 + 0.11 * lake.scale("s.seconds")
    assert float(plot.get_attribute("aria-valuenow")) == pytest.approx(t)
    said = SPOKEN.match(plot.get_attribute("aria-valuetext") or "")
    assert said and float(said[1]) == pytest.approx(t, abs=0.01)
    expect(page.locator("#tip")).to_contain_text("Depth")
    expect(page.get_by_test_id("cursor-depth")).not_to_be_empty()
    assert page.evaluate("() => window.__studio.clock.t") == 5.0
    page.keyboard.press("Enter")
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(t)
    page.keyboard.press("End")
    assert float(plot.get_attribute("aria-valuenow")) == lake.scale("s.to")
    page.keyboard.press("Tab")
    expect(page.locator("#tip")).to_be_hidden()
    # after a click the arrows are the clock's, as before
    page.mouse.click(*lake.place(plot, 10.0))
    page.keyboard.press("ArrowRight")
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(10.1, abs=0.1)
    expect(plot).not_to_be_focused()


def test_the_path_is_walked_by_keys(lake):
    page = lake.page
    path, tip = page.get_by_test_id("plot-path"), page.locator("#path .tip")
    page.evaluate("() => window.__studio.clock.seek(5)")
    path.focus()
    expect(tip).to_contain_text("depth")
    page.keyboard.press("Shift+ArrowRight")
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(6.0)
    depth = lake.state("s.run.columns.z[s.run.columns.t.findIndex(t => t >= 6)]")
    expect(path).to_have_attribute("aria-valuetext", re.compile(rf"^6\.0 s · x \S+ m · depth {depth:.3f} m"))
    page.keyboard.press("End")
    assert page.evaluate("() => window.__studio.clock.t") == lake.state("s.run.columns.t.at(-1)")
    page.keyboard.press("Shift+Tab")
    expect(tip).to_be_hidden()


def test_the_force_polar_is_read_by_keys(lake):
    page = lake.page
    page.get_by_test_id("hydrodynamics").click()
    value = page.locator("#polar-drag-value")
    expect(value).to_contain_text("at")
    drag = page.get_by_test_id("polar-drag").and_(page.locator("canvas"))
    drag.focus()
    start = round(float(drag.get_attribute("aria-valuenow") or "nan"))
    page.keyboard.press("Home")
    expect(value).to_have_text(re.compile(r" at 0\.0°$"))
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(value).to_have_text(re.compile(r" at 11\.0°$"))
    expect(page.locator("#polar-lift-value")).to_have_text(re.compile(r" at 11\.0°$"))
    expect(page.locator("#polar-drag .reading")).to_be_visible()
    expect(drag).to_have_attribute("aria-valuetext", value.inner_text())
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert float(drag.get_attribute("aria-valuenow")) == start, "it begins at the angle now"


def test_the_list_of_keys_has_all_places(lake):
    page = lake.page
    page.get_by_test_id("show-keys").click()
    told = page.get_by_test_id("keys")
    titles = [title.lower() for title in told.locator("h3").all_inner_texts()]
    assert {"playback", "time shown", "lanes", "events", "plots", "parts", "view", "page"} <= set(titles)
    keys = {" ".join(text.split()) for text in told.locator("dt").all_inner_texts()}
    for wanted in (
        "Ctrl + Space / Shift + Space",
        "Ctrl + ← / Ctrl + →",
        "Shift + click / Ctrl + click",
        "double click",
        "Ctrl + wheel",
    ):
        assert wanted in keys
    for words in (
        "On a border between panels: move it",
        "On a bookmark: move it",
        "Choose all points of the lane",
        "On an end of the time shown",
        "On the path: the clock",
        "On a force polar",
        "On a plot: its cursor",
    ):
        expect(told).to_contain_text(words)
