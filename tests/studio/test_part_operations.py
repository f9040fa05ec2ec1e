"""The HTTP of the left panel: each change answers the new revision, each refusal names the member and the way out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import httpx
import pytest

from models.design import Design
from studio.part_kinds import NAMES
from tests.studio.conftest import Studio


@pytest.fixture
def browser(studio: Studio) -> Iterator[httpx.Client]:
    client, _ = studio.open()
    with closing(client):
        client.headers["Origin"] = studio.url
        yield client


def names(browser: httpx.Client) -> list[str]:
    return [row["name"] for row in browser.get("state").json()["components"]]


def test_each_change_answers_what_is_selected_then(browser: httpx.Client) -> None:
    before = browser.get("state").json()["revision"]
    assert browser.post("parts", json={"kind": "piston"}).json() == {"revision": before + 1, "selected": 3}
    assert browser.post("parts/3/copy", json={}).json() == {"revision": before + 2, "selected": 4}
    assert browser.post("parts/4/move", json={"to": 0}).json() == {"revision": before + 3, "selected": 0}
    assert names(browser) == ["Piston 2", "Body", "Front bellows", "Rear bellows", "Piston"]
    assert browser.delete("parts/0").json()["revision"] == before + 4
    assert browser.post("parts/1/marks", json={"locked": True}).json()["revision"] == before + 4
    rows = browser.get("state").json()["components"]
    assert [row["locked"] for row in rows] == [False, True, False, False]


@pytest.mark.parametrize(
    ("address", "body", "pointer", "words"),
    [
        ("parts", {"kind": "sail"}, "/kind", ", ".join(NAMES)),
        ("parts", {}, "/kind", "is missing"),
        ("parts/0/mirror", {"schedule": "other"}, "/schedule", "same, opposite"),
        ("parts/0/mirror", {"schedule": None}, "/mission/solver/model", "choose the spatial model first"),
        ("parts/9/copy", {}, "/vehicle/components/9", "no such component"),
        ("parts/0/move", {"to": "up"}, "/to", "index"),
        ("parts/0/move", {"to": 9}, "/vehicle/components/9", "no such component"),
        ("parts/0/marks", {"locked": "yes"}, "", "locked and hidden"),
        ("parts/0/marks", {"seen": True}, "", "locked and hidden"),
        ("mass-properties", {"kind": "guessed"}, "/kind", "composite, declared"),
    ],
)
def test_each_refusal_says_what_would_do(
    browser: httpx.Client, address: str, body: dict[str, Any], pointer: str, words: str
) -> None:
    before = browser.get("design.json").json()
    answer = browser.post(address, json=body)
    assert answer.status_code == 422
    assert answer.headers["content-type"].startswith("application/problem+json")
    (error,) = answer.json()["errors"]
    assert error["pointer"] == pointer
    assert words in f"{error['message']} {error['hint']}"
    assert browser.get("design.json").json() == before


def test_mass_is_declared_as_the_parts_amount_to(browser: httpx.Client) -> None:
    browser.post("mass-properties", json={"kind": "composite"})
    facts = browser.get("fields").json()["facts"]["mass"]
    browser.post("mass-properties", json={"kind": "declared"})
    declared = browser.get("design.json").json()["vehicle"]["mass_properties"]
    assert declared["mass"] == facts["mass"]
    assert declared["center_of_mass"] == facts["center_of_mass"]
    assert [declared["inertia"][axis] for axis in ("xx", "yy", "zz")] == facts["inertia"]
    assert browser.get("fields").json()["facts"]["mass"]["mass"] == facts["mass"]


def test_the_fields_are_the_document_but_for_its_long_columns(browser: httpx.Client) -> None:
    fields, document = browser.get("fields").json(), browser.get("design.json").json()
    assert fields["revision"] == browser.get("state").json()["revision"]
    source, whole = fields["design"]["vehicle"].pop("hydrodynamics"), document["vehicle"].pop("hydrodynamics")
    assert fields["design"] == document
    rows = len(whole["row_lift"])
    assert rows > 40 and source["row_lift"] == {"entries": rows}
    assert source["provenance"] == whole["provenance"]


def test_the_schema_is_the_design_s_and_sent_once(browser: httpx.Client) -> None:
    answer = browser.get("schema")
    schema, whole = answer.json(), Design.model_json_schema()
    assert schema["$defs"].keys() == whole["$defs"].keys()
    for name, definition in whole["$defs"].items():
        fields = schema["$defs"][name]["properties"]
        assert fields.keys() == definition["properties"].keys()
        for field, told in definition["properties"].items():
            assert fields[field].get("unit") == told.get("unit")
            assert fields[field].get("description") == told.get("description")
    again = browser.get("schema", headers={"If-None-Match": answer.headers["etag"]})
    assert again.status_code == 304 and not again.content
