"""What jobs gave, as the API shows it: cases, trajectories, tables in every format, summaries."""

from __future__ import annotations

import io
import json
import threading

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
from server.jobs.sensitivity import indices
from server.jobs.spec import parse_spec
from server.schemas_jobs import CaseItem, JobRecord, JobSummary, Trajectory
from tests.server.job_api_support import CASES, COMMAND, KEPT, Api
from tests.server.job_support import POSITION, glider, running, sweep
from tests.server.support import assert_problem, read_json

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


def test_no_run_starts_a_thread_for_its_time_limit(api, monkeypatch):
    api.get(f"/{api.done}/cases/3/trajectory")  # the one thread of all limits begins here
    started = []
    original = threading.Thread.start
    monkeypatch.setattr(threading.Thread, "start", lambda self: (started.append(type(self)), original(self))[1])
    api.get(f"/{api.done}/cases/3/trajectory")
    assert threading.Timer not in started


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
    assert json.loads(parquet.schema.metadata[b"batch_document"])["kind"] == "sweep"
    assert json.loads(parquet.schema.metadata[b"design"]) == api.get(f"/{api.done}")["design"]
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
    for name in ("netcdf", "nc"):  # as the command line and files' endings call it
        answer = api.ask("GET", f"/{api.partial}/results?format={name}")
        assert answer.headers["content-disposition"].endswith(f'{api.partial}.nc"')
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
    assert told.interval is None  # a sweep is laid out, not drawn
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
