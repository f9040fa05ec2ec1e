"""Pages announce the modules that their scripts import, all of them, and nothing that is not there."""

from __future__ import annotations

import re
from contextlib import closing
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urljoin

import pytest

from studio.page_files import STATIC, file_page, imported_by, release_of_files
from tests.studio.conftest import Studio

PAGES = {"studio.html": "main.js", "index.html": "index.js", "jobs.html": "jobs.js", "job.html": "job.js"}


class Links(HTMLParser):
    """The addresses of a page's announced modules, and of its module script."""

    def __init__(self) -> None:
        super().__init__()
        self.announced: list[str] = []
        self.script = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "link" and given.get("rel") == "modulepreload":
            self.announced.append(given["href"] or "")
        if tag == "script" and given.get("type") == "module":
            self.script = given["src"] or ""


def links_of(page: str) -> Links:
    found = Links()
    found.feed(page)
    return found


def reached(script: str) -> set[str]:
    """Return every file that is named by some module from `script` on, by any text that looks like a neighbour."""
    found: set[str] = set()
    waiting = {script}
    while waiting:
        name = waiting.pop()
        found.add(name)
        named = re.findall(r'"\./([\w.-]+\.js)"', (STATIC / name).read_text(encoding="utf-8"))
        waiting |= set(named) - found
    return found - {script}


@pytest.mark.parametrize(("page", "script"), PAGES.items())
def test_a_page_announces_each_module_once(page: str, script: str) -> None:
    links = links_of(bytes(file_page(page, {}).body).decode())
    names = [Path(address).name for address in links.announced]
    assert Path(links.script).name == script
    assert len(names) == len(set(names)) and set(names) == reached(script)
    assert names == imported_by(script)


def test_what_is_announced_is_there(studio: Studio) -> None:
    client, _ = studio.open()
    with closing(client):
        links = links_of(client.get("").text)
        for address in (links.announced[0], links.announced[-1], links.script):
            answer = client.get(urljoin(str(client.base_url), address))
            assert answer.status_code == 200 and "javascript" in answer.headers["content-type"]


def test_a_file_that_is_known_is_not_sent_again(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.css").write_text("a {}")
    monkeypatch.setattr("studio.page_files.STATIC", tmp_path)
    with studio.client as client:
        first = client.get("/static/a.css")
        assert first.text == "a {}" and first.headers["content-type"].startswith("text/css")
        again = client.get("/static/a.css", headers={"If-None-Match": first.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
        (tmp_path / "a.css").write_text("b {}")
        changed = client.get("/static/a.css", headers={"If-None-Match": first.headers["etag"]})
        assert (changed.status_code, changed.text) == (200, "b {}")


def test_a_module_that_changes_changes_what_is_announced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studio.page_files.STATIC", tmp_path)
    (tmp_path / "index.html").write_text('<script type="module" src="static/a.js"></script>')
    (tmp_path / "a.js").write_text('import { b } from "./b.js";\n')
    (tmp_path / "b.js").write_text("export const b = 1;\n")
    before = release_of_files()
    assert links_of(bytes(file_page("index.html", {}).body).decode()).announced == [f"static/{before}/b.js"]
    (tmp_path / "c.js").write_text('import "./b.js";\n')
    (tmp_path / "b.js").write_text('export {\n  c,\n} from "./c.js";\n')
    now = release_of_files()
    assert now != before
    announced = links_of(bytes(file_page("index.html", {}).body).decode()).announced
    assert announced == [f"static/{now}/b.js", f"static/{now}/c.js"]


def test_what_a_page_names_is_kept_for_good_until_a_file_changes(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.css").write_text("a {}")
    (tmp_path / "index.html").write_text('<link rel="stylesheet" href="static/a.css">')
    monkeypatch.setattr("studio.page_files.STATIC", tmp_path)
    with studio.client as client:
        first = release_of_files()
        assert f'href="static/{first}/a.css"' in client.get("/").text
        assert "immutable" in client.get(f"/static/{first}/a.css").headers["cache-control"]
        assert client.get("/static/a.css").headers["cache-control"] == "no-cache"
        (tmp_path / "a.css").write_text("b {}")
        late = client.get(f"/static/{first}/a.css")
        assert (late.text, late.headers["cache-control"]) == ("b {}", "no-cache"), (
            "an old page gets it, and keeps nothing"
        )
        assert f'href="static/{release_of_files()}/a.css"' in client.get("/").text
        assert client.get(f"/static/{first}/none.css").status_code == 404
