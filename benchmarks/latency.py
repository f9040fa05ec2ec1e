"""From a slider's message to the new path, on the wire through the proxy; and playback: `python -m benchmarks.latency`.

Raw clients speak Viser's wire to a studio in a process of its own; one client, then eight at once, each in a session
of its own. Playback counts pose updates on the page's main thread in headless Chromium.
"""

from __future__ import annotations

import asyncio
import math
import re
import shutil
import time

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.program import Program, running_program
from tests.browser.conftest import FLAGS
from tests.studio.raw_client import RawClient
from tests.studio.test_wire import is_path

CHANGES = 100
PACE = 0.05  # s between changes: what viser's own client sends at most while a slider is dragged


async def drag(program: Program) -> list[float]:
    """Drag the front cell of a new session to and fro; return each latency, s."""
    page, cookie = await asyncio.to_thread(program.open_session)
    await asyncio.to_thread(program.wait_for_run, page, cookie)
    latencies = []
    async with RawClient(page.replace("http", "ws") + "view", cookie=cookie, origin=program.url) as client:
        await client.wait_for(is_path)
        slider = await client.widget("Position x")
        for k in range(CHANGES):
            heard, sent = len(client.messages), time.perf_counter()
            await client.set_widget(slider, 150.0 + 20.0 * math.sin(0.37 * (k + 1)))
            path = await client.wait_for(is_path, after=heard)
            latencies.append(path["at"] - sent)
            await asyncio.sleep(max(0.0, PACE - (time.perf_counter() - sent)))
    return latencies


async def drag_together(program: Program, designers: int) -> np.ndarray:
    """Let several designers drag at once; return all latencies, ms."""
    return 1e3 * np.concatenate(await asyncio.gather(*(drag(program) for _ in range(designers))))


def playback_rate(program: Program) -> float:
    """Return pose updates a second on the page's main thread while it plays."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), headless=True, args=FLAGS)
        page = chromium.new_page(viewport={"width": 1400, "height": 900})
        page.goto(program.url)
        page.get_by_test_id("open-canete-dual-bellows").click()
        page.wait_for_url(re.compile(r"/s/[^/]+/"))
        page.wait_for_function("() => window.__studio?.state?.run", timeout=60_000)
        page.wait_for_timeout(6000)
        page.get_by_test_id("play").click()
        page.wait_for_timeout(1000)
        before, began = page.evaluate("() => window.__studio.poseUpdates"), time.perf_counter()
        page.wait_for_timeout(8000)
        rate: float = (page.evaluate("() => window.__studio.poseUpdates") - before) / (time.perf_counter() - began)
        chromium.close()
        return rate


def main() -> None:
    """Measure and print."""
    with running_program() as program:
        page, cookie = program.open_session()
        program.wait_for_run(page, cookie)
        for designers, goal in ((1, 50), (8, 100)):
            latency = asyncio.run(drag_together(program, designers))
            p50, p95 = np.percentile(latency, [50, 95])
            measured = f"p50 {p50:6.1f} ms, p95 {p95:6.1f} ms"
            print(f"slider to path, {designers} at once: {measured}   to reach: p95 {goal} ms")
        print(f"playback: {playback_rate(program):.0f} pose updates a second in software GL   to reach: 30")


if __name__ == "__main__":
    main()
