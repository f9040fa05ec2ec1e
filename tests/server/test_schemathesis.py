"""The whole API is as its OpenAPI document says: whatever is sent, no 5xx, no undocumented status, type or shape.

Three kinds of requests to a server with a store, jobs and a session: those that schemathesis makes from the document,
bodies that were right until a value in them was spoilt, and names, queries and headers that no client should send.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest
import requests
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.examples.build import example_requests
from server.store.database import sqlite_url
from tests.server.database import Postgres
from tests.server.job_support import POSITION, glider
from tests.server.whole_api import CHECKS, EXAMPLES, FROM_A_SCHEMA, WholeApi, described, document, operations, whole_api

DOCUMENT = document()
SCHEMA = described(DOCUMENT)
OPERATIONS = operations(DOCUMENT)
LONGEST = 60.0
"""Longest that an answer may take, s: many times what the slowest machine needs."""
REPEATED = settings(
    max_examples=EXAMPLES, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
SPOILT = 25
"""Spoilt bodies an operation."""


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WholeApi]:
    folder = tmp_path_factory.mktemp("api")
    with whole_api(folder, sqlite_url(folder / "studio.sqlite")) as api:
        yield api


@pytest.fixture(scope="module")
def on_postgresql(tmp_path_factory: pytest.TempPathFactory, postgres: Postgres) -> Iterator[WholeApi]:
    """The same on a database that is stricter with text."""
    with whole_api(tmp_path_factory.mktemp("api"), postgres.emptied()) as api:
        yield api


@SCHEMA.parametrize()
@REPEATED
def test_answers_are_as_documented(case, api):
    api.point_at_what_is_there(case)
    case.call_and_validate(base_url=api.url, session=api.session, checks=FROM_A_SCHEMA, timeout=LONGEST)


# bodies


def batches() -> list[dict[str, Any]]:
    """Return a batch document of each kind, few cases each."""
    place = {"pointer": POSITION, "name": "place", "low": 0.1, "high": 0.3}
    mirrored = place | {"also": [{"pointer": "/vehicle/components/2/position/0", "factor": -1.0}]}
    mass = {"pointer": "/vehicle/components/0/mass", "name": "mass"}
    drawn = [
        mass | {"distribution": {"kind": "truncated_normal", "mean": 0.7, "sd": 0.01, "low": 0.68, "high": 0.72}},
        {"pointer": POSITION, "name": "place", "distribution": {"kind": "uniform", "low": 0.1, "high": 0.2}},
    ]
    methods: list[dict[str, Any]] = [
        {"kind": "full_factorial", "parameters": [mirrored | {"count": 2}, mass | {"values": [0.7, 0.71]}]},
        {"kind": "latin_hypercube", "parameters": [place], "count": 3},
        {"kind": "sobol", "parameters": [place], "count": 4},
        {"kind": "cases", "parameters": [mass, {"pointer": "/name"}], "rows": [[0.7, "a"], [0.71, "b"]]},
    ]
    stop = {"metric": "range", "width": 0.5, "least": 4, "every": 2}
    correlated = [{"between": ["mass", "place"], "value": 0.6}]
    several: list[dict[str, Any]] = [
        {"kind": "simulate"},
        *({"kind": "sweep", "method": method} for method in methods),
        {"kind": "monte_carlo", "parameters": drawn, "count": 6, "stop": stop, "correlations": correlated},
        {"kind": "sensitivity", "parameters": [place], "method": {"kind": "sobol", "base": 8, "second_order": True}},
        {"kind": "sensitivity", "parameters": [place], "method": {"kind": "morris", "trajectories": 2}},
    ]
    shared = {
        "format": "glider-batch",
        "version": 1,
        "design": glider(),
        "metrics": ["range", "glide_ratio"],
        "seed": 1,
    }
    return [shared | {"trajectories": [0]} | batch for batch in several]


def patches(part: dict[str, Any]) -> list[Any]:
    """Return patches of the example's design."""
    at = "/vehicle/components/0"
    return [
        [{"op": "replace", "path": "/mission/duration", "value": 20.0}, {"op": "test", "path": "/name", "value": "x"}],
        [{"op": "add", "path": "/vehicle/components/-", "value": part}, {"op": "remove", "path": "/notes"}],
        [
            {"op": "move", "from": at, "path": "/vehicle/components/1"},
            {"op": "copy", "from": "/name", "path": "/notes"},
        ],
    ]


