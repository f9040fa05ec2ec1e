"""The right column follows each edit: trims, margins, warnings that lead to their fields, modes that play, polars."""

from __future__ import annotations

import math
import re

import pytest
from playwright.sync_api import expect

from models.design import loads_design
from models.trim import find_trims
from tests.browser.studio_page import StudioPage

pytestmark = pytest.mark.browser
BODY_X = "/vehicle/components/1/position/0"


HELD = """async ([points, span, extension, duration]) => {
  const { holdPatch } = await import("/static/holdpatch.js");
  const { commandAt } = await import("/static/schedulecopy.js");
  const schedules = [{ cell: "Cell", index: 3, points, initial: 0.5 }];
  const [operation, ...more] = holdPatch({ schedules, duration }, span, { Cell: extension });
  const times = Array.from({ length: 1000 }, (_, i) => ((i + 0.5) * duration) / 1000);
  const inside = (t) => t > span[0] && t < span[1];
  const now = (t) => commandAt(operation.value, 0.5, t);
  return {
    operation: [operation.op, operation.path, more.length],
    held: times.filter(inside).every((t) => Math.abs(now(t) - extension) < 1e-12),
    kept: times.filter((t) => !inside(t)).every((t) => Math.abs(now(t) - commandAt(points, 0.5, t)) < 1e-12),
    rising: operation.value.every((p, k) => k === 0 || p.time > operation.value[k - 1].time),
  };
}"""


def settled(studio: StudioPage) -> None:
    """Wait until the consequences shown are those of the newest run, with trims."""
    studio.page.wait_for_function(
        "() => { const { state, consequences: c } = window.__studio;"
        " return c && c.analyses === 'ready' && c.run === state.run.number && !state.simulating; }"
    )


def pitch_shown(studio: StudioPage) -> float:
    """Return the pitch (rad) at which the 3D view holds the glider, of a planar run."""
    w, _x, y, _z = studio.pose("/glider")["wxyz"]
    return 2.0 * math.atan2(y, w)


def stop_at(studio: StudioPage, time: float) -> None:
    studio.page.evaluate(f"() => window.__studio.clock.seek({time})")


def test_an_edit_changes_the_trim_of_the_hold_at_the_clock(studio):
    page = studio.page
    settled(studio)
    expect(page.locator("#trim-title")).to_have_text("Trim, held 0–10 s")
    before = studio.readout("trim-pitch")
    studio.type_number("Position x", 150)
    studio.wait_for_change("trim-pitch", before)
    settled(studio)
    design = loads_design(page.request.get(f"{studio.url.split('?')[0]}design.json").text())
    for time, title in ((1.0, "Trim, held 0–10 s"), (15.0, "Trim, held 10–20 s")):
        stop_at(studio, time)
        expect(page.locator("#trim-title")).to_have_text(title)
        held = page.evaluate(f"() => window.__studio.consequences.holds[{int(time > 10.0)}].extensions")
        stable = find_trims(design, extensions=held).stable
        pitch, speed = studio.readout("trim-pitch"), studio.readout("trim-speed")
        assert any(abs(t.pitch - pitch) < 1e-5 and abs(t.speed - speed) < 1e-5 for t in stable)
    assert studio.readout("trim-glide-angle") > 0.0  # it climbs then
    expect(page.get_by_test_id("trim-stable")).to_have_text("stable")


def test_numbers_are_compared_with_the_reference(studio):
    page = studio.page
    settled(studio)
    expect(page.get_by_test_id("change-trim-pitch")).to_have_text("")
    page.get_by_test_id("compare").click()
    page.get_by_test_id("keep").click()
    expect(page.get_by_test_id("delta-to")).to_have_text("Δ to Run 1")
    page.keyboard.press("Escape")
    before = studio.readout("trim-pitch")
    studio.edit({"op": "replace", "path": BODY_X, "value": 0.15})
    after = studio.wait_for_change("trim-pitch", before)
    settled(studio)
    change = math.degrees(after - before)
    expect(page.get_by_test_id("change-trim-pitch")).to_have_text(f"{change:+.1f}".replace("-", "\u2212"))


