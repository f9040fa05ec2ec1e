"""Stored designs over HTTP: nobody overwrites what they have not seen, nothing is lost, errors are problems."""

from __future__ import annotations

import copy
import json
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from models.presets import load_preset
from server.settings import Settings
from server.store.designs import DesignStore
from server.store.records import Content
from tests.server.support import ask, assert_problem, local_app, preset, read_json

ALL = "/api/v1/designs"
NOBODY = f"{ALL}/{'0' * 26}"
MERGE = {"content-type": "application/merge-patch+json"}


def without_first_cell():
    """Return a design whose schedules ask for a cell that it has not: well formed, and yet it cannot be simulated."""
    design = preset()
    cell = design["mission"]["control"]["schedules"][0]["cell"]
    design["vehicle"]["components"] = [part for part in design["vehicle"]["components"] if part["name"] != cell]
    return design


@pytest.fixture
def app(store):
    made = local_app()
    made.state.store = store
    return made


@pytest.fixture
def api(app):
    """Return how the API around a new store is asked."""
    return lambda method, path, document=None, **options: ask(method, path, document, app=app, **options)


@pytest.fixture
def one(api):
    """Return the address of a design that is stored at revision 1."""
    return api("POST", ALL, {"design": preset(), "tags": ["Deep", "sea trial"]}).headers["location"]


def at(revision):
    return {"If-Match": f'"{revision}"'}


def shown(answer, status=200):
    assert answer.status_code == status, answer.text
    content = read_json(answer)
    assert answer.headers["etag"] == f'"{content["revision"]}"'
    return content


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_design_is_stored_and_found_at_its_location(api, wrapped):
    sent = {"design": preset(), "name": "Mine", "tags": ["a", "A", "b"], "comment": "new"} if wrapped else preset()
    answer = api("POST", ALL, sent)
    made = shown(answer, 201)
    assert answer.headers["location"] == f"{ALL}/{made['id']}"
    assert shown(api("GET", answer.headers["location"])) == made
    expected = preset() | ({"name": "Mine"} if wrapped else {})
    assert made["design"] == expected and (made["name"], made["notes"]) == (expected["name"], expected["notes"])
    assert (made["tags"], made["comment"]) == ((["a", "b"], "new") if wrapped else ([], ""))
    assert made["revision"] == 1 and made["created"] == made["updated"] and made["created"].endswith("Z")


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"design": {}}, "/design/format"),
        ({"design": preset() | {"name": ""}}, "/design/name"),
        ({"design": without_first_cell()}, "/design/mission/control/schedules/0/cell"),
        ({"name": ""}, "/name"),
        ({"name": "a\nb"}, "/name"),
        ({"name": 7}, "/name"),
        ({"tags": "a"}, "/tags"),
        ({"tags": [""]}, "/tags/0"),
        ({"tags": ["a", " b"]}, "/tags/1"),
        ({"tags": ["a,b"]}, "/tags/0"),
        ({"tags": ["a\u0000b"]}, "/tags/0"),
        ({"tags": ["a" * 41]}, "/tags/0"),
        ({"tags": [str(n) for n in range(21)]}, "/tags"),
        ({"comment": "\u0000"}, "/comment"),
        ({"comment": "c" * 501}, "/comment"),
        ({"tag": []}, "/tag"),
    ],
)
def test_what_is_wrong_is_pointed_at_and_nothing_is_stored(api, change, pointer):
    assert_problem(api("POST", ALL, {"design": preset()} | change), 422, pointer=pointer)
    assert read_json(api("GET", ALL))["items"] == []


def test_an_unchanged_design_is_not_sent_again(api, one):
    for tag in ('"1"', '"7", "1"', 'W/"1"', "*"):
        answer = api("GET", one, headers={"If-None-Match": tag})
        assert (answer.status_code, answer.content, answer.headers["etag"]) == (304, b"", '"1"')
        assert api("GET", f"{one}/components", headers={"If-None-Match": tag}).status_code == 304
    for tag in ('"2"', "1", "", "x"):
        assert shown(api("GET", one, headers={"If-None-Match": tag}))["revision"] == 1


