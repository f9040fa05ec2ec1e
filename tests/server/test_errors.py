"""Every error of every route has the one shape, and hostile input is refused clearly and soon."""

from __future__ import annotations

import asyncio
import json
import re

import httpx
import pytest
from fastapi import Query

from models.problems import DesignError, Problem
from server.errors import MOST_ERRORS
from tests.server.support import (
    APP,
    EDIT,
    MASS,
    PREVIEW,
    SESSION,
    TRIM,
    VALIDATE,
    Stopwatch,
    ask,
    assert_problem,
    local_app,
    preset,
    read_json,
)

POSTS = (PREVIEW, VALIDATE, EDIT, TRIM, MASS, "/api/v1/designs")
BODIES = [("POST", path) for path in POSTS] + [("PATCH", SESSION)]
SOON = 5.0
"""Seconds within which anything is refused: a body of the largest size takes a second to read on a slow machine."""


def every_operation():
    document = read_json(ask("GET", "/api/v1/openapi.json"))
    return [(method.upper(), path) for path, item in document["paths"].items() for method in item]


@pytest.mark.parametrize("path", ["/", "/redoc", "/api/v2", "/api/v1/presets/none", "/api/v1/designs:no", "/a%00"])
def test_404(path):
    assert_problem(ask("GET", path), 404)


@pytest.mark.parametrize("path", ["/api/v1/sessions/none/design"])
def test_404_of_sessions_also_without_a_studio(path):
    assert_problem(ask("GET", path), 404, says="no open session 'none'")
    alone = local_app()
    alone.state.live = None
    assert_problem(ask("GET", SESSION, app=alone), 404, says="no open session")


OPERATIONS = every_operation()


@pytest.mark.parametrize(("method", "path"), OPERATIONS)
def test_405_names_what_is_possible(method, path):
    possible = {other for other, shape in OPERATIONS if shape == path}
    answer = ask(next(other for other in ("DELETE", "POST") if other not in possible), path)
    assert_problem(answer, 405, says=method)
    assert possible <= set(answer.headers["allow"].split(", "))


@pytest.mark.parametrize(("method", "path"), BODIES)
def test_413_announced(method, path):
    with Stopwatch(SOON):
        assert_problem(ask(method, path, b" " * 10_000_000), 413, says="limit of 4194304 bytes")


@pytest.mark.parametrize(("method", "path"), BODIES)
def test_413_streamed_stops_reading(method, path):
    sent = 0

    async def chunks():
        nonlocal sent
        for _ in range(1000):
            sent += 100_000
            yield b" " * 100_000

    with Stopwatch(SOON):
        assert_problem(ask(method, path, content=chunks(), headers={"content-type": "application/json"}), 413)
    # httpx hands over one chunk more than was read
    assert sent < 4 * 2**20 + 300_000


@pytest.mark.parametrize(("method", "path"), BODIES)
@pytest.mark.parametrize(
    "kind", [None, "text/plain", "multipart/form-data", "application/x-www-form-urlencoded", "json"]
)
def test_415(method, path, kind):
    headers = {} if kind is None else {"content-type": kind}
    assert_problem(ask(method, path, content=b"{}", headers=headers), 415, says="must be application/json")


def test_406_before_any_work():
    assert_problem(ask("POST", PREVIEW, preset(), headers={"accept": "image/png"}), 406, says="text/csv")


def test_422_of_a_parameter():
    app = local_app()

    @app.get("/count")
    def count(n: int = Query()) -> int:
        return n

    assert_problem(ask("GET", "/count?n=x", app=app), 422, says="query parameter 'n'")


def test_500_tells_nothing_of_the_inside():
    app = local_app()

    @app.get("/crash")
    def crash() -> None:
        raise RuntimeError("a secret")

    problem = assert_problem(ask("GET", "/crash", app=app), 500)
    assert "secret" not in json.dumps(problem)


