"""Drives the left panel of a session whose 3D view is left out: these tests look at the page around it."""

from __future__ import annotations

import json
from typing import Any

from tests.browser.studio_page import StudioPage


class PanelPage(StudioPage):
    """One open session, without its 3D view."""

    def wait_for_glide(self) -> None:
        self.page.wait_for_function("() => window.__studio?.state?.run")
        self.row("Position x").wait_for()

    def document(self) -> dict[str, Any]:
        answer = self.page.request.get(self.url.split("?")[0] + "design.json")
        assert answer.ok
        document: dict[str, Any] = answer.json()
        return document

    def at(self, *path: str | int) -> Any:
        """Return what the document holds at a path."""
        node: Any = self.document()
        for step in path:
            node = node[step]
        return node

    def open_file(self, document: dict[str, Any]) -> None:
        """Open a design file in this session."""
        content = json.dumps(document).encode()
        file = {"name": "design.json", "mimeType": "application/json", "buffer": content}
        self.page.get_by_test_id("open-file").set_input_files(file)  # type: ignore[arg-type]

    def names(self) -> list[str]:
        found: list[str] = self.page.evaluate("() => window.__studio.state.components.map(c => c.name)")
        return found

    def key(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def focus_tree(self) -> None:
        self.page.locator("[role=treeitem][tabindex='0']").focus()
