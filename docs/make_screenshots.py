"""Makes the pictures of the studio in docs/img: `python -m docs.make_screenshots`. People look at them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

from benchmarks.program import running_program
from tests.browser.conftest import FLAGS

IMAGES = Path(__file__).with_name("img")
SETTLE = 2500  # ms; the view is drawn in software
DESK, LAPTOP, PHONE = (1400, 900), (1280, 720), (390, 844)
STUDIOS = (
    ("studio", "dark", "canete-dual-bellows", 6.0, "side", DESK),
    ("studio-light", "light", "canete-dual-bellows", 12.0, "side", DESK),
    ("studio-three-cells", "dark", "three-cell-glider", 30.0, "side", DESK),
    ("studio-small", "dark", "canete-dual-bellows", 6.0, "side", LAPTOP),
    ("studio-spiral", "dark", "quad-bellows-spiral", 576.0, "chase", DESK),
    ("studio-overview", "dark", "seawing-spiral", 1200.0, "overview", DESK),
)
"""Name, colours, preset, moment in seconds, camera and size."""


@contextmanager
def a_page(browser: Browser, size: tuple[int, int], scheme: str = "dark") -> Iterator[Page]:
    """Give a browser's page of a size and close it in the end."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]},
        color_scheme=scheme,
        bypass_csp=True,  # conditions are scripts
    )
    yield context.new_page()
    context.close()


def open_preset(page: Page, url: str, preset: str) -> None:
    """Open a preset and wait for its glide and the 3D view."""
    page.goto(url)
    page.get_by_test_id(f"open-{preset}").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    page.wait_for_function("() => window.__studio?.state?.run", timeout=60_000)
    view = next(frame for frame in page.frames if "/view/" in frame.url)
    view.wait_for_function("() => '/glider' in (window.__viserSceneTree?.getState() ?? {})", timeout=60_000)
    page.wait_for_timeout(2 * SETTLE)


def show(page: Page, t: float, name: str, camera: str = "side") -> None:
    """Look from a camera, move the clock and take the picture."""
    if camera != "side":
        page.get_by_test_id(f"camera-{camera}").click()
    page.evaluate(f"() => window.__studio.clock.seek({t})")
    page.wait_for_timeout(2 * SETTLE)
    page.screenshot(path=IMAGES / f"{name}.png", timeout=60_000)


def show_modes(page: Page, url: str) -> None:
    """Take the picture of a glide's modes."""
    open_preset(page, url, "quad-bellows-spiral")
    page.get_by_test_id("tab-modes").click()
    show(page, 576.0, "studio-modes")


def main() -> None:
    """Take every picture."""
    with running_program() as program, sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), headless=True, args=FLAGS)
        for name, scheme, preset, t, camera, size in STUDIOS:
            with a_page(chromium, size, scheme) as page:
                open_preset(page, program.url, preset)
                show(page, t, name, camera)
        with a_page(chromium, DESK) as page:
            show_modes(page, program.url)
        with a_page(chromium, PHONE) as page:
            open_preset(page, program.url, "canete-dual-bellows")
            show(page, 6.0, "studio-phone")
        for name, path in (("studio-presets", "/"), ("studio-jobs", "/jobs")):
            with a_page(chromium, DESK) as page:
                page.goto(program.url + path)
                page.wait_for_timeout(SETTLE)
                page.screenshot(path=IMAGES / f"{name}.png")
        chromium.close()


if __name__ == "__main__":
    main()
