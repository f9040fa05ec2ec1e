"""From a cell dragged in the scene to the new path and readouts, on the wire: `python -m benchmarks.latency`.

Raw clients speak Viser's wire through the proxy of a studio in a process of its own, and hear state and consequences
by the event stream, as the page does: the quad-bellows glider in eight components, 60 s in three dimensions; one
designer, then eight at once, each in a session of its own. A step of a drag is done when the new path, the state and
the consequences of that run (trim included) have come. The page itself is measured in headless Chromium that draws in
software.
"""

from __future__ import annotations

import asyncio
import re
import shutil
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import httpx
import numpy as np
from playwright.sync_api import Page, sync_playwright

from benchmarks.program import Program, running_program
from models.presets import load_preset
from tests.browser.conftest import FLAGS
from tests.studio.raw_client import RawClient
from tests.studio.test_wire import is_path

STEPS = 100
WARM = 5
"""Steps before those that count: the first ones find caches empty."""
PACE = 0.05  # s between steps: what viser's own client sends at most while something is dragged
CELL, NODE = 1, "/glider/cell1/stack"
DURATION = 60.0
FOLDED = ("Core sampler", "Lower ballast", "Trim ballast")
"""Parts of the preset that become part of its hull, so that eight components are left."""


def eight_components() -> dict[str, Any]:
    """Return the quad-bellows glider with the mass and volume of three parts in its hull, its first cell second."""
    document: dict[str, Any] = load_preset("quad-bellows-glide").model_dump(mode="json")
    parts = document["vehicle"]["components"]
    hull, cells = parts[0], [part for part in parts if part["kind"] == "bellows"]
    folded = [hull, *(part for part in parts if part["name"] in FOLDED)]
    centers = [np.add(part["position"], part.get("center_of_mass") or (0.0, 0.0, 0.0)) for part in folded]
    masses = [part["mass"] for part in folded]
    hull["center_of_mass"] = (np.average(centers, axis=0, weights=masses) - hull["position"]).tolist()
    hull["mass"], hull["volume"] = sum(masses), sum(part["volume"] for part in folded)
    rest = [part for part in parts[1:] if part["name"] not in FOLDED and part["kind"] != "bellows"]
    document["vehicle"]["components"] = [hull, *cells, *rest]
    document["mission"]["duration"] = DURATION
    return document


@dataclass
class Designer:
    """One page: what it heard, each with its time."""

    page: str
    cookie: str
    http: httpx.AsyncClient
    states: list[tuple[float, int]] = field(default_factory=list)
    consequences: list[tuple[float, int]] = field(default_factory=list)
    state_bytes: int = 0
    news: asyncio.Event = field(default_factory=asyncio.Event)

    async def hear(self) -> None:
        """Follow the event stream: the state at each change, and the consequences as they come."""
        async with self.http.stream("GET", f"{self.page}events", headers={"Cookie": self.cookie}) as answer:
            kind = ""
            async for line in answer.aiter_lines():
                if line.startswith("event: "):
                    kind = line[7:]
                elif line.startswith("data: "):
                    self.take(kind, line[6:])

    def take(self, kind: str, data: str) -> None:
        """Remember when what came."""
        at, run = time.perf_counter(), r'"run":(\d+)' if kind == "consequences" else r'"run":\{"number":(\d+)'
        found = re.search(run, data)
        heard = self.consequences if kind == "consequences" else self.states
        heard.append((at, int(found[1]) if found else 0))
        self.state_bytes = len(data) if kind == "state" else self.state_bytes
        self.news.set()

    async def first_after(self, heard: list[tuple[float, int]], number: int) -> float:
        """Return when the first of what was heard of a run after `number` came."""
        async with asyncio.timeout(30.0):
            while not (found := [at for at, run in heard if run > number]):
                self.news.clear()
                await self.news.wait()
        return found[0]


@asynccontextmanager
async def designer(program: Program, document: dict[str, Any]) -> AsyncIterator[tuple[Designer, RawClient]]:
    """Open a session on a document, with a page that hears of it."""
    async with httpx.AsyncClient(trust_env=False, timeout=60.0) as http:
        answer = await http.post(f"{program.url}/sessions", json=document, headers={"Origin": program.url})
        assert answer.status_code == 201, answer.text
        page = program.url + answer.json()["url"]
        name = f"gs_{page.rstrip('/').split('/')[-1]}"
        made = Designer(page, f"{name}={http.cookies[name]}", http)
        await asyncio.to_thread(program.wait_for_run, page, made.cookie)
        listening = asyncio.create_task(made.hear())
        address = page.replace("http", "ws") + "view"
        async with RawClient(address, cookie=made.cookie, origin=program.url) as client:
            await client.wait_for(is_path)
            await made.first_after(made.states, 0)
            yield made, client
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)


