"""The jobs as the API shows them: submitted once, listed, cancelled, and all that they give, in every format."""

from __future__ import annotations

import asyncio
import io
import json
from pathlib import Path

import numpy as np
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
import pytest
import xarray as xr
from scipy.io import loadmat

import server.trajectory
from models.design import parse_design
from models.run import Run
from models.simulate import simulate
from server.app import create_app
from server.jobs.engines import SerialEngine
from server.jobs.opening import finder
from server.jobs.sensitivity import indices
from server.jobs.service import Jobs
from server.jobs.spec import batch_schema, parse_spec
from server.schemas_jobs import CaseItem, JobPage, JobRecord, JobSummary, Trajectory
from server.settings import Settings
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.records import Content
from tests.server.job_support import POSITION, finished, glider, listed, running, sweep
from tests.server.support import ask, assert_problem, read_json

JOBS = "/api/v1/jobs"
COMMAND = "/mission/control/schedules/0/points/0/extension"
CASES, KEPT = 12, (0, 7)
NOBODY = "0" * 26
TOKEN = "the-token-of-anna-1"


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


@pytest.fixture(scope="module")
def api(tmp_path_factory):
    """Jobs that run, one that is done and one that is partial."""
    api = Api(tmp_path_factory.mktemp("api"))
    with running(api.jobs):
        api.done = api.submit(sweep(CASES, name="Bellows along the hull", trajectories=list(KEPT)))
        api.partial = api.submit(listed(COMMAND, [0.0, 0.5, 1e-4], name="=Too far/../é"))
        yield api
    api.designs.database.close()


@pytest.fixture
def idle(tmp_path):
    """Jobs that wait, since nobody works on them."""
    api = Api(tmp_path)
    yield api
    api.designs.database.close()


# submitting


def test_a_job_is_accepted_watched_and_done(api):
    answer = api.ask("POST", "", sweep(3, name="Three"))
    assert answer.status_code == 202 and answer.headers["retry-after"] == "1"
    record = JobRecord.model_validate_json(answer.content)
    assert answer.headers["location"] == f"{JOBS}/{record.id}"
    finished(api.jobs, api.jobs.store.get(record.id))
    record = JobRecord.model_validate(api.get(f"/{record.id}"), strict=False)
    assert record.state == "succeeded" and record.over and record.progress.done == 3
    assert record.name == "Three" and record.kind == "sweep"


def test_a_key_submits_once(idle):
    first = idle.ask("POST", "", sweep(), headers={"Idempotency-Key": "monday"})
    again = idle.ask("POST", "?fresh=true", sweep(), headers={"Idempotency-Key": "monday"})
    assert first.json() == again.json() and again.status_code == 202
    assert "idempotent-replayed" not in first.headers and again.headers["idempotent-replayed"] == "true"
    other = idle.ask("POST", "", sweep(13), headers={"Idempotency-Key": "monday"})
    assert_problem(other, 422, says="Idempotency-Key")
    assert len(idle.get("")["items"]) == 1


@pytest.mark.parametrize("key", ["", "x" * 256, "two words", "é".encode("latin-1")])
def test_odd_keys_are_refused(idle, key):
    assert_problem(idle.ask("POST", "", sweep(), headers={"Idempotency-Key": key}), 422, says="Idempotency-Key")


def test_equal_jobs_are_one_unless_fresh(idle):
    first, equal = (idle.ask("POST", "", sweep(name=name)).json() for name in ("a", "b"))
    fresh = idle.ask("POST", "?fresh=true", sweep()).json()
    assert equal == first and fresh["id"] != first["id"] and fresh["checksum"] == first["checksum"]


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"kind": "sweeep"}, "/kind"),
        ({"metrics": ["range", "speed of light"]}, "/metrics/1"),
        ({"trajectories": [99]}, "/trajectories/0"),
        ({"design_id": "x"}, ""),
        ({"version": 2}, "/version"),
        ({"method": {"kind": "cases", "parameters": [{"pointer": "/nowhere"}], "rows": [[1]]}}, None),
    ],
)
def test_what_is_wrong_is_pointed_at_and_nothing_is_kept(idle, change, pointer):
    problem = assert_problem(idle.ask("POST", "", sweep() | change), 422)
    assert pointer is None or pointer in [item["pointer"] for item in problem["errors"]], problem
    assert idle.get("")["items"] == []


