"""Designs that last: saved, opened by their links, saved again where somebody else was quicker, shown at a moment."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from models.design import Design
from models.presets import load_preset
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.identifiers import new_id
from server.store.records import Content, StoredDesign

pytestmark = pytest.mark.browser

POSITION = "/vehicle/components/1/position/0"
COMMENT = "Ballast moved forward"


@pytest.fixture
def store(program) -> Iterator[DesignStore]:
    """The program's store, as another writer beside it uses it."""
    database = Database(sqlite_url(program.data / "studio.sqlite"))
    yield DesignStore(database)
    database.close()


def named(name: str) -> Design:
    document = load_preset("canete-dual-bellows").model_dump(mode="json") | {"name": name}
    return Design.model_validate(document)


class Opened:
    """A session in a browser tab."""

    def __init__(self, page: Page) -> None:
        self.page = page
        page.wait_for_url(re.compile(r"/s/[^/]+/"))
        page.wait_for_function("() => window.__studio?.state?.run && !window.__studio.state.simulating")

    @classmethod
    def by_link(cls, page: Page, link: str) -> Opened:
        page.goto(link)
        return cls(page)

    def state(self, expression: str) -> Any:
        """Evaluate an expression of the state the page shows."""
        return self.page.evaluate(f"() => (s => {expression})(window.__studio.state)")

    def shows_moment(self, t: float) -> None:
        self.page.wait_for_function("t => window.__studio.clock.t === t", arg=t)
        assert self.page.evaluate("() => window.__studio.clock.playing") is False

    def move(self, x: float) -> None:
        """Move the front bellows through the session's operations, as a script beside the page would."""
        address = self.page.url.split("?")[0]
        patch = [{"op": "replace", "path": POSITION, "value": x}]
        answer = self.page.request.post(f"{address}edit", data={"patch": patch})
        assert answer.ok, answer.text()
        self.page.wait_for_function("() => window.__studio.state.origin?.changed === true")


def position(stored: StoredDesign) -> float:
    return stored.design.vehicle.components[1].position[0]


def test_save_come_back_by_the_link_and_save_the_next_revision(program, page, store):
    answer = page.request.post(f"{program.url}/sessions", data=named("Made to last").model_dump(mode="json"))
    studio = Opened.by_link(page, program.url + answer.json()["url"])
    expect(page.get_by_test_id("saved")).to_have_text("Not saved")
    page.get_by_test_id("save").click()
    expect(page.get_by_test_id("saved")).to_have_text("Revision 1")
    expect(page.get_by_test_id("save")).to_be_disabled()
    design_id = studio.state("s.origin.design_id")

    page.goto(program.url)
    card = page.get_by_test_id(f"stored-{design_id}")
    expect(card).to_contain_text("Made to last")
    page.wait_for_function(
        "id => document.querySelector(`[data-testid=stored-${id}] img`)?.naturalWidth > 0", arg=design_id
    )
    card.get_by_role("link").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    page.go_back()
    expect(page.get_by_test_id("stored-list")).to_be_visible()

    again = Opened.by_link(page, f"{program.url}/d/{design_id}")
    again.move(0.15)
    expect(page.get_by_test_id("saved")).to_have_text("Revision 1 · unsaved changes")
    assert page.title().startswith("● ")
    page.keyboard.press("Control+s")
    expect(page.get_by_test_id("saved")).to_have_text("Revision 2")
    assert position(store.get(design_id)) == 0.15


def test_a_conflict_loses_nothing(program, page, store):
    first = store.create(Content(named("Two writers")))
    studio = Opened.by_link(page, f"{program.url}/d/{first.id}")
    studio.move(0.15)
    theirs = store.change(first.id, lambda before: Content(named("Two writers, theirs"), before.tags), comment=COMMENT)
    page.get_by_test_id("save").click()
    dialog = page.get_by_test_id("conflict")
    expect(dialog).to_contain_text("“Two writers, theirs” is at revision 2")
    expect(dialog).to_contain_text(COMMENT)
    page.get_by_test_id("conflict-later").click()
    expect(dialog).to_be_hidden()
    expect(page.get_by_test_id("saved")).to_have_text("Revision 1 · unsaved changes")

    page.get_by_test_id("save").click()
    with page.context.expect_page() as opened:
        page.get_by_test_id("conflict-theirs").click()
    opened.value.wait_for_url(re.compile(r"/s/[^/]+/"))
    expect(opened.value.get_by_test_id("name")).to_have_text("Two writers, theirs")
    opened.value.close()

    page.get_by_test_id("conflict-over").click()
    expect(dialog).to_be_hidden()
    expect(page.get_by_test_id("saved")).to_have_text("Revision 3")
    assert position(store.get(first.id)) == 0.15
    assert store.revision(first.id, 2).design == theirs.design


