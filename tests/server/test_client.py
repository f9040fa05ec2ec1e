"""The client: everything it asks is in the OpenAPI document, and it survives what networks do."""

from __future__ import annotations

import inspect
import json
import threading

import httpx
import pyarrow.parquet as pq
import pytest

from models.design import parse_design
from models.simulate import simulate
from server import client as client_module
from server.app import create_app
from server.client import FORMATS, OPERATIONS, Client, ProblemError
from server.jobs.engines import SerialEngine
from server.jobs.opening import finder
from server.jobs.service import Jobs
from server.jobs.spec import parse_spec
from server.routes.job_results import MEDIA
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from tests.server.job_support import glider, listed, sweep
from tests.server.serving import Served, served
from tests.server.support import ask, read_json

COMMAND = "/mission/control/schedules/0/points/0/extension"
TOKEN = "a-token-long-enough"


def make_app(folder, **settings):
    store = DesignStore(Database(sqlite_url(folder / "studio.sqlite")))
    jobs = Jobs(store.database, SerialEngine(), folder / "jobs", find_design=finder(store))
    options = {"host": "127.0.0.1", "token": None, "data": folder} | settings
    return create_app(Settings(**options), store=store, jobs=jobs)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with served(make_app(tmp_path_factory.mktemp("client"))) as server:
        yield server


@pytest.fixture
def client(server):
    with Client(server.url) as client:
        yield client


def test_all_it_asks_is_in_the_openapi_document():
    paths = read_json(ask("GET", "/api/v1/openapi.json"))["paths"]
    told = {
        operation["operationId"]: (method.upper(), path)
        for path, item in paths.items() for method, operation in item.items()
    }  # fmt: skip
    for operation, (method, path) in OPERATIONS.items():
        assert told[operation] == (method, f"/api/v1{path}"), operation
    offered = paths["/api/v1/jobs/{job_id}/results"]["get"]["responses"]["200"]["content"]
    assert set(FORMATS.values()) == set(offered) and dict(FORMATS) == MEDIA


def test_it_asks_nothing_else():
    """Each operation that the client names is in its table, and each in the table is used."""
    source = inspect.getsource(client_module).partition("FORMATS")[2]
    assert {name for name in OPERATIONS if f'"{name}"' in source} == set(OPERATIONS)


def test_designs_are_stored_changed_and_found(client):
    design = parse_design(glider())
    kept = client.create_design(design, name="By the client", tags=["mine"], comment="first")
    assert kept.revision == 1 and kept.name == "By the client" and client.design(kept.id) == kept
    changed = client.put_design(kept.id, kept.design.model_dump(mode="json") | {"notes": "Longer"}, revision=1)
    assert changed.revision == 2 and client.design(kept.id, 1) == kept
    with pytest.raises(ProblemError) as refused:
        client.put_design(kept.id, design, revision=1)
    assert refused.value.status == 412
    assert client.put_design(kept.id, design).revision == 3
    assert [item.id for item in client.designs("longer", tags=["mine"])] == []
    assert [item.id for item in client.designs(tags=["MINE"])] == [kept.id]


def test_a_job_from_the_document_to_the_table(client, tmp_path):
    seen = []
    record = client.submit(parse_spec(sweep(7, trajectories=[2])), key="monday")
    assert client.submit(parse_spec(sweep(7, trajectories=[2])), key="monday").id == record.id
    last = client.wait(record.id, seen.append, timeout=120.0)
    assert last == seen[-1] == client.job(record.id) and last.state == "succeeded"
    done = [item.progress.done for item in seen]
    assert done == sorted(done) and done[-1] == 7
    cases = list(client.cases(record.id))
    assert [case.case for case in cases] == list(range(7))
    path = client.download(record.id, tmp_path / "results.parquet")
    assert pq.read_table(path).column("range").to_pylist() == [case.metrics["range"] for case in cases]
    assert client.results(record.id, "csv").startswith(b"case,status,reason,place [m],range [m]")
    assert json.loads(client.results(record.id, "json"))["columns"]["case"] == list(range(7))
    assert client.summary(record.id).metrics["range"].count == 7
    path = client.trajectory(record.id, 2, columns=["x", "z"], max_points=10)
    assert path.kept and len(path.columns["t"]) == 10
    assert simulate(client.case_design(record.id, 2)).final["z"] == pytest.approx(path.final["z"], abs=1e-9)
    assert parse_spec(client.spec(record.id)).kind == "sweep"
    assert record.id in [item.id for item in client.jobs(states=["succeeded"], kinds=["sweep"])]
    client.delete(record.id)
    with pytest.raises(ProblemError, match="there is no job"):
        client.job(record.id)


