"""Links that open stored designs and cases, saving with what others saved meanwhile, and pictures; on a real store."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import httpx
import pytest

from models.design import Design
from server.jobs.engines import SerialEngine
from server.jobs.service import Jobs
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.errors import DeletedError, NotFoundError, RevisionError
from server.store.identifiers import new_id
from server.store.listing import DesignQuery
from server.store.records import Content, StoredDesign
from server.store.thumbnails import SVG
from studio.origin import CaseOrigin, StoredOrigin, origin_document, read_origin
from studio.registry import OpenSession, Sessions
from studio.saving import SaveRequest, keep_picture, origin_of, save
from tests.studio.conftest import make_app, serving, wait_until

POSITION = "/vehicle/components/1/position/0"
FOREIGN = {"Origin": "http://evil.example"}
TOKEN = "a-token-that-is-long-enough-to-be-one"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(tmp_path_factory.mktemp("data"))


@pytest.fixture(scope="module")
def store(folder: Path) -> Iterator[DesignStore]:
    database = Database(sqlite_url(folder / "studio.sqlite"))
    yield DesignStore(database)
    database.close()


@pytest.fixture(scope="module")
def jobs(store: DesignStore, folder: Path) -> Jobs:
    return Jobs(store.database, SerialEngine(), folder / "jobs", find_design=lambda i, n: (store.get(i).design, 1))


@pytest.fixture
def sessions(kernel: None, tmp_path: Path) -> Iterator[Sessions]:
    opened = Sessions(tmp_path / "sessions")
    yield opened
    opened.close()


@pytest.fixture
def opened(sessions: Sessions, dual_bellows: Design) -> OpenSession:
    return sessions.create(dual_bellows)[0]


@contextmanager
def browser(settings: Settings, store: DesignStore | None, jobs: Jobs | None) -> Iterator[httpx.Client]:
    with (
        serving(make_app(settings, store=store, jobs=jobs)[0]) as url,
        httpx.Client(base_url=url, trust_env=False) as web,
    ):
        yield web


@pytest.fixture(scope="module")
def web(kernel: None, store: DesignStore, jobs: Jobs, folder: Path) -> Iterator[httpx.Client]:
    with browser(Settings(data=folder, token=None), store, jobs) as client:
        yield client


def kept(store: DesignStore, design: Design) -> StoredDesign:
    return store.create(Content(design, ("wing",)))


def other(design: Design, x: float) -> Design:
    document = design.model_dump(mode="json")
    document["vehicle"]["components"][1]["position"][0] = x
    return Design.model_validate(document)


def overtake(store: DesignStore, stored: StoredDesign, x: float) -> StoredDesign:
    return store.change(stored.id, lambda before: Content(other(before.design, x), before.tags))


def case_link(jobs: Jobs, design: Design | StoredDesign, case: int) -> str:
    given = {"design": design.model_dump(mode="json")} if isinstance(design, Design) else {"design_id": design.id}
    method = {"kind": "cases", "parameters": [{"name": "place", "pointer": POSITION}], "rows": [[0.1], [0.2]]}
    document = {"format": "glider-batch", "version": 1, "kind": "sweep", "name": "<b>Places</b>", "method": method}
    job, _ = jobs.submit(document | given)
    return f"{job.id}.{case}"


def go(web: httpx.Client, link: str) -> str:
    """Open a link as a browser does: its page, then its form. Return the address of the session."""
    page = web.get(link)
    assert page.status_code == 200, page.text
    assert 'method="post"' in page.text
    answer = web.post(link)
    assert answer.status_code == 303, answer.text
    return answer.headers["location"]


def state_at(web: httpx.Client, address: str) -> dict:
    return web.get(address.split("?")[0] + "state").json()


def test_a_first_save_makes_a_design_and_the_next_its_revision(opened: OpenSession, store: DesignStore) -> None:
    first = save(opened, store, SaveRequest())
    assert (first.revision, first.design) == (1, opened.session.design)
    assert opened.session.origin == origin_of(first)
    assert not opened.session.changed
    opened.session.set_field(POSITION, 0.15)
    assert opened.session.changed
    second = save(opened, store, SaveRequest())
    assert (second.id, second.revision) == (first.id, 2)
    assert store.get(first.id).design == opened.session.design
    assert not opened.session.changed
    assert save(opened, store, SaveRequest()).revision == 2, "the same again is no new revision"


def test_what_is_undone_needs_no_save(opened: OpenSession, store: DesignStore) -> None:
    save(opened, store, SaveRequest())
    opened.session.set_field(POSITION, 0.15)
    opened.session.undo()
    assert not opened.session.changed


def test_tags_stay_with_a_new_revision(opened: OpenSession, store: DesignStore) -> None:
    stored = kept(store, opened.session.design)
    opened.session.come_from(origin_of(stored))
    opened.session.set_field(POSITION, 0.15)
    assert save(opened, store, SaveRequest()).tags == ("wing",)


def test_what_others_saved_is_never_overwritten_unseen(opened: OpenSession, store: DesignStore) -> None:
    first = save(opened, store, SaveRequest())
    overtake(store, first, 0.12)
    opened.session.set_field(POSITION, 0.15)
    with pytest.raises(RevisionError, match="revision 2"):
        save(opened, store, SaveRequest())
    overtake(store, first, 0.13)
    with pytest.raises(RevisionError, match="revision 3"):
        save(opened, store, SaveRequest(how="over", revision=2))
    assert opened.session.changed
    on_top = save(opened, store, SaveRequest(how="over", revision=3))
    assert on_top.revision == 4
    assert on_top.design == opened.session.design
    assert store.revision(first.id, 3).design == other(first.design, 0.13), "theirs stays in the history"


def test_a_conflict_can_end_in_two_designs(opened: OpenSession, store: DesignStore) -> None:
    first = save(opened, store, SaveRequest())
    theirs = overtake(store, first, 0.12)
    opened.session.set_field(POSITION, 0.15)
    mine = save(opened, store, SaveRequest(how="new", name="Mine"))
    assert (mine.revision, mine.design.name) == (1, "Mine")
    assert mine.id != first.id
    assert store.get(first.id).design == theirs.design
    assert opened.session.origin == origin_of(mine)


def test_a_deleted_design_is_brought_back_only_on_demand(opened: OpenSession, store: DesignStore) -> None:
    first = save(opened, store, SaveRequest())
    store.delete(first.id)
    opened.session.set_field(POSITION, 0.15)
    with pytest.raises(DeletedError):
        save(opened, store, SaveRequest())
    assert save(opened, store, SaveRequest(how="restore")).revision == 2


def test_a_file_opened_in_a_session_overwrites_no_design(opened: OpenSession, store: DesignStore) -> None:
    first = save(opened, store, SaveRequest())
    opened.session.replace(other(first.design, 0.11))
    assert opened.session.origin is None
    assert save(opened, store, SaveRequest()).id != first.id


def test_the_origin_outlives_a_restart(opened: OpenSession, sessions: Sessions, store: DesignStore) -> None:
    stored = save(opened, store, SaveRequest())
    wait_until(lambda: opened.saved_at is not None)
    sessions.close()
    again = Sessions(sessions._autosave._folder)
    found = again.get(opened.session.id)
    assert found is not None
    assert found.origin == origin_of(stored)
    assert not found.changed
    again.close()


@pytest.mark.parametrize("origin", [None, StoredOrigin("d", 3, "x"), CaseOrigin("j", "Sweep", 4, "x")])
def test_an_origin_is_read_as_it_was_written(origin: StoredOrigin | CaseOrigin | None) -> None:
    assert read_origin(json.loads(json.dumps(origin_document(origin)))) == origin


def test_the_picture_shows_the_glide(opened: OpenSession, store: DesignStore) -> None:
    stored = save(opened, store, SaveRequest())
    keep_picture(opened.session, store, stored)
    picture = store.thumbnail(stored.id)
    assert picture.media_type == SVG
    assert b"<polyline" in picture.content


def test_a_link_opens_the_newest_revision_or_the_one_it_names(
    web: httpx.Client, store: DesignStore, dual_bellows: Design
) -> None:
    stored = overtake(store, kept(store, dual_bellows), 0.12)
    state = state_at(web, go(web, f"/d/{stored.id}"))
    assert state["origin"]["design_id"] == stored.id
    assert (state["origin"]["revision"], state["origin"]["changed"]) == (2, False)
    address = go(web, f"/d/{stored.id}?revision=1&t=12.5")
    assert address.endswith("/?t=12.5")
    assert state_at(web, address)["origin"]["revision"] == 1
    assert web.get(address.split("?")[0] + "design.json").json() == dual_bellows.model_dump(mode="json")


def test_asking_for_a_link_opens_no_session(web: httpx.Client, store: DesignStore, dual_bellows: Design) -> None:
    """What scans mails or fetches pages ahead asks for every link it finds."""
    link = f"/d/{kept(store, dual_bellows).id}"
    for headers in ({}, {"Sec-Purpose": "prefetch;prerender"}, {"Sec-Fetch-Site": "cross-site"}):
        answer = web.get(link, headers=headers)
        assert answer.status_code == 200
        assert "set-cookie" not in answer.headers
    for foreign in (FOREIGN, {"Sec-Fetch-Site": "cross-site"}, {"Host": "evil.example"}):
        answer = web.post(link, headers=foreign)
        assert answer.status_code == 403
        assert answer.headers["content-type"].startswith("text/html")
        assert "set-cookie" not in answer.headers


def test_a_link_opens_a_case_of_a_job(web: httpx.Client, jobs: Jobs, dual_bellows: Design) -> None:
    run = case_link(jobs, dual_bellows, 1)
    page = web.get(f"/d?run={run}").text
    assert "Case 1 of the job &lt;b&gt;Places&lt;/b&gt;" in page
    address = go(web, f"/d?run={run}&t=3")
    assert address.endswith("/?t=3")
    origin = state_at(web, address)["origin"]
    assert (origin["kind"], origin["case"], origin["job_name"]) == ("case", 1, "<b>Places</b>")
    found = web.get(address.split("?")[0] + "design.json").json()
    assert found["vehicle"]["components"][1]["position"][0] == 0.2


def test_a_case_is_also_reached_from_the_design_that_ran(
    web: httpx.Client, store: DesignStore, jobs: Jobs, dual_bellows: Design
) -> None:
    stored = kept(store, dual_bellows)
    run = case_link(jobs, stored, 0)
    assert state_at(web, go(web, f"/d/{stored.id}?run={run}"))["origin"]["case"] == 0


@pytest.mark.parametrize(
    ("link", "status", "said"),
    [
        ("/d/nothing", 404, "There is no design"),
        ("/d/" + "0" * 26, 404, "There is no design"),
        ("/d/{id}?revision=7", 404, "its newest is 1"),
        ("/d/{id}?revision=first", 422, "not a whole number from 1"),
        ("/d/{id}?t=nan", 422, "not a number of seconds from 0"),
        ("/d/{id}?t=-1", 422, "not a number of seconds from 0"),
        ("/d", 422, "names no design and no run"),
        ("/d?run=1", 422, "as JOB.CASE"),
        ("/d?run=" + "0" * 26 + ".0", 404, "There is no job"),
        ("/d?run={run}", 404, "the job has cases 0 to 1"),
        ("/d/<script>", 404, "&lt;script&gt;"),
    ],
)
def test_what_cannot_be_opened_is_told_on_a_page(
    web: httpx.Client, store: DesignStore, jobs: Jobs, dual_bellows: Design, link: str, status: int, said: str
) -> None:
    run = case_link(jobs, dual_bellows, 2)
    link = link.replace("{id}", kept(store, dual_bellows).id).replace("{run}", run)
    for answer in (web.get(link), web.post(link)):
        assert answer.status_code == status
        assert answer.headers["content-type"].startswith("text/html")
        assert said in answer.text
        assert "<script>" not in answer.text
        assert "set-cookie" not in answer.headers


def test_a_document_that_cannot_be_simulated_is_told_with_its_reasons(
    web: httpx.Client, store: DesignStore, dual_bellows: Design
) -> None:
    document = dual_bellows.model_dump(mode="json")
    document["mission"]["control"]["schedules"][0]["cell"] = "nobody"
    stored = kept(store, Design.model_validate(document))
    answer = web.post(f"/d/{stored.id}")
    assert answer.status_code == 422
    assert "/mission/control/schedules/0" in answer.text


def test_a_case_that_was_refused_leads_back_to_its_job(web: httpx.Client, jobs: Jobs, dual_bellows: Design) -> None:
    command = {"name": "command", "pointer": "/mission/control/schedules/0/points/0/extension"}
    method = {"kind": "cases", "parameters": [command], "rows": [[0.0], [0.5]]}
    document = {"format": "glider-batch", "version": 1, "kind": "sweep", "name": "Too far", "method": method}
    job, _ = jobs.submit(document | {"design": dual_bellows.model_dump(mode="json")})
    answer = web.post(f"/d?run={job.id}.1")
    assert answer.status_code == 422
    assert "Case 1 cannot be opened" in answer.text and "outside its stops" in answer.text
    assert f'href="./jobs/{job.id}"' in answer.text
    below = web.post(f"/d/nothing?run={job.id}.1")
    assert below.status_code == 422 and f'href="../jobs/{job.id}"' in below.text


def test_a_link_to_a_case_leads_to_its_job_or_to_all_jobs(web: httpx.Client, jobs: Jobs, dual_bellows: Design) -> None:
    run = case_link(jobs, dual_bellows, 2)
    assert f'href="./jobs/{run.split(".")[0]}"' in web.get(f"/d?run={run}").text
    for run in ("0" * 26 + ".0", "1"):
        assert 'href="./jobs"' in web.get(f"/d?run={run}").text
    assert "/jobs" not in web.get("/d/nothing").text


def test_a_deleted_design_is_restored_from_its_page(
    web: httpx.Client, store: DesignStore, dual_bellows: Design
) -> None:
    stored = kept(store, dual_bellows)
    store.delete(stored.id)
    gone = web.get(f"/d/{stored.id}")
    assert gone.status_code == 410
    assert f'action="../d/{stored.id}/restore"' in gone.text
    assert web.post(f"/d/{stored.id}/restore", headers=FOREIGN).status_code == 403
    with pytest.raises(DeletedError):
        store.get(stored.id)
    answer = web.post(f"/d/{stored.id}/restore")
    assert answer.status_code == 303
    assert store.get(stored.id).revision == 1


def test_where_a_token_is_demanded_links_need_it(
    kernel: None, store: DesignStore, jobs: Jobs, tmp_path: Path, dual_bellows: Design
) -> None:
    stored = kept(store, dual_bellows)
    with browser(Settings(data=tmp_path, token=TOKEN), store, jobs) as web:
        for answer in (
            web.get(f"/d/{stored.id}"), web.post(f"/d/{stored.id}"), web.get(f"/d/{stored.id}/picture"),
            web.post(f"/d/{stored.id}/restore"),
        ):  # fmt: skip
            assert answer.status_code == 401
            assert dual_bellows.name not in answer.text
        wrong = web.get(f"/?token={TOKEN}x")
        assert (wrong.status_code, dict(wrong.cookies)) == (401, {}) and "This token is not known here" in wrong.text
        web.cookies.set("gs_token", web.get(f"/?token={TOKEN}").cookies["gs_token"])
        assert go(web, f"/d/{stored.id}")


def test_saving_through_the_page(web: httpx.Client, store: DesignStore, dual_bellows: Design) -> None:
    first = kept(store, dual_bellows)
    address = go(web, f"/d/{first.id}").split("?")[0]
    patch = [{"op": "replace", "path": POSITION, "value": 0.15}]
    assert web.post(f"{address}edit", json={"patch": patch}).status_code == 200
    assert state_at(web, address)["origin"]["changed"]
    theirs = overtake(store, first, 0.12)
    refused = web.post(f"{address}save", json={"how": "next"})
    assert refused.status_code == 412
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.headers["etag"] == '"2"'
    newest = refused.json()["newest"]
    assert (newest["design_id"], newest["revision"], newest["updated"]) == (first.id, 2, theirs.updated)
    saved = web.post(f"{address}save", json={"how": "over", "revision": 2})
    assert saved.json() == {"design_id": first.id, "revision": 3, "name": dual_bellows.name}
    assert not state_at(web, address)["origin"]["changed"]
    wait_until(lambda: store.find(DesignQuery(limit=1)).items[0].thumbnail is not None)  # drawn after the answer
    assert b"<polyline" in store.thumbnail(first.id).content


@pytest.mark.parametrize(
    "body",
    [[], {"how": "quickly"}, {"how": "over"}, {"how": "next", "name": "x"}, {"how": "new", "revision": 2},
     {"how": "restore"}, {"how": "over", "revision": 1}, {"how": "new", "name": ""}, {"how": "new", "name": 3}],
)  # fmt: skip
def test_what_cannot_be_saved_is_told(web: httpx.Client, body: object) -> None:
    address = web.post("/sessions", data={"preset": "canete-dual-bellows"}).headers["location"]
    answer = web.post(f"{address}save", json=body)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["message"]


def test_saving_needs_the_session(web: httpx.Client, store: DesignStore) -> None:
    address = web.post("/sessions", data={"preset": "canete-dual-bellows"}).headers["location"]
    foreign = web.post(f"{address}save", json={}, headers=FOREIGN)
    assert foreign.status_code == 403
    web.cookies.clear()
    assert web.post(f"{address}save", json={}).status_code == 403


def test_without_a_store_the_page_says_so(kernel: None, tmp_path: Path) -> None:
    with browser(Settings(data=tmp_path, token=None), None, None) as web:
        assert web.get("/d/" + "0" * 26).status_code == 503
        assert web.get("/d?run=" + "0" * 26 + ".0").status_code == 503
        address = web.post("/sessions", data={"preset": "canete-dual-bellows"}).headers["location"]
        assert web.post(f"{address}save", json={}).status_code == 503


def test_pictures_are_drawn_where_none_is_kept(web: httpx.Client, store: DesignStore, dual_bellows: Design) -> None:
    stored = kept(store, dual_bellows)
    drawn = web.get(f"/d/{stored.id}/picture")
    assert drawn.headers["content-type"].startswith("image/svg+xml")
    assert "sandbox" in drawn.headers["content-security-policy"]
    assert ElementTree.fromstring(drawn.text).tag.endswith("svg")
    known = {"If-None-Match": drawn.headers["etag"]}
    assert web.get(f"/d/{stored.id}/picture", headers=known).status_code == 304
    store.set_thumbnail(stored.id, SVG, b'<svg xmlns="http://www.w3.org/2000/svg"/>')
    assert web.get(f"/d/{stored.id}/picture", headers=known).text == '<svg xmlns="http://www.w3.org/2000/svg"/>'
    assert web.get(f"/d/{new_id()}/picture").status_code == 404
    with pytest.raises(NotFoundError):
        store.thumbnail(new_id())
