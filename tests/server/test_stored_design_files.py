"""Designs as files over HTTP: out and in again, one by one and in archives; and their thumbnails."""

from __future__ import annotations

import io
import json
import zipfile

import pytest

from models.design import loads_design, parse_design
from models.presets import load_preset
from server.app import create_app
from server.settings import Settings
from server.store.records import Content
from server.store.thumbnails import LARGEST_THUMBNAIL
from tests.server.support import ask, assert_problem, local_app, preset, read_json

ALL = "/api/v1/designs"
ZIP = {"content-type": "application/zip"}
SVG = {"content-type": "image/svg+xml; charset=utf-8"}
PICTURE = b'<svg xmlns="http://www.w3.org/2000/svg"><rect width="3" height="4"/></svg>'


@pytest.fixture
def api(store):
    app = local_app()
    app.state.store = store
    return lambda method, path, document=None, **options: ask(method, path, document, app=app, **options)


def create(api, name, *tags):
    return read_json(api("POST", ALL, {"design": preset() | {"name": name}, "tags": list(tags)}))["id"]


def zipped(**files):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return file.getvalue()


def test_a_design_is_exported_as_the_file_that_is_opened_everywhere(api):
    design_id = create(api, 'A "glider"\\ / ü')
    answer = api("GET", f"{ALL}/{design_id}:export")
    assert answer.headers["content-type"] == "application/json"
    assert answer.headers["content-disposition"] == f'attachment; filename="a-glider-{design_id}.json"'
    assert loads_design(answer.content) == loads_design(json.dumps(preset() | {"name": 'A "glider"\\ / ü'}))


def test_archives_go_out_and_in_again(api):
    ids = [create(api, f"Glider {n}", f"t{n % 2}") for n in range(5)]
    answer = api("GET", f"{ALL}:export", params={"ids": f"{ids[0]}, {ids[3]},{ids[0]}"})
    assert (answer.headers["content-type"], answer.status_code) == ("application/zip", 200)
    assert answer.headers["content-disposition"] == 'attachment; filename="designs.zip"'
    report = read_json(api("POST", f"{ALL}:import", content=answer.content, headers=ZIP))
    assert (report["imported"], report["refused"]) == (2, 0)
    for item, old in zip(report["items"], (ids[0], ids[3]), strict=True):
        new, before = (read_json(api("GET", f"{ALL}/{i}")) for i in (item["id"], old))
        assert new["id"] != before["id"] and new["comment"] == f"Imported from {item['entry']}"
        same = ("name", "notes", "tags", "identity", "design")
        assert [new[key] for key in same] == [before[key] for key in same]
    by_tag = api("GET", f"{ALL}:export", params={"tag": "t0"})
    assert len(zipfile.ZipFile(io.BytesIO(by_tag.content)).namelist()) == 3 + 1 + 1
    everything = api("GET", f"{ALL}:export")
    assert len(zipfile.ZipFile(io.BytesIO(everything.content)).namelist()) == 7 + 1


def test_an_export_is_never_more_than_an_import_takes_back(store, monkeypatch):
    """Zips may be larger than other bodies, up to what an archive may hold; the quota of bytes counts them as any."""
    monkeypatch.setattr("server.middleware.LARGEST_FILE", 60_000)
    app = create_app(Settings(host="127.0.0.1", max_body_bytes=16_000, token="a-token-of-some-length"))
    app.state.store = store
    headers = ZIP | {"authorization": "Bearer a-token-of-some-length"}
    spent = []
    monkeypatch.setattr(app.state.quotas, "spend_bytes", lambda principal, count: spent.append(count))
    for n in range(12):
        store.create(Content(parse_design(preset() | {"name": f"Glider {n}"}), ()))
    archive = ask("GET", f"{ALL}:export", app=app, headers=headers).content
    assert 16_000 < len(archive) < 60_000
    report = read_json(ask("POST", f"{ALL}:import", app=app, content=archive, headers=headers))
    assert (report["imported"], report["refused"]) == (12, 0) and sum(spent) == len(archive)
    padded = archive + b" " * 60_000
    answer = ask("POST", f"{ALL}:import", app=app, content=padded, headers=headers)
    assert_problem(answer, 413, says="limit of 60000 bytes")
    as_json = headers | {"content-type": "application/json"}
    assert_problem(ask("POST", f"{ALL}:import", app=app, content=archive, headers=as_json), 413, says="of 16000 bytes")
    assert_problem(ask("POST", ALL, app=app, content=archive, headers=headers), 413, says="limit of 16000 bytes")


def test_exports_of_what_is_not_there(api):
    gone = create(api, "Gone")
    assert api("DELETE", f"{ALL}/{gone}").status_code == 204
    assert_problem(api("GET", f"{ALL}:export", params={"ids": gone}), 410)
    assert_problem(api("GET", f"{ALL}:export", params={"ids": "none"}), 404)
    many = ",".join(f"{n:026d}" for n in range(1001))
    assert_problem(api("GET", f"{ALL}:export", params={"ids": many}), 422, says="more than 1000 designs")
    assert zipfile.ZipFile(io.BytesIO(api("GET", f"{ALL}:export").content)).namelist() == ["manifest.json"]


