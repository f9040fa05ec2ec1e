"""The right column follows each edit: trims, margins, warnings that lead to their fields, modes that play, polars."""

from __future__ import annotations

import math
import re
from typing import cast

import numpy as np
import pytest
from playwright.sync_api import expect

from models.design import Design, loads_design, parse_design
from models.energy import energy_bill
from models.mass_properties import mass_balance
from models.run import Run
from models.simulate import simulate
from models.stability import stability_over
from models.trim import Trim, find_trims
from models.water import density_at, gravity_of
from studio.cell_reach import NEAR_STOP
from tests.browser.panel_page import PanelPage
from tests.studio.spiral import ROLL_ANGLE

pytestmark = pytest.mark.browser
BODY_X = "/vehicle/components/1/position/0"


HELD = """async ([points, span, extension, duration]) => {
  const { holdPatch } = await import("/static/holdpatch.js");
  const { commandAt } = await import("/static/schedulecopy.js");
  const schedules = [{ cell: "Cell", index: points.length ? 3 : null, points, initial: 0.5 }];
  const [operation, ...more] = holdPatch({ schedules, duration }, span, { Cell: extension });
  const times = Array.from({ length: 1000 }, (_, i) => ((i + 0.5) * duration) / 1000);
  const inside = (t) => t > span[0] && t < span[1];
  const value = operation.value.points ?? operation.value;
  const now = (t) => commandAt(value, 0.5, t);
  return {
    operation: [operation.op, operation.path, more.length],
    held: times.filter(inside).every((t) => Math.abs(now(t) - extension) < 1e-12),
    kept: times.filter((t) => !inside(t)).every((t) => Math.abs(now(t) - commandAt(points, 0.5, t)) < 1e-12),
    rising: value.every((p, k) => k === 0 || p.time > value[k - 1].time),
  };
}"""


WITHOUT_UNIT = """() => [...document.querySelectorAll("#pane-readouts .readouts .value")]
  .filter((node) => node.checkVisibility() && /[0-9]/.test(node.textContent))
  .filter((node) => !node.parentElement.querySelector(".unit")?.textContent)
  .map((node) => node.dataset.testid)"""


def test_an_edit_changes_the_trim_of_the_hold_at_the_clock(panel):
    page = panel.page
    panel.wait_for_consequences()
    expect(page.locator("#trim-title")).to_have_text("Trim, held 0–10 s")
    before = panel.readout("trim-pitch")
    panel.type_number("Position x", 150)
    panel.wait_for_change("trim-pitch", before)
    panel.wait_for_consequences()
    design = loads_design(page.request.get(f"{panel.url.split('?')[0]}design.json").text())
    for time, title in ((1.0, "Trim, held 0–10 s"), (15.0, "Trim, held 10–20 s")):
        panel.seek(time)
        expect(page.locator("#trim-title")).to_have_text(title)
        held = page.evaluate(f"() => window.__studio.consequences.holds[{int(time > 10.0)}].extensions")
        stable = find_trims(design, extensions=held).stable
        pitch, speed = panel.readout("trim-pitch"), panel.readout("trim-speed")
        assert any(abs(t.pitch - pitch) < 1e-5 and abs(t.speed - speed) < 1e-5 for t in stable)
    assert panel.readout("trim-glide-angle") > 0.0  # it climbs then
    expect(page.get_by_test_id("trim-stable")).to_have_text("stable")


def test_numbers_are_compared_with_the_reference(panel):
    page = panel.page
    panel.wait_for_consequences()
    expect(page.get_by_test_id("change-trim-pitch")).to_have_text("")
    page.get_by_test_id("compare").click()
    page.get_by_test_id("keep").click()
    expect(page.get_by_test_id("delta-to")).to_have_text("Δ to Run 1")
    page.keyboard.press("Escape")
    before = panel.readout("trim-pitch")
    panel.edit({"op": "replace", "path": BODY_X, "value": 0.15})
    after = panel.wait_for_change("trim-pitch", before)
    panel.wait_for_consequences()
    change = math.degrees(after - before)
    expect(page.get_by_test_id("change-trim-pitch")).to_have_text(f"{change:+.1f}".replace("-", "\u2212"))


def test_a_warning_leads_to_its_field_and_its_time(panel):
    page = panel.page
    stop = panel.state("s.components[1].extension_max")
    panel.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": stop})
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


