"""Looks at a page by the rules of WCAG 2 A and AA that a program can check (axe-core)."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from playwright.sync_api import Page

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
SCHEMES = ("dark", "light")


def violations(page: Page, part: str) -> list[str]:
    """Return what axe finds in a part of the page, which must be there, but not in a frame: that is another program."""
    found: dict[str, Any] = page.evaluate(
        """async ([source, rules, part]) => {
            if (!window.axe) (0, eval)(source);
            const context = { include: [[part]], exclude: [["iframe"]] };
            return window.axe.run(context, { runOnly: rules, resultTypes: ["violations"], iframes: false });
        }""",
        [AXE, RULES, part],
    )
    return [
        f"{rule['id']}: {node['target']} {node['failureSummary']}"
        for rule in found["violations"]
        for node in rule["nodes"]
    ]


def assert_accessible(page: Page, part: str = "html") -> None:
    found = violations(page, part)
    assert found == [], "\n".join(found)


def choose_scheme(page: Page, scheme: str) -> None:
    page.evaluate("scheme => document.documentElement.setAttribute('data-theme', scheme)", scheme)
    page.evaluate("() => document.dispatchEvent(new CustomEvent('scheme'))")
    page.wait_for_function("() => document.getAnimations().length === 0")  # colours fade


def assert_accessible_in_both(page: Page, part: str = "html") -> None:
    """Look at what is open in both schemes: to get there costs more than to look."""
    for scheme in SCHEMES:
        choose_scheme(page, scheme)
        assert_accessible(page, part)
