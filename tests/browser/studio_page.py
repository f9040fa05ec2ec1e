"""Drives the studio's page as a person would: finds things by what is written on them."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import APIResponse, Locator, Page, ViewportSize

from models.presets import load_preset

SIZE: ViewportSize = {"width": 1400, "height": 900}
BEGIN_AGAIN = """() => {
  const { clock } = window.__studio;
  clock.pause();
  clock.setSpeed(1);
  clock.setLoop(false);
  clock.setRange(null);
}"""


def document_of(preset: str) -> dict[str, Any]:
    """Return a preset's document."""
    return load_preset(preset).model_dump(mode="json")


class StudioPage:
    """One open session in a browser tab."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.wait_for_glide()

    @classmethod
    def open_preset(cls, page: Page, url: str, preset: str) -> StudioPage:
        return cls.open_document(page, url, document_of(preset))

    @classmethod
    def open_document(cls, page: Page, url: str, document: dict[str, Any]) -> StudioPage:
        """Open a design document as the page of presets does with a file."""
        answer = page.request.post(f"{url}/sessions", data=document)
        assert answer.status == 201, answer.text()
        # a quarter of the pixels: the test machine draws in software
        page.goto(f"{url}{answer.json()['url']}?fixedDpr=0.25")
        return cls(page)

    def begin_again(self, document: dict[str, Any]) -> None:
        """Show a document as if this tab had just been opened with it."""
        page = self.page
        page.set_viewport_size(SIZE)
        page.keyboard.press("Escape")
        page.evaluate(BEGIN_AGAIN)
        for kept in self.state("s.kept.map(k => k.id)"):
            self.ask("delete", f"runs/{kept}")
        self.ask("post", "display", {"color_by": "speed", "ghost": None})
        revision = self.ask("put", "design", document).json()["revision"]
        self.ask("post", "select", {"component": 0})
        ready = "(s => s.revision === revision && s.run && !s.simulating && !s.kept.length && s.selected === 0)"
        page.wait_for_function(f"revision => {ready}(window.__studio.state)", arg=revision)
        for name, pressed in (("moments", "false"), ("forces", "true")):
            button = page.get_by_test_id(f"toggle-{name}")
            if button.get_attribute("aria-pressed") != pressed:
                button.click()
        page.get_by_test_id("camera-side").click()
        page.evaluate("() => window.__studio.clock.seek(0)")

    def ask(self, method: str, path: str, document: Any = None) -> APIResponse:
        """Use one of the session's operations, as a script beside the page would."""
        address = self.url.split("?")[0]
        origin = "/".join(address.split("/")[:3])
        answer = self.page.request.fetch(f"{address}{path}", method=method, data=document, headers={"Origin": origin})
        assert answer.ok, answer.text()
        return answer

    def edit(self, *patch: dict[str, Any]) -> None:
        """Change the design."""
        self.ask("post", "edit", {"patch": list(patch)})

    def pose(self, name: str) -> dict[str, Any] | None:
        """Return where Viser's client holds a node, and its attitude (w, x, y, z)."""
        frame = next(f for f in self.page.frames if "/view/" in f.url)
        found: dict[str, Any] | None = frame.evaluate(f"() => window.__viserMutable.nodePoseData['{name}']")
        return found

    @property
    def url(self) -> str:
        return self.page.url

    @property
    def panel(self) -> Locator:
        """The left panel: the list of parts and the fields."""
        return self.page.locator("#parts")

    def wait_for_glide(self) -> None:
        self.page.wait_for_function("() => window.__studio?.state?.run")
        self.row("Position x").wait_for()
        self.scene("() => window.__viserSceneTree && '/glider' in window.__viserSceneTree.getState()")

    def scene(self, condition: str) -> None:
        """Wait until a condition holds in Viser's document."""
        frame = next(f for f in self.page.frames if "/view/" in f.url)
        frame.wait_for_function(condition)

    def wait_for_consequences(self) -> None:
        """Wait until the consequences shown are those of the newest run, with trims."""
        self.page.wait_for_function(
            "() => { const { state, consequences: c } = window.__studio;"
            " return c && c.analyses === 'ready' && c.run === state.run.number && !state.simulating; }"
        )

    def seek(self, time: float) -> None:
        self.page.evaluate("time => window.__studio.clock.seek(time)", time)

    def downloaded(self, item: str, folder: Path) -> Path:
        """Return the file that an item of the export menu gives."""
        self.page.get_by_test_id("export").click()
        with self.page.expect_download() as download:
            self.page.get_by_test_id(item).click()
        target = folder / download.value.suggested_filename
        download.value.save_as(target)
        return target

    def state(self, expression: str) -> object:
        """Evaluate an expression of the state the page shows."""
        return self.page.evaluate(f"() => (s => {expression})(window.__studio.state)")

    def readout(self, name: str) -> float:
        """Return a readout's value in SI units, as the page holds it."""
        return float(self.page.get_by_test_id(f"readout-{name}").get_attribute("data-value") or "nan")

    def row(self, label: str) -> Locator:
        """Return the row of a field in the panel, from its label."""
        labels = self.panel.locator(".field-label").filter(has_text=re.compile(rf"^{re.escape(label)}$"))
        return labels.first.locator("xpath=..")

    def box(self, label: str) -> Locator:
        """Return the box of a number in the panel."""
        return self.row(label).locator("input.field-box").first

    def type_number(self, label: str, value: float | str) -> None:
        """Type a number in the unit that the row shows, or with one of its own."""
        self.box(label).fill(str(value))
        self.box(label).press("Enter")

    def choose(self, label: str, option: str) -> None:
        self.row(label).locator("select.field-choice").select_option(label=option)

    def open_section(self, name: str) -> Locator:
        """Open a section below the selected part's fields: vehicle, mass, water, start, mission, control or design."""
        section = self.page.get_by_test_id(f"section-{name}")
        if section.get_attribute("open") is None:
            section.locator("summary").first.click()
        return section

    def part(self, name: str) -> Locator:
        """Return a part's row in the list."""
        return self.page.get_by_test_id(f"part-{name}")

    def add_part(self, kind: str) -> None:
        """Add a part by the words of the palette, such as Piston."""
        self.page.get_by_test_id("parts-add").click()
        self.page.get_by_role("menuitem", name=kind, exact=True).click()

    def wait_until(self, condition: Callable[[], bool], *, seconds: float = 20.0) -> None:
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, "the page did not get there in time"
            self.page.wait_for_timeout(50)

    def wait_for_change(self, name: str, before: float) -> float:
        """Wait until a readout differs from what it was, and return it."""
        self.wait_until(lambda: abs(self.readout(name) - before) > 1e-6)
        return self.readout(name)
