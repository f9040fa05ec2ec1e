"""Drives the timeline of a session whose other panels are not waited for."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Locator

from tests.browser.studio_page import StudioPage


class Timeline(StudioPage):
    """The page of a session, of which only the timeline is waited for."""

    def wait_for_glide(self) -> None:
        self.page.wait_for_function("() => window.__studio?.state?.run && window.__studio.timeline.lanes.list.length")

    def points(self, cell: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.page.evaluate(
            "name => window.__studio.state.schedules.find(s => s.cell === name).points", cell
        )
        return found

    def times(self, cell: str) -> list[float]:
        return [point["time"] for point in self.points(cell)]

    def point(self, cell: str, k: int) -> Locator:
        return self.page.get_by_test_id(f"point-{cell}-{k}")

    def scale(self, expression: str) -> Any:
        return self.page.evaluate(f"() => (s => {expression})(window.__studio.timeline.scale)")

    def place(self, where: Locator, t: float, share: float = 0.5) -> tuple[float, float]:
        """Return where on the screen a time is in a lane or plot."""
        box = where.bounding_box()
        assert box is not None
        return box["x"] + self.scale(f"s.x({t})"), box["y"] + share * box["height"]

    def drag(self, start: tuple[float, float], by: tuple[float, float], steps: int = 6) -> None:
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(start[0] + by[0], start[1] + by[1], steps=steps)
        self.page.mouse.up()

    def lane(self, cell: str) -> Locator:
        return self.page.get_by_test_id(f"lane-{cell}").locator("svg.lane")

    def chosen(self) -> int:
        return int(self.page.evaluate("() => window.__studio.timeline.lanes.selection.size"))

    def settled(self, condition: str) -> None:
        self.page.wait_for_function(f"() => (s => {condition})(window.__studio.state)")

    def menu(self, cell: str, item: str) -> None:
        self.page.get_by_test_id(f"lane-menu-{cell}").click()
        self.page.get_by_test_id(item).click()


def center(node: Locator) -> tuple[float, float]:
    box = node.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