def test_a_glider_without_a_trim_says_why(panel):
    page = panel.page
    page.set_viewport_size({"width": 1280, "height": 600})
    panel.wait_for_consequences()
    panel.edit(
        {"op": "replace", "path": "/mission/control/schedules", "value": []},
        {"op": "replace", "path": "/mission/initial/extensions", "value": {}},
    )
    expect(page.get_by_test_id("trim-missing")).to_contain_text("weighs what it displaces")
    expect(page.get_by_test_id("trim-now")).to_be_hidden()
    expect(page.get_by_test_id("warnings")).to_contain_text("there is no steady glide")
    page.get_by_test_id("trim-for-angle").fill("-30")
    page.get_by_test_id("trim-for-find").click()
    expect(page.get_by_test_id("trim-for-found")).to_contain_text("\u221230.0°")
    expect(page.get_by_test_id("trim-for-answer")).to_be_in_viewport(ratio=0.99)  # scrolled to
    page.get_by_test_id("trim-for-apply").click()
    panel.wait_for_consequences()
    panel.wait_until(lambda: abs(panel.readout("trim-glide-angle") + math.radians(30.0)) < 1e-4)
    page.get_by_test_id("undo").click()
    expect(page.get_by_test_id("trim-missing")).to_contain_text("weighs what it displaces")
    page.get_by_test_id("trim-for-angle").fill("steep")
    page.get_by_test_id("trim-for-find").click()
    expect(page.get_by_test_id("trim-for-answer")).to_contain_text("is a number from")


def step(time: float, extension: float) -> dict[str, object]:
    return {"time": time, "extension": extension, "shape": "step"}


HOLDS: dict[str, tuple[list[dict[str, object]], tuple[float, float]]] = {
    "a whole hold": ([step(0.0, 0.1), step(100.0, 0.2), step(200.0, 0.3)], (100.0, 200.0)),
    "across holds": ([step(0.0, 0.1), step(100.0, 0.2), step(200.0, 0.3)], (50.0, 150.0)),
    "to the end": ([step(0.0, 0.1), step(60.0, 0.2), step(120.0, 0.1)], (30.0, 300.0)),
    "before the first point": ([step(120.0, 0.1)], (0.0, 120.0)),
    "a cell without a schedule": ([], (0.0, 120.0)),
    "such a cell later": ([], (40.0, 120.0)),
    "after a ramp": ([step(10.0, 0.1), step(40.0, 0.1) | {"shape": "ramp"}], (100.0, 250.0)),
}


def test_a_wanted_glide_holds_in_its_span_alone(program, page):
    page.goto(program.url)
    for name, (points, span) in HOLDS.items():
        found = page.evaluate(HELD, [points, span, 0.7, 300.0])
        path = "/mission/control/schedules/3/points" if points else "/mission/control/schedules/-"
        assert found.pop("operation") == ["replace" if points else "add", path, 0], name
        assert found == {"held": True, "kept": True, "rising": True}, name


def test_a_glide_that_its_hold_is_too_short_for_says_so(panel):
    page = panel.page
    panel.wait_for_consequences()
    growth = page.evaluate("() => window.__studio.consequences.holds[0].trim.growth")
    assert -1.0 / growth > 10.0, "the paper's glider turns round long before it has settled"
    told = f"Held 10.0 s, less than the {-1.0 / growth:.1f} s in which it settles"
    expect(page.get_by_test_id("held-message")).to_contain_text(told)
    switch = {"op": "replace", "path": "/mission/control/schedules/0/points/1/time", "value": 100.0}
    panel.edit(switch, {"op": "replace", "path": "/mission/duration", "value": 110.0})
    panel.wait_until(lambda: panel.state("s.run?.columns.t.at(-1)") == 110.0)
    panel.wait_for_consequences()
    panel.seek(50.0)
    expect(page.get_by_test_id("held-message")).not_to_contain_text("less than")


def test_what_a_command_of_time_zero_changes_is_told(panel):
    panel.wait_for_consequences()
    first = panel.at("mission", "control", "schedules", 0, "points", 0)
    commanded = panel.row("Commanded at 0 s")
    expect(commanded).to_contain_text(f"{1e3 * first['extension']:.1f}")
    begun = panel.state("s.run.columns.net_buoyancy[0]")
    note = panel.page.locator("#balance").get_by_text("N by the commands at 0 s")
    expect(note).to_contain_text(f"{begun:.4f} N".replace("-", "\u2212"))
    panel.type_number("Extension at start", 1e3 * first["extension"])
    expect(commanded).to_have_count(0)
    expect(note).to_be_hidden()


def test_the_polars_show_the_trims_and_the_run_its_error(panel):
    page = panel.page
    panel.wait_for_consequences()
    page.get_by_test_id("glide-polar-open").click()
    expect(page.get_by_test_id("glide-polar-trim")).to_have_count(2)
    expect(page.get_by_test_id("glide-polar-legend")).to_contain_text("Best range")
    counts = [page.locator(f"#glide-polar-plot {mark}").count() for mark in ("circle.only", "svg")]
    expect(page.get_by_test_id("glide-polar-words")).to_contain_text("6 lines and 2 single points")
    assert counts == [2, 1]
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
    PanelPage(page)
    expect(page.get_by_test_id("margins")).to_be_hidden()