WRITES = [
    ("PUT", "", preset()),
    ("PATCH", "", {"name": "B"}),
    ("POST", ":revert", {"revision": 1}),
    ("POST", "/components", {"kind": "rigid", "name": "Lead", "mass": 0.1, "volume": 1e-5, "position": [0, 0, 0]}),
    ("PATCH", "/components/Fuselage", {"notes": "x"}),
    ("DELETE", "/components/Fuselage", None),
]


@pytest.mark.parametrize(("method", "path", "body"), WRITES)
def test_every_change_says_what_it_starts_from(api, one, method, path, body):
    assert_problem(api(method, one + path, body), 428, says="send If-Match with the ETag")
    for unreadable in ("1", "", '"', "x", '"1" "2"', "'1'"):
        says = "write If-Match: "
        assert_problem(api(method, one + path, body, headers={"If-Match": unreadable}), 422, says=says)
    for wrong in ('"2"', '"0"', 'W/"1"', '"x"', '"99999999999999999999"', '"٣"'):
        problem = assert_problem(api(method, one + path, body, headers={"If-Match": wrong.encode()}), 412)
        assert "is at revision 1" in problem["detail"]
    assert api(method, one + path, body, headers={"If-Match": '"2"'}).headers["etag"] == '"1"'
    assert len(read_json(api("GET", f"{one}/revisions"))["items"]) == 1


def test_an_etag_without_its_quotes_is_told_how_it_is_written(api, one):
    problem = assert_problem(api("PUT", one, preset(), headers={"If-Match": "12"}), 422)
    (told,) = problem["errors"]
    assert told["message"].startswith("header parameter 'If-Match': '12' is no ETag")
    assert """-H 'If-Match: "12"'""" in told["hint"]


@pytest.mark.parametrize("tag", ['"1"', "*", '"7", "1"', ' "1" '])
def test_a_change_that_knows_the_revision_makes_the_next(api, one, tag):
    made = shown(api("PUT", one, preset() | {"name": "B"}, headers={"If-Match": tag}))
    assert (made["revision"], made["name"], made["tags"]) == (2, "B", ["Deep", "sea trial"])
    assert shown(api("GET", one)) == made


def test_replacing_by_the_same_makes_no_revision(api, one):
    assert shown(api("PUT", one, preset(), headers=at(1)))["revision"] == 1
    assert shown(api("PUT", one, {"design": preset(), "tags": ["x"], "comment": "c"}, headers=at(1)))["revision"] == 2
    problem = assert_problem(api("PUT", one, {"design": preset() | {"name": ""}}, headers=at(2)), 422)
    assert [item["pointer"] for item in problem["errors"]] == ["/design/name"]


PATCH = [{"op": "replace", "path": "/mission/duration", "value": 12.5}]


@pytest.mark.parametrize("kind", ["application/json", "application/json-patch+json"])
@pytest.mark.parametrize("sent", [PATCH, {"patch": PATCH, "comment": "c"}])
def test_a_design_is_patched(api, one, kind, sent):
    made = shown(api("PATCH", one, sent, headers=at(1) | {"content-type": kind}))
    assert made["design"]["mission"]["duration"] == 12.5 and made["revision"] == 2


def test_name_notes_and_tags_are_changed_with_the_document(api, one):
    made = shown(api("PATCH", one, {"name": "B", "notes": "N", "tags": [], "patch": PATCH}, headers=at(1)))
    assert (made["name"], made["notes"], made["tags"], made["revision"]) == ("B", "N", [], 2)
    changed = copy.deepcopy(preset()) | {"name": "B", "notes": "N"}
    changed["mission"]["duration"] = 12.5
    assert made["design"] == changed


