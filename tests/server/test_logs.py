"""The log: one line a request, with its id, its user and its figures, and no way to forge a line."""

from __future__ import annotations

import io
import json
import logging
import threading
from collections.abc import Iterator

import pytest
from starlette.concurrency import run_in_threadpool

from models.problems import DesignError, Problem
from server.app import create_app
from server.logs import RequestFilter, TextFormatter, configure_logging, json_formatter
from server.request_context import request_id
from server.settings import Settings
from tests.server.support import ask, assert_problem, local_app

PRESET = "/api/v1/presets/three-cell-glider"


class Log:
    def __init__(self, formatter: logging.Formatter) -> None:
        self.stream = io.StringIO()
        self.handler = logging.StreamHandler(self.stream)
        self.handler.setFormatter(formatter)
        self.handler.addFilter(RequestFilter())

    @property
    def lines(self) -> list[str]:
        return self.stream.getvalue().splitlines()

    @property
    def items(self) -> list[dict]:
        return [json.loads(line) for line in self.lines]


@pytest.fixture
def log() -> Iterator[Log]:
    made, root = Log(json_formatter()), logging.getLogger()
    level = root.level
    root.addHandler(made.handler)
    root.setLevel(logging.DEBUG)
    yield made
    root.setLevel(level)
    root.removeHandler(made.handler)


def requests(log: Log) -> list[dict]:
    return [item for item in log.items if item["logger"] == "server.requests"]


def test_a_request_is_one_line_with_its_figures(log):
    answer = ask("GET", PRESET, headers={"x-request-id": "run-7.a_B"})
    (item,) = requests(log)
    assert answer.headers["x-request-id"] == item["request_id"] == "run-7.a_B"
    assert item["route"] == "/api/v1/presets/{preset_id}"
    assert (item["method"], item["status"], item["level"], item["principal"]) == ("GET", 200, "INFO", "local")
    assert item["bytes"] == len(answer.content)
    assert 0.0 < item["duration_ms"] < 10_000.0
    assert item["timestamp"]


@pytest.mark.parametrize("given", ["", "a b", "x" * 65, "a\tb", 'a"b', "ä", "../x"])
def test_an_odd_id_is_replaced(given):
    answer = ask("GET", PRESET, headers={"x-request-id": given.encode("latin-1")})
    assert answer.headers["x-request-id"] != given
    assert request_id(answer.headers["x-request-id"]) == answer.headers["x-request-id"]


def test_ids_differ():
    assert len({ask("GET", "/healthz").headers["x-request-id"] for _ in range(20)}) == 20


def test_lines_of_services_carry_the_id_in_threads_too(log):
    app = local_app()
    service = logging.getLogger("server.some_service")

    @app.get("/api/v1/work")
    async def work() -> None:
        service.info("in the loop")
        await run_in_threadpool(service.info, "in a thread")

    ask("GET", "/api/v1/work", app=app, headers={"x-request-id": "abc"})
    threading.Thread(target=service.info, args=("beside any request",)).start()
    told = {item["message"]: item["request_id"] for item in log.items if item["logger"] == "server.some_service"}
    assert told == {"in the loop": "abc", "in a thread": "abc", "beside any request": "-"}


def test_the_token_is_named_and_never_written(log):
    secret = "the-secret-of-anna-1"
    app = create_app(Settings(host="0.0.0.0", token=f"anna:{secret}"))
    bearer = {"authorization": f"Bearer {secret}"}
    ask("GET", PRESET, app=app, headers=bearer)
    # in the address of an operation it is an unknown parameter: told by its name, never by its value
    assert secret not in ask("GET", f"{PRESET}?token={secret}", app=app, headers=bearer).text
    ask("GET", PRESET, app=app, headers={"authorization": f"Bearer {secret}x"})
    known, odd, unknown = requests(log)
    assert (known["principal"], known["status"]) == ("anna", 200)
    assert (odd["principal"], odd["status"]) == ("anna", 422)
    assert (unknown["status"], unknown["route"]) == (401, "(none)")
    assert unknown["principal"] == "-"
    assert not [item for item in log.items if item["logger"] != "httpx" and secret in json.dumps(item)]


def test_a_crash_is_told_once_with_its_id_and_traceback(log):
    app = local_app()

    @app.get("/api/v1/crash")
    def crash() -> None:
        raise RuntimeError("a secret")

    answer = ask("GET", "/api/v1/crash", app=app, headers={"x-request-id": "abc"})
    assert_problem(answer, 500)
    assert answer.headers["x-request-id"] == "abc"
    errors = [item for item in log.items if item["level"] == "ERROR"]
    assert [item["logger"] for item in errors] == ["server.errors", "server.requests"]
    assert {item["request_id"] for item in errors} == {"abc"}
    assert "RuntimeError: a secret" in errors[0]["exc_info"]
    assert errors[1]["status"] == 500


def test_refusals_are_logged_as_what_they_are(log):
    app = local_app()

    @app.get("/api/v1/wrong")
    def wrong() -> None:
        raise DesignError([Problem("/x", "too much")])

    ask("GET", "/api/v1/wrong", app=app)
    ask("POST", PRESET, app=app)
    ask("GET", PRESET, app=app, headers={"host": "evil.example"})
    assert [(item["status"], item["level"]) for item in requests(log)] == [(422, "INFO"), (405, "INFO"), (421, "INFO")]


def test_probes_are_told_only_to_who_debugs(log):
    ask("GET", "/healthz")
    assert [item["level"] for item in requests(log)] == ["DEBUG"]


def test_text_lines_cannot_be_forged():
    log = Log(TextFormatter())
    logger = logging.Logger("test")
    logger.addHandler(log.handler)
    logger.warning("asked for %s", "x\n2026-01-01 INFO all is well\r\x1b[31m\u2028\x85")
    (line,) = log.stream.getvalue().split("\n")[:-1]
    assert r"x\n2026-01-01 INFO all is well\r\x1b[31m\u2028\x85" in line
    assert " WARNING test [- -] asked for x" in line


@pytest.mark.parametrize("kind", ["text", "json"])
def test_configuring_again_replaces_what_was(kind):
    root = logging.getLogger()
    handlers, level = list(root.handlers), root.level
    stream = io.StringIO()
    try:
        configure_logging("text", "debug", stream=io.StringIO())
        configure_logging(kind, "warning", stream=stream)
        logging.getLogger("test").info("too little")
        logging.getLogger("test").warning("enough")
    finally:
        for handler in list(root.handlers):
            root.removeHandler(handler)
        for handler in handlers:
            root.addHandler(handler)
        root.setLevel(level)
    (line,) = stream.getvalue().splitlines()
    assert "enough" in line
    assert kind == "text" or json.loads(line)["message"] == "enough"
