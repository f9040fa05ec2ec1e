"""Owns what the journeys of jobs share: batches, the API beside the browser, two jobs that are done; their fixtures."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from playwright.sync_api import ConsoleMessage, Error, Page

from models.presets import load_preset

if TYPE_CHECKING:
    from tests.browser.conftest import Program

FRONT = "/vehicle/components/1/position/0"
SLIGHTLY = 24


def batch(kind: str, name: str, **more: Any) -> dict[str, Any]:
    design = load_preset("canete-dual-bellows").model_dump(mode="json")
    return {"format": "glider-batch", "version": 1, "kind": kind, "name": name, "design": design, **more}


def sweep(name: str, count: int) -> dict[str, Any]:
    mass = {"pointer": "/vehicle/components/1/mass", "low": 0.029, "high": 0.031}
    ranges = [{"pointer": FRONT, "low": 0.15, "high": 0.2}, mass]
    return batch("sweep", name, method={"kind": "latin_hypercube", "count": count, "parameters": ranges})


class Api:
    """The API of the program, as a script beside the browser uses it."""

    def __init__(self, url: str) -> None:
        self.client = httpx.Client(base_url=f"{url}/api/v1/", trust_env=False, timeout=60)

    def post(self, document: dict[str, Any]) -> str:
        answer = self.client.post("jobs", json=document, params={"fresh": True})
        assert answer.status_code == 202, answer.text
        return str(answer.json()["id"])

    def get(self, path: str) -> Any:
        answer = self.client.get(path)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def wait(self, job_id: str) -> dict[str, Any]:
        end = time.monotonic() + 120
        while (job := self.get(f"jobs/{job_id}"))["state"] in ("queued", "running", "cancelling"):
            assert time.monotonic() < end, job
            time.sleep(0.1)
        return dict(job)


@pytest.fixture(scope="package")
def api(program: Program) -> Iterator[Api]:
    made = Api(program.url)
    yield made
    made.client.close()


@pytest.fixture(scope="package")
def swept(api: Api) -> str:
    """A sweep all of whose cases went well."""
    job_id = api.post(sweep("A sweep that succeeds", SLIGHTLY))
    assert api.wait(job_id)["state"] == "succeeded"
    return job_id


@pytest.fixture(scope="package")
def partial(api: Api) -> dict[str, Any]:
    """A job some of whose cases are refused: a duration drawn below zero."""
    duration = {
        "pointer": "/mission/duration",
        "name": "time",
        "distribution": {"kind": "normal", "mean": 4.0, "sd": 5.0},
    }
    job = api.wait(api.post(batch("monte_carlo", "Draws of which some fail", parameters=[duration], count=60)))
    assert job["state"] == "partial"
    return job


@pytest.fixture
def watched(page: Page) -> Iterator[Page]:
    """A page of which nothing is wrong in the end: no error in its console, nothing that its policy forbids."""
    wrong: list[str] = []

    def on_console(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            wrong.append(message.text)

    def on_error(error: Error) -> None:
        wrong.append(str(error))

    page.on("console", on_console)
    page.on("pageerror", on_error)
    yield page
    page.remove_listener("console", on_console)
    page.remove_listener("pageerror", on_error)
    assert wrong == []


def opened(page: Page, program: Program, job_id: str) -> Page:
    page.goto(f"{program.url}/jobs/{job_id}")
    page.wait_for_function("() => window.__job?.get('plots') && document.querySelector('#scatter .main-svg') !== null")
    return page


def wait_until(page: Page, condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end, "the page did not get there in time"
        page.wait_for_timeout(50)


def row(page: Page, job_id: str) -> Any:
    return page.get_by_test_id(f"job-{job_id}")
