"""Owns what the tests of jobs over the API share: an application with jobs of its own, and some that are done."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from server.app import create_app
from server.jobs.engines import SerialEngine
from server.jobs.opening import finder
from server.jobs.service import Jobs
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from tests.server.job_support import finished, listed, running, sweep
from tests.server.support import ask, read_json

JOBS = "/api/v1/jobs"
COMMAND = "/mission/control/schedules/0/points/0/extension"
CASES, KEPT = 12, (0, 7)
NOBODY = "0" * 26


class Api:
    """An application with jobs of its own."""

    def __init__(self, folder: Path, **settings) -> None:
        self.designs = DesignStore(Database(sqlite_url(folder / "studio.sqlite")))
        self.jobs = Jobs(
            self.designs.database, SerialEngine(), folder / "jobs", find_design=finder(self.designs), max_cases=1000
        )
        options = {"host": "127.0.0.1", "token": None, "data": folder} | settings
        self.app = create_app(Settings(**options), store=self.designs, jobs=self.jobs)

    def submit(self, document):
        return finished(self.jobs, self.jobs.submit(document, fresh=True)[0]).id

    def ask(self, method, path, document=None, **options):
        return ask(method, JOBS + path, document, app=self.app, **options)

    def get(self, path, **options):
        answer = self.ask("GET", path, **options)
        assert answer.status_code == 200, answer.text
        return read_json(answer)


@contextmanager
def idle_api(folder: Path, **settings):
    """Jobs that wait, since nobody works on them."""
    api = Api(folder, **settings)
    try:
        yield api
    finally:
        api.designs.database.close()


@pytest.fixture
def idle(tmp_path: Path) -> Iterator[Api]:
    with idle_api(tmp_path) as api:
        yield api


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    """Jobs that run, one that is done and one that is partial."""
    with idle_api(tmp_path_factory.mktemp("api")) as api, running(api.jobs):
        api.done = api.submit(sweep(CASES, name="Bellows along the hull", trajectories=list(KEPT)))
        api.partial = api.submit(listed(COMMAND, [0.0, 0.5, 1e-4], name="=Too far/../é"))
        yield api
