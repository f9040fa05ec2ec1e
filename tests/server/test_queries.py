"""What nothing reads is told: query parameters that a route does not declare, and settings that are none."""

from __future__ import annotations

import time

import pytest

from models.presets import load_preset
from models.suggestions import suggestion
from server.queries import MOST_TOLD
from server.settings import Settings, unknown_settings
from server.store.records import Content
from tests.server.job_api_support import idle_api
from tests.server.job_support import sweep
from tests.server.support import APP, ask, assert_problem, read_json

OPENAPI = APP.openapi()
OPERATIONS = [
    (method.upper(), path, operation)
    for path, item in OPENAPI["paths"].items()
    for method, operation in item.items()
    if path.startswith("/api/")
]
PYDANTICS_OWN = ("Input should", "String should", "Value error", "valid integer", "valid boolean", "unable to ")


def declared(operation) -> list[str]:
    return sorted(item["name"] for item in operation.get("parameters", ()) if item["in"] == "query")


@pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS, ids=lambda part: str(part)[:60])
def test_every_operation_refuses_what_it_does_not_declare_and_says_what_it_does(method, path, operation):
    assert "422" in operation["responses"]
    problem = assert_problem(ask(method, path, params={"no_such": "1"}), 422, says="query parameter 'no_such'")
    assert problem["title"] == "The request cannot be used as it is"
    known = ", ".join(declared(operation))
    assert (f"known are {known}" if known else "there are none") in problem["detail"]


@pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS, ids=lambda part: str(part)[:60])
def test_what_an_operation_declares_is_not_refused_as_unknown(method, path, operation):
    for name in declared(operation):
        assert "is unknown here" not in ask(method, path, params={name: "1"}).text


def test_a_misspelt_parameter_is_told_with_the_one_that_was_meant():
    problem = assert_problem(ask("GET", "/api/v1/jobs?stats=failed&limit=2"), 422)
    (told,) = problem["errors"]
    assert told["message"] == "query parameter 'stats' is unknown here; known are cursor, kind, limit, search, state"
    assert told["hint"] == "did you mean state?"
    (told,) = assert_problem(ask("GET", "/api/v1/presets?pretty=1"), 422)["errors"]
    assert told["hint"] == "leave it out"


@pytest.mark.parametrize(
    ("query", "message", "hint"),
    [
        ("/jobs?limit=abc", "'limit': a whole number from 1 to 200 is wanted, not 'abc'", "leave it out for 50"),
        ("/jobs?limit=201", "'limit': a whole number from 1 to 200 is wanted, not '201'", "leave it out for 50"),
        ("/designs?deleted=maybe", "'deleted': true or false is wanted, not 'maybe'", "leave it out for false"),
        ("/jobs?kind=sweeep", "'monte_carlo' or 'sensitivity' is wanted, not 'sweeep'", "did you mean sweep?"),
        ("/jobs?search=" + "a" * 201, "'search': text of at most 200 characters is wanted, not 'aaa", "leave it out"),
        ("/designs:export?ids=a/b", "'ids': 'a/b' does not have the form ^[0-9A-Za-z, ]*$",
         "give identifiers, with commas; else all"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_told_with_all_that_would_do(tmp_path, query, message, hint):
    with idle_api(tmp_path) as api:
        problem = assert_problem(ask("GET", f"/api/v1{query}", app=api.app), 422)
    (told,) = problem["errors"]
    assert told["message"].startswith("query parameter '") and message in told["message"]
    assert told["hint"] == hint
    assert problem["detail"] == f"{told['message']} ({hint})"


def test_values_in_addresses_and_headers_are_told_alike(tmp_path):
    with idle_api(tmp_path) as api:
        one = api.jobs.submit(sweep(2))[0].id
        (told,) = assert_problem(api.ask("GET", f"/{one}/cases/x/trajectory"), 422)["errors"]
        assert told["message"].startswith("path parameter 'case': a whole number from 0 to ")
        (told,) = assert_problem(api.ask("POST", "", {}, headers={"Idempotency-Key": ""}), 422)["errors"]
        assert told["message"] == "header parameter 'Idempotency-Key': text of 1 to 255 characters is wanted, not ''"
        assert told["limit"] == 1


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """An application with a job and a design, and how an operation's address leads to them."""
    with idle_api(tmp_path_factory.mktemp("kept")) as api:
        job, stored = api.jobs.submit(sweep(2))[0], api.designs.create(Content(load_preset("three-cell-glider")))
        yield api.app, {"{job_id}": job.id, "{design_id}": stored.id, "{case}": "0", "{number}": "1"}


@pytest.mark.parametrize(("method", "path", "operation"), OPERATIONS, ids=lambda part: str(part)[:60])
def test_no_value_is_answered_in_the_words_of_a_library(kept, method, path, operation):
    app, names = kept
    for placeholder, name in names.items():
        path = path.replace(placeholder, name)
    for name in declared(operation):
        for odd in ("", "x", "-1", "1e400", "%00", "a" * 40_000):
            answer = ask(method, f"{path}?{name}={odd}", app=app)
            assert answer.status_code < 500, answer.text
            assert not any(words in answer.text for words in PYDANTICS_OWN), answer.text


def test_very_many_parameters_are_refused_soon():
    began = time.perf_counter()
    problem = assert_problem(ask("GET", "/api/v1/jobs?" + "&".join(f"s{k}" for k in range(8000))), 422)
    # matched one by one against the names they would take seconds
    assert time.perf_counter() - began < 2.0
    assert len(problem["errors"]) <= MOST_TOLD


def test_probes_take_whatever_a_balancer_adds():
    assert read_json(ask("GET", "/healthz?from=balancer"))["status"] == "ok"


def test_a_suggestion_is_like_what_was_written_in_whichever_case():
    assert suggestion("Stat", ["state", "kind"]) == "did you mean state?"
    assert suggestion("pre", ["max_cases"]) is None


def test_unknown_settings_are_told_and_known_ones_are_not():
    names = [f"GLIDER_STUDIO_{name.upper()}" for name in Settings.model_fields]
    assert list(unknown_settings([*names, "GLIDER_STUDIO_KERNEL_CACHE", "glider_studio_port", "PATH"])) == []
    wrong = ["GLIDER_STUDIO_PROT", "GLIDER_STUDIO_XYZZY"]
    assert list(unknown_settings([*wrong, *names])) == [
        "GLIDER_STUDIO_PROT is no setting, and nothing reads it: did you mean GLIDER_STUDIO_PORT?",
        "GLIDER_STUDIO_XYZZY is no setting, and nothing reads it: unset it",
    ]