@pytest.mark.parametrize(
    ("sent", "pointer"),
    [
        ({}, ""),
        ({"comment": "only"}, ""),
        ("text", "/patch"),
        ([{"op": "remove", "path": "/none"}], "/patch/0/path"),
        ([{"op": "replace", "path": "/name", "value": ""}], "/name"),
        ({"name": ""}, "/name"),
        ({"tags": [1]}, "/tags/0"),
        ([{"op": "copy", "from": "/vehicle/components/0", "path": "/vehicle/components/-"}], "/vehicle"),
    ],
)
def test_wrong_patches_change_nothing(api, one, sent, pointer):
    assert_problem(api("PATCH", one, sent, headers=at(1)), 422, pointer=pointer)
    assert shown(api("GET", one))["revision"] == 1


def test_a_patch_stays_within_the_limits(store):
    app = local_app(max_components=5)
    app.state.store = store
    made = store.create(Content(load_preset("three-cell-glider")))
    count = len(made.design.vehicle.components)
    part = {"kind": "rigid", "mass": 0.1, "volume": 1e-5, "position": [0, 0, 0]}
    add = [{"op": "add", "path": "/vehicle/components/-", "value": part | {"name": f"p{n}"}} for n in range(9)]
    address = f"{ALL}/{made.id}"
    assert_problem(
        ask("PATCH", address, add, app=app, headers=at(1)), 422, pointer="/vehicle/components", says="limit of 5"
    )
    for n in range(count, 5):
        answer = ask("POST", f"{address}/components", part | {"name": f"q{n}"}, app=app, headers={"If-Match": "*"})
        assert answer.status_code == 201
    assert_problem(
        ask("POST", f"{address}/components", part | {"name": "more"}, app=app, headers={"If-Match": "*"}), 422,
        says="limit of 5",
    )  # fmt: skip


def test_a_deleted_design_is_gone_until_it_is_restored(api, one):
    shown(api("PATCH", one, {"name": "B"}, headers=at(1)))
    assert_problem(api("DELETE", one, headers=at(1)), 412)
    answer = api("DELETE", one, headers=at(2))
    assert (answer.status_code, answer.content) == (204, b"")
    for method, path, body in [("GET", "", None), ("DELETE", "", None), ("GET", ":export", None), *WRITES]:
        assert_problem(api(method, one + path, body, headers={"If-Match": "*"}), 410, says="restore it")
    assert read_json(api("GET", ALL))["items"] == []
    (gone,) = read_json(api("GET", f"{ALL}?deleted=true"))["items"]
    assert gone["deleted"] and gone["revision"] == 2 and one.endswith(gone["id"])
    assert shown(api("POST", f"{one}:restore"))["name"] == "B" == shown(api("POST", f"{one}:restore"))["name"]
    assert len(read_json(api("GET", f"{one}/revisions"))["items"]) == 2
    assert api("DELETE", one).status_code == 204


def test_revisions_are_listed_read_and_gone_back_to(api, one):
    for n in range(2, 6):
        shown(api("PATCH", one, {"name": f"Name {n}", "comment": f"c{n}"}, headers=at(n - 1)))
    page = read_json(api("GET", f"{one}/revisions?limit=3"))
    rest = read_json(api("GET", f"{one}/revisions", params={"limit": 3, "cursor": page["next"]}))
    assert [item["revision"] for item in page["items"] + rest["items"]] == [5, 4, 3, 2, 1] and rest["next"] is None
    assert page["items"][0]["comment"] == "c5" and rest["items"][-1]["name"] == preset()["name"]
    first = shown(api("GET", f"{one}/revisions/1"))
    assert first["design"] == preset()
    back = shown(api("POST", f"{one}:revert", {"revision": 1}, headers=at(5)))
    assert (back["revision"], back["identity"], back["design"]) == (6, first["identity"], preset())
    for number in (0, 7, -1, 10**12):
        assert_problem(api("GET", f"{one}/revisions/{number}"), 404, says=f"no revision {number}: its newest is 6")
    assert_problem(api("GET", f"{one}/revisions/x"), 422, says="path parameter")
    assert_problem(api("POST", f"{one}:revert", {"revision": 9}, headers=at(6)), 404)
    for wrong, pointer in (
        ({}, "/revision"),
        ({"revision": 0}, "/revision"),
        ({"revision": "1"}, "/revision"),
        ([], ""),
    ):
        assert_problem(api("POST", f"{one}:revert", wrong, headers=at(6)), 422, pointer=pointer)


