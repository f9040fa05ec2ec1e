"""What is marked over and in the lanes: events, phases, warnings, end stops, bookmarks and the played range."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from models.presets import load_preset
from tests.browser.timeline_page import Timeline, center

pytestmark = pytest.mark.browser

LAKE, PORT = "canete-dual-bellows", "Front port cell"


@pytest.fixture
def lake(program, page) -> Timeline:
    return Timeline.open_preset(page, program.url, LAKE)


def test_what_happened_is_marked_over_the_lanes(program, page):
    """A yo-yo between waypoints."""
    document = load_preset("quad-bellows-waypoints").model_dump(mode="json")
    document["mission"]["duration"] = 3000.0
    timeline = Timeline.open_document(page, program.url, document)
    kinds = {event["kind"] for event in timeline.state("s.run.events")}
    assert "climb" in kinds
    shown = page.locator("[data-testid^=event-]")
    assert shown.count() >= 2
    shown.last.hover()
    expect(page.locator("#tip")).to_contain_text("End of the mission")
    expect(page.get_by_test_id("phase-vertical-0")).to_have_attribute("aria-label", re.compile("^Dive, from"))
    expect(page.get_by_test_id("phase-lateral-0")).to_contain_text("Leg 1 of")
    climb = timeline.state("s.run.phases.find(p => p.name === 'Climb')")
    page.get_by_test_id("phase-vertical-1").press("Enter")
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(climb["from"], abs=10.0)
    expect(page.get_by_test_id(f"lane-{PORT}")).to_have_attribute("data-controlled", "true")


def test_marks_of_surface_switches_end_stops_and_bed(program, page):
    document = load_preset("quad-bellows-waypoints").model_dump(mode="json")
    document["mission"]["duration"] = 300.0
    vertical = document["mission"]["control"]["controller"]["vertical"]
    vertical |= {"top": 0.0, "bottom": 40.0, "first": "climb"}
    timeline = Timeline.open_document(page, program.url, document)

    def marked(*kinds: str) -> None:
        timeline.wait_until(lambda: {e["kind"] for e in timeline.state("s.run.events")} == set(kinds))
        for kind in kinds:
            mark = page.locator(f".mark.{kind}").first
            expect(mark).to_be_visible()
            drawn = mark.locator("path")
            timeline.wait_until(lambda drawn=drawn: drawn.evaluate("path => path.getBBox().width") > 0.0)

    marked("surface", "end_of_stroke")
    expect(page.locator(".mark.end_of_stroke").first).to_have_attribute("aria-label", re.compile("cell: end stop at"))
    dives = vertical | {"top": 0.5, "first": "dive"}
    timeline.edit({"op": "replace", "path": "/mission/control/controller/vertical", "value": dives})
    marked("climb")
    timeline.edit({"op": "replace", "path": "/mission/environment/bed_depth", "value": 30.0})
    marked("bed")
    expect(page.locator(".mark.bed")).to_have_attribute("aria-label", re.compile("^Bed at "))
    page.locator(".mark.bed").press("Enter")
    end = timeline.state("s.run.columns.t.at(-1)")
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(end, abs=0.01)


def test_a_lane_is_hatched_where_the_cell_is_near_a_stop(lake):
    stops = lake.lane("Front bellows").locator(".near-stop")
    expect(stops).to_have_attribute("d", "")
    most = lake.state("s.components[1].extension_max")
    lake.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": most})
    expect(stops).to_have_attribute("d", re.compile("^M"))
    (stretch,) = lake.page.evaluate("() => window.__studio.timeline.lanes.list[0].nearStops()")
    assert 9.9 < stretch[0] < stretch[1] == lake.state("s.run.columns.t.at(-1)")


def test_a_warning_on_the_timeline_leads_to_the_list(lake):
    page = lake.page
    (warning,) = lake.state("s.warnings.filter(w => w.times.length)")
    assert warning["times"] == lake.state("s.run.outside[0].spans")
    bar = page.locator(".doubt[aria-label*='slower than']")
    entry = page.locator("#warnings details", has_text="slower than the data")
    bar.click()
    expect(entry.locator("summary")).to_be_focused()
    expect(entry).to_have_attribute("open", "")
    expect(bar).to_have_class(re.compile("focused"))


def test_bookmarks_and_the_played_range_are_dragged(lake):
    page = lake.page
    page.evaluate("() => window.__studio.clock.seek(5)")
    page.get_by_test_id("bookmarks").click()
    page.get_by_test_id("bookmark-add").click()
    page.keyboard.press("Escape")
    mark = page.get_by_test_id("mark-bookmark-0")
    lake.drag(center(mark), (lake.scale("s.x(8) - s.x(5)"), 0.0))
    page.get_by_test_id("bookmarks").click()
    expect(page.get_by_test_id("bookmark-0")).to_have_text("8.0 s")
    page.keyboard.press("Escape")
    page.evaluate("() => window.__studio.clock.setRange({ from: 4, to: 10 })")
    end = page.get_by_test_id("range-end-to")
    lake.drag(center(end), (lake.scale("s.x(14) - s.x(10)"), 0.0))
    assert page.evaluate("() => window.__studio.clock.range.to") == pytest.approx(14.0, abs=0.1)
    end.press("ArrowLeft")
    assert page.evaluate("() => window.__studio.clock.range.to") == pytest.approx(13.8, abs=0.11)
    # an end set under the playing clock stops it; with Loop on it goes round the range
    page.keyboard.press("u")
    page.evaluate("() => (c => { c.seek(1); c.setSpeed(5); c.play(); })(window.__studio.clock)")
    page.wait_for_function("() => window.__studio.clock.t > 3")
    page.keyboard.press("o")
    page.wait_for_function("() => !window.__studio.clock.playing")
    page.keyboard.press("l")
    assert page.evaluate("() => (c => c.playing && c.t < c.range.to)(window.__studio.clock)")
