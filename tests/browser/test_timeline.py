"""The journeys on the timeline: moving and copying points, looking closer, choosing what is plotted, and marks."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from tests.browser.timeline_page import Timeline, center

pytestmark = pytest.mark.browser

SPIRAL, LAKE = "quad-bellows-spiral", "canete-dual-bellows"
PORT, STARBOARD, REAR_PORT = "Front port cell", "Front starboard cell", "Rear port cell"
COMMAND_Y = "([name, e]) => window.__studio.timeline.lanes.lanes.get(name).y(e)"
SAME_COMMAND = """async ([name, by, wrap]) => {
  const copy = await import("../../static/schedulecopy.js");
  const { schedules, duration } = window.__studio.state;
  const { points, initial } = schedules.find((s) => s.cell === name);
  const round = (t) => ((t % duration) + duration) % duration;
  const shifted = copy.shifted(points, by, { start: initial, duration, wrap, gap: 0.01 });
  const before = (t) => copy.commandAt(points, initial, t);
  const wanted = (t) => (wrap ? before(round(t - by)) : t < by ? initial : before(t - by));
  // a step is on one side or the other within a gap of itself
  const edges = [...points.map((p) => p.time + by), ...shifted.map((p) => p.time)].map(round);
  const times = Array.from({ length: 997 }, (_, i) => ((i + 0.5) * duration) / 997);
  const clear = times.filter((t) => edges.every((e) => Math.abs(t - e) > 0.02));
  const away = clear.map((t) => Math.abs(copy.commandAt(shifted, initial, t) - wanted(t)));
  const rising = shifted.every((p, k) => k === 0 || p.time > shifted[k - 1].time);
  return { worst: Math.max(...away), rising, end: shifted.at(-1).time <= duration };
}"""


@pytest.fixture
def spiral(program, page) -> Timeline:
    return Timeline.open_preset(page, program.url, SPIRAL)


@pytest.fixture
def lake(program, page) -> Timeline:
    return Timeline.open_preset(page, program.url, LAKE)


def test_chosen_points_move_together_in_one_step_of_undo(spiral):
    before = {cell: spiral.points(cell) for cell in (PORT, STARBOARD)}
    spiral.point(PORT, 2).click(modifiers=["Shift"])
    spiral.point(STARBOARD, 2).click(modifiers=["Shift"])
    assert spiral.chosen() == 2
    x = spiral.scale("s.x(20) - s.x(0)")
    spiral.drag(center(spiral.point(PORT, 2)), (-x, 0.0))
    moved = before[PORT][2]["time"] - 20.0
    spiral.wait_until(lambda: abs(spiral.times(PORT)[2] - moved) < 2.0)
    by = spiral.times(PORT)[2] - before[PORT][2]["time"]
    assert spiral.times(STARBOARD)[2] - before[STARBOARD][2]["time"] == pytest.approx(by, abs=1e-3)
    assert spiral.times(PORT)[2] == pytest.approx(round(spiral.times(PORT)[2], 1), abs=1e-9), "it snaps to tenths"
    assert spiral.times(PORT)[3] == before[PORT][3]["time"]
    spiral.page.get_by_test_id("undo").click()
    spiral.wait_until(lambda: {cell: spiral.points(cell) for cell in (PORT, STARBOARD)} == before)


def test_a_sweep_chooses_and_keys_copy_turn_and_delete(spiral):
    page = spiral.page
    first = spiral.place(spiral.lane(PORT), 400.0, 0.05)
    last = spiral.place(spiral.lane(STARBOARD), 1.0, 0.95)
    spiral.drag(first, (last[0] - first[0], last[1] - first[1]))
    assert spiral.chosen() == 2 * len([t for t in spiral.times(PORT) if 0.0 < t < 400.0]) == 6
    count = len(spiral.points(REAR_PORT))
    spiral.lane(PORT).click(position={"x": spiral.scale("s.x(600)"), "y": 12})
    assert spiral.chosen() == 0
    assert page.evaluate("() => window.__studio.clock.t") == pytest.approx(600.0, abs=2.0)
    page.keyboard.press("Control+a")
    assert spiral.chosen() == 4
    page.keyboard.press("Control+c")
    page.evaluate("() => window.__studio.clock.seek(500)")
    spiral.lane(REAR_PORT).evaluate("lane => lane.focus()")
    page.evaluate(f"() => (t => t.active = t.lanes.get('{REAR_PORT}'))(window.__studio.timeline.lanes)")
    page.keyboard.press("Control+v")
    spiral.wait_until(lambda: len(spiral.points(REAR_PORT)) == count + 4)
    assert spiral.times(REAR_PORT)[count:] == pytest.approx(
        [500.0 + t - spiral.times(PORT)[0] for t in spiral.times(PORT)]
    )
    spiral.wait_until(lambda: spiral.chosen() == 4)
    shapes = [point["shape"] for point in spiral.points(REAR_PORT)[count:]]
    page.keyboard.press("r")
    spiral.wait_until(lambda: [p["shape"] for p in spiral.points(REAR_PORT)[count:]] == [
        "step" if shapes[0] == "ramp" else "ramp"] * 4)  # fmt: skip
    page.keyboard.press("Delete")
    spiral.wait_until(lambda: len(spiral.points(REAR_PORT)) == count)


def test_points_are_moved_and_opened_by_keys(lake):
    page = lake.page
    lake.point("Front bellows", 1).focus()
    page.keyboard.press("ArrowLeft")
    lake.settled("Math.abs(s.schedules[0].points[1].time - 9.9) < 1e-6")
    page.get_by_test_id("snap-time").select_option("1")
    page.get_by_test_id("snap-extension").select_option("coarse")
    lake.point("Front bellows", 1).focus()
    page.keyboard.press("ArrowRight")
    lake.settled("s.schedules[0].points[1].time === 11")
    page.keyboard.press("ArrowUp")
    lake.settled("Math.abs(s.schedules[0].points[1].extension - 0.019) < 1e-9")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("point-time")).to_have_value("11")
    page.keyboard.press("Escape")
    expect(lake.point("Front bellows", 1)).to_be_focused()
    page.reload()
    lake.wait_for_glide()
    assert page.get_by_test_id("snap-time").input_value() == "1"


def test_a_refused_number_stays_in_its_popup_with_the_reason(lake):
    page = lake.page
    before = lake.points("Front bellows")
    lake.point("Front bellows", 1).click()
    box, refused = page.get_by_test_id("point-extension"), page.get_by_test_id("point-refused")
    box.fill("500")
    page.get_by_test_id("point-apply").click()
    expect(refused).to_contain_text("stop")
    expect(box).to_have_value("500")
    expect(box).to_have_attribute("aria-invalid", "true")
    assert lake.points("Front bellows") == before
    box.fill(str(1e3 * before[1]["extension"]))
    expect(refused).to_be_hidden()
    page.get_by_test_id("point-time").fill("0")
    page.get_by_test_id("point-apply").click()
    expect(refused).to_contain_text("point 2 of 'Front bellows'")
    page.get_by_test_id("point-time").fill("11")
    page.get_by_test_id("point-apply").click()
    expect(page.get_by_test_id("point-editor")).to_be_hidden()
    lake.settled("s.schedules[0].points[1].time === 11")


def test_a_point_is_typed_in_the_unit_of_the_fields(lake):
    page = lake.page
    extension = lake.points("Front bellows")[1]["extension"]
    beside = "new URL('unitchoice.js', document.querySelector('script[type=module]').src)"
    choose = f"symbol => import({beside}).then(units => units.chooseUnit('length', symbol))"
    for symbol, per, typed in (("cm", 1e2, 0.017), ("m", 1.0, 0.0165)):
        page.evaluate(choose, symbol)
        lake.point("Front bellows", 1).focus()
        page.keyboard.press("Enter")
        box = page.get_by_test_id("point-extension")
        assert float(box.input_value()) == pytest.approx(per * extension, rel=1e-8)
        expect(page.get_by_test_id("point-editor").locator("label").nth(1).locator("u")).to_have_text(symbol)
        box.fill(str(typed * per))
        page.get_by_test_id("point-apply").click()
        lake.settled(f"Math.abs(s.schedules[0].points[1].extension - {typed}) < 1e-12")
        expect(page.get_by_test_id("point-editor")).to_be_hidden()
        extension = typed


def test_a_refused_copy_keeps_its_dialog_open(lake):
    page = lake.page
    reason = {"title": "Too many points", "status": 422, "errors": [{"pointer": "/mission", "message": "use fewer"}]}
    page.route("**/edit", lambda route: route.fulfill(status=422, json=reason), times=1)
    lake.menu("Front bellows", "shift-schedule")
    page.get_by_test_id("copy-later").fill("1")
    page.get_by_test_id("copy-apply").click()
    expect(page.get_by_test_id("copy-refused")).to_contain_text("use fewer")
    expect(page.get_by_test_id("copy-later")).to_have_value("1")
    page.get_by_test_id("copy-apply").click()
    expect(page.get_by_test_id("copy-dialog")).to_be_hidden()


def test_a_drag_shows_its_numbers_and_the_tip_tells_the_new_command(lake):
    page = lake.page
    page.mouse.move(*center(lake.point("Front bellows", 1)))
    page.mouse.down()
    page.mouse.move(center(lake.point("Front bellows", 1))[0] - 40, center(lake.point("Front bellows", 1))[1], steps=3)
    shown = page.get_by_test_id("drag-tip").inner_text()
    assert re.fullmatch(r"\d+\.\d\d s · \d+\.\d+ mm", shown)
    page.mouse.up()
    expect(page.get_by_test_id("drag-tip")).to_be_hidden()
    time = float(shown.split()[0])
    lake.settled(f"Math.abs(s.schedules[0].points[1].time - {time}) < 0.02")
    first, second = (f"{1e3 * point['extension']:.2f} mm" for point in lake.points("Front bellows")[:2])
    describe = "t => window.__studio.timeline.lanes.list[0].describe(t)[0][1]"
    assert [page.evaluate(describe, time + by) for by in (-0.02, 0.02)] == [first, second], "nothing between the two"
    page.mouse.move(*lake.place(lake.lane("Front bellows"), time + 3.0, 0.9))
    expect(page.locator("#tip")).to_contain_text(second)
    lake.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": 0.0168})
    expect(page.locator("#tip")).to_contain_text("Command16.80 mm")


def test_a_schedule_is_copied_mirrored_to_the_partner(spiral):
    page = spiral.page
    before = spiral.points(STARBOARD)
    spiral.menu(PORT, "copy-schedule")
    assert page.get_by_test_id("copy-to").input_value() == STARBOARD
    page.get_by_test_id("copy-how").select_option("mirrored")
    page.get_by_test_id("copy-apply").click()
    port, starboard = (spiral.state(f"s.components.find(c => c.name === '{cell}')") for cell in (PORT, STARBOARD))
    middle = port["extension_neutral"] + starboard["extension_neutral"]
    stops = starboard["extension_min"], starboard["extension_max"]
    wanted = [min(max(middle - p["extension"], stops[0]), stops[1]) for p in spiral.points(PORT)]
    spiral.wait_until(lambda: [p["extension"] for p in spiral.points(STARBOARD)] == pytest.approx(wanted, abs=1e-6))
    assert spiral.times(STARBOARD) == spiral.times(PORT)
    page.get_by_test_id("undo").click()
    spiral.wait_until(lambda: spiral.points(STARBOARD) == before)


@pytest.mark.parametrize("wrap", [False, True])
def test_a_shifted_command_is_the_same_later(spiral, wrap):
    for by in (250.0, 700.0):
        found = spiral.page.evaluate(SAME_COMMAND, [PORT, by, wrap])
        assert found["worst"] < 1e-9 and found["rising"] and found["end"]


def test_a_copy_is_shifted_in_phase_and_stretched(spiral):
    page = spiral.page
    before = spiral.times(PORT)
    spiral.menu(PORT, "copy-schedule")
    page.get_by_test_id("copy-to").select_option(REAR_PORT)
    page.get_by_test_id("copy-later").fill("100")
    page.get_by_test_id("copy-factor").fill("2")
    page.get_by_test_id("copy-apply").click()
    spiral.wait_until(lambda: spiral.times(REAR_PORT)[-1] == pytest.approx(2.0 * before[-1] + 100.0))
    spiral.menu(PORT, "shift-schedule")
    page.get_by_test_id("copy-later").fill("50")
    page.get_by_test_id("copy-apply").click()
    spiral.wait_until(lambda: spiral.times(PORT)[-1] == pytest.approx(before[-1] + 50.0))


def test_lanes_and_plots_are_looked_at_closer_together(spiral):
    page = spiral.page
    page.mouse.move(*spiral.place(page.get_by_test_id("plot-0"), 480.0))
    page.keyboard.down("Control")
    page.mouse.wheel(0, -500)
    page.keyboard.up("Control")
    spiral.wait_until(lambda: spiral.scale("s.zoomed"))
    page.wait_for_timeout(100)
    length = spiral.scale("s.seconds")
    assert length < 400.0 and spiral.scale("(s.from + s.to) / 2") == pytest.approx(480.0, abs=30.0)
    assert float(page.locator("#scrub").get_attribute("min")) == pytest.approx(spiral.scale("s.from"))
    expect(spiral.point(PORT, 0)).to_be_hidden()
    # playing on beyond the window turns the page; the clock's line is in sight
    page.evaluate("() => window.__studio.clock.seek(900)")
    assert spiral.scale("s.shows(900)") and spiral.scale("s.seconds") == pytest.approx(length)
    expect(page.locator("#scrub")).to_have_attribute("data-outside", "")
    page.evaluate("n => (l => { l.scale.setWindow(100, 100 + n); l.redraw(); })(window.__studio.timeline)", length)
    expect(page.locator("#scrub")).to_have_attribute("data-outside", "after")
    expect(page.get_by_test_id("clock-line")).to_be_hidden()
    page.get_by_test_id("zoom-from").focus()
    page.keyboard.press("ArrowLeft")
    spiral.wait_until(lambda: spiral.scale("s.seconds") > length * 1.05)
    page.get_by_test_id("zoom-bar").dblclick()
    spiral.wait_until(lambda: not spiral.scale("s.zoomed"))
    page.keyboard.press("+")
    spiral.wait_until(lambda: spiral.scale("s.zoomed"))


def test_outputs_are_chosen_searched_and_remembered(lake):
    page = lake.page
    page.get_by_test_id("add-plot").click()
    search = page.get_by_test_id("output-search")
    search.fill("kinetic")
    expect(page.get_by_test_id("output-list").locator("label:visible")).to_have_count(1)
    page.get_by_test_id("output-kinetic_energy").check()
    page.wait_for_function("() => window.__studio.timeline.plots.rows[2].plot.series[0]?.values.length > 100")
    search.fill("extension bellows")
    page.get_by_test_id("output-extension@Front bellows").check()
    expect(page.get_by_test_id("legend-extension@Front bellows")).to_contain_text("mm")
    search.fill("speed")
    expect(page.get_by_test_id("output-speed")).to_be_disabled()  # a third unit
    page.get_by_test_id("range-right-from").fill("10")
    page.get_by_test_id("range-right-to").fill("20")
    page.get_by_test_id("range-right-to").press("Tab")
    axis = "window.__studio.timeline.plots.rows[2].plot.axes[1]"
    page.wait_for_function(f"() => {axis}.low === 10 && {axis}.high === 20")
    page.get_by_test_id("plot-up").click()
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("plot-picker")).to_have_count(0)
    page.reload()
    lake.wait_for_glide()
    expect(page.get_by_test_id("plot-row-1").get_by_test_id("legend-kinetic_energy")).to_be_visible()
    page.get_by_test_id("plot-menu-1").click()
    page.get_by_test_id("plot-remove").click()
    expect(page.locator("[data-testid^=plot-row-]")).to_have_count(2)


def test_a_kept_run_is_laid_over(lake):
    page = lake.page
    before = lake.readout("end-depth")
    page.evaluate("() => import('../../static/keptruns.js').then(kept => kept.keepRun('Before'))")
    lake.settled("s.kept?.length === 1")
    lake.edit({"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": 0.0168})
    lake.wait_for_change("end-depth", before)
    kept = "window.__studio.timeline.plots.rows[0].plot.series[0].kept"
    page.wait_for_function(f"() => {kept}.length === 1 && {kept}[0].values.length > 100")
    assert page.evaluate(f"() => {kept}[0].values.at(-1)") == pytest.approx(before, abs=1e-6)
    expect(page.get_by_test_id("plot-row-0").get_by_role("group", name="Kept runs laid under")).to_have_text("Before")
    page.wait_for_function("() => window.__studio.timeline.path.kept.length === 1")
    page.mouse.move(*lake.place(page.get_by_test_id("plot-0"), 19.0))
    expect(page.locator("#tip")).to_contain_text("Before")
    page.get_by_test_id("plot-menu-0").click()
    page.locator("[data-testid^=show-kept-]").uncheck()
    page.wait_for_function(f"() => {kept}.length === 0")


def test_a_double_click_adds_a_point_on_the_command_or_where_it_is(lake):
    page, name = lake.page, "Front bellows"
    first, last = lake.points(name)
    lane = lake.lane(name)
    for t, beside, extension in ((5.0, 3.0, first["extension"]), (15.0, -3.0, last["extension"])):
        count = len(lake.points(name))
        box, on = lane.bounding_box(), page.evaluate(COMMAND_Y, [name, extension])
        page.mouse.dblclick(box["x"] + lake.scale(f"s.x({t})"), box["y"] + on + beside)
        lake.wait_until(lambda count=count: len(lake.points(name)) == count + 1)
        (added,) = (point for point in lake.points(name) if point["time"] == pytest.approx(t, abs=0.11))
        assert added["extension"] == pytest.approx(extension, abs=1e-7)
    box, off = lane.bounding_box(), page.evaluate(COMMAND_Y, [name, 0.0176])
    page.mouse.dblclick(box["x"] + lake.scale("s.x(7.0)"), box["y"] + off)
    lake.wait_until(lambda: len(lake.points(name)) == 5)
    (added,) = (point for point in lake.points(name) if point["time"] == pytest.approx(7.0, abs=0.11))
    assert added["extension"] == pytest.approx(0.0176, abs=2e-4)


def test_a_locked_cell_keeps_its_schedule(lake):
    page = lake.page
    address = lake.url.split("?")[0]
    origin = "/".join(address.split("/")[:3])
    before = lake.points("Front bellows")
    answer = page.request.post(f"{address}parts/1/marks", data={"locked": True}, headers={"Origin": origin})
    assert answer.ok, answer.text()
    lake.settled("s.components[1].locked === true")
    expect(page.get_by_role("img", name="Locked").first).to_be_visible()
    lake.drag(center(lake.point("Front bellows", 1)), (-60.0, 0.0))
    lake.point("Front bellows", 1).press("Delete")
    lake.lane("Front bellows").dblclick(position={"x": 300, "y": 12})
    expect(page.get_by_test_id("lane-hint")).to_contain_text("is locked")
    assert lake.points("Front bellows") == before
