"""The pages of jobs as they are sent: strict about scripts and styles, and the chart library sent once."""

from __future__ import annotations

import re
from importlib.resources import files

import pytest

from tests.studio.conftest import Studio

LIBRARY = "/vendor/plotly.min.js"


@pytest.mark.parametrize("path", ["/jobs", "/jobs/01hzzzzzzzzzzzzzzzzzzzzzzz", "/jobs/no%20such"])
def test_the_pages_allow_own_scripts_and_styles_alone(studio: Studio, path: str) -> None:
    with studio.client as client:
        answer = client.get(path)
    policy = answer.headers["content-security-policy"]
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    assert "script-src 'self'; style-src 'self'; " in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert not re.search(r"<script(?![^>]*src=)|<style| style=|\son\w+=", answer.text)


@pytest.mark.parametrize(("path", "base"), [("/jobs", "/"), ("/jobs/some", "/")])
def test_everything_that_the_pages_load_is_there(studio: Studio, path: str, base: str) -> None:
    with studio.client as client:
        for address in re.findall(r'(?:src|href)="([^"#]+\.(?:js|css|svg))"', client.get(path).text):
            assert client.get(base + address.removeprefix("../")).status_code == 200, address


def test_modules_import_files_that_exist() -> None:
    static = files("static")
    for module in (m for m in static.iterdir() if m.name.endswith(".js")):
        for name in re.findall(r'from "\./([^"]+)"', module.read_text()):
            assert static.joinpath(name).is_file(), f"{module.name} imports {name}"


def test_the_chart_library_is_sent_once_and_compressed(studio: Studio) -> None:
    with studio.client as client:
        zipped = client.get(LIBRARY, headers={"Accept-Encoding": "gzip, deflate"})
        plain = client.get(LIBRARY, headers={"Accept-Encoding": "identity"})
        again = client.get(LIBRARY, headers={"If-None-Match": zipped.headers["etag"]})
        other = client.get(LIBRARY, headers={"If-None-Match": '"of another version"'})
    assert zipped.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in plain.headers
    assert zipped.content == plain.content
    assert plain.text.lstrip().startswith("/**\n* plotly.js v")
    assert int(zipped.headers["content-length"]) < len(plain.content) / 2
    assert "max-age=604800" in zipped.headers["cache-control"]
    assert zipped.headers["vary"] == "Accept-Encoding"
    assert (again.status_code, again.content) == (304, b"")
    assert other.status_code == 200
