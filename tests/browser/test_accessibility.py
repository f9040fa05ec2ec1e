"""Every page and dialog against the rules of WCAG 2 A and AA that a program can check (axe-core), in light and dark."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from models.presets import load_preset
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.records import Content
from tests.browser.axe import assert_accessible, assert_accessible_in_both
from tests.browser.conftest import EMPTY_VIEW, Program
from tests.browser.timeline_page import Timeline

pytestmark = pytest.mark.browser

DIALOG, MENU, PARTS_MENU = "dialog[open]", "details.menu[open]", "[data-testid=parts-menu]"
CELL, CELL_IN_THE_PLANE = "Front port cell", "Front bellows"
NO_WEBGL = """() => {
  const given = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
    return kind.startsWith("webgl") ? null : given.call(this, kind, ...rest);
  };
}"""
KEEP_SOURCE = """() => {
  const { EventSource } = window;
  window.EventSource = class extends EventSource {
    constructor(...given) {
      super(...given);
      window.__source = this;
    }
  };
}"""
"""For tests that lose the connection."""
IN_VIEW = """node => {
  const box = node.getBoundingClientRect();
  const middle = [box.left + box.width / 2, box.top + box.height / 2];
  const seen = node.contains(document.elementFromPoint(...middle)) && node.textContent.trim() !== "";
  return seen && box.left >= 0 && box.right <= innerWidth && box.top >= 0 && box.bottom <= innerHeight ? box.width : 0;
}"""
"""How wide a text is on the screen, px; none where it is covered, empty or out of sight."""


@pytest.fixture
def alone(program: Program, page: Page) -> Page:
    """The studio's page of the paper's preset."""
    return Timeline.open_preset(page, program.url, "canete-dual-bellows").page


def test_the_studio_is_accessible(alone):
    assert_accessible_in_both(alone)


def test_menus_and_dialogs_of_the_studio_are_accessible(alone):
    for opener in ("show-keys", "hydrodynamics"):
        alone.get_by_test_id(opener).click()
        assert_accessible_in_both(alone, DIALOG)
        alone.keyboard.press("Escape")
    alone.get_by_test_id("compare").click()
    alone.get_by_test_id("keep").click()
    alone.wait_for_function("() => window.__studio.state.kept.length > 0")
    assert_accessible_in_both(alone, MENU)
    alone.keyboard.press("Escape")
    alone.get_by_test_id("bookmarks").click()
    alone.get_by_test_id("bookmark-add").click()
    assert_accessible_in_both(alone, MENU)
    alone.keyboard.press("Escape")
    for menu in ("export", "link"):
        alone.get_by_test_id(menu).click()
        assert_accessible_in_both(alone, MENU)
        alone.keyboard.press("Escape")


def test_all_that_opens_over_a_glider_that_turns_is_accessible(program, page):
    spiral = Timeline.open_preset(page, program.url, "quad-bellows-spiral")
    assert_accessible_in_both(page)
    page.get_by_test_id("display").click()
    assert_accessible_in_both(page, MENU)
    page.keyboard.press("Escape")
    page.get_by_test_id("parts-add").click()
    page.get_by_test_id("parts-menu").wait_for()
    assert_accessible_in_both(page, PARTS_MENU)
    page.keyboard.press("Escape")
    spiral.part(CELL).click(button="right")
    page.get_by_test_id("parts-menu").wait_for()
    assert_accessible_in_both(page, PARTS_MENU)
    page.keyboard.press("Escape")
    page.get_by_test_id("tab-modes").click()
    page.get_by_test_id("modes-table").wait_for()
    assert_accessible_in_both(page, "#results")
    page.get_by_test_id("tab-readouts").click()
    page.get_by_test_id("glide-polar-open").click()
    page.get_by_test_id("glide-polar-trim").first.wait_for()
    assert_accessible_in_both(page, DIALOG)


def test_all_that_opens_over_the_timeline_is_accessible(alone):
    alone.get_by_test_id(f"lane-menu-{CELL_IN_THE_PLANE}").click()
    alone.get_by_role("menu").wait_for()
    assert_accessible_in_both(alone, "[role=menu]")
    alone.get_by_test_id("copy-schedule").click()
    alone.get_by_test_id("copy-dialog").wait_for()
    assert_accessible_in_both(alone, "[data-testid=copy-dialog]")
    alone.keyboard.press("Escape")
    alone.get_by_test_id("add-plot").click()
    alone.get_by_test_id("output-list").locator("label").first.wait_for()
    assert_accessible_in_both(alone, "[data-testid=plot-picker]")
    alone.keyboard.press("Escape")
    alone.get_by_test_id(f"point-{CELL_IN_THE_PLANE}-1").focus()
    alone.keyboard.press("Enter")
    alone.get_by_test_id("point-editor").wait_for()
    assert_accessible_in_both(alone, "[data-testid=point-editor]")


def test_a_conflict_of_two_writers_is_told_accessibly(program, page):
    database = Database(sqlite_url(program.data / "studio.sqlite"))
    store = DesignStore(database)
    design = load_preset("canete-dual-bellows")
    stored = store.create(Content(design))
    page.goto(f"{program.url}/d/{stored.id}")
    page.wait_for_function("() => window.__studio?.state?.run")
    patch = [{"op": "replace", "path": "/vehicle/components/1/position/0", "value": 0.15}]
    changed = page.request.post(f"{page.url.split('?')[0]}edit", data={"patch": patch})
    assert changed.ok, changed.text()
    page.wait_for_function("() => window.__studio.state.origin.changed")
    theirs = design.model_copy(update={"name": "Theirs"})
    store.change(stored.id, lambda before: Content(theirs, before.tags), comment="By another")
    database.close()
    page.get_by_test_id("save").click()
    page.get_by_test_id("conflict").wait_for()
    assert_accessible_in_both(page, "[data-testid=conflict]")


def test_a_refused_change_is_told_accessibly(alone):
    origin = "/".join(alone.url.split("/")[:3])
    patch = [{"op": "replace", "path": "/vehicle/components/0/mass", "value": -5}]
    refused = alone.request.post(f"{alone.url.split('?')[0]}edit", data={"patch": patch}, headers={"Origin": origin})
    assert refused.status == 422
    alone.get_by_test_id("problem").wait_for()
    assert_accessible(alone)


def test_the_list_of_presets_and_the_page_of_jobs_are_accessible(program, page):
    for path, there in (("/", "[data-testid^='open-canete']"), ("/jobs", "h1")):
        page.goto(program.url + path)
        page.locator(there).first.wait_for()
        assert_accessible_in_both(page)


def test_the_studio_on_a_phone_is_accessible(alone):
    alone.set_viewport_size({"width": 390, "height": 844})
    for tab in ("parts", "results", "timeline"):
        alone.get_by_test_id(f"tab-{tab}").click()
        assert_accessible(alone)


def test_a_browser_that_cannot_draw_in_3d_is_told_so_and_shows_the_rest(program, new_page):
    page = new_page
    page.add_init_script(f"({NO_WEBGL})()")
    viewed: list[str] = []
    page.on("request", lambda request: viewed.append(request.url) if "/view/" in request.url else None)
    studio = Timeline.open_preset(page, program.url, "canete-dual-bellows")
    expect(page.get_by_test_id("no-view")).to_contain_text("cannot draw in 3D")
    expect(page.locator("#view")).to_be_hidden()
    expect(page.get_by_test_id("camera-side")).to_be_hidden()
    page.evaluate("() => window.__studio.clock.seek(5)")
    studio.wait_until(lambda: studio.readout("speed") > 0.0)
    assert viewed == [], "nothing is loaded that could not be shown"
    assert_accessible(page)


@pytest.mark.parametrize("preset", ["quad-bellows-spiral", "three-cell-glider"])
def test_the_force_data_are_named_with_their_range_on_a_small_screen(program, new_page, preset):
    page = new_page
    page.set_viewport_size({"width": 1280, "height": 720})
    page.add_init_script(EMPTY_VIEW)
    page.add_init_script(f"({KEEP_SOURCE})()")
    Timeline.open_preset(page, program.url, preset)
    name = page.evaluate("() => window.__studio.state.hydrodynamics")
    for lost in (False, True):
        if lost:
            page.evaluate("() => window.__source.dispatchEvent(new Event('error'))")
            expect(page.get_by_test_id("status")).to_have_attribute("data-state", "offline")
        for shown in ("hydrodynamics-source", "hydrodynamics-range", "source-title", "source-range"):
            assert page.get_by_test_id(shown).evaluate(IN_VIEW) >= 60.0, shown
        assert name in (page.get_by_test_id("hydrodynamics").get_attribute("title") or "")
        assert page.get_by_test_id("source-title").get_attribute("title") == name


def test_keys_of_all_parts_of_the_page_are_in_its_list(alone):
    alone.get_by_test_id("show-keys").click()
    groups = {title.lower() for title in alone.get_by_test_id("keys").locator("h3").all_inner_texts()}
    assert {"playback", "design", "parts", "page"} <= groups
