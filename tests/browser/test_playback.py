"""Playback by journeys: clock, range, bookmarks, frames of the server, replays, pictures, kept runs, looks."""

from __future__ import annotations

import json
from itertools import pairwise, product

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from tests.browser.panel_page import PanelPage
from tests.browser.studio_page import StudioPage

pytestmark = pytest.mark.browser

CLOCK = "window.__studio.clock"


def clock(page: Page, member: str) -> float:
    return float(page.evaluate(f"() => {CLOCK}.{member}"))


def pressed(page: Page, key: str) -> None:
    """Press a key with the focus nowhere in particular."""
    page.evaluate("() => document.activeElement?.blur()")
    page.keyboard.press(key)


def test_the_clock_steps_from_sample_to_sample_by_keys_and_buttons(panel):
    page = panel.page
    times = panel.state("s.run.columns.t")
    panel.seek(times[10])
    page.get_by_test_id("step-on").click()
    assert clock(page, "t") == times[11]
    pressed(page, ",")
    pressed(page, ",")
    assert clock(page, "t") == times[9]
    panel.seek((times[4] + times[5]) / 2)
    pressed(page, ".")
    assert clock(page, "t") == times[5]


def test_a_range_is_played_and_looped_and_its_bounds_follow_the_keys(panel):
    page = panel.page
    panel.seek(4.0)
    pressed(page, "i")
    panel.seek(5.0)
    pressed(page, "o")
    assert page.evaluate(f"() => {CLOCK}.range") == {"from": 4.0, "to": 5.0}
    expect(page.get_by_test_id("clear-range")).to_contain_text("4.0 – 5.0 s")
    panel.seek(0.0)
    page.get_by_test_id("speed").select_option("5")
    page.get_by_test_id("play").click()
    page.wait_for_function(f"() => !{CLOCK}.playing")
    assert clock(page, "t") == 5.0  # without a loop the range's end is where it stops
    page.evaluate(f"() => {{ window.seen = []; {CLOCK}.watch(({{ t }}) => window.seen.push(t)); }}")
    pressed(page, "l")  # which takes up what the range's end stopped
    page.wait_for_function("() => window.seen.some((t, k) => k > 1 && t < window.seen[k - 1])")
    pressed(page, "Space")
    seen = page.evaluate("() => window.seen.slice(1)")
    assert min(seen) >= 4.0 and max(seen) <= 5.0
    pressed(page, "u")
    assert page.evaluate(f"() => {CLOCK}.range") is None


def test_speed_is_a_hundred_times_and_a_tenth(panel):
    page = panel.page
    for speed in ("100", "0.1"):
        page.get_by_test_id("speed").select_option(speed)
        assert clock(page, "speed") == float(speed)
    panel.seek(0.0)
    page.evaluate(f"() => {{ window.began = performance.now(); {CLOCK}.play(); }}")
    page.wait_for_timeout(1500)
    t, passed = page.evaluate(f"() => [{CLOCK}.t, (performance.now() - window.began) / 1000]")
    page.evaluate(f"() => {CLOCK}.pause()")
    assert 0.0 < t <= 0.1 * passed + 1e-6


def test_bookmarks_are_named_jumped_to_and_remembered_with_the_range(panel):
    page = panel.page
    panel.seek(2.0)
    pressed(page, "i")
    pressed(page, "l")
    panel.seek(3.0)
    pressed(page, "b")
    page.keyboard.type("Bottom")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("bookmark-add")).to_be_hidden()
    panel.seek(8.0)
    page.get_by_test_id("bookmarks").click()
    page.get_by_test_id("bookmark-add").click()
    page.keyboard.press("Escape")
    panel.seek(9.5)
    pressed(page, "[")
    assert clock(page, "t") == 8.0
    pressed(page, "[")
    assert clock(page, "t") == 3.0
    pressed(page, "]")
    assert clock(page, "t") == 8.0
    page.goto(panel.url)
    PanelPage(page)
    expect(page.get_by_test_id("clear-range")).to_contain_text("2.0 –")
    assert clock(page, "loop") == 1.0
    expect(page.get_by_test_id("bookmark-count")).to_have_text("2")
    page.get_by_test_id("bookmarks").click()
    expect(page.get_by_test_id("bookmark-name-0")).to_have_value("Bottom")
    page.get_by_test_id("bookmark-0").click()
    assert clock(page, "t") == 3.0
    page.get_by_test_id("bookmark-delete-0").click()
    expect(page.get_by_test_id("bookmark-count")).to_have_text("1")


def test_keys_typed_into_a_field_or_the_list_of_keys_stay_there(panel):
    page = panel.page
    panel.seek(5.0)
    page.get_by_test_id("rename").click()
    page.get_by_test_id("rename-field").fill("")
    page.keyboard.type("k b i o ? .")
    page.keyboard.press("Enter")
    panel.wait_until(lambda: panel.state("s.name") == "k b i o ? .")
    expect(page.get_by_test_id("name")).to_have_text("k b i o ? .")
    assert clock(page, "t") == 5.0
    assert panel.state("s.kept") == []
    pressed(page, "?")
    keys = page.get_by_test_id("keys")
    expect(keys).to_be_visible()
    for words in ("Play or pause", "Back by one sample", "Bookmark this moment", "Undo", "Save"):
        expect(keys).to_contain_text(words)
    page.keyboard.press("Space")  # the dialog's own: the glide stays where it is
    page.keyboard.press("Escape")
    expect(keys).to_be_hidden()
    assert clock(page, "t") == 5.0 and not clock(page, "playing")


def hide_the_hook(page: Page) -> None:
    """Have Viser's client offer no hook, as another version might; what it holds stays readable for the test."""
    page.add_init_script(
        "Object.defineProperty(window, '__viserMutable', { get: () => undefined, set(v) { window.__kept = v; } })"
    )


