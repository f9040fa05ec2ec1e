"""What is drawn on the timeline's canvases: the ground outside of the force data, and the units of the axes."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from models.presets import load_preset
from tests.browser.timeline_page import Timeline
from tests.models.test_moments import MOMENTS

pytestmark = pytest.mark.browser

CHANGED = """([name, places]) => {
  const { timeline } = window.__studio;
  const plot = name === "path" ? timeline.path : timeline.plots.rows[name].plot;
  const read = () => places.map((t) => {
    const { columns } = plot.run;
    const i = columns.t.findIndex((each) => each >= t);
    const at = name === "path"
      ? [plot.px(plot.column("across")[i]), plot.pz(plot.column("along")[i])]
      : [timeline.scale.x(t), plot.canvas.clientHeight / 2];
    const [x, y] = at.map((v) => Math.round((v - 9) * devicePixelRatio));
    const side = Math.round(18 * devicePixelRatio);
    return [...plot.canvas.getContext("2d").getImageData(x, y, side, side).data];
  });
  const { run } = plot;
  read(); // from here on the browser draws this canvas in software: lines must be smoothed in one way
  plot.draw();
  const hatched = read();
  plot.run = { ...run, outside: [] };
  plot.draw();
  const clean = read();
  plot.run = run;
  plot.draw();
  return hatched.map((data, k) => data.filter((v, i) => Math.abs(v - clean[k][i]) > 8).length / data.length);
}"""
"""Which share of the pixels round some moments of a plot is there because they are outside the data."""


@pytest.mark.parametrize("name", [0, 1, "path"])
def test_what_is_outside_the_force_data_is_hatched(program, page, name):
    timeline = Timeline.open_preset(page, program.url, "three-cell-glider")
    spans = timeline.state("s.run.outside[0].spans")  # as it turns it is slower than the data
    inside, clear = sum(spans[1]) / 2.0, (spans[0][1] + spans[1][0]) / 2.0
    there, elsewhere = page.evaluate(CHANGED, [name, [inside, clear]])
    assert there > 0.05
    assert elsewhere == 0.0
    page.evaluate("t => window.__studio.clock.seek(t)", inside)
    page.get_by_test_id("plot-path" if name == "path" else f"plot-{name}").focus()
    tip = page.locator("#path .tip" if name == "path" else "#tip")
    expect(tip).to_contain_text(str(timeline.state("s.run.outside[0].what")))


def test_every_axis_says_its_unit(program, page, cleaner):
    free = {"left": None, "right": None}
    chosen = {
        "spatial": [{"outputs": ["theta", "phi", "heading"], "ranges": free}, {"outputs": ["z", "u"], "ranges": free}]
    }
    cleaner.evaluate("plots => localStorage.setItem('glider-studio.plots', JSON.stringify(plots))", chosen)
    Timeline.open_preset(page, program.url, "quad-bellows-spiral")
    expect(page.get_by_test_id("plot-row-0").locator("h3")).to_have_text("Angles (°), heading (°) at right")
    for row, symbols in ((0, ("°", "°")), (1, (" m", " m/s"))):
        for axis, symbol in enumerate(symbols):
            ticks = page.evaluate(
                """([row, axis]) => {
                  const found = window.__studio.timeline.plots.rows[row].plot.axes[axis];
                  return found.ticks.map(({ v }) => found.tell(v));
                }""",
                [row, axis],
            )
            assert [text.endswith(symbol) for text in ticks].count(True) == 1, ticks
            if symbol == "°":  # parts of a right angle
                assert all(float(text.rstrip("°").replace("\u2212", "-")) % 15.0 == 0.0 for text in ticks), ticks


def test_a_glider_at_rest_has_no_angles_of_the_flow(panel):
    page = panel.page
    assert panel.state("s.run.columns.speed[0]") == 0.0
    expect(page.get_by_test_id("legend-attack")).to_have_text("–")
    expect(page.get_by_test_id("legend-pitch")).to_have_text("0.0 °")
    page.evaluate("() => import('../../static/keptruns.js').then(kept => kept.keepRun('Before'))")
    page.wait_for_function("() => window.__studio.timeline.plots.rows[1].plot.series[2].kept.length === 1")
    first, second = page.evaluate(
        """() => {
          const { values, kept } = window.__studio.timeline.plots.rows[1].plot.series[2];
          return [0, 1].map((k) => [values[k], kept[0].values[k]]);
        }"""
    )
    assert first == [None, None] and all(abs(angle) > 1.0 for angle in second), "it begins by sinking"
    panel.seek(5.0)
    expect(page.get_by_test_id("legend-attack")).not_to_have_text("–")


READABLE = 70.0
"""Pixels: the least height of a plot, at which an axis, its unit and the legend are read."""


def test_plots_of_four_lanes_are_readable_on_a_laptop_and_names_are_whole(program, page):
    page.set_viewport_size({"width": 1280, "height": 720})
    Timeline.open_preset(page, program.url, "quad-bellows-spiral")
    plots = page.locator("[data-testid^=plot-row-]")
    for shown in (page.get_by_test_id("lane-Rear starboard cell"), *plots.all()):
        expect(shown).to_be_in_viewport(ratio=1.0)
    assert plots.count() == 2
    for plot in plots.all():
        box = plot.bounding_box()
        assert box is not None and box["height"] >= READABLE
    legend = plots.last.locator(".legend-rows")
    assert legend.evaluate("rows => rows.scrollHeight - rows.clientHeight") == 0
    cut = "names => names.filter(name => name.scrollWidth > name.clientWidth).length"
    assert page.locator(".lane-name span").evaluate_all(cut) == 0


def test_many_lanes_scroll_and_leave_the_plots_their_height(program, page):
    document = load_preset("quad-bellows-spiral").model_dump(mode="json")
    components, schedules = document["vehicle"]["components"], document["mission"]["control"]["schedules"]
    for schedule in list(schedules):
        twin = next(part for part in components if part["name"] == schedule["cell"])
        name = f"{twin['name']} of the second row behind"
        components.append(twin | {"name": name})
        schedules.append(schedule | {"cell": name})
    page.set_viewport_size({"width": 1280, "height": 720})
    Timeline.open_document(page, program.url, document)
    lanes = page.locator("#lanes")
    assert lanes.evaluate("node => node.scrollHeight > node.clientHeight")
    box = page.get_by_test_id("plot-row-0").bounding_box()
    assert box is not None and box["height"] >= READABLE
    expect(page.get_by_test_id("plot-row-0")).to_be_in_viewport(ratio=1.0)
    expect(page.locator("#time-axis")).to_be_in_viewport(ratio=1.0)
    labels = page.locator(".lane-row .label")
    assert max(box["width"] for node in labels.all() if (box := node.bounding_box())) <= 290.0
    # the split between scene and timeline is moved, and stays where it was put
    split, timeline = page.get_by_test_id("split-bottom"), page.locator("#timeline")
    before = timeline.evaluate("node => node.clientHeight")
    for _ in range(3):
        split.press("ArrowUp")
    page.reload()
    page.wait_for_function("() => window.__studio?.state?.run")
    assert timeline.evaluate("node => node.clientHeight") == pytest.approx(before + 48, abs=2)
    page.set_viewport_size({"width": 1024, "height": 720})  # names take no room that the plots need
    assert page.locator("#ruler-label").evaluate("node => node.offsetWidth") == 206


KEPT_LOOKS = """() => window.__studio.timeline.plots.rows[0].plot.series.map(
  ({ dash, color, kept }) => [String(dash), color, ...kept.map((run) => run.color)])"""


def test_a_kept_run_is_told_by_its_colour_and_an_output_by_its_dash(program, page):
    timeline = Timeline.open_document(page, program.url, load_preset("canete-dual-bellows").model_dump(mode="json"))
    outputs = ["speed", "u", "w"]
    ranges = {"left": None, "right": None}
    page.evaluate("plots => window.__studio.timeline.plots.choose(plots)", [{"outputs": outputs, "ranges": ranges}])
    for name in ("One", "Two"):
        page.evaluate("name => import('../../static/keptruns.js').then(kept => kept.keepRun(name))", name)
    page.wait_for_function(f"() => ({KEPT_LOOKS})().every((look) => look.length === 4)")
    looks = page.evaluate(KEPT_LOOKS)
    assert len({dash for dash, *_ in looks}) == len(outputs), "each output has a dash of its own"
    (colors,) = {tuple(colors) for _, *colors in looks}
    assert len(set(colors)) == 3, "each run has a colour of its own, in all outputs"
    legend = page.get_by_test_id("plot-row-0")
    expect(legend.locator(".key line")).to_have_count(9)  # of each run, with each dash
    dashes = legend.locator(".key line").evaluate_all(
        "lines => lines.map(line => line.getAttribute('stroke-dasharray'))"
    )
    assert [dash.replace(" ", ",") for dash in dashes] == [dash for dash, *_ in looks for _ in range(3)]
    expect(legend.get_by_role("group", name="Kept runs laid under")).to_have_text("OneTwo")
    assert timeline.state("s.kept.length") == 2


def test_the_page_tells_moments_as_the_server_does(page, program):
    Timeline.open_preset(page, program.url, "quad-bellows-spiral")
    for t, end, told in MOMENTS:
        asked = "([t, end]) => import('../../static/format.js').then((format) => format.clockText(t, end))"
        shown = page.evaluate(asked, [t, end]).replace("\u2212", "-")
        value, unit = shown.split()
        assert (f"{float(value):.4g} {unit}" if unit == "s" else shown) == told
    expect(page.get_by_test_id("readout-end-time")).to_have_text("16:00")
    sentence = "at -6.4 % L, from -0.5 to (-2) of 0-90 deg in 2026-11-26, 1e-5"
    minus = "text => import('../../static/format.js').then((format) => format.trueMinus(text))"
    found = page.evaluate(minus, sentence)
    assert found == "at −6.4 % L, from −0.5 to (−2) of 0-90 deg in 2026-11-26, 1e-5".replace("−", "\u2212")
    expect(page.locator("#warnings summary", has_text="margin in pitch")).to_contain_text("0:16 to 0:32 min")
    ticks = "import('../../static/timescale.js').then((m) => m.timeTicks({ from: 60, to: 150, end: 960 }, 6))"
    assert page.evaluate(f"() => {ticks}.then((t) => t.values.map(t.tell))") == [
        "1:00", "1:15", "1:30", "1:45", "2:00", "2:15", "2:30",
    ]  # fmt: skip
