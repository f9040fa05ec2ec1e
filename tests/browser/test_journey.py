"""The journeys of a designer: open, play, drag, type, reschedule, save, come back."""

from __future__ import annotations

import json
import re

import pytest
from playwright.sync_api import expect

from models.design import loads_design
from models.presets import preset_ids
from models.simulate import simulate
from tests.browser.studio_page import StudioPage

pytestmark = pytest.mark.browser


def end_depth(design_json: str) -> float:
    """Return the end depth of a document by the library, without the studio."""
    return simulate(loads_design(design_json)).final["z"]


def saved_design(studio: StudioPage) -> str:
    response = studio.page.request.get(studio.url.split("?")[0] + "design.json")
    assert response.ok
    return response.text()


def test_presets_are_listed_with_pictures(program, page):
    page.goto(program.url)
    cards = page.locator("form[action$='/sessions'], form[action$='sessions']")
    expect(cards).to_have_count(len(preset_ids()))
    pictures = page.locator("img[src*='presets/']")
    expect(pictures).to_have_count(len(preset_ids()))
    for k in range(pictures.count()):  # they load as they come into sight
        pictures.nth(k).scroll_into_view_if_needed()
    page.wait_for_function("() => [...document.images].every(i => i.complete && i.naturalWidth > 0)")


def test_opening_a_preset_from_the_list_shows_its_glide(program, new_page):
    page = new_page
    page.goto(program.url)
    page.get_by_test_id("open-canete-dual-bellows").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    studio = StudioPage(page)
    depth = studio.readout("end-depth")
    assert depth == pytest.approx(end_depth(saved_design(studio)), abs=1e-6)  # state rounds to 7 digits
    expect(studio.page.get_by_test_id("readout-end-depth")).to_contain_text(f"{depth:.3f}")
    # dives for 10 s, then climbs
    z = studio.state("s.run.columns.z")
    t = studio.state("s.run.columns.t")
    deepest = max(range(len(z)), key=lambda i: z[i])
    assert 9.0 < t[deepest] < 13.0
    assert z[0] == 0.5 and z[deepest] > 0.75 and z[-1] < 0.5


def test_typing_a_position_moves_the_cell_and_changes_the_glide(panel):
    before = panel.readout("end-depth")
    panel.type_number("Position x", 150)
    after = panel.wait_for_change("end-depth", before)
    document = json.loads(saved_design(panel))
    assert document["vehicle"]["components"][1]["position"][0] == pytest.approx(0.150)
    assert after == pytest.approx(end_depth(json.dumps(document)), abs=1e-6)


def test_dragging_the_slider_changes_the_glide_on_the_way(panel):
    page, before = panel.page, panel.readout("end-depth")
    thumb = panel.row("Position x").get_by_role("slider").first
    box = thumb.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    seen = set()
    for k in range(12):
        page.mouse.move(x - 2 * k, y)
        page.wait_for_timeout(120)
        seen.add(panel.readout("end-depth"))
    page.mouse.up()
    panel.wait_for_change("end-depth", before)
    assert len(seen) >= 3, "the glide should have changed while the mouse was down"
    assert json.loads(saved_design(panel))["vehicle"]["components"][1]["position"][0] < 0.180


def test_changing_the_schedule_changes_the_end_depth(panel):
    page, before = panel.page, panel.readout("end-depth")
    page.get_by_test_id("point-Front bellows-1").click()
    box = page.get_by_test_id("point-extension")
    box.fill("16.8")
    page.get_by_test_id("point-apply").click()
    after = panel.wait_for_change("end-depth", before)
    assert after > before  # less buoyancy at the end: it climbs less
    points = json.loads(saved_design(panel))["mission"]["control"]["schedules"][0]["points"]
    assert points[1]["extension"] == pytest.approx(0.0168)


def test_a_bad_number_says_what_is_wrong_and_keeps_the_last_glide(panel):
    before, saved = panel.readout("end-depth"), saved_design(panel)
    panel.type_number("Mass", -5)
    problem = panel.page.get_by_test_id("problem")
    expect(problem).to_be_visible()
    expect(problem).to_contain_text("at least 0")
    assert panel.readout("end-depth") == before
    assert saved_design(panel) == saved


def test_what_is_no_number_stays_in_its_box_beside_the_message(panel):
    before, saved = panel.readout("end-depth"), saved_design(panel)
    for nonsense in ("0x10", "12 ft", "abc"):
        panel.type_number("Position x", nonsense)
        expect(panel.row("Position x").get_by_role("alert")).to_contain_text(f"‘{nonsense}’ is no number")
        assert panel.box("Position x").input_value() == nonsense
        assert panel.readout("end-depth") == before and saved_design(panel) == saved
        panel.box("Position x").press("Escape")
        assert panel.box("Position x").input_value() == "180.0"


def test_undo_and_redo(panel):
    before = panel.readout("end-depth")
    panel.type_number("Position x", 120)
    changed = panel.wait_for_change("end-depth", before)
    panel.page.get_by_test_id("undo").click()
    assert panel.wait_for_change("end-depth", changed) == before
    panel.page.get_by_test_id("redo").click()
    assert panel.wait_for_change("end-depth", before) == changed


def test_a_saved_file_opens_as_the_same_glide(panel, tmp_path):
    document = json.loads(saved_design(panel))
    document["name"] = "Reopened"
    document["mission"]["duration"] = 12.0
    path = tmp_path / "design.json"
    path.write_text(json.dumps(document))
    panel.page.get_by_test_id("open-file").set_input_files(path)
    panel.wait_until(lambda: panel.state("s.name") == "Reopened")
    panel.wait_until(lambda: panel.state("s.run && s.run.columns.t.at(-1)") == 12.0)
    assert panel.readout("end-depth") == pytest.approx(end_depth(path.read_text()), abs=1e-6)
