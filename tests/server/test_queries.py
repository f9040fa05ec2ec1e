"""What nothing reads is told: query parameters that a route does not declare, and settings that are none."""

from __future__ import annotations

import time

import pytest

from models.suggestions import suggestion
from server.queries import MOST_TOLD
from server.settings import Settings, unknown_settings
from tests.server.support import APP, ask, assert_problem, read_json

OPENAPI = APP.openapi()
OPERATIONS = [
    (method.upper(), path, operation)
    for path, item in OPENAPI["paths"].items()
    for method, operation in item.items()
    if path.startswith("/api/")
]


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