@pytest.mark.parametrize(
    "path", ["", ":export", "/revisions", "/revisions/1", "/components", "/components/x", "/thumbnail"]
)
@pytest.mark.parametrize("address", [NOBODY, f"{ALL}/none", f"{ALL}/%00", f"{ALL}/{'x' * 3000}"])
def test_designs_that_are_not_there(api, address, path):
    assert_problem(api("GET", address + path), 404, says="there is no")


def test_unknown_deeds_are_not_taken_for_designs(api, one):
    for method, path in (("POST", ":none"), ("GET", ":none"), ("GET", "/none"), ("GET", ":export:x")):
        assert_problem(api(method, one + path), 404, says="there is nothing at")


def test_lists_are_searched_sorted_and_paged(api):
    for n in range(7):
        sent = {"design": preset() | {"name": f"Glider {n}"}, "tags": ["even" if n % 2 == 0 else "odd", "all"]}
        assert api("POST", ALL, sent).status_code == 201

    def names(**query):
        answer = read_json(api("GET", ALL, params=query))
        return [item["name"][-1] for item in answer["items"]], answer["next"]

    assert names() == (list("6543210"), None) and names(sort="created") == (list("0123456"), None)
    assert names(tag="EVEN", sort="name") == (list("0246"), None)
    assert names(tag=["odd", "all"], sort="-name") == (list("531"), None)
    assert names(tag=["odd", "even"]) == ([], None)
    assert names(search="glider 4") == (["4"], None)
    first, cursor = names(sort="name", limit=3)
    second, cursor = names(sort="name", limit=3, cursor=cursor)
    third, cursor = names(sort="name", limit=3, cursor=cursor)
    assert (first, second, third, cursor) == (list("012"), list("345"), list("6"), None)


@pytest.mark.parametrize(
    ("query", "says"),
    [
        ("limit=0", "'limit'"), ("limit=201", "'limit'"), ("limit=x", "'limit'"), ("sort=size", "'sort'"),
        ("deleted=7", "'deleted'"), ("cursor=x", "'cursor'"), (f"search={'x' * 201}", "'search'"),
    ],
)  # fmt: skip
def test_wrong_queries_are_named(api, query, says):
    assert_problem(api("GET", f"{ALL}?{query}"), 422, says=f"query parameter {says}")


def test_nothing_in_a_query_troubles_the_database(api, one):
    for odd in ("%00", "%F0%9F%9A%A4", "'", '"', "%25", "\\", "*", "()", "a:b", "NEAR", "AND", "a" * 190):
        for query in (f"search={odd}", f"search={odd}xx", f"tag={odd}"):
            assert api("GET", f"{ALL}?{query}").status_code == 200


def test_components_are_read_added_changed_and_removed(api, one):
    parts = preset()["vehicle"]["components"]
    listed = shown(api("GET", f"{one}/components"))
    assert listed["items"] == parts
    cell = {
        "kind": "piston", "name": "Tail piston/π?".replace("/", " "), "mass": 0.05, "volume": 5e-5,
        "volume_range": [3e-5, 7e-5], "position": [-0.1, 0.0, 0.01],
    }  # fmt: skip
    answer = api("POST", f"{one}/components", cell, headers=at(1))
    assert answer.status_code == 201 and answer.headers["etag"] == '"2"'
    address = answer.headers["location"]
    assert address == f"{one}/components/Tail%20piston%20%CF%80%3F"
    assert read_json(answer) == read_json(api("GET", address)) and read_json(answer)["mass"] == 0.05
    answer = api("PATCH", address, {"mass": 0.07, "shapes": None, "name": "Tail"}, headers=at(2) | MERGE)
    assert (read_json(answer)["mass"], read_json(answer)["name"], answer.headers["etag"]) == (0.07, "Tail", '"3"')
    assert_problem(api("GET", address), 404, says="no component 'Tail piston π?'")
    gone = api("DELETE", f"{one}/components/Tail", headers=at(3))
    assert (gone.status_code, gone.content, gone.headers["etag"]) == (204, b"", '"4"')
    assert shown(api("GET", one))["design"] == preset()
    assert len(read_json(api("GET", f"{one}/revisions"))["items"]) == 4


