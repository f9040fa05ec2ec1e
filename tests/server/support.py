"""Owns how the tests ask the API, and the one check of an error's shape."""

from __future__ import annotations

import asyncio
import json
import math
import time
from typing import Any

import httpx
from fastapi import FastAPI

from models.presets import load_preset
from server.app import create_app
from server.examples.build import DemoSessions
from server.settings import Settings

PREVIEW = "/api/v1/simulations:preview"
VALIDATE = "/api/v1/designs:validate"
EDIT = "/api/v1/designs:edit"
TRIM = "/api/v1/designs:trim-ballast"
MASS = "/api/v1/analyses:mass"
SESSION = "/api/v1/sessions/demo/design"
JSON = {"content-type": "application/json"}


def local_app(**settings: Any) -> FastAPI:
    """Return the API as it is on a loopback address, whatever the environment says."""
    return create_app(Settings(host="127.0.0.1", token=None, **settings), live=DemoSessions())


APP = local_app()


def ask(method: str, path: str, document: Any = None, *, app: FastAPI = APP, **options: Any) -> httpx.Response:
    """Return the answer to one request; a crash in the app is the answer 500, as over a socket."""

    async def once() -> httpx.Response:
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.request(method, path, **options)

    if document is not None:
        options["content"] = document if isinstance(document, bytes) else json.dumps(document).encode()
        options["headers"] = JSON | options.get("headers", {})
    return asyncio.run(once())


def preset(preset_id: str = "three-cell-glider") -> dict[str, Any]:
    return load_preset(preset_id).model_dump(mode="json")


def _refuse(token: str) -> float:
    raise AssertionError(f"{token} in an answer")


def read_json(answer: httpx.Response) -> Any:
    """Decode an answer, which must be strict JSON."""
    return json.loads(answer.text, parse_constant=_refuse)


def assert_problem(answer: httpx.Response, status: int, *, pointer: str | None = None, says: str = "") -> Any:
    """Check that an answer is a problem document (RFC 9457) that points at `pointer` and says `says`."""
    assert answer.status_code == status, answer.text[:500]
    assert answer.headers["content-type"] == "application/problem+json"
    problem = read_json(answer)
    assert set(problem) - {"detail"} == {"type", "title", "status", "errors"}
    assert problem["type"] == "about:blank" and problem["status"] == status and problem["title"]
    for item in problem["errors"]:
        assert set(item) == {"pointer", "message", "limit", "hint"}
        assert item["pointer"] == "" or item["pointer"].startswith("/")
        assert item["message"]
        assert not isinstance(item["limit"], float) or math.isfinite(item["limit"])
    # an answer stays small whatever was sent
    assert len(answer.content) < 100_000
    if pointer is not None:
        assert pointer in [item["pointer"] for item in problem["errors"]], answer.text[:500]
    assert says in answer.text, answer.text[:500]
    return problem


class Stopwatch:
    """Asserts that what happens within it is over soon."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        self.began = time.perf_counter()

    def __exit__(self, *error: object) -> None:
        assert time.perf_counter() - self.began < self.seconds