def test_an_error_that_quotes_what_is_not_finite_stays_json():
    app = local_app()

    @app.get("/odd")
    def odd() -> None:
        raise DesignError([Problem("/x", "too much", limit=float("inf"))])

    assert assert_problem(ask("GET", "/odd", app=app), 422)["errors"][0]["limit"] is None


def test_what_is_wrong_with_the_whole_document_needs_no_pointer():
    app = local_app()

    @app.get("/whole")
    def whole() -> None:
        raise DesignError([Problem("", "too much", hint="send less")])

    assert assert_problem(ask("GET", "/whole", app=app), 422)["detail"] == "too much (send less)"


def deep(opening: bytes, closing: bytes, depth: int) -> bytes:
    return opening * depth + b"1" + closing * depth


@pytest.mark.parametrize(("method", "path"), BODIES)
@pytest.mark.parametrize(
    ("body", "status", "says"),
    [
        (b"", 400, "empty"),
        (b"  \n", 400, "empty"),
        (b"{", 400, "line 1, column 2"),
        (b"{}{}", 400, "Extra data"),
        (b"{'a': 1}", 400, "not JSON"),
        (b"\xff\xfe{}", 400, "not UTF-8: byte 0"),
        ("{}".encode("utf-16"), 400, "not UTF-8"),
        (b"\xef\xbb\xbf{}", 400, "BOM"),
        (b"1" * 5000, 400, "too many digits"),
        (b"[" * 1_000_000, 400, "nested more than 64 deep"),
        (deep(b"[", b"]", 200), 422, "nested more than 64 deep"),
        (deep(b'{"a":', b"}", 200), 422, "nested more than 64 deep"),
        (deep(b'{"design":', b"}", 60), 422, ""),
        (b"[" + b"1," * 300_000 + b"1]", 422, "more than 250000 values"),
        (b'{"a": NaN}', 422, '"/a"'),
        (b'{"a": [1, -Infinity]}', 422, '"/a/1"'),
        (b'{"a": 1e999}', 422, '"/a"'),
        (b'{"a": 1, "a": 1}', 422, "given twice"),
        (rb'{"a": "\ud800"}', 422, "surrogate"),
        (rb'{"\udfff": 1}', 422, "surrogate"),
        (b"null", 422, ""),
        (b"true", 422, ""),
        (b"7", 422, ""),
        (b'"x"', 422, ""),
        (b"{}", 422, ""),
        (b"[{}]", 422, ""),
    ],
    ids=lambda value: repr(value[:24]) if isinstance(value, bytes) else None,
)
def test_hostile_bodies(method, path, body, status, says):
    with Stopwatch(SOON):
        assert_problem(ask(method, path, body), status, says=says)


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize(
    "token",
    ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", "1e300", "1" + "0" * 400, '"x"', "null", "true", "[]", "{}"],
)
@pytest.mark.parametrize("wrapped", [False, True])
def test_wrong_numbers_are_pointed_at(path, token, wrapped):
    text = re.sub(r'("duration": )[0-9.]+', lambda match: match[1] + token, json.dumps(preset()))
    pointer = "/mission/duration"
    if wrapped or path == EDIT:
        text, pointer = (
            f'{{"design": {text}, "patch": []}}' if path == EDIT else f'{{"design": {text}}}',
            f"/design{pointer}",
        )
    with Stopwatch(SOON):
        problem = assert_problem(ask("POST", path, text.encode()), 422, pointer=pointer)
    assert not re.search(r"\b(nan|inf)\b", json.dumps(problem))


@pytest.mark.parametrize("path", POSTS)
def test_misspelt_fields_are_named(path):
    design = preset() | {"mision": {}}
    assert_problem(ask("POST", path, {"design": design, "patch": []}), 422, pointer="/design/mision")
    design = preset()
    assert_problem(ask("POST", path, {"design": design, "optons": {}}), 422, pointer="/optons", says="spelling")


def pistons(count):
    cell = {"kind": "piston", "mass": 0.01, "volume": 1e-5, "volume_range": [0.5e-5, 1.5e-5], "position": [0, 0, 0]}
    return [cell | {"name": f"Cell {i}"} for i in range(count)]


