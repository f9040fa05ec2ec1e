"""Starts the whole program on a free port, and one headless Chromium for all journeys."""

from __future__ import annotations

import shutil
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright
from xdist.remote import Producer
from xdist.scheduler import LoadFileScheduling

from models.warm import warm_kernel
from server.settings import Settings
from studio.serve import Server, make_app, uvicorn_config
from tests.browser.jobs_support import api, partial, swept, watched  # noqa: F401
from tests.browser.panel_page import PanelPage
from tests.browser.studio_page import SIZE, StudioPage, document_of
from tests.studio.spiral import spiral_document

FLAGS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-gpu", "--enable-unsafe-swiftshader",
]  # fmt: skip
"""WebGL is drawn in software, and so is the page around it, by what draws pages fastest that way."""
EMPTY_VIEW = """(() => {
  const { src } = Object.getOwnPropertyDescriptors(HTMLIFrameElement.prototype);
  const empty = "<!doctype html><html lang='en'><title>Nothing</title></html>";
  const set = function (value) {
    if (value.startsWith("view/")) this.srcdoc = empty;
    else src.set.call(this, value);
  };
  Object.defineProperty(HTMLIFrameElement.prototype, "src", { ...src, set });
})()"""


GROUPS = {"scene": ("scene", "turning", "view"), "jobs": ("jobs", "job_page")}
"""Files of tests that share what is slow to set up, such as the tab with the 3D view."""


class Groups(LoadFileScheduling):
    """Leaves all tests of a group, and otherwise those of a file, to one of the processes that share the tests."""

    def _split_scope(self, nodeid: str) -> str:
        file: str = super()._split_scope(nodeid)
        name = Path(file).stem.removeprefix("test_")
        return next((group for group, names in GROUPS.items() if name in names), file)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> Groups:
    return Groups(config, log)


class Program:
    """The program on one port of this machine; `restart` keeps its data."""

    def __init__(self, data: Path) -> None:
        self.data = data
        self.port = 0
        self.start()

    def start(self) -> None:
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", self.port))
        self.port = listener.getsockname()[1]
        settings = Settings(port=self.port, data=self.data)
        app = make_app(settings)
        self.server = Server(uvicorn_config(app), app.state.stopping)
        self.thread = threading.Thread(target=self.server.run, kwargs={"sockets": [listener]}, daemon=True)
        self.thread.start()
        while not self.server.started:
            time.sleep(0.02)

    def stop(self) -> None:
        self.server.should_exit = True
        self.thread.join(20)

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"


@pytest.fixture(scope="package")  # playwright holds an event loop: it must end with these tests
def program(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Program]:
    warm_kernel()
    running = Program(tmp_path_factory.mktemp("data"))
    yield running
    running.stop()


@pytest.fixture(scope="package")  # playwright holds an event loop: it must end with these tests
def browser() -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    assert chromium, "chromium is missing: install Debian's package chromium"
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=chromium, headless=True, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture(scope="package")
def context(browser: Browser) -> Iterator[BrowserContext]:
    """What all tabs share, as one person's do: files that were loaded before, with which a page opens sooner."""
    opened = browser.new_context(viewport=SIZE, color_scheme="dark")
    opened.set_default_timeout(60_000)
    yield opened
    opened.close()


@pytest.fixture(scope="package")
def cleaner(program: Program, context: BrowserContext) -> Page:
    """A tab that is never looked at, through which what pages keep is forgotten."""
    opened = context.new_page()
    opened.goto(f"{program.url}/healthz")
    return opened


@pytest.fixture(scope="package")
def bare_tab(context: BrowserContext) -> Iterator[Page]:
    """A tab in which the 3D view stays empty: drawn in software it slows all that asks nothing of it."""
    opened = context.new_page()
    opened.add_init_script(EMPTY_VIEW)
    yield opened
    opened.close()


@pytest.fixture
def page(program: Program, bare_tab: Page, cleaner: Page) -> Iterator[Page]:
    """That tab for somebody who has not been here before: it opens a page in half the time that a new one takes."""
    bare_tab.goto(f"{program.url}/healthz")  # ends what the last page may still be about to keep
    cleaner.evaluate("() => localStorage.clear()")
    bare_tab.bring_to_front()  # a tab behind another draws nothing, and its timers come late
    bare_tab.set_viewport_size(SIZE)
    bare_tab.mouse.move(0.0, 0.0)
    yield bare_tab
    bare_tab.unroute_all()


@pytest.fixture
def new_page(context: BrowserContext, cleaner: Page) -> Iterator[Page]:
    """A new tab, for what needs its 3D view, or a script that stays in it."""
    cleaner.evaluate("() => localStorage.clear()")
    opened = context.new_page()
    yield opened
    opened.close()


@pytest.fixture(scope="package")
def scene_tab(program: Program, context: BrowserContext) -> Iterator[StudioPage]:
    """A tab whose 3D view stays open: software that draws takes many seconds to get ready for another one."""
    opened = context.new_page()
    yield StudioPage.open_document(opened, program.url, document_of("canete-dual-bellows"))
    opened.close()


@pytest.fixture
def reopened(scene_tab: StudioPage, cleaner: Page) -> Iterator[Callable[[dict[str, Any]], StudioPage]]:
    """Puts a document into that tab, and all else there back to how it was opened."""

    def reopen(document: dict[str, Any]) -> StudioPage:
        cleaner.evaluate("() => localStorage.clear()")
        scene_tab.page.bring_to_front()
        scene_tab.begin_again(document)
        return scene_tab

    yield reopen
    scene_tab.page.evaluate("() => window.__studio.clock.pause()")


@pytest.fixture
def turning(reopened: Callable[[dict[str, Any]], StudioPage]) -> StudioPage:
    """A glider that banks and turns."""
    return reopened(spiral_document(duration=300.0))


@pytest.fixture
def studio(reopened: Callable[[dict[str, Any]], StudioPage]) -> StudioPage:
    """The paper's preset."""
    return reopened(document_of("canete-dual-bellows"))


@pytest.fixture
def panel(program: Program, page: Page) -> PanelPage:
    """The paper's preset, without its 3D view."""
    return PanelPage.open_document(page, program.url, document_of("canete-dual-bellows"))


@pytest.fixture
def spatial(program: Program, page: Page) -> PanelPage:
    """A glider that turns, without its 3D view."""
    return PanelPage.open_document(page, program.url, spiral_document(duration=20.0))