def test_one_document_is_imported(api):
    report = read_json(api("POST", f"{ALL}:import", preset()))
    (item,) = report["items"]
    assert (report["imported"], item["entry"], item["name"], item["problem"]) == (1, "", preset()["name"], None)
    assert read_json(api("GET", f"{ALL}/{item['id']}"))["design"] == preset()
    assert_problem(api("POST", f"{ALL}:import", preset() | {"name": ""}), 422, pointer="/name")
    assert_problem(api("POST", f"{ALL}:import", b"{"), 400)


def test_what_is_wrong_in_an_archive_stops_nothing_else(api):
    manifest = {"format": "glider-designs", "items": [{"file": "tagged.json", "tags": ["x", ""]}]}
    files = {
        "good.json": load_preset("seawing-spiral").to_json(), "folder/README.txt": "Hello", "empty.json": "",
        "wrong.json": json.dumps(preset() | {"name": ""}), "newer.json": json.dumps(preset() | {"version": 2}),
        "twice.json": '{"a": 1, "a": 2}', "tagged.json": json.dumps(preset()), "also good.json": json.dumps(preset()),
        "manifest.json": json.dumps(manifest),
    }  # fmt: skip
    report = read_json(api("POST", f"{ALL}:import", content=zipped(**files), headers=ZIP))
    assert (report["imported"], report["refused"]) == (2, 6)
    items = {item["entry"]: item for item in report["items"]}
    assert set(items) == set(files) - {"manifest.json"}
    assert items["good.json"]["id"] and items["also good.json"]["id"]
    said = {"folder/README.txt": "not JSON", "empty.json": "empty", "wrong.json": "/name", "newer.json": "newer",
            "twice.json": "twice", "tagged.json": "the manifest's tags"}  # fmt: skip
    for name, says in said.items():
        assert items[name]["id"] is None and says in json.dumps(items[name]["problem"]), name
    assert len(read_json(api("GET", ALL))["items"]) == 2


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "no zip file"),
        (b"{}", "no zip file"),
        (zipped(**{"../x.json": "{}"}), "a path that leads elsewhere"),
        (zipped(**{"x.zip": "{}"}), "itself an archive"),
        (zipped(**{"x.json": " " * 5_000_000}), "more than 4194304 bytes unpacked"),
    ],
)
def test_archives_that_may_do_harm_are_refused_whole(api, content, says):
    assert_problem(api("POST", f"{ALL}:import", content=content, headers=ZIP), 422, says=says)
    assert read_json(api("GET", ALL))["items"] == []


@pytest.mark.parametrize("kind", ["text/plain", "multipart/form-data", "application/x-zip", ""])
def test_other_kinds_of_files_are_415(api, kind):
    assert_problem(api("POST", f"{ALL}:import", content=b"{}", headers={"content-type": kind}), 415)
    design_id = create(api, "A")
    answer = api("PUT", f"{ALL}/{design_id}/thumbnail", content=PICTURE, headers={"content-type": kind})
    assert_problem(answer, 415, says="image/png or image/svg+xml")


def test_thumbnails_are_kept_and_can_only_draw(api):
    address = f"{ALL}/{create(api, 'A')}/thumbnail"
    assert_problem(api("GET", address), 404, says="has no thumbnail")
    put = api("PUT", address, content=PICTURE, headers=SVG)
    assert (put.status_code, put.content) == (204, b"")
    got = api("GET", address)
    assert (got.content, got.headers["etag"]) == (PICTURE, put.headers["etag"])
    assert got.headers["content-type"].startswith("image/svg+xml")
    assert got.headers["content-security-policy"].startswith("default-src 'none';")
    assert "sandbox" in got.headers["content-security-policy"] and got.headers["x-content-type-options"] == "nosniff"
    assert api("GET", address, headers={"If-None-Match": put.headers["etag"]}).status_code == 304
    (item,) = read_json(api("GET", ALL))["items"]
    assert f'"{item["thumbnail"]}"' == put.headers["etag"] and item["revision"] == 1


def test_thumbnails_that_are_none_are_refused(api):
    address = f"{ALL}/{create(api, 'A')}/thumbnail"
    script = PICTURE.replace(b"<rect", b"<script/><rect")
    assert_problem(api("PUT", address, content=script, headers=SVG), 422, says="may do more than draw")
    large = PICTURE + b" " * LARGEST_THUMBNAIL
    assert_problem(api("PUT", address, content=large, headers=SVG), 413, says=f"limit of {LARGEST_THUMBNAIL} bytes")
    answer = api("PUT", address, content=b" " * 5_000_000, headers=SVG)
    assert_problem(answer, 413, says="limit of 4194304 bytes")
    nobody = f"{ALL}/{'0' * 26}/thumbnail"
    assert_problem(api("PUT", nobody, content=PICTURE, headers=SVG), 404)
    assert_problem(api("GET", address), 404)