def shown_trim(studio: PanelPage, design: Design, index: int) -> Trim:
    """Return the library's trim at what a hold holds, the one that the page tells among several."""
    hold = studio.page.evaluate(f"() => window.__studio.consequences.holds[{index}]")
    found = find_trims(design, extensions=hold["extensions"], depth=hold["depth"]).stable
    return min(found, key=lambda trim: abs(trim.pitch - hold["trim"]["pitch"]) + abs(trim.roll - hold["trim"]["roll"]))


def shows_floating(studio: PanelPage, design: Design, held: dict[str, float], cell: str, depth: float) -> None:
    """Assert that the rows of balance are the library's, `cell` being the one that changes volume."""
    vehicle, water = design.vehicle, design.mission.environment
    surroundings = density_at(water.water, depth), gravity_of(water)
    stops = next(part.stroke for _, part in vehicle.actuated if part.name == cell)
    balance = mass_balance(vehicle, held)
    now = balance.net_buoyancy(*surroundings)
    least, most = sorted(mass_balance(vehicle, held | {cell: stop}).net_buoyancy(*surroundings) for stop in stops)
    assert studio.readout("held-net-buoyancy") == pytest.approx(now, abs=1e-9)
    assert studio.readout("reserve-up") == pytest.approx(most - now, abs=1e-9)
    assert studio.readout("reserve-down") == pytest.approx(now - least, abs=1e-9)
    share = round(100 * (most - now) / (most - least))
    expect(studio.page.get_by_test_id("note-reserve-up")).to_have_text(f"{share} % of the stroke")
    offset = balance.center_of_mass - balance.center_of_buoyancy
    for axis, row in enumerate(("com-ahead-of-cob", "com-starboard-of-cob", "com-below-cob")):
        assert studio.readout(row) == pytest.approx(offset[axis], abs=1e-12)


def shows_margins(studio: PanelPage, run: Run, at: int) -> None:
    """Assert that margins at the clock, and the least of the run and when it is, are the library's."""
    stability = stability_over(run, 1)
    for row, values, per, unit in (
        ("margin-pitch-stiffness", stability.pitch_stiffness, 1e3, "mm"),
        ("margin-roll-stiffness", stability.roll_stiffness, 1e3, "mm"),
        ("margin-pitch", stability.pitch_margin, 1e2, "% L"),
        ("margin-yaw", stability.yaw_margin, 1e2, "% L"),
    ):
        assert studio.readout(row) == pytest.approx(values[at], rel=1e-5)
        note = studio.page.get_by_test_id(f"note-{row}")
        told = re.fullmatch(r"least (\S+) (.+) at (\S+) s", (note.text_content() or "").replace("\u2212", "-"))
        assert told is not None and told[2] == unit, note.text_content()
        assert float(told[1]) == pytest.approx(per * np.nanmin(values), abs=0.006)
        assert float(told[3]) == pytest.approx(run.times[np.nanargmin(values)], abs=0.06)


def test_every_consequence_is_the_number_of_the_library(spatial):
    page = spatial.page
    spatial.edit({"op": "replace", "path": "/mission/initial/extensions", "value": {"Battery": ROLL_ANGLE}})
    spatial.wait_for_consequences()
    spatial.seek(16.0)
    design = parse_design(spatial.document())
    run, held = simulate(design), page.evaluate("() => window.__studio.consequences.holds[1].extensions")
    trim = shown_trim(spatial, design, 1)
    expect(page.locator("#trim-title")).to_have_text("Trim, held 2–20 s")
    assert spatial.readout("trim-sink-rate") == pytest.approx(trim.sink_rate, rel=1e-6)
    assert spatial.readout("trim-glide-ratio") == pytest.approx(trim.glide_ratio, rel=1e-6)
    assert trim.turn_radius is not None
    assert spatial.readout("trim-turn-radius") == pytest.approx(trim.turn_radius, rel=1e-6)
    shows_floating(spatial, design, held, "Engine", trim.depth)
    at = int(np.searchsorted(run.times, 16.0 - 1e-9))
    shows_margins(spatial, run, at)
    bill = energy_bill(run)
    assert bill is not None and bill.whole.per_km is not None
    assert spatial.readout("energy-per-km") == pytest.approx(bill.whole.per_km, rel=1e-6)
    assert spatial.readout("energy-whole") == pytest.approx(bill.whole.total, rel=1e-6)
    for k, (_, part) in enumerate(design.vehicle.actuated):
        share = (run.cell_values["extension"][:, k] - part.stroke[0]) / (part.stroke[1] - part.stroke[0])
        nearest = np.minimum(share, 1.0 - share).min()
        side = "lower" if share.min() < 1.0 - share.max() else "upper"
        row = page.get_by_test_id(f"reach-{part.name}")
        expect(row).to_contain_text(f"{100 * nearest:.1f} % of the stroke from its {side} stop")
    assert page.evaluate(WITHOUT_UNIT) == ["readout-trim-glide-ratio"]