def test_too_many_cases_are_refused_with_the_bound(idle):
    problem = assert_problem(idle.ask("POST", "", sweep(1001)), 422, says="1001")
    assert problem["errors"][0]["limit"] == 1000


def test_bodies_are_json(idle):
    assert_problem(idle.ask("POST", "", b"{"), 400)
    assert_problem(idle.ask("POST", "", b"{}", headers={"content-type": "text/plain"}), 415)
    assert_problem(idle.ask("POST", "", b"x" * 5_000_000), 413)


def test_a_stored_design_is_found_at_its_revision(idle):
    stored = idle.designs.create(Content(parse_design(glider())))
    document = {name: value for name, value in sweep(4).items() if name != "design"}
    record = idle.ask("POST", "", document | {"design_id": stored.id}).json()
    assert record["design"] == {"name": stored.design.name, "identity": stored.identity, "id": stored.id, "revision": 1}
    wrong = idle.ask("POST", "", document | {"design_id": stored.id, "revision": 9})
    assert_problem(wrong, 422, pointer="/revision", says="newest is 1")
    assert_problem(idle.ask("POST", "", document | {"design_id": NOBODY}), 422, pointer="/design_id")


def test_quotas_count_new_jobs_and_their_cases(tmp_path):
    api = Api(tmp_path, token=f"anna:{TOKEN}", quota_running_jobs=2, quota_cases_per_day=50)
    anna = {"Authorization": f"Bearer {TOKEN}"}

    def post(document, **headers):
        return api.ask("POST", "?fresh=true", document, headers=anna | headers)

    assert_problem(post(sweep(51)), 413, says="51 cases exceeds")
    first = post(sweep(20), **{"Idempotency-Key": "a"})
    assert first.status_code == 202
    # neither a request that comes again nor one that is refused counts
    assert post(sweep(20), **{"Idempotency-Key": "a"}).json()["id"] == first.json()["id"]
    answer = post(sweep(40))
    assert_problem(answer, 429, says="what is left to the token 'anna'")
    assert int(answer.headers["retry-after"]) > 60
    assert post(sweep(20)).status_code == 202
    assert_problem(post(sweep(2)), 429, says="2 jobs of the token 'anna' are unfinished")
    api.designs.database.close()


def test_without_jobs_the_server_says_so():
    answer = ask("GET", JOBS, app=create_app(Settings(host="127.0.0.1", token=None)))
    assert_problem(answer, 503, says="keeps no jobs")
    assert answer.headers["retry-after"]


# listing


def test_lists_are_paged_filtered_and_searched(idle):
    ids = [idle.ask("POST", "?fresh=true", sweep(2, name=f"Job {k}")).json()["id"] for k in range(5)]
    idle.jobs.cancel(ids[3])
    seen, cursor = [], None
    while True:
        query = {"limit": 2} | ({"cursor": cursor} if cursor else {})
        page = JobPage.model_validate_json(idle.ask("GET", "", params=query).content)
        seen += [item.id for item in page.items]
        cursor = page.next
        if cursor is None:
            break
    assert seen == ids[::-1]
    assert [item["id"] for item in idle.get("?state=cancelled&state=failed")["items"]] == [ids[3]]
    assert [item["id"] for item in idle.get("?search=jOB 2")["items"]] == [ids[2]]
    assert idle.get("?search=%25")["items"] == [] and idle.get("?kind=monte_carlo")["items"] == []


@pytest.mark.parametrize("query", ["state=done", "kind=x", "limit=0", "limit=201", "cursor=abc", "search=%00"])
def test_odd_questions_are_refused(idle, query):
    assert_problem(idle.ask("GET", f"?{query}"), 422, says=query.split("=")[0])


@pytest.mark.parametrize("job_id", [NOBODY, "x", "%00", "..", "0" * 25 + "É"])
@pytest.mark.parametrize("what", ["", "/spec", "/events", "/cases", "/cases/0", "/results", "/summary"])
def test_jobs_that_are_not_there(idle, job_id, what):
    assert_problem(idle.ask("GET", f"/{job_id}{what}"), 404)


# states


