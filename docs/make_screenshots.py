"""Makes the pictures of the studio in docs/img: `python -m docs.make_screenshots`. People look at them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from benchmarks.program import running_program
from tests.browser.conftest import FLAGS

IMAGES = Path(__file__).with_name("img")
SETTLE = 2500  # ms; the view is drawn in software


def open_preset(page: Page, url: str, preset: str) -> None:
    """Open a preset and wait for its glide and the 3D view."""
    page.goto(url)
    page.get_by_test_id(f"open-{preset}").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    page.wait_for_function("() => window.__studio?.state?.run", timeout=60_000)
    page.frame_locator("iframe").get_by_role("button", name="+ Bellows").wait_for()
    page.wait_for_timeout(3 * SETTLE)
    close = page.frame_locator("iframe").locator(".mantine-Notification-closeButton")
    for k in range(close.count()):
        close.nth(k).click()


def show(page: Page, t: float, name: str, camera: str) -> None:
    """Look from a camera, move the clock and take the picture."""
    if camera != "side":
        page.get_by_test_id(f"camera-{camera}").click()
    page.evaluate(f"() => window.__studio.clock.seek({t})")
    page.wait_for_timeout(SETTLE)
    page.screenshot(path=IMAGES / f"{name}.png", timeout=60_000)


def main() -> None:
    """Take every picture."""
    with running_program() as program, sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), headless=True, args=FLAGS)
        for name, scheme, preset, t, camera, size in (
            ("studio", "dark", "canete-dual-bellows", 6.0, "side", (1400, 900)),
            ("studio-light", "light", "canete-dual-bellows", 12.0, "side", (1400, 900)),
            ("studio-three-cells", "dark", "three-cell-glider", 30.0, "side", (1400, 900)),
            ("studio-small", "dark", "canete-dual-bellows", 6.0, "side", (1280, 720)),
            ("studio-spiral", "dark", "quad-bellows-spiral", 576.0, "chase", (1400, 900)),
            ("studio-overview", "dark", "seawing-spiral", 1200.0, "overview", (1400, 900)),
        ):
            page = chromium.new_page(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
            open_preset(page, program.url, preset)
            show(page, t, name, camera)
            page.close()
        page = chromium.new_page(viewport={"width": 1400, "height": 900}, color_scheme="dark")
        page.goto(program.url)
        page.wait_for_timeout(SETTLE)
        page.screenshot(path=IMAGES / "studio-presets.png")
        chromium.close()


if __name__ == "__main__":
    main()
