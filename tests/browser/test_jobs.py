"""The journeys of who runs batches: watch, cancel, filter, look at cases and their paths, by pointer or keyboard."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.jobs_support import FRONT, SLIGHTLY, opened, row, sweep, wait_until

pytestmark = pytest.mark.browser

MANY = 20_000
CHARTS_FIT = """() => [...document.querySelectorAll(".plot .main-svg")].every((svg) => {
  const [chart, box] = [svg.getBoundingClientRect(), svg.closest(".plot").getBoundingClientRect()];
  return Math.abs(chart.height - box.height) <= 1 && Math.abs(chart.width - box.width) <= 1;
})"""


def test_list_and_page_follow_a_job_live_until_it_is_cancelled(program, watched, api, swept):
    document = sweep("A long sweep", MANY)
    document["design"]["mission"]["solver"] |= {"method": "rk4", "step": 5e-5}  # slow, so that there is time to watch
    long = api.post(document)
    page = watched
    page.goto(f"{program.url}/jobs")
    expect(row(page, swept)).to_have_attribute("data-state", "succeeded")
    expect(row(page, swept)).to_contain_text(f"{SLIGHTLY} of {SLIGHTLY}")
    expect(row(page, long)).to_have_attribute("data-state", "running", timeout=60_000)
    done = lambda: int(row(page, long).get_attribute("data-done") or 0)  # noqa: E731
    wait_until(page, lambda: done() > 0)
    before = done()
    wait_until(page, lambda: done() > before)
    row(page, long).get_by_test_id("open-job").click()
    page.wait_for_url(f"**/jobs/{long}")
    shown = lambda: int(page.evaluate("() => window.__job?.get('table')?.size ?? 0"))  # noqa: E731
    wait_until(page, lambda: shown() > 0)
    before = shown()
    wait_until(page, lambda: shown() > before)
    page.get_by_test_id("jobs-link").click()
    row(page, long).get_by_test_id("cancel").click()
    expect(row(page, long)).to_have_attribute("data-state", "cancelled", timeout=60_000)
    kept = api.get(f"jobs/{long}")["progress"]["done"]
    assert 0 < kept < MANY
    expect(row(page, long).get_by_test_id("retry")).to_have_text("Continue")
    row(page, long).get_by_test_id("delete").click()
    page.get_by_test_id("confirm-delete").click()
    expect(row(page, long)).to_have_count(0)
    assert api.client.get(f"jobs/{long}").status_code == 404


def test_the_list_is_filtered_by_state_and_name(program, watched, swept, partial):
    page = watched
    page.goto(f"{program.url}/jobs")
    page.get_by_test_id("filter-state").select_option("partial")
    expect(row(page, swept)).to_have_count(0)
    expect(row(page, partial["id"])).to_be_visible()
    page.get_by_test_id("filter-state").select_option("")
    page.get_by_test_id("search").fill("SUCCEEDS")
    expect(row(page, partial["id"])).to_have_count(0)
    expect(row(page, swept)).to_be_visible()
    assert page.url.endswith("/jobs?search=SUCCEEDS")
    page.get_by_test_id("search").fill("there is no such name")
    expect(page.get_by_test_id("note")).to_contain_text("No job is like that")
    page.get_by_test_id("clear-filter").click()
    expect(row(page, swept)).to_be_visible()
    expect(row(page, partial["id"])).to_be_visible()


def point_at(page: Page, n: int) -> None:
    """Move the pointer to a case's point until the chart says that it is the one."""

    def found() -> bool:
        at = page.evaluate("n => window.__job.pointAt(n)", n)
        page.mouse.move(at["x"] - 2, at["y"])
        page.mouse.move(at["x"], at["y"])
        page.wait_for_timeout(100)
        return page.locator("#scatter .hoverlayer", has_text=f"Case {n}").count() == 1

    wait_until(page, found)


def test_a_click_on_a_point_overlays_the_path_of_its_case(program, watched, api, swept):
    page = opened(watched, program, swept)
    scatter, paths = page.get_by_test_id("scatter"), page.get_by_test_id("paths")
    expect(scatter).to_have_attribute("data-points", str(SLIGHTLY))
    page.wait_for_function(CHARTS_FIT)
    for n in (3, 11):
        point_at(page, n)
        page.mouse.down()
        page.mouse.up()
        wait_until(page, lambda n=n: str(n) in (paths.get_attribute("data-cases") or "").split())
    page.get_by_test_id("case-5").click()
    expect(paths).to_have_attribute("data-cases", "3 11 5")
    expect(page.get_by_test_id("selected")).to_have_attribute("data-cases", "3 11 5")
    expect(scatter).to_have_attribute("data-selected", "3")
    ends = "p => ({ x: p.data.map(({ x }) => x.at(-1) - x[0]), title: p.layout.xaxis.title.text })"
    drawn = paths.evaluate(ends)
    per = 1e3 if drawn["title"].endswith("mm") else 1.0
    ranges = [api.get(f"jobs/{swept}/cases/{n}")["metrics"]["range"] for n in (3, 11, 5)]
    assert [abs(x) / per for x in drawn["x"]] == pytest.approx(ranges, rel=1e-5, abs=1e-6)
    assert page.get_by_test_id("open-case-11").get_attribute("href") == f"{program.url}/d?run={swept}.11"
    page.get_by_test_id("drop-3").click()
    expect(paths).to_have_attribute("data-cases", "11 5")
    page.get_by_test_id("clear-selected").click()
    expect(page.get_by_test_id("selected")).to_be_hidden()