def test_a_waiting_job_is_cancelled_at_once_and_deleted(idle):
    job_id = idle.ask("POST", "", sweep()).json()["id"]
    assert_problem(idle.ask("DELETE", f"/{job_id}"), 409, says="queued: cancel it first")
    assert_problem(idle.ask("POST", f"/{job_id}:resume"), 409, says="queued")
    assert_problem(idle.ask("POST", f"/{job_id}:retry"), 409, says="queued")
    answer = idle.ask("POST", f"/{job_id}:cancel")
    assert answer.status_code == 202 and answer.json()["state"] == "cancelled"
    assert answer.headers["location"] == f"{JOBS}/{job_id}"
    assert_problem(idle.ask("POST", f"/{job_id}:cancel"), 409, says="was cancelled")
    assert idle.ask("POST", f"/{job_id}:retry").json()["state"] == "queued"
    idle.ask("POST", f"/{job_id}:cancel")
    answer = idle.ask("DELETE", f"/{job_id}")
    assert answer.status_code == 204 and not answer.content
    assert_problem(idle.ask("GET", f"/{job_id}"), 404)


def test_the_batch_document_comes_back_and_gives_the_same_job(api):
    document = api.get(f"/{api.done}/spec")
    assert document["design"] == parse_design(glider()).model_dump(mode="json")
    again = api.ask("POST", "", document).json()
    assert again["id"] == api.done


def test_the_schema_is_the_documents_own(api):
    assert read_json(ask("GET", "/api/v1/schemas/batch", app=api.app)) == json.loads(json.dumps(batch_schema()))


# cases


def test_cases_are_paged_and_filtered(api):
    whole = api.get(f"/{api.done}/cases")
    assert [item["case"] for item in whole["items"]] == list(range(CASES)) and whole["next"] is None
    first = api.get(f"/{api.done}/cases", params={"limit": 5})
    second = api.get(f"/{api.done}/cases", params={"limit": 5, "cursor": first["next"]})
    assert first["items"] + second["items"] == whole["items"][:10]
    items = api.get(f"/{api.partial}/cases?status=refused&status=crashed")["items"]
    assert [(item["case"], item["status"]) for item in items] == [(1, "refused")]
    assert "outside its stops" in items[0]["reason"] and set(items[0]["metrics"].values()) == {None}
    assert items[0]["parameters"] == {"value": 0.5}
    assert api.get(f"/{api.done}/cases/7") == whole["items"][7]
    CaseItem.model_validate(whole["items"][7])


@pytest.mark.parametrize(
    ("path", "status"),
    [("/cases/12", 404), ("/cases/-1", 422), ("/cases/x", 422), ("/cases/1e3", 422), (f"/cases/{10**30}", 422),
     ("/cases?status=fine", 422), ("/cases?limit=1001", 422), ("/cases?cursor=e30", 422)],
)  # fmt: skip
def test_cases_that_are_not_there(api, path, status):
    assert_problem(api.ask("GET", f"/{api.done}{path}"), status)


def test_a_case_that_is_not_done_says_so(idle):
    job_id = idle.ask("POST", "", sweep()).json()["id"]
    assert_problem(idle.ask("GET", f"/{job_id}/cases/3"), 404, says="case 3 is not done: the job is queued")
    assert idle.get(f"/{job_id}/cases") == {"items": [], "next": None}
    assert idle.get(f"/{job_id}/results")["columns"] == {"case": [], "status": [], "reason": []}
    assert idle.get(f"/{job_id}/summary")["cases"] == 0


def test_the_design_of_a_case_is_the_one_that_was_simulated(api):
    design = parse_design(api.get(f"/{api.done}/cases/7/design"))
    case = api.get(f"/{api.done}/cases/7")
    assert design.vehicle.components[1].position[0] == case["parameters"]["place"]
    assert simulate(design).final["x"] == pytest.approx(case["metrics"]["range"], rel=1e-9)


# trajectories


@pytest.mark.parametrize("case", [7, 3])
def test_a_trajectory_is_the_cases_own_whether_kept_or_simulated_again(api, case):
    shown = api.get(f"/{api.done}/cases/{case}/trajectory")
    assert Trajectory.model_validate(shown, strict=False).kept == (case in KEPT)
    run = simulate(parse_design(api.get(f"/{api.done}/cases/{case}/design")))
    assert shown["status"] == run.status.name and shown["message"] == run.message and shown["case"] == case
    assert shown["columns"]["t"] == run.times.tolist()
    for name in ("x", "z", "theta"):
        assert shown["columns"][name] == pytest.approx(run.values[name].tolist(), rel=1e-12, abs=1e-12)
    assert [cell["name"] for cell in shown["cells"]] == list(run.cells)
    for k, cell in enumerate(shown["cells"]):
        assert cell["extension"] == pytest.approx(run.cell_values["extension"][:, k].tolist(), rel=1e-12, abs=1e-12)
    metrics = api.get(f"/{api.done}/cases/{case}")["metrics"]
    assert metrics["final_depth"] == shown["final"]["z"]