@pytest.mark.parametrize("path", POSTS)
def test_too_many_components_name_the_limit(path):
    design = preset()
    design["vehicle"]["components"] += pistons(300)
    with Stopwatch(SOON):
        assert_problem(
            ask("POST", path, {"design": design, "patch": []}), 422, pointer="/design/vehicle/components", says="256"
        )


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize(("count", "status", "says"), [(20_000, 422, "limit of 10000"), (1_000_000, 413, "4194304")])
def test_too_many_schedule_points_name_the_limit(path, count, status, says):
    design = preset()
    points = ",".join(f'{{"time":{i},"extension":0}}' for i in range(count))
    design["mission"]["control"]["schedules"] = [{"cell": "Middle piston", "points": ["POINTS"]}]
    body = json.dumps({"design": design, "patch": []}).replace('"POINTS"', points).encode()
    with Stopwatch(SOON):
        assert_problem(ask("POST", path, body), status, says=says)


def test_very_many_errors_are_counted_not_listed():
    design = preset()
    design["vehicle"]["components"] = [{}] * 250
    problem = assert_problem(ask("POST", VALIDATE, design), 422)
    assert len(problem["errors"]) == MOST_ERRORS
    assert "errors, of which the first 100 are listed" in problem["detail"]


def test_a_table_of_very_many_speeds_is_over_soon():
    design, speeds = preset(), 2500
    table = design["vehicle"]["hydrodynamics"]
    table["row_speed"] = [1 + k * 1e-3 for k in range(speeds) for _ in range(4)]
    table["row_alpha_deg"] = [0.0, 30.0, 60.0, 90.0] * speeds
    for name in ("row_lift", "row_drag", "row_moment"):
        table[name] = [1.0] * (4 * speeds)
    with Stopwatch(SOON):
        assert ask("POST", VALIDATE, design).status_code == 200


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"duration": 1e8}, "/mission/duration"),
        ({"duration": 6e5}, "/mission/solver/output_interval"),
        ({"output_interval": 1e-5}, "/mission/solver/output_interval"),
        ({"method": "rk4", "step": 1e-6}, "/mission/solver/step"),
    ],
)
def test_missions_beyond_a_preview_name_the_limit(change, pointer):
    design = preset()
    design["mission"] |= {k: v for k, v in change.items() if k == "duration"}
    design["mission"]["solver"] |= {k: v for k, v in change.items() if k != "duration"}
    with Stopwatch(SOON):
        assert_problem(ask("POST", PREVIEW, design), 422, pointer=pointer, says="exceed the limit of")


def test_body_limit_leaves_other_traffic_alone():
    """A body of just the limit passes, and routes that read bodies through FastAPI are capped as well."""
    app = local_app(max_body_bytes=2000)

    @app.post("/size")
    def size(values: list[int]) -> int:
        return len(values)

    fits = b"[" + b" " * 1998 + b"]"
    assert ask("POST", "/size", fits, app=app).json() == 0
    assert_problem(ask("POST", "/size", fits + b" ", app=app), 413)

    async def chunks():
        for _ in range(10):
            yield b" " * 300

    assert_problem(ask("POST", "/size", content=chunks(), headers={"content-type": "application/json"}, app=app), 413)


def test_clients_in_parallel_do_not_disturb_each_other():
    async def all_at_once():
        transport = httpx.ASGITransport(APP, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            good = [client.post(PREVIEW, json={"design": preset(), "options": {"max_points": 9}}) for _ in range(6)]
            bad = [client.post(PREVIEW, json=preset() | {"name": ""}) for _ in range(6)]
            return await asyncio.gather(*good, *bad)

    answers = asyncio.run(all_at_once())
    assert [answer.status_code for answer in answers] == [200] * 6 + [422] * 6
    assert len({json.dumps(answer.json()["columns"]) for answer in answers[:6]}) == 1