def test_a_conflict_can_end_in_a_design_of_its_own(program, page, store):
    first = store.create(Content(named("Apart")))
    studio = Opened.by_link(page, f"{program.url}/d/{first.id}")
    studio.move(0.15)
    store.delete(first.id)
    page.get_by_test_id("save").click()
    expect(page.get_by_test_id("conflict")).to_contain_text("This design was deleted meanwhile")
    page.get_by_test_id("conflict-name").fill("")
    page.get_by_test_id("conflict-new").click()
    expect(page.get_by_test_id("conflict").get_by_role("alert")).to_contain_text("name")
    page.get_by_test_id("conflict-name").fill("Apart, mine")
    page.get_by_test_id("conflict-name").press("Enter")
    expect(page.get_by_test_id("name")).to_have_text("Apart, mine")
    expect(page.get_by_test_id("saved")).to_have_text("Revision 1")
    mine = store.get(studio.state("s.origin.design_id"))
    assert (mine.design.name, position(mine)) == ("Apart, mine", 0.15)


def test_a_link_leads_to_its_moment(program, page, store):
    first = store.create(Content(named("A moment")))
    studio = Opened.by_link(page, f"{program.url}/d/{first.id}?t=12.5")
    studio.shows_moment(12.5)
    assert page.get_by_test_id("time").inner_text().startswith("12.5")

    page.evaluate("() => window.__studio.clock.seek(7.256)")
    page.get_by_test_id("link").click()
    link = f"{program.url}/d/{first.id}?revision=1&t=7.26"
    expect(page.get_by_test_id("link-address")).to_have_value(link)
    expect(page.get_by_test_id("link-warning")).to_be_hidden()
    page.keyboard.press("Escape")
    studio.move(0.15)
    page.get_by_test_id("link").click()
    expect(page.get_by_test_id("link-warning")).to_contain_text("it leads to revision 1 as it is stored")
    there = Opened.by_link(page, link)
    there.shows_moment(7.26)
    assert there.state("s.origin.changed") is False


def test_a_case_of_a_job_is_replayed(program, page):
    method = {"kind": "cases", "parameters": [{"name": "place", "pointer": POSITION}], "rows": [[0.1], [0.15]]}
    document: dict[str, Any] = {"format": "glider-batch", "version": 1, "kind": "sweep", "name": "Along the hull"}
    document |= {"design": named("Swept").model_dump(mode="json"), "method": method}
    answer = page.request.post(f"{program.url}/api/v1/jobs", data=document)
    assert answer.ok, answer.text()
    job = answer.json()["id"]
    studio = Opened.by_link(page, f"{program.url}/d?run={job}.1&t=3")
    studio.shows_moment(3)
    assert page.title() == "Case 1 · Along the hull · Swept · Glider studio"
    expect(page.get_by_test_id("case")).to_have_attribute("href", f"../../jobs/{job}")
    assert studio.state("s.components[1].position[0]") == 0.15
    page.get_by_test_id("link").click()
    expect(page.get_by_test_id("link-address")).to_have_value(f"{program.url}/d?run={job}.1&t=3")


def test_what_a_link_cannot_open_is_told_with_a_way_on(program, page, store):
    page.goto(f"{program.url}/d/{new_id()}")
    expect(page.get_by_test_id("problem")).to_contain_text("There is nothing at this link")
    page.get_by_role("link", name="Presets and stored designs").click()
    expect(page.get_by_test_id("presets")).to_be_visible()

    gone = store.create(Content(named("Once deleted")))
    store.delete(gone.id)
    page.goto(f"{program.url}/d/{gone.id}")
    page.get_by_test_id("restore").click()
    page.wait_for_url(re.compile(r"/s/[^/]+/"))
    expect(page.get_by_test_id("name")).to_have_text("Once deleted")


def test_the_list_is_searched_and_goes_on(program, page, store):
    for k in range(9):
        store.create(Content(named(f"Listed {k}"), ("odd",) if k % 2 else ()))
    store.create(Content(named("Newest")))  # which is first until what is sought is there
    page.goto(program.url)
    page.get_by_test_id("stored-search").fill("listed")
    cards = page.get_by_test_id("stored-list").locator("li")
    expect(cards.first).to_contain_text("Listed 8")
    expect(cards).to_have_count(6)
    page.get_by_test_id("stored-more").click()
    expect(cards).to_have_count(9)
    expect(cards.last).to_contain_text("Listed 0")
    expect(page.get_by_test_id("stored-more")).to_be_hidden()
    page.get_by_test_id("stored-search").fill("listed odd")
    expect(cards).to_have_count(4)
    page.get_by_test_id("stored-search").fill("no such words")
    expect(page.get_by_test_id("stored-note")).to_contain_text("No stored design holds “no such words”")
