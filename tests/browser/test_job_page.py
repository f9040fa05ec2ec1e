"""What a job's page says: figures that follow a brush, small values, failed cases and what can be done about them."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.browser.axe import assert_accessible_in_both
from tests.browser.conftest import EMPTY_VIEW
from tests.browser.jobs_support import SLIGHTLY, batch, opened, row

pytestmark = pytest.mark.browser

COLOR = "node => getComputedStyle(node).color"
VARIABLE = """name => {
  const probe = document.body.appendChild(document.createElement("i"));
  probe.style.color = `var(${name})`;
  const color = getComputedStyle(probe).color;
  probe.remove();
  return color;
}"""
SHOWN = "v => window.__job.get('table').scale('range').show(v)"
SPREAD = "async values => (await import('../static/jobspread.js')).spreadOf(values)"


def test_the_figures_of_the_spread_follow_a_brush(program, watched, api, swept):
    page = opened(watched, program, swept)
    spread, note = page.get_by_test_id("spread"), page.get_by_test_id("spread-note")
    expect(note).to_contain_text(f"Of all {SLIGHTLY} cases with a value")
    expect(note).to_contain_text("the cases are laid out, not drawn")
    expect(spread).not_to_contain_text("±")
    page.get_by_test_id("metric").select_option("range")
    handle = page.get_by_test_id("least-range")
    handle.focus()
    for _ in range(20):
        page.keyboard.press("ArrowUp")
    low = float(handle.get_attribute("aria-valuenow") or "nan")
    kept = [r for case in api.get(f"jobs/{swept}/cases")["items"] if (r := case["metrics"]["range"]) >= low]
    assert 0 < len(kept) < SLIGHTLY
    expect(note).to_have_text(f"Of {len(kept)} brushed {'case' if len(kept) == 1 else 'cases'}.")
    told = page.evaluate(SPREAD, kept)
    assert told["mean"] == pytest.approx(np.mean(kept), rel=1e-13)
    assert told["sd"] == pytest.approx(np.std(kept, ddof=1), rel=1e-12)
    percents = {str(p): np.percentile(kept, p) for p in (5, 25, 50, 75, 95)}
    assert told["percentiles"] == pytest.approx(percents, rel=1e-14)
    least = spread.locator("div", has_text="Least").locator("dd")
    assert least.inner_text().split()[0] == page.evaluate(
        "v => window.__job.get('table').scale('range').show(v)", min(kept)
    )
    page.keyboard.press("Escape")
    expect(note).to_contain_text(f"Of all {SLIGHTLY} cases with a value")


def test_a_mean_of_draws_has_an_interval(program, watched, partial):
    page = opened(watched, program, partial["id"])
    page.get_by_test_id("metric").select_option("range")
    expect(page.get_by_test_id("spread")).to_contain_text("±")
    page.get_by_test_id("filter-status").select_option("failed")
    expect(page.get_by_test_id("spread")).to_have_text("None of these cases has a value.")
    expect(page.get_by_test_id("spread-note")).to_contain_text(f"Of {partial['progress']['failed']} filtered cases")


def test_values_far_smaller_than_their_column_stay_readable(program, watched, api):
    tolerances = [1e-12, 2.5e-9, 1e-4, 0.01]
    axis = {"name": "tolerance", "pointer": "/mission/solver/tolerance"}
    method = {"kind": "cases", "parameters": [axis], "rows": [[value] for value in tolerances]}
    job_id = api.post(batch("sweep", "Tolerances", method=method))
    api.wait(job_id)
    page = opened(watched, program, job_id)
    shown = ["1.0×10⁻¹²", "2.5×10⁻⁹", "0.00010", "0.01000"]
    cells = page.get_by_test_id("cases").locator("tbody td:nth-child(3)")
    expect(cells).to_have_text(shown)
    expect(page.locator(".axis", has_text="Tolerance").locator(".axis-end").last).to_have_text("1.0×10⁻¹²")
    page.get_by_test_id("case-1").click()
    expect(page.get_by_test_id("selected").get_by_role("row", name="Tolerance")).to_contain_text("2.5×10⁻⁹")
    assert "2.5×10⁻⁹" in page.evaluate("() => document.querySelector('#scatter').data[1].text[1]")
    places = [page.evaluate("n => window.__job.pointAt(n).x", n) for n in range(len(tolerances))]
    assert (
        min(b - a for a, b in itertools.pairwise(places)) > 20.0
    )  # pixels: a linear axis has three of them in one place


def test_a_failed_case_tells_why_and_offers_what_can_work(program, watched, api, partial):
    page = opened(watched, program, partial["id"])
    [failed, *_] = [case for case in api.get(f"jobs/{partial['id']}/cases")["items"] if case["status"] == "refused"]
    n = failed["case"]
    page.get_by_test_id("filter-status").select_option("failed")
    page.get_by_test_id(f"case-{n}").click()
    note = page.get_by_test_id(f"note-{n}")
    expect(note).to_contain_text(f"Case {n} was refused")
    pointer, _, why = failed["reason"].partition(": ")
    expect(note).to_contain_text(pointer)
    expect(note).to_contain_text(why[0].upper() + why[1:])
    expect(note).to_contain_text("Time −")
    expect(page.get_by_test_id("paths")).to_be_hidden()
    expect(page.get_by_test_id("paths-hint")).to_contain_text(f"Case {n} has no path")
    expect(page.get_by_test_id(f"open-case-{n}")).to_have_count(0)
    other = page.context.new_page()
    other.add_init_script(EMPTY_VIEW)
    other.goto(note.get_by_role("link", name="in the studio").get_attribute("href") or "")
    other.wait_for_url("**/s/**")
    other.close()


def test_the_link_of_a_refused_case_leads_back(program, page, api, partial):
    n = next(case["case"] for case in api.get(f"jobs/{partial['id']}/cases")["items"] if case["status"] == "refused")
    page.goto(f"{program.url}/d?run={partial['id']}.{n}")
    expect(page.get_by_test_id("problem")).to_contain_text(f"Case {n} cannot be opened")
    page.get_by_role("link", name="Back to the job").click()
    page.wait_for_url(f"**/jobs/{partial['id']}")


def test_a_retry_is_offered_only_where_it_may_mend(program, watched, partial):
    page = opened(watched, program, partial["id"])
    expect(page.get_by_test_id("delete")).to_be_visible()
    expect(page.get_by_test_id("retry")).to_have_count(0)
    expect(page.get_by_test_id("retry-why")).to_contain_text("would fail again")
    failures = [{"reason": "crashed: its workers died with it", "count": 2, "case": 0}]
    told = partial | {"failures": failures + partial["failures"]}
    told["progress"] = partial["progress"] | {"failed": partial["progress"]["failed"] + 2}
    page.route(f"**/api/v1/jobs/{partial['id']}", lambda route: route.fulfill(json=told))
    page.reload()
    expect(page.get_by_test_id("retry")).to_have_text("Retry failed")
    expect(page.get_by_test_id("retry-why")).to_contain_text(
        "may mend the 2 cases whose computation broke off; the others"
    )


def test_a_job_that_knows_enough_is_a_success(program, watched, api):
    mass = {
        "name": "mass", "pointer": "/vehicle/components/1/mass",
        "distribution": {"kind": "uniform", "low": 0.029, "high": 0.031},
    }  # fmt: skip
    stop = {"metric": "range", "width": 10.0, "least": 10, "every": 10}
    job_id = api.post(batch("monte_carlo", "Draws until enough is known", parameters=[mass], count=500, stop=stop))
    job = api.wait(job_id)
    assert (job["state"], job["stopped_early"]) == ("succeeded", True)
    page = watched
    page.goto(f"{program.url}/jobs")
    told = row(page, job_id).get_by_test_id("reason")
    expect(told).to_have_text(f"{job['reason'][0].upper()}{job['reason'][1:]}")
    assert told.evaluate(COLOR) == page.evaluate(VARIABLE, "--good")
    opened(page, program, job_id)
    expect(page.get_by_test_id("reason")).to_have_class("box good")
    assert page.get_by_test_id("reason").evaluate("n => getComputedStyle(n).borderLeftColor") == page.evaluate(
        VARIABLE, "--good"
    )


def test_a_page_of_the_first_cases_says_so(program, page, api, swept):
    """As of a job of more cases than a page holds: the figures beside bars are of those bars."""
    kind = "text/javascript"
    page.route("**/jobdata.js", lambda route: route.fulfill(body=few(route.fetch().text()), content_type=kind))
    opened(page, program, swept)
    expect(page.get_by_test_id("part-of-all")).to_contain_text(f"the first 7 of {SLIGHTLY} cases")
    expect(page.get_by_test_id("spread-note")).to_have_text(f"Of the first 7 of {SLIGHTLY} cases.")
    page.get_by_test_id("metric").select_option("range")
    ranges = [case["metrics"]["range"] for case in api.get(f"jobs/{swept}/cases?limit=7")["items"]]
    expect(page.get_by_test_id("spread")).to_contain_text(f"Mean{page.evaluate(SHOWN, float(np.mean(ranges)))}")


def few(module: str) -> str:
    assert "MOST_CASES = 20_000" in module
    return module.replace("MOST_CASES = 20_000", "MOST_CASES = 7")


def test_a_lost_connection_is_forgotten_once_it_is_back(program, page, swept):
    page.route(re.compile(r"/results(\?|$)"), lambda route: route.abort(), times=1)
    page.goto(f"{program.url}/jobs/{swept}")
    expect(page.get_by_test_id("problem")).to_contain_text("cannot be reached")
    expect(page.get_by_test_id("problem")).to_be_hidden(timeout=20_000)  # it tries again by itself
    expect(page.get_by_test_id("spread")).to_contain_text("Mean")


def test_the_page_of_a_job_is_accessible(program, page, swept, partial):
    for job_id in (swept, partial["id"]):
        opened(page, program, job_id)
        assert_accessible_in_both(page)