def right_bodies() -> dict[str, list[Any]]:
    """Return bodies that are right, by operation: the worked examples and more."""
    examples = example_requests()
    bodies = {name: [example["request"]] for name, example in examples.items() if "request" in example}
    del bodies["set_thumbnail"]  # no JSON
    design, part = bodies["trim_ballast"][0]["design"], bodies["add_component"][0]
    several = patches(part)
    bodies["create_job"] += batches()
    bodies["edit_session_design"] += several
    bodies["change_design"] += [*several, {"patch": several[1], "notes": "Changed", "tags": ["a", "b"]}]
    bodies["edit_design"] += [{"design": design, "patch": patch} for patch in several]
    bodies["add_component"] += design["vehicle"]["components"]
    bodies["change_component"] += [{"mass": 0.03, "position": [0.1, 0.0, 0.0], "extension_range": [0.0, 0.02]}]
    bodies["analyze_trim"] += [{"design": design, "options": {"search": {"angle_step": 0.2, "banks": [0.1]}}}]
    bodies["design_controller"] += [{"design": design, "options": {"kind": "cascade"}}]
    return bodies


BODIES = right_bodies()
ODD_VALUES: tuple[Any, ...] = (
    None, True, 0, -1, 2**31, 2**63, 10**30, 10**400, 1.5, 5e-324, 1e-12, 1e12, 1e308, -1e308, float("nan"),
    float("inf"), "", "\x00", "\ud800", "\U0010ffff", "~2", "/", "../..", "x" * 10_000, "case", "theta", [], {}, [[]],
    {"": None}, [0] * 300,
)  # fmt: skip
FACTORS = (0.0, -1.0, 1e-12, 1e-3, 0.5, 1.0000001, 2.0, 1e3, 1e6)


