"""A designer's journey in three dimensions: a glider that banks and turns, and the way into and out of the plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from playwright.sync_api import expect

from models.design import parse_design
from models.presets import load_preset
from models.simulate import simulate
from studio.attitude import attitude_at, rotate
from tests.browser.panel_page import PanelPage
from tests.browser.studio_page import StudioPage
from tests.studio.spiral import spiral_document

pytestmark = pytest.mark.browser

DURATION = 300.0


def axes(studio: StudioPage) -> np.ndarray:
    """Return the glider's nose, starboard and keel in the world's axes as the client shows it; a row each."""
    pose = studio.pose("/glider")
    assert pose is not None
    return rotate(np.eye(3), tuple(pose["wxyz"]))


def test_it_banks_and_turns_on_screen(turning):
    page = turning.page
    page.get_by_test_id("speed").select_option("100")
    page.get_by_test_id("play").click()
    # at this speed a click may come after the end, where it would play again
    page.wait_for_function("() => (c => c.t > 150 && (c.pause(), true))(window.__studio.clock)")
    t = page.evaluate("() => window.__studio.clock.t")
    run = simulate(parse_design(spiral_document(duration=DURATION)))
    expected = rotate(np.eye(3), attitude_at(run, t))
    # the page thins the samples and writes seven digits
    turning.wait_until(lambda: axes(turning) == pytest.approx(expected, abs=1e-3))
    nose, starboard, _ = axes(turning)
    assert nose[1] > 0.2, "it turns to starboard: east of north"
    assert nose[2] > 0.4, "it dives, and z points down"
    assert starboard[2] < -0.15, "it banks to port: the starboard wing is up"
    assert math.degrees(turning.readout("roll")) == pytest.approx(-13.6, abs=0.3)
    assert turning.readout("turn-rate") == pytest.approx(0.0038, abs=1e-4)
    assert turning.readout("turn-radius") == pytest.approx(103.0, abs=1.0)


def test_the_rolling_mass_swings_about_its_pivot_on_screen(turning):
    turning.page.evaluate("() => window.__studio.clock.seek(100)")
    swung = [0.4216, -0.014 * math.sqrt(0.5), 0.014 * math.sqrt(0.5)]
    turning.wait_until(lambda: turning.pose("/glider/part1")["position"] == pytest.approx(swung, abs=1e-5))
    expect(turning.page.get_by_test_id("lane-Battery")).to_contain_text("45.0 °")


def test_the_chase_view_turns_with_the_glider(turning):
    turning.page.evaluate("() => window.__studio.clock.seek(250)")
    turning.wait_until(lambda: abs(axes(turning)[0][1]) > 0.2)
    bank = axes(turning)[1][2]
    turning.page.get_by_test_id("camera-chase").click()
    turning.wait_until(lambda: abs(axes(turning)[0][1]) < 1e-3)  # the nose points away from the camera
    assert axes(turning)[1][2] == pytest.approx(bank, abs=1e-3)
    water = rotate(np.array([[1.0, 0.0, 0.0]]), tuple(turning.pose("/world")["wxyz"]))[0]
    assert math.atan2(water[1], water[0]) == pytest.approx(-turning.readout("heading"), abs=1e-3)


def test_the_overview_holds_the_path_still_and_marks_the_glider(turning):
    turning.page.get_by_test_id("camera-overview").click()
    turning.scene("() => window.__viserSceneTree.getState()['/glider/beacon'].visibility === true")
    before = turning.pose("/world")["position"]
    turning.page.evaluate("() => window.__studio.clock.seek(250)")
    end = [turning.readout(name) for name in ("north", "east", "depth")]
    turning.wait_until(lambda: turning.pose("/world")["position"] == pytest.approx(before, abs=1e-6))
    expected = np.array(end) + before
    turning.wait_until(lambda: turning.pose("/glider")["position"] == pytest.approx(expected, abs=1e-3))
    turning.page.get_by_test_id("camera-side").click()
    turning.wait_until(lambda: turning.pose("/glider")["position"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9))


def test_the_path_is_seen_from_the_side_and_from_above(turning):
    page = turning.page
    expect(page.get_by_test_id("time")).to_have_text("0:00 / 5:00 min")
    page.get_by_text("Plan", exact=True).click()
    expect(page.locator("#path-title")).to_have_text("Path, north up")
    page.evaluate("() => window.__studio.clock.seek(300)")
    # the marker of a glider that has turned right of north points right of upwards
    style = page.locator(".glider-marker").get_attribute("style")
    turn = float(style.split("rotate(")[1].split("deg")[0])
    assert turn == pytest.approx(math.degrees(turning.readout("heading")) - 90.0, abs=0.01)
    for name in ("pitch", "roll", "attack", "heading"):
        expect(page.get_by_test_id(f"legend-{name}")).to_contain_text("°")


def test_forces_without_data_points_are_drawn_with_their_range(turning):
    page = turning.page
    page.get_by_test_id("hydrodynamics").click()
    expect(page.locator("#polar-measured")).to_have_text("−20 to 20°")
    expect(page.get_by_test_id("polar-provenance")).to_contain_text("beyond, the formulas go on")
    expect(page.locator("#polar-lift-value")).to_contain_text("at")
    expect(page.locator("#polar-fit")).to_be_hidden()


def test_the_model_is_chosen_in_the_panel_and_told_what_is_missing(program, page):
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    document["vehicle"]["mass_properties"]["inertia"] |= {"xx": 1e-3, "zz": 1e-2}
    page, studio = page, PanelPage.open_document(page, program.url, document)
    expect(page.get_by_test_id("readout-roll")).to_be_hidden()
    studio.open_section("mission")
    studio.choose("Model", "spatial")
    studio.wait_until(lambda: studio.state("s.run.model") == "spatial")
    expect(page.get_by_test_id("readout-roll")).to_be_visible()
    expect(page.get_by_test_id("readout-distance")).to_be_hidden()
    warning = page.get_by_test_id("warnings").locator("details", has_text="nothing holds the glider against sideslip")
    expect(warning.get_by_role("button")).to_be_hidden()
    warning.locator("summary").press("Enter")
    expect(warning.get_by_role("button")).to_have_text("Show the force data")
    studio.row("Position y").wait_for()


def test_an_offset_cell_banks_the_glider(turning):
    """Through the session's own operations: level the battery, and put the engine to starboard instead."""
    turning.edit(
        {"op": "remove", "path": "/mission/control/schedules/0"},
        {"op": "replace", "path": "/vehicle/components/2/position/1", "value": 0.05},
    )
    turning.wait_until(lambda: turning.state("s.components[2].position[1]") == 0.05)
    turning.wait_until(lambda: turning.state("s.run.cells[0].command.at(-1)") == 0)
    # shrunk, it lifts less to starboard than it weighs: that side goes down, and it turns the other way
    turning.wait_until(lambda: turning.readout("end-roll") > math.radians(1.0))
    assert turning.readout("end-heading") < 0.0
    # the plot's line goes on below zero; both numbers are those of the compass
    turning.page.evaluate(f"() => window.__studio.clock.seek({DURATION})")
    turning.wait_until(lambda: turning.readout("heading") > math.pi)
    shown = f"{math.degrees(turning.readout('heading')):.1f}"
    expect(turning.page.get_by_test_id("readout-heading")).to_have_text(shown)
    expect(turning.page.get_by_test_id("legend-heading")).to_have_text(f"{shown} °")


def test_the_bed_is_seen_only_from_near_and_in_the_overview(reopened):
    """Through lake water a plane far below would look as if it were near; the overview shows where the water ends."""
    document = spiral_document(duration=DURATION)
    document["mission"]["environment"]["bed_depth"] = 40.0
    studio = reopened(document)
    page = studio.page
    shown = "() => document.querySelector('iframe').contentWindow.__viserSceneTree.getState()['/world/bed']?.visibility"
    studio.wait_until(lambda: page.evaluate(shown) is False)
    page.get_by_test_id("camera-overview").click()
    studio.wait_until(lambda: page.evaluate(shown) is True)
    page.get_by_test_id("camera-side").click()
    studio.wait_until(lambda: page.evaluate(shown) is False)
    page.evaluate("() => window.__studio.clock.seek(window.__studio.clock.end)")
    studio.wait_until(lambda: page.evaluate(shown) is True)