def test_kept_and_simulated_again_are_equal_to_the_last_bit(api, monkeypatch):
    kept = api.get(f"/{api.done}/cases/7/trajectory")
    monkeypatch.setattr("server.trajectory._kept_run", lambda *_: None)
    again = api.get(f"/{api.done}/cases/7/trajectory")
    assert kept["kept"] and not again["kept"]
    assert kept["columns"] == again["columns"] and kept["cells"] == again["cells"] and kept["final"] == again["final"]


def test_trajectories_are_thinned_and_come_as_files(api, tmp_path):
    path = f"/{api.done}/cases/0/trajectory"
    shown = api.get(path, params={"columns": "x, z", "max_points": 5})
    assert set(shown["columns"]) == {"t", "x", "z"} and len(shown["columns"]["t"]) == 5
    whole = api.get(path)
    for name in ("x", "z"):
        assert min(shown["columns"][name]) == min(whole["columns"][name])
    text = api.ask("GET", path, headers={"accept": "text/csv"}, params={"max_points": 5})
    assert len(text.text.splitlines()) == 6 and text.headers["content-type"].startswith("text/csv")
    assert f"{api.done}-case-0.csv" in text.headers["content-disposition"]
    file = tmp_path / "case.nc"
    file.write_bytes(api.ask("GET", path, headers={"accept": "application/x-netcdf"}).content)
    run = Run.from_netcdf(file)
    assert run.times.tolist() == whole["columns"]["t"] and run.values["z"].tolist() == whole["columns"]["z"]


@pytest.mark.parametrize(
    ("query", "says"), [("columns=depth", "no column 'depth'"), ("max_points=1", "max_points"), ("columns=", None)]
)
def test_odd_trajectories_are_refused(api, query, says):
    answer = api.ask("GET", f"/{api.done}/cases/0/trajectory?{query}")
    if says is None:
        assert set(read_json(answer)["columns"]) == {"t"}
    else:
        assert_problem(answer, 422, says=says)


def test_a_refused_case_has_neither_design_nor_trajectory(api):
    answer = api.ask("GET", f"/{api.partial}/cases/1/trajectory")
    assert_problem(answer, 422, pointer=COMMAND, says="outside its stops")
    assert_problem(api.ask("GET", f"/{api.done}/cases/0/trajectory", headers={"accept": "image/png"}), 406)


def test_a_case_that_takes_too_long_again_says_how_to_keep_it(api, monkeypatch):
    monkeypatch.setattr(server.trajectory, "LONGEST", 0.0)
    design = glider(duration=1000.0)
    design["mission"]["solver"] |= {"method": "rk4", "step": 2.5e-4, "output_interval": 10.0}
    job, _ = api.jobs.submit(sweep(2, design=design))
    answer = api.ask("GET", f"/{job.id}/cases/1/trajectory")
    api.jobs.cancel(job.id)
    assert_problem(answer, 409, says='"trajectories\\": [1]')


def test_another_kernel_is_told(api, monkeypatch):
    path = f"/{api.done}/cases/3/trajectory"
    assert not any("kernel" in item["message"] for item in api.get(path)["warnings"])
    monkeypatch.setattr("models.simulate.KERNEL_HASH", "another")
    warning = api.get(path)["warnings"][0]["message"]
    assert "kernel another" in warning and api.get(f"/{api.done}")["engine"]["kernel"] in warning


# results


def table(api, media, job=None):
    answer = api.ask("GET", f"/{job or api.done}/results", headers={"accept": media})
    assert answer.status_code == 200 and answer.headers["content-type"].split(";")[0] == media
    assert answer.headers["content-disposition"].startswith('attachment; filename="bellows-along-the-hull-')
    return answer.content