def test_failed_cases_are_found_and_retried(client):
    record = client.submit(listed(COMMAND, [0.0, 0.5]))
    assert client.wait(record.id, timeout=120.0).state == "partial"
    assert [case.case for case in client.cases(record.id, status=["refused"])] == [1]
    assert client.retry(record.id).state == "queued"
    assert client.wait(record.id, timeout=120.0).state == "partial"
    with pytest.raises(ProblemError) as refused:
        client.cancel(record.id)
    assert refused.value.status == 409 and "over" in str(refused.value)
    with pytest.raises(ProblemError, match="only a paused job"):
        client.resume(record.id)


def test_errors_point_into_what_was_sent(client):
    with pytest.raises(ProblemError, match="/method/parameters/0/pointer") as refused:
        client.submit(listed("/vehicle/nothing", [1]))
    error = refused.value
    assert error.status == 422 and error.errors[0].pointer == "/method/parameters/0/pointer"
    with pytest.raises(ProblemError) as refused:
        client.create_design(glider() | {"nam": "x"})
    assert refused.value.errors[0].pointer == "/design/nam"


def test_formats_are_known_by_name_or_ending(client, tmp_path):
    with pytest.raises(ValueError, match="no format 'xlsx'"):
        client.results("0" * 26, "xlsx")
    with pytest.raises(ValueError, match="tells no format"):
        client.download("0" * 26, tmp_path / "results.xlsx")
    with pytest.raises(ProblemError):
        client.download("0" * 26, tmp_path / "results.nc")
    for name in ("netcdf", "nc"):
        with pytest.raises(ProblemError, match="no job"):
            client.results("0" * 26, name)
    assert list(tmp_path.iterdir()) == []


def test_a_token_is_sent(tmp_path):
    with served(make_app(tmp_path, token=f"anna:{TOKEN}")) as server:
        with Client(server.url, TOKEN) as client:
            assert list(client.jobs()) == []
        with Client(server.url) as client, pytest.raises(ProblemError) as refused:
            list(client.jobs())
    assert refused.value.status == 401


def test_waiting_goes_on_over_a_restart_of_the_server(tmp_path, monkeypatch):
    """The first server does no work and is stopped; the second, on the same port, does it."""
    monkeypatch.setattr(client_module, "RECONNECT", 0.05)
    idle = make_app(tmp_path)
    idle.state.jobs.start = lambda: None
    first = Served(idle)
    states, heard = [], threading.Event()

    def progress(record):
        states.append(record.state)
        heard.set()

    with Client(first.url) as client:
        job_id = client.submit(sweep(3)).id
        result = []
        waiter = threading.Thread(target=lambda: result.append(client.wait(job_id, progress, timeout=120.0)))
        waiter.start()
        assert heard.wait(30.0)
        first.stop()
        second = Served(make_app(tmp_path), port=first.port)
        waiter.join(120.0)
        second.stop()
    assert result[0].state == "succeeded" and states[0] == "queued" and states.count("queued") == 1


def test_waiting_ends_where_it_should(tmp_path, monkeypatch):
    monkeypatch.setattr(client_module, "RECONNECT", 0.05)
    idle = make_app(tmp_path)
    idle.state.jobs.start = lambda: None
    server = Served(idle)
    with Client(server.url) as client:
        job_id = client.submit(sweep(3)).id
        with pytest.raises(TimeoutError, match=r"not over after 0\.5 s"):
            client.wait(job_id, timeout=0.5)
        with pytest.raises(ProblemError, match="there is no job"):
            client.wait("0" * 26)
        with pytest.raises(httpx.TransportError):
            client.wait(job_id, lambda _: server.stop(), patience=0.2)
        with pytest.raises(httpx.ConnectError):
            client.wait(job_id)


def test_an_answer_from_something_else_is_an_error_too():
    problem = httpx.Response(502, text="<html>Bad gateway</html>", headers={"retry-after": "7"})
    with pytest.raises(ProblemError, match="Bad gateway") as refused:
        client_module._check(problem)
    assert refused.value.status == 502 and refused.value.retry_after == 7.0
