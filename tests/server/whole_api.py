"""Owns the whole program as the fuzz tests ask it: a server with a store, jobs and a session, whose names are known.

What is asked for by a name that exists is found; what a request deletes or changes is there again for the next one.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import requests
import schemathesis
from schemathesis import Case, GenerationMode
from schemathesis.checks import (
    content_type_conformance,
    negative_data_rejection,
    not_a_server_error,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
)
from schemathesis.config import SchemathesisConfig
from schemathesis.core.parameters import ParameterLocation

from models.design import parse_design
from server.app import create_app
from server.examples.build import DemoSessions, example_document
from server.examples.stored import PICTURE
from server.jobs.engines import SerialEngine
from server.jobs.opening import finder
from server.jobs.service import Jobs
from server.settings import Settings
from server.store.database import Database
from server.store.designs import DesignStore
from server.store.errors import DeletedError, NotFoundError
from server.store.records import Content
from tests.server.job_support import finished, listed
from tests.server.serving import served

SEED = 20260101
EXAMPLES = 5
"""Random requests an operation, beside those that schemathesis makes by rule."""
MOST_CASES = 60
COMMAND = "/mission/control/schedules/0/points/0/extension"
CHECKS = [
    not_a_server_error, status_code_conformance, content_type_conformance, response_headers_conformance,
    response_schema_conformance,
]  # fmt: skip
FROM_A_SCHEMA = [*CHECKS, negative_data_rejection]
"""Also that what a schema forbids is refused; not that what it allows is taken, for a design must fit together too."""
Operation = dict[str, Any]


def document() -> dict[str, Any]:
    """Return the OpenAPI document of the program on a loopback address."""
    return create_app(Settings(host="127.0.0.1", token=None)).openapi()


def operations(document: dict[str, Any]) -> dict[str, Operation]:
    """Return the operations by their ids, each with its method and path."""
    found = {}
    for path, item in document["paths"].items():
        for method, operation in item.items():
            found[operation["operationId"]] = operation | {"method": method.upper(), "path": path}
    return found


def _referred(node: Any) -> Iterator[str]:
    """Yield the schemas that a part of the document refers to directly, by name."""
    if isinstance(node, dict):
        if isinstance(node.get("$ref"), str):
            yield node["$ref"].rpartition("/")[2]
        node = list(node.values())
    for child in node if isinstance(node, list) else ():
        yield from _referred(child)


def holds_designs(document: dict[str, Any], operation: Operation) -> bool:
    """Whether a body may hold a whole design or component, of which there are many thousand borderline cases."""
    schemas, known = document["components"]["schemas"], set()
    coming = set(_referred(operation.get("requestBody", {})))
    while coming - known:
        name = (coming - known).pop()
        known.add(name)
        coming |= set(_referred(schemas[name]))
    return not known.isdisjoint({"Design", "Rigid"})


def described(document: dict[str, Any]) -> schemathesis.BaseSchema:
    """Return the document as schemathesis uses it: with every borderline case, save bodies that hold designs."""
    large = [name for name, operation in operations(document).items() if holds_designs(document, operation)]
    config = SchemathesisConfig.from_dict(
        {
            "seed": SEED,
            "generation": {"deterministic": True, "max-examples": EXAMPLES, "database": "none"},
            "checks": {
                "negative_data_rejection": {
                    "expected-statuses": ["400", "404", "405", "406", "412", "415", "422", "428"]
                }
            },
            "operations": [{"include-operation-id": large, "phases": {"coverage": {"enabled": False}}}],
        }
    )
    return schemathesis.openapi.from_dict(document, config=config)


class WholeApi:
    """A program in a folder of its own, and what is in it."""

    def __init__(self, folder: Path, url: str) -> None:
        self.store = DesignStore(Database(url))
        self.jobs = Jobs(
            self.store.database, SerialEngine(), folder / "jobs", find_design=finder(self.store), max_cases=MOST_CASES
        )
        settings = Settings(host="127.0.0.1", token=None, data=folder)
        self.app = create_app(settings, live=DemoSessions(), store=self.store, jobs=self.jobs)
        self.url, self.session = "", requests.Session()
        self.session.trust_env = False
        self._design_id = self._store_design()
        self._job_id = self._run_job()

    def _store_design(self) -> str:
        first = parse_design(example_document())
        stored = self.store.create(Content(first, ("example",)))
        longer = parse_design(example_document() | {"notes": "Changed once"})
        self.store.change(stored.id, lambda _: Content(longer, ("example",)), expected=None)
        self.store.set_thumbnail(stored.id, "image/svg+xml", PICTURE.encode())
        return stored.id

    def _run_job(self) -> str:
        """Submit a job of which one case fails and some are kept."""
        batch = listed(COMMAND, [0.0, 0.5, 1e-4, 2e-4], name="=Too far/../é", trajectories=[0, 2])
        return self.jobs.submit(batch, fresh=True)[0].id

    @property
    def design_id(self) -> str:
        """A stored design, with two revisions at least and a thumbnail."""
        try:
            self.store.get(self._design_id)
        except DeletedError:
            self.store.restore(self._design_id)
        return self._design_id

    @property
    def job_id(self) -> str:
        """A job that is over."""
        try:
            job = self.jobs.store.get(self._job_id)
        except NotFoundError:
            self._job_id = self._run_job()
            job = self.jobs.store.get(self._job_id)
        return finished(self.jobs, job).id

    def names(self, operation: Operation, number: int) -> dict[str, Any]:
        """Return what the parameters of an operation's path may be so that something is found; by number, which."""
        wanted = {
            part[1:-1].split(":")[0] for part in operation["path"].replace(":", "/").split("/") if part[:1] == "{"
        }
        found: dict[str, Any] = {
            "session_id": "demo",
            "preset_id": "three-cell-glider",
            "number": 1,
            "case": number % 5,
        }
        if "design_id" in wanted:
            found["design_id"] = self.design_id
            components = self.store.get(found["design_id"]).design.vehicle.components
            found["name"] = components[number % len(components)].name
        if "job_id" in wanted:
            found["job_id"] = self.job_id
        return {name: found[name] for name in wanted}

    def point_at_what_is_there(self, case: Case) -> None:
        """Have three of four requests ask for what exists, and change it whatever it is now.

        Where schemathesis has made the path wrong it stays so.
        """
        path = case.meta.components.get(ParameterLocation.PATH) if case.meta is not None else None
        if path is not None and path.mode is GenerationMode.NEGATIVE:
            return
        given = repr((case.path_parameters, case.query, dict(case.headers), case.body))
        number = zlib.crc32(given.encode(errors="replace"))
        if number % 4 == 0 or not case.path_parameters:
            return
        known = self.names({"path": case.operation.path}, number // 4)
        case.path_parameters = case.path_parameters | known
        if case.method != "GET" and "design_id" in known:
            case.headers["If-Match"] = "*"

    def path_of(self, operation: Operation, names: dict[str, Any]) -> str:
        """Return the address of an operation with these names in it."""
        path = self.url + operation["path"]
        for name, value in names.items():
            path = path.replace(f"{{{name}}}", quote(str(value), safe="%"))
        return path


@contextmanager
def whole_api(folder: Path, url: str) -> Iterator[WholeApi]:
    """Enter the program, served on a socket: answers come as clients get them."""
    api = WholeApi(folder, url)
    with served(api.app) as server:
        api.url = server.url
        with api.session:
            yield api
    api.store.database.close()
