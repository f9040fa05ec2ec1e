"""The 3D view with the page around it: it follows the clock, the design and the colours, and is given away as files."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from imageio.v3 import imread
from playwright.sync_api import Browser, expect

from tests.browser.studio_page import StudioPage
from tests.browser.timeline_page import Timeline

pytestmark = pytest.mark.browser


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


def test_a_click_moves_the_clock_and_the_scene_and_redraws_no_curve(studio):
    lake, page = Timeline(studio.page), studio.page
    page.evaluate("""() => {
      window.__drawn = 0;
      for (const { plot } of window.__studio.timeline.plots.rows) {
        const draw = plot.draw;
        plot.draw = function () { window.__drawn += 1; return draw.call(this); };
      }
    }""")
    page.mouse.click(*lake.place(page.get_by_test_id("plot-1"), 15.0))
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(15.0, abs=0.1)
    shown = f"{lake.readout('depth'):.3f} m"
    expect(page.get_by_test_id("legend-depth")).to_have_text(shown)
    lake.wait_until(lambda: abs(lake.pose("/glider")["wxyz"][2]) > 0.3)  # pitched up by 60 degrees
    assert page.evaluate("() => window.__drawn") == 0
    page.evaluate("() => window.__studio.timeline.plots.rows.forEach(({ plot }) => delete plot.draw)")
    page.mouse.move(*lake.place(page.get_by_test_id("plot-1"), 5.0))
    expect(page.locator("#tip")).to_contain_text("Pitch")
    expect(page.get_by_test_id("cursor-depth")).not_to_be_empty()
    z = lake.state("s.run.columns.z[s.run.columns.t.findIndex(t => t >= 5)]")
    assert float(page.get_by_test_id("cursor-depth").inner_text()) == pytest.approx(z, abs=0.02)


def pitch_shown(studio: StudioPage) -> float:
    """Return the pitch (rad) at which the 3D view holds the glider, of a planar run."""
    w, _x, y, _z = studio.pose("/glider")["wxyz"]
    return 2.0 * math.atan2(y, w)


def test_a_mode_moves_the_glider_while_it_plays(studio):
    page = studio.page
    studio.wait_for_consequences()
    studio.seek(5.0)
    page.get_by_test_id("tab-modes").click()
    expect(page.get_by_test_id("modes-words")).to_contain_text("All small motions die out")
    growth = page.evaluate("() => window.__studio.consequences.holds[0].trim.growth")
    expect(page.get_by_test_id("mode-mark-0")).to_have_attribute(
        "aria-label", re.compile(rf"pitch oscillation: \u2212{-growth:.4f} ±")
    )
    trim = page.evaluate("() => window.__studio.consequences.holds[0].trim.pitch")
    page.get_by_test_id("mode-play").click()
    near = math.radians(12.5)  # the amplitude is 12 deg
    studio.wait_until(lambda: abs(pitch_shown(studio) - trim) < near)
    seen: set[float] = set()
    studio.wait_until(lambda: len(seen.add(pitch_shown(studio)) or seen) > 5)
    assert all(abs(pitch - trim) < near for pitch in seen)
    expect(page.get_by_test_id("mode-pill")).to_contain_text("Playing mode: pitch oscillation")
    page.get_by_test_id("mode-pill-stop").click()
    studio.wait_until(lambda: abs(pitch_shown(studio) - studio.readout("pitch")) < 1e-5)
    page.get_by_test_id("modes-point").select_option("clock")
    expect(page.get_by_test_id("modes-words")).to_contain_text("no equilibrium")
    page.get_by_test_id("tab-modes").press("ArrowLeft")
    expect(page.get_by_test_id("now")).to_be_visible()


def test_adding_and_removing_a_cell(studio):
    count = len(studio.state("s.components"))
    studio.add_part("Piston")
    studio.wait_until(lambda: len(studio.state("s.components")) == count + 1)
    expect(studio.page.get_by_test_id("lane-Piston")).to_be_visible()
    studio.scene(f"() => '/glider/cell{count}/stack' in window.__viserSceneTree.getState()")
    studio.page.get_by_test_id("parts-remove").click()
    studio.wait_until(lambda: len(studio.state("s.components")) == count)


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


def test_the_scene_is_light_or_dark_with_the_page(studio):
    for scheme in ("light", "dark"):
        studio.page.get_by_test_id("theme").click()
        studio.scene(f"() => document.documentElement.getAttribute('data-mantine-color-scheme') === '{scheme}'")


def test_the_picture_shows_the_view(studio, tmp_path):
    file = studio.downloaded("export-png", tmp_path)
    picture = imread(file)[..., :3].astype(int)
    # as many pixels as the page has, though the view itself is drawn with fewer, and then with those again
    view = studio.page.locator("iframe#view").bounding_box()
    assert picture.shape[:2] == pytest.approx((view["height"], view["width"]), abs=1.0)
    studio.scene("() => window.__viserMutable.canvas.width < 0.3 * window.__viserMutable.canvas.clientWidth")
    # water grows darker with depth, and something that is no water is in front of it
    assert picture[0].sum(axis=-1).mean() > picture[-1].sum(axis=-1).mean() + 50
    assert (picture[..., 0] > picture[..., 2]).mean() > 1e-3, "nothing in the picture is warmer than water"


def test_a_replay_opens_without_a_network_and_its_numbers_follow(studio, browser: Browser, tmp_path):
    columns = studio.state("s.run.columns")
    file = studio.downloaded("export-replay", tmp_path)
    assert file.suffix == ".html" and file.stat().st_size <= 3_000_000
    context = browser.new_context(viewport={"width": 800, "height": 500}, offline=True)
    context.set_default_timeout(60_000)
    replay, asked = context.new_page(), []
    replay.on("request", lambda request: asked.append(request.url))
    replay.goto(file.as_uri() + "?fixedDpr=0.25")
    replay.wait_for_function("() => window.__replay?.ready")
    replay.evaluate("() => window.__replay.clock.seek(6.0)")
    at = {name: np.interp(6.0, columns["t"], columns[name]) for name in ("z", "speed", "theta")}
    expect(replay.get_by_test_id("hud-time")).to_have_text("6.0 s")
    expect(replay.get_by_test_id("hud-depth")).to_have_text(f"{at['z']:.3f}")
    expect(replay.get_by_test_id("hud-speed")).to_have_text(f"{at['speed']:.3f}")
    expect(replay.get_by_test_id("hud-pitch")).to_have_text(f"{np.rad2deg(at['theta']):.1f}".replace("-", "−"))
    expect(replay.get_by_test_id("hud-roll")).to_have_text("0.0")
    expect(replay.get_by_test_id("legend-arrows").get_by_role("listitem")).to_have_text(
        ["Net buoyancy", "Lift", "Drag"]
    )
    expect(replay.get_by_test_id("legend-path")).to_contain_text(re.compile(r"Path: speed.* m/s.* m/s"))
    replay.wait_for_function(
        f"() => Math.abs(-window.__viserMutable.nodePoseData['/world'].position[2] - {at['z']}) < 1e-3"
    )
    replay.get_by_test_id("play").click()
    replay.wait_for_function("() => window.__replay.clock.t > 6.5 && window.__replay.poseUpdates > 5")
    replay.get_by_test_id("play").click()
    stray = [url for url in asked if not url.startswith(("file:", "data:", "blob:"))]
    context.close()
    assert stray == []


def test_a_page_comes_back_by_itself_after_a_restart(program, studio):
    before = studio.readout("end-depth")
    for count in (1, 2):
        studio.page.keyboard.press("k")
        studio.wait_until(lambda wanted=count: studio.state("s.kept.length") == wanted)
    first, second = studio.state("s.kept.map(k => k.id)")
    studio.wait_until(lambda: studio.state("s.scene.ghost") == first)
    studio.page.evaluate("() => window.__studio.clock.setRange({ from: 4, to: 5 })")
    studio.type_number("Position x", 140)
    changed = studio.wait_for_change("end-depth", before)
    kept = studio.state("s.kept[0]")
    program.stop()  # which saves
    expect(studio.page.locator("#lost")).to_be_visible()
    file = program.data / "sessions" / f"{studio.state('s.id')}.json"
    saved = json.loads(file.read_bytes())
    saved["kept"]["runs"][1]["design"]["mission"]["duration"] = -1.0
    file.write_text(json.dumps(saved))
    program.start()
    expect(studio.page.locator("#status")).to_have_text("Ready", timeout=30_000)
    expect(studio.page.locator("#lost")).to_be_hidden(timeout=60_000)
    assert studio.readout("end-depth") == changed
    studio.wait_until(lambda: studio.state("s.kept[0]") == kept)
    expect(studio.page.get_by_test_id(f"kept-note-{second}")).to_contain_text(
        "cannot be computed any more: /mission/duration"
    )
    assert studio.page.evaluate("() => window.__studio.clock.range") == {"from": 4, "to": 5}
    studio.type_number("Position x", 160)
    assert studio.wait_for_change("end-depth", changed) != before
    drawn = "window.__viserSceneTree.getState()"
    studio.scene(f"() => '/glider' in {drawn} && '/ghost/silhouette' in {drawn}")