def pointer(phase: str, x: float) -> dict[str, Any]:
    """Return what Viser's client sends while a cell is dragged to and fro along the hull."""
    return {
        "type": "SceneNodeDragMessage", "name": NODE, "instance_index": None, "phase": phase, "button": "left",
        "start_screen_pos": (0.5, 0.5), "end_screen_pos": (0.5, 0.5), "modifier": None, "owner": "",
        "start_position": (0.0, 0.0, 0.0), "end_position": (x, 0.0, 0.0),
    }  # fmt: skip


async def drag(program: Program, document: dict[str, Any]) -> tuple[np.ndarray, int]:
    """Drag the first cell of a new session; return when path, state and consequences came (steps, 3) s, and bytes."""
    steps = []
    async with designer(program, document) as (page, client):
        await client.send(**pointer("start", 0.0))
        number = page.states[-1][1]
        for k in range(WARM + STEPS):
            heard, sent = len(client.messages), time.perf_counter()
            # to and fro in steps of 7 mm, so that each is another design
            await client.send(**pointer("update", 1e-3 * (7 * (k + 1) % 23 - 11.0)))
            path = await client.wait_for(is_path, after=heard, timeout=30.0)
            state = await page.first_after(page.states, number)
            told = await page.first_after(page.consequences, number)
            number = max(page.states[-1][1], page.consequences[-1][1])
            steps.append([path["at"] - sent, state - sent, told - sent])
            await asyncio.sleep(max(0.0, PACE - (time.perf_counter() - sent)))
        await client.send(**pointer("end", 0.0))
        size = page.state_bytes
    return np.array(steps[WARM:]), size


async def drag_together(program: Program, designers: int) -> tuple[np.ndarray, int]:
    """Let several designers drag at once; return all their steps, ms."""
    document = eight_components()
    found = await asyncio.gather(*(drag(program, document) for _ in range(designers)))
    return 1e3 * np.concatenate([steps for steps, _ in found]), found[0][1]


def print_drags(program: Program) -> None:
    """Measure and print the drags of one designer and of eight."""
    for designers, goal in ((1, 60), (8, 150)):
        steps, size = asyncio.run(drag_together(program, designers))
        for name, column in (("path", steps[:, 0]), ("state", steps[:, 1]), ("trim", steps[:, 2])):
            p50, p95 = np.percentile(column, [50, 95])
            print(f"drag to {name:<6} {designers} at once: p50 {p50:6.1f} ms, p95 {p95:6.1f} ms")
        whole = np.percentile(steps.max(axis=1), 95)
        print(f"drag to all    {designers} at once: p95 {whole:6.1f} ms   to reach: {goal} ms   (state {size} bytes)")


def _open_page(page: Page, program: Program) -> tuple[float, int]:
    """Open a preset's page; return when the glider is drawn, s, and the bytes that came until then."""
    received = 0

    def count(event: dict[str, Any]) -> None:
        nonlocal received
        received += int(event.get("encodedDataLength", 0))

    def count_frame(event: dict[str, Any]) -> None:
        nonlocal received
        received += len(event["response"]["payloadData"])

    page.goto(program.url)
    network = page.context.new_cdp_session(page)
    network.send("Network.enable")
    network.on("Network.loadingFinished", count)
    network.on("Network.webSocketFrameReceived", count_frame)
    began = time.perf_counter()
    page.get_by_test_id("open-canete-dual-bellows").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"), wait_until="commit")  # what loads after the glider is seen counts not
    view = "document.querySelector('iframe')?.contentWindow?.__viserMutable"
    page.wait_for_function(f"() => Boolean({view}?.nodeRefFromName?.['{NODE}'])", timeout=60_000)
    return time.perf_counter() - began, received


def print_page(program: Program) -> None:
    """Measure and print what a browser sees: how soon, how many bytes, and how often the glider moves."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), headless=True, args=FLAGS)
        page = chromium.new_page(viewport={"width": 1400, "height": 900})
        visible, received = _open_page(page, program)
        print(f"glider in the scene after {visible:.1f} s in software GL   to reach: 5 s")
        print(f"bytes until then: {received / 1e6:.2f} MB   to reach: 2 MB")
        page.wait_for_function("() => window.__studio?.state?.run", timeout=60_000)
        page.wait_for_timeout(6000)
        page.get_by_test_id("play").click()
        page.wait_for_timeout(1000)
        before, began = page.evaluate("() => window.__studio.poseUpdates"), time.perf_counter()
        page.wait_for_timeout(8000)
        rate = (page.evaluate("() => window.__studio.poseUpdates") - before) / (time.perf_counter() - began)
        print(f"playback: {rate:.0f} pose updates a second on the page's main thread   to reach: 60")
        chromium.close()


def main() -> None:
    """Measure and print."""
    with running_program() as program:
        page, cookie = program.open_session()
        program.wait_for_run(page, cookie)
        print_drags(program)
        print_page(program)


if __name__ == "__main__":
    main()