def test_all_formats_hold_the_same_numbers(api, tmp_path):
    cases = api.get(f"/{api.done}/cases")["items"]
    ranges = [case["metrics"]["range"] for case in cases]
    shown = json.loads(table(api, "application/json"))
    assert shown["columns"]["range"] == ranges and shown["units"]["range"] == "m"
    assert shown["columns"]["status"] == [case["status"] for case in cases]
    assert pacsv.read_csv(io.BytesIO(table(api, "text/csv"))).column("range [m]").to_pylist() == ranges
    parquet = pq.read_table(io.BytesIO(table(api, "application/vnd.apache.parquet")))
    assert parquet.column("range").to_pylist() == ranges
    assert parquet.schema.field("range").metadata[b"unit"] == b"m"
    (tmp_path / "r.nc").write_bytes(table(api, "application/x-netcdf"))
    with xr.open_dataset(tmp_path / "r.nc", decode_times=False) as data:
        assert data["range"].values.tolist() == ranges and data.attrs["title"] == "Bellows along the hull"
        assert json.loads(data.attrs["batch_document"])["kind"] == "sweep"
        assert np.flatnonzero(data["row_size"].values).tolist() == list(KEPT)
    stored = loadmat(io.BytesIO(table(api, "application/x-matlab-data")))
    assert stored["range"].ravel().tolist() == ranges
    assert not list(api.jobs.files(api.jobs.store.get(api.done)).folder.glob("download-*"))


def test_links_choose_a_format_by_name(api):
    answer = api.ask("GET", f"/{api.partial}/results?format=csv", headers={"accept": "text/html"})
    assert answer.headers["content-type"].startswith("text/csv") and "refused" in answer.text
    assert answer.headers["content-disposition"] == f'attachment; filename="too-far-{api.partial}.csv"'
    assert_problem(api.ask("GET", f"/{api.partial}/results?format=xlsx"), 422, says="format")
    assert_problem(api.ask("GET", f"/{api.partial}/results", headers={"accept": "text/html"}), 406)


def test_results_that_are_gone_are_told(tmp_path):
    api = Api(tmp_path)
    with running(api.jobs):
        job_id = api.submit(sweep(3))
    api.jobs.files(api.jobs.store.get(job_id)).path(0).write_bytes(b"not Parquet")
    for path in ("/cases", "/summary", "/results?format=mat"):
        assert_problem(api.ask("GET", f"/{job_id}{path}"), 404, says="run the job again")
    api.designs.database.close()


def test_the_summary_is_that_of_the_numbers(api):
    summary = JobSummary.model_validate(api.get(f"/{api.done}/summary"), strict=False)
    ranges = [case["metrics"]["range"] for case in api.get(f"/{api.done}/cases")["items"]]
    told = summary.metrics["range"]
    assert (summary.cases, told.count, told.missing) == (CASES, CASES, 0)
    assert told.mean == pytest.approx(np.mean(ranges)) and told.percentiles["50"] == pytest.approx(np.median(ranges))
    assert {item.parameter for item in summary.correlations} == {"place"} and summary.indices is None
    partial = JobSummary.model_validate(api.get(f"/{api.partial}/summary"), strict=False)
    assert partial.failed == 1 and partial.failures[0].case == 1
    assert JobRecord.model_validate(api.get(f"/{api.partial}"), strict=False).failures == partial.failures


def test_a_sensitivity_study_has_indices(api):
    place = {"name": "place", "pointer": POSITION, "low": 0.05, "high": 0.3}
    study = {"kind": "sensitivity", "method": {"kind": "morris", "trajectories": 4}, "parameters": [place]}
    job_id = api.submit(sweep() | study | {"metrics": ["range"]})
    summary = JobSummary.model_validate(api.get(f"/{job_id}/summary"), strict=False)
    ranges = [case["metrics"]["range"] for case in api.get(f"/{job_id}/cases")["items"]]
    own = indices(parse_spec(api.get(f"/{job_id}/spec")), ["place"], {"range": ranges})
    assert summary.indices["range"].model_dump(exclude_none=True) | {"reason": None} == own["range"]
    assert summary.indices["range"].mu_star["place"].value > 0.0


def test_health_asks_the_engine_too(api):
    assert ask("GET", "/readyz", app=api.app).json()["checks"]["engine"] == "ok"
    assert "job_listeners" in ask("GET", "/metrics", app=api.app).text


def test_the_application_starts_and_stops_its_jobs(tmp_path):
    api = Api(tmp_path)

    async def live():
        async with api.app.router.lifespan_context(api.app):
            job, _ = api.jobs.submit(sweep(2))
            await asyncio.to_thread(finished, api.jobs, job)

    asyncio.run(live())
    assert not api.jobs.manager._thread.is_alive()