def test_near_a_stop_means_one_thing(panel):
    page = panel.page
    panel.wait_for_consequences()
    group, title = page.locator("#reach-group"), page.locator("#reach-title")
    hatch = page.get_by_test_id("lane-Front bellows").locator(".near-stop")
    expect(title).to_have_text("Stops")
    assert group.get_attribute("open") is None
    stop = panel.state("s.components[1].extension_max")
    low = panel.state("s.components[1].extension_min")

    def ask(share: float) -> None:
        value = stop - share * (stop - low)
        panel.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": value})

    warning = page.get_by_test_id("warnings").locator("details", has_text="its upper stop")
    ask(1.2 * NEAR_STOP)
    panel.wait_for_consequences()
    expect(hatch).to_have_attribute("d", "")
    expect(title).to_have_text("Stops")
    expect(warning).to_have_count(0)
    ask(0.8 * NEAR_STOP)
    expect(hatch).to_have_attribute("d", re.compile("^M"))
    expect(title).to_have_text("Stops, 1 near")
    expect(group).to_have_attribute("open", "")
    warning.locator("summary").click()
    expect(warning).to_contain_text(f"comes within {80 * NEAR_STOP:.2g} % of its stroke of its upper stop")
    expect(warning).to_have_attribute("data-severity", "note")
    warning.locator(".time-link").first.click()
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(10.0, abs=0.2)
    warning.get_by_role("button", name=re.compile("Show Front bellows: stroke")).click()
    page.wait_for_function("() => document.querySelector('#parts').contains(document.activeElement)")
    # what was folded by hand stays so; what opened by itself is not remembered
    assert page.evaluate("() => localStorage.getItem('glider-studio.groups')?.includes('reach') ?? false") is False
    group.locator("summary").click()
    ask(0.0)
    expect(warning).to_have_count(1)
    expect(warning).to_contain_text("is at its upper stop")
    assert group.get_attribute("open") is None


def test_what_is_left_out_is_told(panel):
    page = panel.page
    high = panel.state("s.components[1].extension_max")
    many = [{"time": k + 0.5 * back, "extension": 0.002 if back else high} for k in range(20) for back in (0, 1)]
    path = "/mission/control/schedules/0/points"
    panel.edit({"op": "replace", "path": path, "value": many})
    visits = math.ceil(cast(float, panel.state("s.run.columns.t.at(-1)")))  # it may surface before the end
    assert visits > 12
    expect(page.locator(".doubt[aria-label*='at its upper stop']")).to_have_count(visits)
    warning = page.get_by_test_id("warnings").locator("details", has_text="is at its upper stop")
    warning.locator("summary").click()
    expect(warning.locator(".when")).to_have_text(re.compile(rf"and {visits - 4} more$"))
    stairs = [{"time": 2.0 * k, "extension": 0.01 + 0.001 * k} for k in range(8)]
    panel.edit({"op": "replace", "path": path, "value": stairs})
    panel.wait_for_consequences()
    message = page.get_by_test_id("held-message")
    panel.seek(5.0)
    expect(message).to_contain_text("shorter holds are not told")
    expect(message).not_to_contain_text("What is held now")
    panel.seek(11.0)
    expect(message).to_contain_text("What is held now is shorter than the holds told: shown is the one held")
    expect(page.locator("#energy-message")).to_contain_text("The planar model keeps no account of the battery")


def test_the_energy_residual_says_of_what_it_is(panel):
    page = panel.page
    unit = page.get_by_test_id("readout-energy-residual").locator("xpath=following-sibling::*")
    expect(unit).to_have_text("rel.")
    page.get_by_test_id("estimate").click()
    expect(page.locator("#error-text")).to_have_text(re.compile(r"of the energy exchanged\.$"))
    panel.edit(
        {"op": "replace", "path": "/mission/control/schedules", "value": []},
        {"op": "replace", "path": "/mission/initial/extensions", "value": {}},
        {"op": "replace", "path": "/mission/environment/gravity", "value": 0.0},
    )
    expect(unit).to_have_text("J")  # nothing was exchanged that it could be a share of
