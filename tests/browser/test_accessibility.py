"""Every page and dialog against the rules of WCAG 2 A and AA that a program can check (axe-core), in light and dark."""

from __future__ import annotations

import re
from importlib.resources import files
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.browser.conftest import Program

pytestmark = pytest.mark.browser

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
SCHEMES = ("dark", "light")


def violations(page: Page) -> list[str]:
    """Return what axe finds on the page itself; the viewer's client in its frame is another program."""
    found: dict[str, Any] = page.evaluate(
        """async ([source, rules]) => {
            if (!window.axe) (0, eval)(source);
            const context = { include: [["html"]], exclude: [["iframe"]] };
            return window.axe.run(context, { runOnly: rules, resultTypes: ["violations"], iframes: false });
        }""",
        [AXE, RULES],
    )
    return [
        f"{rule['id']}: {node['target']} {node['failureSummary']}"
        for rule in found["violations"]
        for node in rule["nodes"]
    ]


def assert_accessible(page: Page) -> None:
    found = violations(page)
    assert found == [], "\n".join(found)


def choose_scheme(page: Page, scheme: str) -> None:
    page.evaluate("scheme => document.documentElement.setAttribute('data-theme', scheme)", scheme)
    page.evaluate("() => document.dispatchEvent(new CustomEvent('scheme'))")
    page.wait_for_timeout(250)  # colours fade


@pytest.fixture
def alone(program: Program, page: Page) -> Page:
    """The studio's page without the 3D view in its frame: Viser's client is another program, and slow to draw."""
    empty = "<!doctype html><html lang='en'><title>Nothing</title></html>"
    page.route(re.compile(r"/view/(\?|$)"), lambda route: route.fulfill(body=empty, content_type="text/html"))
    page.goto(f"{program.url}/")
    page.get_by_test_id("open-canete-dual-bellows").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    page.wait_for_function("() => window.__studio?.state?.run")
    return page


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_studio_is_accessible(alone, scheme):
    choose_scheme(alone, scheme)
    assert_accessible(alone)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_menus_and_dialogs_of_the_studio_are_accessible(alone, scheme):
    choose_scheme(alone, scheme)
    for opener in ("show-keys", "hydrodynamics"):
        alone.get_by_test_id(opener).click()
        assert_accessible(alone)
        alone.keyboard.press("Escape")
    alone.get_by_test_id("compare").click()
    alone.get_by_test_id("keep").click()
    alone.wait_for_function("() => window.__studio.state.kept.length > 0")
    assert_accessible(alone)
    alone.keyboard.press("Escape")
    alone.get_by_test_id("bookmarks").click()
    alone.get_by_test_id("bookmark-add").click()
    assert_accessible(alone)
    alone.keyboard.press("Escape")
    for menu in ("export", "link"):
        alone.get_by_test_id(menu).click()
        assert_accessible(alone)
        alone.keyboard.press("Escape")


def test_a_refused_change_is_told_accessibly(alone):
    origin = "/".join(alone.url.split("/")[:3])
    patch = [{"op": "replace", "path": "/vehicle/components/0/mass", "value": -5}]
    refused = alone.request.post(f"{alone.url}edit", data={"patch": patch}, headers={"Origin": origin})
    assert refused.status == 422
    alone.get_by_test_id("problem").wait_for()
    assert_accessible(alone)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_list_of_presets_and_the_page_of_jobs_are_accessible(program, page, scheme):
    for path, there in (("/", "[data-testid^='open-canete']"), ("/jobs", "h1")):
        page.goto(program.url + path)
        page.locator(there).first.wait_for()
        choose_scheme(page, scheme)
        assert_accessible(page)


def test_the_studio_on_a_phone_is_accessible(alone):
    alone.set_viewport_size({"width": 390, "height": 844})
    for tab in ("parts", "results", "timeline"):
        alone.get_by_test_id(f"tab-{tab}").click()
        assert_accessible(alone)


def test_keys_of_all_parts_of_the_page_are_in_its_list(alone):
    alone.get_by_test_id("show-keys").click()
    groups = {title.lower() for title in alone.get_by_test_id("keys").locator("h3").all_inner_texts()}
    assert {"playback", "design", "parts", "page"} <= groups
