"""Presets, the schema, sessions and the worked examples of the OpenAPI document."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from models.design import Design
from models.presets import load_preset, preset_ids
from server.examples import load_examples
from server.examples.build import DemoSession, build, demo_app, example_design
from server.summaries import LONGEST_SUMMARY, summarize
from tests.server.support import (
    EDIT,
    PREVIEW,
    SESSION,
    VALIDATE,
    ask,
    assert_problem,
    local_app,
    preset,
    read_json,
)

OPENAPI = read_json(ask("GET", "/api/v1/openapi.json"))
OPERATIONS = [
    (method.upper(), path, operation) for path, item in OPENAPI["paths"].items() for method, operation in item.items()
]
IDS = [operation["operationId"] for _, _, operation in OPERATIONS]
BODILESS = {"restore_design", "cancel_job", "retry_job", "resume_job"}
"""What is done to a thing and needs no more than its name."""
CHANGES = {"elapsed", "version", "kernel", "processors", "checksum"}
"""What a machine or an installation decides."""


def test_presets_are_listed_and_answered():
    items = read_json(ask("GET", "/api/v1/presets"))["items"]
    assert [item["id"] for item in items] == list(preset_ids())
    for item in items:
        design = load_preset(item["id"])
        assert item["name"] == design.name
        assert 0 < len(item["summary"]) <= LONGEST_SUMMARY
        assert design.notes.startswith(item["summary"].rstrip("…"))
        assert read_json(ask("GET", f"/api/v1/presets/{item['id']}")) == design.model_dump(mode="json")


@pytest.mark.parametrize(
    ("notes", "summary"),
    [
        ("", ""),
        ("One. Two.", "One. Two."),
        ("By L. Canete and J. Paquibot. " + "Long " * 50 + ".", "By L. Canete and J. Paquibot."),
        ("word " * 100, ("word " * 43).strip() + "…"),
        ("x" * 300, "x" * 219 + "…"),
    ],
)
def test_summaries_end_at_sentences_or_words(notes, summary):
    assert summarize(notes) == summary


def test_the_schema_is_the_models_own():
    schema = read_json(ask("GET", "/api/v1/schemas/design"))
    assert schema.pop("$schema").startswith("https://json-schema.org/")
    assert schema == Design.model_json_schema()


def test_valid_designs_have_an_identity_that_is_their_own():
    design = load_preset("three-cell-glider")
    for sent in (preset(), {"design": preset()}, {"design": preset(), "options": {}}):
        answer = read_json(ask("POST", VALIDATE, sent))
        assert answer == {"valid": True, "identity": design.identity, "warnings": []}


def test_warnings_are_told():
    design = preset()
    design["mission"]["duration"] = 30.0
    warnings = read_json(ask("POST", VALIDATE, design))["warnings"]
    assert "points after the mission's end" in warnings[0]["message"]


def test_a_newer_document_is_refused_politely():
    assert_problem(ask("POST", VALIDATE, preset() | {"version": 2}), 422, pointer="/version", says="newer")


@pytest.mark.parametrize(
    ("patch", "pointer"),
    [
        ([{"op": "remove", "path": f"/{name}"} for name in preset()], "/design/format"),
        ([{"op": "remove", "path": ""}], "/patch/0/path"),
        ([{"op": "remove", "path": "/vehicle/components/4"}], "/design/mission/control/schedules/0/cell"),
        ([{"op": "remove", "path": "/x"}] * 1001, "/patch"),
        ({"op": "remove"}, "/patch"),
    ],
)
def test_edits_that_leave_no_glider_are_refused(patch, pointer):
    assert_problem(ask("POST", EDIT, {"design": preset(), "patch": patch}), 422, pointer=pointer)


def test_an_edit_needs_a_patch():
    assert_problem(ask("POST", EDIT, preset()), 422, pointer="/patch")


class OneSession:
    """A studio with one open session that keeps its edits."""

    def __init__(self):
        self.session = DemoSession(load_preset("three-cell-glider"))

    def get(self, session_id):
        return self.session if session_id == "demo" else None


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize("kind", ["application/json", "application/json-patch+json"])
def test_an_open_session_is_read_and_edited(wrapped, kind):
    app = local_app()
    app.state.live = OneSession()
    assert read_json(ask("GET", SESSION, app=app)) == preset()
    patch = [{"op": "replace", "path": "/name", "value": "Renamed"}]
    sent = {"patch": patch} if wrapped else patch
    answer = read_json(ask("PATCH", SESSION, sent, app=app, headers={"content-type": kind}))
    assert answer["design"] == preset() | {"name": "Renamed"}
    assert answer["mass_properties"]["mass"] > 0.0 and answer["warnings"] == []
    assert read_json(ask("GET", SESSION, app=app))["name"] == "Renamed"


@pytest.mark.parametrize(
    ("sent", "pointer"),
    [
        ({}, "/patch"),
        ({"patch": [], "pach": []}, "/pach"),
        ([{"op": "remove", "path": "/x"}], "/patch/0/path"),
        ([{"op": "replace", "path": "/name", "value": ""}], "/name"),
    ],
)
def test_a_wrong_edit_leaves_the_session_as_it_was(sent, pointer):
    app = local_app()
    app.state.live = OneSession()
    assert_problem(ask("PATCH", SESSION, sent, app=app), 422, pointer=pointer)
    assert read_json(ask("GET", SESSION, app=app)) == preset()


def test_health_says_whether_the_kernel_is_ready(monkeypatch):
    assert ask("GET", "/healthz").json()["kernel"] == "ready"
    monkeypatch.setattr("server.routes.health.kernel_is_ready", lambda: False)
    assert ask("GET", "/healthz").json() | {"version": ""} == {"status": "ok", "kernel": "compiling", "version": ""}


@pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS, ids=IDS)
def test_operations_are_documented(method, path, operation):
    assert operation["summary"] and operation["description"] and operation["tags"]
    bodiless = operation["operationId"] in BODILESS
    assert ("requestBody" in operation) == (method in {"POST", "PUT", "PATCH"} and not bodiless)
    (done,) = (item for status, item in operation["responses"].items() if status.startswith("2"))
    for media, content in done.get("content", {}).items():
        assert content["itemSchema" if media == "text/event-stream" else "schema"]
        assert "example" in content or media != "application/json"
    failures = {status: item for status, item in operation["responses"].items() if status.startswith(("4", "5"))}
    assert {"401", "405", "500"} <= set(failures)
    if "requestBody" in operation:
        assert {"400", "413", "415", "422"} <= set(failures)
    for item in failures.values():
        schema = item["content"]["application/problem+json"]["schema"]
        assert item["description"] and schema == {"$ref": "#/components/schemas/ProblemDocument"}


@pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS, ids=IDS)
def test_examples_work(method, path, operation):
    """Every worked example, as the OpenAPI document shows it, is answered as it says."""
    given: dict[str, dict[str, Any]] = {"path": {}, "query": {}, "header": {}}
    for parameter in operation.get("parameters", ()):
        if "example" in parameter:
            given[parameter["in"]][parameter["name"]] = parameter["example"]
    bodies = operation.get("requestBody", {}).get("content", {})
    media, body = next(((m, b["example"]) for m, b in bodies.items() if "example" in b), (None, None))
    sent = {"content": body if isinstance(body, str) else json.dumps(body)} if media is not None else {}
    headers = given["header"] | ({"content-type": media} if media is not None else {})
    with demo_app() as app:
        answer = ask(method, path.format(**given["path"]), app=app, params=given["query"], headers=headers, **sent)
    (status,) = (status for status in operation["responses"] if status.startswith("2"))
    assert answer.status_code == int(status), answer.text
    content = operation["responses"][status].get("content")
    if content is None:
        assert not answer.content
    elif "application/json" in content:
        assert_shows(content["application/json"]["example"], read_json(answer))
    else:
        assert answer.headers["content-type"].partition(";")[0] in content


def assert_shows(example: Any, answer: Any, pointer: str = "") -> None:
    """Check that what an example shows is in the answer."""
    if isinstance(example, dict):
        assert set(example) <= set(answer), pointer
        for name in set(example) - CHANGES:
            assert_shows(example[name], answer[name], f"{pointer}/{name}")
    elif isinstance(example, list):
        assert len(example) == len(answer), pointer
        for i, (shown, given) in enumerate(zip(example, answer, strict=True)):
            assert_shows(shown, given, f"{pointer}/{i}")
    elif isinstance(example, float):
        # processors round apart; residuals of the balance are made of rounding, J
        assert answer == pytest.approx(example, rel=1e-6, abs=1e-9), pointer
    else:
        assert answer == example, pointer


def test_the_committed_examples_are_those_the_program_makes():
    made, committed = asyncio.run(build()), load_examples()
    assert set(made) == set(committed) == set(IDS)
    for name, example in committed.items():
        assert example.get("request") == made[name].get("request"), name
        assert ("response" in example) == ("response" in made[name]), name
        if "response" in example:
            assert_shows(example["response"], made[name]["response"], name)
            assert_shows(made[name]["response"], example["response"], name)


def test_references_in_the_openapi_document_resolve():
    def walk(node: Any) -> None:
        if isinstance(node, dict):
            if isinstance(node.get("$ref"), str):
                assert node["$ref"].rpartition("/")[2] in OPENAPI["components"]["schemas"], node["$ref"]
            for child in node.values():
                walk(child)
        elif isinstance(node, list):
            for child in node:
                walk(child)

    walk(OPENAPI)
    assert "HTTPValidationError" not in OPENAPI["components"]["schemas"]


def test_the_example_is_small():
    assert len(example_design().model_dump_json()) < 6000
    assert read_json(ask("POST", PREVIEW, load_examples()["preview_simulation"]["request"]))["status"] == "completed"