def test_without_the_hook_the_server_moves_the_scene(program, new_page):
    page = new_page
    hide_the_hook(page)
    studio = StudioPage.open_preset(page, program.url, "canete-dual-bellows")
    page.wait_for_timeout(8500)  # the page waits for the hook as long
    frame = next(f for f in page.frames if "/view/" in f.url)
    depth = "() => -window.__kept.nodePoseData['/world'].position[2]"
    studio.seek(0.0)
    frame.wait_for_function(f"() => Math.abs(({depth})() - {studio.state('s.run.columns.z[0]')}) < 1e-3")
    studio.seek(8.0)
    expected = np.interp(8.0, studio.state("s.run.columns.t"), studio.state("s.run.columns.z"))
    frame.wait_for_function(f"() => Math.abs(({depth})() - {expected}) < 1e-3")


SCHEME = "() => [document.documentElement.dataset.theme, getComputedStyle(document.body).backgroundColor]"


def test_the_glide_comes_as_csv_and_netcdf(panel, tmp_path):
    text = panel.downloaded("export-csv", tmp_path).read_text()
    assert text.count("\n") > 100
    assert panel.downloaded("export-nc", tmp_path).read_bytes()[:4] == b"\x89HDF"


def test_glides_are_kept_named_referred_to_and_deleted(panel):
    page = panel.page
    page.get_by_test_id("compare").click()
    page.get_by_test_id("keep-name").fill("As published")
    page.get_by_test_id("keep").click()
    panel.wait_until(lambda: [k["name"] for k in panel.state("s.kept")] == ["As published"])
    kept = panel.state("s.kept[0].id")
    # the first one kept is the reference without more ado
    panel.wait_until(lambda: page.evaluate("() => window.__studio.view.ghost") == kept)
    name = page.get_by_test_id(f"kept-name-{kept}")
    name.fill("Before")
    name.press("Enter")
    panel.wait_until(lambda: panel.state("s.kept[0].name") == "Before")
    for _ in range(3):
        page.get_by_test_id("keep").click()
        page.wait_for_timeout(150)
    panel.wait_until(lambda: len(panel.state("s.kept")) == 4)
    expect(page.get_by_test_id("keep")).to_be_disabled()
    page.get_by_test_id(f"forget-{kept}").click()
    panel.wait_until(lambda: len(panel.state("s.kept")) == 3)
    panel.wait_until(lambda: page.evaluate("() => window.__studio.view.ghost") is None)


def test_light_and_dark_are_chosen_and_remembered(panel):
    page = panel.page
    assert page.evaluate(SCHEME)[0] == "dark"
    page.get_by_test_id("theme").click()
    chosen, color = page.evaluate(SCHEME)
    assert chosen == "light" and color == "rgb(238, 242, 246)"
    page.goto(panel.url)
    PanelPage(page)
    assert page.evaluate(SCHEME) == ["light", color]


def test_columns_are_resized_by_pointer_and_keys_and_remembered(panel):
    page = panel.page
    border, parts = page.get_by_test_id("split-left"), page.get_by_test_id("parts")
    before = parts.bounding_box()["width"]
    box = border.bounding_box()
    page.mouse.move(box["x"] + 4, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 64, box["y"] + 100, steps=4)
    page.mouse.up()
    assert parts.bounding_box()["width"] == pytest.approx(before + 60, abs=2)
    border.press("ArrowLeft")
    assert parts.bounding_box()["width"] == pytest.approx(before + 44, abs=2)
    page.goto(panel.url)
    PanelPage(page)
    assert parts.bounding_box()["width"] == pytest.approx(before + 44, abs=2)
    border.dblclick()
    assert parts.bounding_box()["width"] == pytest.approx(before, abs=2)


def test_nothing_in_the_header_or_transport_wraps_or_overlaps(panel):
    page = panel.page
    for (width, height), bar in product([(1280, 720), (1400, 900)], (".top", ".transport")):
        page.set_viewport_size({"width": width, "height": height})
        boxes = page.evaluate(
            "bar => [...document.querySelector(bar).children]"
            ".map(c => [c.id || c.textContent, c.getBoundingClientRect()])"
            ".filter(([, r]) => r.width > 1).map(([n, r]) => [n.trim(), r.left, r.right, r.height])",
            bar,
        )
        for (name, _, right, high), (following, left, *_) in pairwise(boxes):
            assert right <= left + 0.5, f"{name} runs into {following} at {width} px"
            assert high <= 40, f"{name} wraps at {width} px"
        assert boxes[-1][2] <= width
        expect(page.get_by_test_id("hydrodynamics-range")).to_be_in_viewport()
        assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


def test_on_a_phone_the_panels_take_turns(panel):
    page = panel.page
    page.set_viewport_size({"width": 390, "height": 844})
    for tab, shown, hidden in (("parts", "parts", "now"), ("results", "now", "parts"), ("timeline", "scrub", "now")):
        page.get_by_test_id(f"tab-{tab}").click()
        expect(page.get_by_test_id(shown)).to_be_visible()
        expect(page.get_by_test_id(hidden)).to_be_hidden()
        expect(page.get_by_test_id("play")).to_be_in_viewport()
        assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


def test_the_hydrodynamic_source_is_named_with_its_range(panel):
    document = json.loads(panel.page.request.get(panel.url.split("?")[0] + "design.json").text())
    speeds = document["vehicle"]["hydrodynamics"]["row_speed"]
    expect(panel.page.get_by_test_id("hydrodynamics-range")).to_have_text(
        f"α ±90°, {min(speeds):g}–{max(speeds):g} m/s"
    )
