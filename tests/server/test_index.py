"""Where one begins: the index of the API leads somewhere, and the page of operations shows all there are."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from urllib.parse import urljoin

import pytest

from server import openapi
from server.app import create_app
from server.examples import load_examples
from server.operations_page import operations_page
from server.settings import Settings
from server.version import VERSION
from tests.server.job_api_support import idle_api
from tests.server.support import APP, ask, assert_problem, local_app, read_json

OPENAPI = APP.openapi()


class Page(HTMLParser):
    """The elements of a page: names of tags, values of attributes, and what is said."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.tags.append(tag)
        self.ids += [given["id"]] if "id" in given else []
        self.links += [given["href"]] if "href" in given else []

    def handle_data(self, data):
        self.text += data


def test_all_that_the_index_names_is_there(tmp_path):
    with idle_api(tmp_path) as api:
        index = read_json(ask("GET", "/api/v1", app=api.app))
        assert index["version"] == VERSION
        assert {"openapi", "docs", "presets", "designs", "jobs", "schemas/design"} <= set(index["links"])
        for address in index["links"].values():
            assert ask("GET", address, app=api.app).status_code == 200, address


def test_the_page_shows_every_operation_and_asks_nobody_else():
    answer = ask("GET", "/docs")
    assert answer.status_code == 200 and answer.headers["content-type"] == "text/html; charset=utf-8"
    assert "default-src 'none'" in answer.headers["content-security-policy"]
    page = Page(answer.text)
    operations = [operation for item in OPENAPI["paths"].values() for operation in item.values()]
    assert page.ids == [operation["operationId"] for operation in operations]
    for operation in operations:
        assert operation["summary"] in page.text and operation["description"] in page.text
    assert not {"script", "link", "img", "iframe"} & set(page.tags)
    for link in page.links:
        assert ask("GET", urljoin("http://localhost/docs", link).removeprefix("http://localhost")).status_code == 200


def test_the_document_is_built_once_whoever_asks_meanwhile(monkeypatch):
    app, built = local_app(), []
    monkeypatch.setattr(openapi, "load_examples", lambda: built.append(1) or load_examples())
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda _: app.openapi(), range(2))
    assert first is second and built == [1]


def test_the_page_needs_no_token_and_the_index_does():
    app = create_app(Settings(host="127.0.0.1", token="a-token-of-some-length"))
    assert ask("GET", "/docs", app=app).status_code == 200
    assert_problem(ask("GET", "/api/v1", app=app), 401)


@pytest.mark.parametrize("text", ["<script>alert(1)</script>", '"><img src=x>'])
def test_nothing_on_the_page_is_taken_for_markup(text):
    told = {"tags": [text], "summary": text, "description": text, "operationId": text, "responses": {"200": {}}}
    told["parameters"] = [{"name": text, "in": "query", "description": text}]
    told["requestBody"] = {"content": {text: {"example": text}}}
    document = {"info": {"title": text, "version": text, "description": text}, "paths": {f"/{text}": {"get": told}}}
    page = Page(operations_page(document))
    assert not {"script", "img"} & set(page.tags)