def places(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value below a node."""
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for name, child in children:
        yield (*path, name)
        yield from places(child, (*path, name))


def parent_of(node: Any, path: tuple[Any, ...]) -> Any:
    for name in path[:-1]:
        node = node[name]
    return node


@st.composite
def spoilt(draw: st.DrawFn, right: list[Any]) -> Any:
    """A right body with one to three values changed, left out, doubled, or put where another is expected."""
    body = copy.deepcopy(draw(st.sampled_from(right)))
    for _ in range(draw(st.integers(1, 3))):
        known = list(places(body))
        if not known:
            break
        path = draw(st.sampled_from(known))
        parent, name = parent_of(body, path), path[-1]
        old, deed = (
            parent[name],
            draw(st.sampled_from(("scale", "scale", "replace", "replace", "remove", "double", "move"))),
        )
        if deed == "scale" and type(old) in (int, float) and abs(old) < 1e300:
            parent[name] = type(old)(old * draw(st.sampled_from(FACTORS)))
        elif deed == "remove":
            del parent[name]
        elif deed == "double" and isinstance(parent, list):
            parent.insert(name, copy.deepcopy(old))
        elif deed == "move":
            other = draw(st.sampled_from(known))
            parent[name] = copy.deepcopy(parent_of(body, other)[other[-1]])
        else:
            parent[name] = copy.deepcopy(draw(st.sampled_from(ODD_VALUES)))
    return body


def assert_documented(
    api: WholeApi, operation_id: str, *, names: dict[str, Any] | None = None, **options: Any
) -> requests.Response:
    """Send a request for what there is, or for other names; return the answer, which is as documented."""
    operation = OPERATIONS[operation_id]
    named = api.names(operation, 0) | (names or {})
    path = api.path_of(operation, named)
    with api.session.request(operation["method"], path, timeout=LONGEST, **options) as answer:
        case = SCHEMA.find_operation_by_id(operation_id).Case(path_parameters=named)
        case.validate_response(answer, checks=CHECKS)
        return answer


@pytest.mark.parametrize("operation_id", BODIES)
def test_spoilt_bodies_are_answered_as_documented(on_postgresql, operation_id):
    @settings(REPEATED, max_examples=SPOILT)
    @given(spoilt(BODIES[operation_id]))
    def ask(body):
        content = json.dumps(body).encode()
        headers = {"content-type": "application/json", "if-match": "*"}
        answer = assert_documented(on_postgresql, operation_id, data=content, headers=headers)
        if operation_id == "create_job" and answer.status_code == 202:
            assert_results_are_as_documented(on_postgresql, answer.json()["id"])

    ask()


RESULTS = (
    "watch_job", "get_job", "get_job_spec", "get_summary", "list_cases", "get_case", "get_case_design",
    "get_trajectory",
)  # fmt: skip


def assert_results_are_as_documented(api: WholeApi, job_id: str) -> None:
    """Check all that a job gives once it is over."""
    for operation_id in RESULTS:
        assert_documented(api, operation_id, names={"job_id": job_id, "case": 0})
    for format in ("json", "csv", "parquet", "netcdf", "mat"):
        assert_documented(api, "get_results", names={"job_id": job_id}, params={"format": format})


# names, queries and headers

ODD_TEXTS = (
    "%00", "a%00b", "%ED%A0%80", "%FF%FE", "%F0%9F%9A%80", "%20", "a%2Fb", "a%3Arestore", "%27%22%3B--", "%25",
    "%5C%25_", "x" * 5000, "-1", "1e3", "9" * 400, "%C2%B2", "null",
)  # fmt: skip
"""As they stand in an address: not in UTF-8, with NUL, halves of surrogates, separators, and numbers that are none."""
ODD_HEADERS: tuple[tuple[str, str], ...] = (
    ("accept", ""), ("accept", "*/*;q=0"), ("accept", "text/html"), ("accept", "a/b/c;q=x, ,;"), ("accept", "é"),
    ("accept", "application/json;q=1e400"), ("accept-encoding", "identity;q=0"), ("range", "bytes=0-1"),
    ("if-match", '"'), ("if-match", 'W/"1"'), ("if-match", '"9999999999999999999999"'), ("if-match", '"²", "1"'),
    ("if-none-match", '"'), ("if-none-match", "*"), ("if-none-match", 'W/"1", é'),
    ("last-event-id", "-1"), ("last-event-id", "9" * 50), ("last-event-id", "²"), ("last-event-id", ""),
    ("idempotency-key", "k" * 255), ("idempotency-key", "é"), ("idempotency-key", "k" * 5000),
    ("content-type", "application/json; charset=utf-16"), ("content-type", ";;"), ("content-encoding", "gzip"),
    ("content-type", "multipart/form-data"), ("host", "elsewhere.example"), ("host", "["), ("host", ""),
    ("origin", "https://elsewhere.example"), ("origin", "http://["), ("cookie", "gs_token=é; =;"),
    ("authorization", "Bearer \xff"), ("x-request-id", "é" * 300),
)  # fmt: skip


def parameters(operation: dict[str, Any], where: str) -> list[str]:
    return [parameter["name"] for parameter in operation.get("parameters", ()) if parameter["in"] == where]


def with_body(operation_id: str, headers: dict[str, str] | None = None) -> dict[str, Any]:
    """Return what a request of an operation needs beside its address; `headers` go before those it has."""
    if operation_id == "set_thumbnail":
        body: dict[str, Any] = {"data": b"<svg/>", "headers": {"content-type": "image/svg+xml"}}
    elif operation_id in BODIES:
        content = json.dumps(BODIES[operation_id][0]).encode()
        body = {"data": content, "headers": {"content-type": "application/json"}}
    else:
        body = {"headers": {}}
    given_headers = {name: value.encode("latin-1") for name, value in (headers or {}).items()}
    return body | {"headers": {"if-match": "*"} | body["headers"] | given_headers}


@pytest.mark.parametrize("operation_id", [name for name, item in OPERATIONS.items() if parameters(item, "path")])
def test_odd_names_are_answered_as_documented(on_postgresql, operation_id):
    for name in parameters(OPERATIONS[operation_id], "path"):
        for text in ODD_TEXTS:
            assert_documented(on_postgresql, operation_id, names={name: text}, **with_body(operation_id))


@pytest.mark.parametrize("operation_id", [name for name, item in OPERATIONS.items() if parameters(item, "query")])
def test_odd_queries_are_answered_as_documented(on_postgresql, operation_id):
    for name in [*parameters(OPERATIONS[operation_id], "query"), "unknown"]:
        for text in ODD_TEXTS:
            query = f"{name}={text}&{name}={text}"
            assert_documented(on_postgresql, operation_id, params=query, **with_body(operation_id))


@pytest.mark.parametrize("operation_id", OPERATIONS)
def test_odd_headers_are_answered_as_documented(on_postgresql, operation_id):
    """All that the operation reads, and every fifth of the others, which are the same code for all operations."""
    read = {name.lower() for name in parameters(OPERATIONS[operation_id], "header")}
    turn = list(OPERATIONS).index(operation_id)
    for number, (header, value) in enumerate(ODD_HEADERS):
        if header in read or (number + turn) % 5 == 0:
            assert_documented(on_postgresql, operation_id, **with_body(operation_id, {header: value}))