def test_a_warning_leads_to_its_field_and_its_time(studio):
    page = studio.page
    stop = studio.state("s.components[1].extension_max")
    studio.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": stop})
    warning = page.get_by_test_id("warnings").locator("details", has_text="is at its upper stop")
    warning.locator("summary").click()
    expect(warning).to_have_attribute("data-severity", "note")
    warning.get_by_role("button", name=re.compile("Show Front bellows: stroke")).click()
    page.wait_for_function("() => document.querySelector('#parts').contains(document.activeElement)")
    warning.locator(".time-link").first.click()
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(10.0, abs=0.2)
    # both ways: the stretch on the timeline and the line in the list light up together
    warning.locator("summary").hover()
    expect(page.locator(".doubt.focused").first).to_have_attribute("aria-label", re.compile("upper stop"))


def test_a_glider_without_a_trim_says_why(studio):
    page = studio.page
    settled(studio)
    studio.edit(
        {"op": "replace", "path": "/mission/control/schedules", "value": []},
        {"op": "replace", "path": "/mission/initial/extensions", "value": {}},
    )
    expect(page.get_by_test_id("trim-missing")).to_contain_text("weighs what it displaces")
    expect(page.get_by_test_id("trim-now")).to_be_hidden()
    expect(page.get_by_test_id("warnings")).to_contain_text("there is no steady glide")
    page.get_by_test_id("trim-for-angle").fill("-30")
    page.get_by_test_id("trim-for-find").click()
    expect(page.get_by_test_id("trim-for-found")).to_contain_text("\u221230.0°")
    page.get_by_test_id("trim-for-apply").click()
    settled(studio)
    studio.wait_until(lambda: abs(studio.readout("trim-glide-angle") + math.radians(30.0)) < 1e-4)
    page.get_by_test_id("undo").click()
    expect(page.get_by_test_id("trim-missing")).to_contain_text("weighs what it displaces")
    page.get_by_test_id("trim-for-angle").fill("steep")
    page.get_by_test_id("trim-for-find").click()
    expect(page.get_by_test_id("trim-for-answer")).to_contain_text("is a number from")


def step(time: float, extension: float) -> dict[str, object]:
    return {"time": time, "extension": extension, "shape": "step"}


@pytest.mark.parametrize(
    ("points", "span"),
    [
        ([step(0.0, 0.1), step(100.0, 0.2), step(200.0, 0.3)], (100.0, 200.0)),
        ([step(0.0, 0.1), step(100.0, 0.2), step(200.0, 0.3)], (50.0, 150.0)),
        ([step(0.0, 0.1), step(60.0, 0.2), step(120.0, 0.1)], (30.0, 300.0)),
        ([step(120.0, 0.1)], (0.0, 120.0)),
        ([step(10.0, 0.1), step(40.0, 0.1) | {"shape": "ramp"}], (100.0, 250.0)),
    ],
    ids=["whole hold", "across holds", "to the end", "before the first point", "after a ramp"],
)
def test_a_wanted_glide_holds_in_its_span_alone(program, bare, points, span):
    bare.goto(program.url)
    found = bare.evaluate(HELD, [points, span, 0.7, 300.0])
    assert found == {
        "operation": ["replace", "/mission/control/schedules/3/points", 0], "held": True, "kept": True, "rising": True,
    }  # fmt: skip


def test_a_mode_moves_the_glider_while_it_plays(studio):
    page = studio.page
    settled(studio)
    stop_at(studio, 5.0)
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


def test_the_polars_show_the_trims_and_the_run_its_error(studio):
    page = studio.page
    settled(studio)
    page.get_by_test_id("glide-polar-open").click()
    expect(page.get_by_test_id("glide-polar-trim")).to_have_count(2)
    expect(page.get_by_test_id("glide-polar-legend")).to_contain_text("Best range")
    page.get_by_test_id("polar-page-forces").check(force=True)
    attack = math.degrees(page.evaluate("() => window.__studio.consequences.holds[0].trim.angle_of_attack"))
    expect(page.get_by_test_id("polar-trim").first).to_contain_text(f"trim held 0–10 s, at {attack:.2f}°")
    page.get_by_test_id("polar-close").click()
    expect(page.get_by_test_id("source-range")).to_contain_text("α ±90°")
    expect(page.get_by_test_id("source-now")).not_to_be_empty()
    page.get_by_test_id("estimate").click()
    expect(page.get_by_test_id("error-z")).to_be_visible()
    assert 0.0 < float(page.get_by_test_id("error-z").get_attribute("data-value")) < 1e-4
    # a group stays as it was left
    page.locator("[data-group=margins] > summary").click()
    page.wait_for_function("() => JSON.parse(localStorage.getItem('glider-studio.groups'))?.margins === false")
    page.reload()
    StudioPage(page)
    expect(page.get_by_test_id("margins")).to_be_hidden()
