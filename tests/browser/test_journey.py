"""The journeys of a designer: open, play, drag, type, reschedule, save, come back."""

from __future__ import annotations

import json
import re

import numpy as np
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


def test_opening_a_preset_from_the_list_shows_its_glide(program, page):
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


def test_playing_moves_the_glider_and_the_readouts(studio):
    page = studio.page
    page.get_by_test_id("play").click()
    page.wait_for_function("() => window.__studio.clock.t > 1.0")
    updates = page.evaluate("() => window.__studio.poseUpdates")
    page.wait_for_function(f"() => window.__studio.poseUpdates > {updates} + 5")
    page.get_by_test_id("play").click()
    # a busy machine may take the click seconds later: what counts is that the readouts are those of the clock
    time = page.evaluate("() => window.__studio.clock.t")
    for name, column in (("depth", "z"), ("pitch", "theta")):
        shown = np.interp(time, studio.state("s.run.columns.t"), studio.state(f"s.run.columns.{column}"))
        assert studio.readout(name) == pytest.approx(shown, abs=1e-9)
    studio.page.wait_for_timeout(300)
    assert page.evaluate("() => window.__studio.clock.t") == time


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


def test_adding_and_removing_a_cell(studio):
    count = len(studio.state("s.components"))
    studio.add_part("Piston")
    studio.wait_until(lambda: len(studio.state("s.components")) == count + 1)
    expect(studio.page.get_by_test_id("lane-Piston")).to_be_visible()
    studio.scene(f"() => '/glider/cell{count}/stack' in window.__viserSceneTree.getState()")
    studio.page.get_by_test_id("parts-remove").click()
    studio.wait_until(lambda: len(studio.state("s.components")) == count)


def test_undo_and_redo(panel):
    before = panel.readout("end-depth")
    panel.type_number("Position x", 120)
    changed = panel.wait_for_change("end-depth", before)
    panel.page.get_by_test_id("undo").click()
    assert panel.wait_for_change("end-depth", changed) == before
    panel.page.get_by_test_id("redo").click()
    assert panel.wait_for_change("end-depth", before) == changed


def test_a_page_comes_back_by_itself_after_a_restart(program, studio_alone):
    before = studio_alone.readout("end-depth")
    for count in (1, 2):
        studio_alone.page.keyboard.press("k")
        studio_alone.wait_until(lambda wanted=count: studio_alone.state("s.kept.length") == wanted)
    studio_alone.wait_until(lambda: studio_alone.state("s.scene.ghost") == "run-1")
    studio_alone.page.evaluate("() => window.__studio.clock.setRange({ from: 4, to: 5 })")
    studio_alone.type_number("Position x", 140)
    changed = studio_alone.wait_for_change("end-depth", before)
    kept = studio_alone.state("s.kept[0]")
    program.stop()  # which saves
    expect(studio_alone.page.locator("#lost")).to_be_visible()
    file = program.data / "sessions" / f"{studio_alone.state('s.id')}.json"
    saved = json.loads(file.read_bytes())
    saved["kept"]["runs"][1]["design"]["mission"]["duration"] = -1.0
    file.write_text(json.dumps(saved))
    program.start()
    expect(studio_alone.page.locator("#status")).to_have_text("Ready", timeout=30_000)
    expect(studio_alone.page.locator("#lost")).to_be_hidden(timeout=60_000)
    assert studio_alone.readout("end-depth") == changed
    studio_alone.wait_until(lambda: studio_alone.state("s.kept[0]") == kept)
    expect(studio_alone.page.get_by_test_id("kept-note-run-2")).to_contain_text(
        "cannot be computed any more: /mission/duration"
    )
    assert studio_alone.page.evaluate("() => window.__studio.clock.range") == {"from": 4, "to": 5}
    studio_alone.type_number("Position x", 160)
    assert studio_alone.wait_for_change("end-depth", changed) != before
    drawn = "window.__viserSceneTree.getState()"
    studio_alone.scene(f"() => '/glider' in {drawn} && '/ghost/silhouette' in {drawn}")


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


def test_the_nose_points_down_on_screen_when_pitch_is_negative(studio):
    """Body x, turned by the pose that Viser holds, must point along +z (down) at a negative pitch."""
    studio.page.evaluate("() => window.__studio.clock.seek(6)")
    studio.wait_until(lambda: studio.readout("pitch") < -0.5)
    frame = next(f for f in studio.page.frames if "/view/" in f.url)
    pose = "() => window.__viserMutable.nodePoseData['/glider']?.wxyz"
    frame.wait_for_function(f"() => Math.abs(({pose})()[2]) > 0.2")
    w, x, y, z = frame.evaluate(pose)
    nose_down = 2 * (x * z - w * y)  # third row, first column of the rotation: world z of body x
    assert nose_down > 0.4


def test_force_arrows_can_be_switched_off(studio):
    frame = next(f for f in studio.page.frames if "/view/" in f.url)
    visible = "() => window.__viserSceneTree.getState()['/glider/arrow_drag'].visibility"
    studio.page.evaluate("() => window.__studio.clock.seek(6)")
    frame.wait_for_function(f"() => ({visible})() === true")
    studio.page.get_by_test_id("toggle-forces").click()
    frame.wait_for_function(f"() => ({visible})() === false")