@pytest.mark.parametrize(
    ("method", "path", "body", "pointer", "says"),
    [
        ("POST", "", {}, "/kind", "the kind is missing"),
        ("POST", "", [], "", ""),
        ("POST", "", "x", "", ""),
        ("POST", "", {"kind": "none", "name": "x"}, "/kind", "no kind 'none'"),
        ("POST", "", {"kind": "rigid", "name": "x", "mass": -1, "volume": 0, "position": [0, 0, 0]}, "/mass", ""),
        ("POST", "", {"kind": "rigid", "name": "Fuselage"}, "/name", "already"),
        ("POST", "", {"kind": "rigid", "name": "a/b", "mass": 1, "volume": 0, "position": [0, 0, 0]}, "/name", ""),
        ("PATCH", "/Fuselage", {"mass": "x"}, "/mass", ""),
        ("PATCH", "/Fuselage", {"mas": 1}, "/mas", "did you mean mass"),
        ("PATCH", "/Fuselage", {"mass": None}, "/mass", ""),
        ("PATCH", "/Fuselage", [], "", "an object of fields"),
        ("PATCH", "/Front bellows", {"name": "Other"}, "", "is named 'Front bellows'"),
        ("DELETE", "/Front bellows", None, "", "/mission/control/schedules"),
    ],
)
def test_wrong_components_are_pointed_at(api, one, method, path, body, pointer, says):
    answer = api(method, f"{one}/components{path}", body, headers=at(1))
    assert_problem(answer, 422, pointer=pointer, says=says)
    assert shown(api("GET", one))["revision"] == 1


def test_clients_that_change_the_same_revision_at_once(app, one):
    barrier = threading.Barrier(6)

    def change(n):
        barrier.wait()
        return ask("PUT", one, preset() | {"name": f"Writer {n}"}, app=app, headers=at(1))

    with ThreadPoolExecutor(6) as pool:
        answers = list(pool.map(change, range(6)))
    assert sorted(answer.status_code for answer in answers) == [200] + [412] * 5
    won = next(answer for answer in answers if answer.status_code == 200)
    assert shown(ask("GET", one, app=app)) == read_json(won)


def test_a_database_that_does_not_answer_is_503():
    app = local_app(database_url="postgresql://anna:secret@127.0.0.1:1/studio")
    for method, path, body in (("GET", ALL, None), ("POST", ALL, preset()), ("GET", NOBODY, None)):
        answer = ask(method, path, body, app=app)
        problem = assert_problem(answer, 503, says="the database does not answer")
        assert answer.headers["retry-after"] == "5" and "secret" not in json.dumps(problem)
    assert_problem(ask("GET", "/readyz", app=app), 503, says="store")


def test_the_store_is_in_the_data_folder_and_closed_at_the_end(tmp_path):
    app = local_app(data=tmp_path / "data")
    assert not (tmp_path / "data").exists()
    address = ask("POST", ALL, preset(), app=app).headers["location"]
    assert (tmp_path / "data" / "studio.sqlite").exists()
    store: DesignStore = app.state.store
    store.database.close()
    assert not (tmp_path / "data" / "studio.sqlite-wal").exists()
    assert ask("GET", address, app=local_app(data=tmp_path / "data")).status_code == 200


@pytest.mark.parametrize("url", ["mysql://x/y", "sqlite://", "sqlite:///", "/tmp/x.sqlite", "postgresql:x"])
def test_other_databases_are_refused_at_the_start(url):
    with pytest.raises(ValueError, match="database_url"):
        Settings(host="127.0.0.1", database_url=url)
    assert "secret" not in repr(Settings(host="127.0.0.1", database_url="postgresql://a:secret@h/d"))