def test_failures_are_grouped_and_filter_the_cases(program, watched, partial):
    page = opened(watched, program, partial["id"])
    failed = partial["progress"]["failed"]
    expect(page.get_by_test_id("failed")).to_have_text(f"{failed} failed")
    expect(page.get_by_test_id("failure")).to_have_count(len(partial["failures"]))
    page.get_by_test_id("failure").first.click()
    count = partial["failures"][0]["count"]
    expect(page.get_by_test_id("cases")).to_have_attribute("data-rows", str(count))
    expect(page.get_by_test_id("shown")).to_have_text(f"{count} of 60 cases")
    expect(page.get_by_test_id("scatter")).to_have_attribute("data-points", "0")
    page.get_by_test_id("unfilter").click()
    expect(page.get_by_test_id("cases")).to_have_attribute("data-rows", "60")
    page.get_by_test_id("filter-status").select_option("fine")
    expect(page.get_by_test_id("cases")).to_have_attribute("data-rows", str(60 - failed))
    page.get_by_test_id("metric").select_option("energy_residual")  # so small that its axis has exponents
    expect(page.get_by_test_id("histogram")).to_have_attribute("data-cases", str(60 - failed))


def test_a_journey_by_keyboard_alone(program, watched, swept):
    page = watched
    page.goto(f"{program.url}/jobs")
    expect(row(page, swept)).to_be_visible()
    page.keyboard.press("?")
    expect(page.get_by_test_id("keys")).to_be_visible()
    page.keyboard.press("Escape")
    page.keyboard.press("/")
    page.keyboard.type("sweep that succeeds")
    expect(page.get_by_test_id("rows").locator("tr")).to_have_count(1)
    page.keyboard.press("Enter")
    expect(row(page, swept).get_by_test_id("open-job")).to_be_focused()
    page.keyboard.press("Enter")
    page.wait_for_url(f"**/jobs/{swept}")
    page.wait_for_function("() => window.__job?.get('plots') && window.__job.get('table')")
    press_until(page, "Tab", "least-range")
    for _ in range(10):
        page.keyboard.press("ArrowUp")
    expect(page.get_by_test_id("parallel")).to_have_attribute("data-brushes", "1")
    wait_until(page, lambda: int(page.get_by_test_id("cases").get_attribute("data-rows") or 0) < SLIGHTLY)
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("cases")).to_have_attribute("data-rows", str(SLIGHTLY))
    press_until(page, "Tab", "case-0")
    page.keyboard.press("j")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("case-1")).to_be_focused()
    expect(page.get_by_test_id("case-1")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("paths")).to_have_attribute("data-cases", "1")


def press_until(page: Page, key: str, test_id: str) -> None:
    for _ in range(120):
        page.keyboard.press(key)
        if page.evaluate("() => document.activeElement?.dataset?.testid") == test_id:
            return
    raise AssertionError(f"{key} does not lead to {test_id}")


def test_a_document_is_checked_and_its_faults_are_shown_in_place(program, page, api):
    page.goto(f"{program.url}/jobs")
    page.get_by_test_id("new-job").click()
    page.get_by_test_id("example").click()
    area = page.get_by_test_id("document")
    wait_until(page, lambda: "glider-batch" in area.input_value())
    document = json.loads(area.input_value())
    document["method"]["parameters"][0]["pointer"] = "/vehicle/components/1/positoin/0"
    area.fill(json.dumps(document, indent=1))
    page.get_by_test_id("submit").click()
    problem = page.get_by_test_id("new-problem")
    expect(problem).to_contain_text("positoin")
    problem.get_by_role("button", name="/method/parameters/0").first.click()
    marked = area.evaluate("a => a.value.slice(a.selectionStart, a.selectionEnd)")
    assert "positoin" in marked
    area.fill('{"format": ')
    page.get_by_test_id("submit").click()
    expect(problem).to_contain_text("This is not JSON")
    document["method"]["parameters"][0] = {"pointer": FRONT, "values": [0.17, 0.18]}
    area.fill(json.dumps(document))
    page.get_by_test_id("submit").click()
    page.wait_for_url("**/jobs/*")
    assert api.wait(page.url.rsplit("/", 1)[1])["progress"]["cases"] == 2


def test_files_are_fetched_from_the_page(program, watched, swept):
    page = opened(watched, program, swept)
    page.get_by_test_id("downloads").click()
    with page.expect_download() as started:
        page.get_by_test_id("download-csv").click()
    assert started.value.suggested_filename.endswith(".csv")
    with open(started.value.path()) as file:
        assert len(file.read().splitlines()) == SLIGHTLY + 1


def test_a_job_that_does_not_exist_says_so(program, page):
    page.goto(f"{program.url}/jobs/01hzzzzzzzzzzzzzzzzzzzzzzz")
    expect(page.get_by_role("heading", name="This job does not exist")).to_be_visible()
    for part in ("state", "status", "downloads"):
        expect(page.get_by_test_id(part)).to_be_hidden()
    page.get_by_role("link", name="All jobs").click()
    page.wait_for_url("**/jobs")


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_nothing_is_wider_than_a_phone(program, browser: Browser, swept, scheme):
    context = browser.new_context(viewport={"width": 390, "height": 844}, color_scheme=scheme, has_touch=True)
    page = context.new_page()
    page.goto(f"{program.url}/jobs")
    expect(row(page, swept)).to_be_visible()
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    opened(page, program, swept)
    page.get_by_test_id("show-telling").click()
    wait_until(page, lambda: int(page.get_by_test_id("paths").get_attribute("data-paths") or 0) == 3)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    context.close()
