"""A job computes each case once and says what became of it; what goes wrong with one takes nothing else along."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from models.assemble import assemble
from models.limits import DEFAULT_LIMITS
from models.metrics import evaluate, metrics_for
from models.problems import DesignError
from models.simulate import run_assembly
from models.variation import Target, Varied
from server.jobs.engines import SerialEngine
from server.jobs.files import part_of
from server.jobs.spec import parse_spec
from server.jobs.submission import Request
from server.jobs.task import FINE
from server.jobs.trajectories import read_trajectory
from server.store.errors import NotFoundError
from server.store.job_records import JobStateError, KeyReusedError
from tests.server.job_support import (
    POSITION,
    assert_whole,
    finished,
    glider,
    listed,
    open_at,
    running,
    sweep,
    table_of,
    wait_for,
)

COMMAND = "/mission/control/schedules/0/points/0/extension"


def chunks_of(size, monkeypatch):
    """Have jobs cut into chunks of so many cases, whatever they cost."""
    monkeypatch.setattr("server.jobs.submission.chunk_size", lambda plan, limits, workers: size)


@pytest.fixture
def jobs(tmp_path):
    with running(open_at(tmp_path)) as jobs:
        yield jobs


def metrics_of_rows(table):
    fixed = table.drop_columns(["case", "status", "reason"])
    return np.column_stack([fixed.column(name).to_numpy(zero_copy_only=False) for name in fixed.column_names])


def test_a_sweep_is_what_single_runs_give(jobs):
    job = finished(jobs, jobs.submit(sweep(7))[0])
    assert job.state == "succeeded" and job.failed == 0
    table = assert_whole(jobs, job)
    spec = parse_spec(json.loads(job.spec))
    metrics = metrics_for(spec.design)
    varied = Varied(spec.design, [[Target(POSITION)]])
    for row, place in zip(table.to_pylist(), np.linspace(0.05, 0.3, 7), strict=True):
        assert row["place"] == pytest.approx(place, abs=1e-15)
        run = run_assembly(assemble(varied.design([row["place"]])))
        expected = evaluate(run, metrics)
        assert [row[m.name] for m in metrics] == [v if np.isfinite(v) else None for v in expected]
        assert row["status"] == run.status.name


def test_the_record_tells_what_it_is_about(jobs):
    job = finished(jobs, jobs.submit(sweep(5, name="places"))[0])
    record = jobs.record(job)
    assert record["name"] == "places" and record["kind"] == "sweep" and record["state"] == "succeeded"
    assert record["progress"] | {"rate": None, "seconds_left": None} == {
        "cases": 5, "done": 5, "failed": 0, "chunks": job.chunks, "chunks_done": job.chunks,
        "rate": None, "seconds_left": None,
    }  # fmt: skip
    assert record["parameters"] == [{"name": "place", "unit": "m", "pointer": POSITION}]
    assert {"name": "range", "unit": "m"}.items() <= record["metrics"][0].items()
    assert record["created"] <= record["started"] <= record["finished"]
    assert len(record["engine"]["processors"]) == 1


def test_a_case_that_is_refused_is_a_result_with_its_reason(jobs):
    """A command beyond the stop is a fine number by itself, but no design that can be simulated."""
    document = listed(COMMAND, [0.0, 0.5, 1e-4, 0.4])
    job = finished(jobs, jobs.submit(document)[0])
    assert job.state == "partial" and job.failed == 2
    rows = assert_whole(jobs, job).to_pylist()
    assert [row["status"] in FINE for row in rows] == [True, False, True, False]
    assert rows[1]["status"] == "refused" and "outside its stops" in rows[1]["reason"]
    assert rows[1]["range"] is None and rows[0]["range"] is not None
    [failure] = jobs.record(job)["failures"]
    assert failure["count"] == 2 and failure["case"] == 1 and failure["reason"].startswith("refused")


def test_failures_of_one_kind_are_one_group(jobs):
    design = glider()
    design["mission"]["solver"] = {"model": "planar", "method": "rk4", "step": 0.01, "output_interval": 0.1}
    document = listed("/mission/solver/step", [5e-4, 0.5, 1.0, 2.0], design=design)
    document["design"]["vehicle"]["damping"] = {"surge": 50.0, "heave": 50.0, "pitch": 50.0}
    job = finished(jobs, jobs.submit(document)[0])
    rows = assert_whole(jobs, job).to_pylist()
    assert rows[0]["status"] == "completed" and {row["status"] for row in rows[1:]} == {"diverged"}
    assert all("stopped at t =" in row["reason"] for row in rows[1:])
    assert jobs.record(job)["failures"] == [{"reason": "diverged", "count": 3, "case": 1}]


def test_a_job_of_which_nothing_succeeds_has_failed(jobs):
    job = finished(jobs, jobs.submit(listed(COMMAND, [0.5, 0.6, 0.7]))[0])
    assert job.state == "failed" and job.failed == 3


def test_one_glide_keeps_its_trajectory(jobs):
    document = {"format": "glider-batch", "version": 1, "kind": "simulate", "design": glider()}
    job = finished(jobs, jobs.submit(document)[0])
    times, values, tables, cells = read_trajectory(jobs.files(job).path(0, "nc"), 0)
    run = run_assembly(assemble(parse_spec(document).design))
    assert np.array_equal(times, run.times) and tuple(cells) == run.cells
    assert all(np.array_equal(values[name], run.values[name]) for name in run.variables)
    assert all(np.array_equal(tables[name], run.cell_values[name]) for name in run.cell_variables)


def test_trajectories_of_chosen_cases_are_kept(tmp_path):
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(sweep(9, trajectories=[0, 4, 8]))[0])
        files = jobs.files(job)
        kept = [
            case for case in range(9)
            if files.path(case // job.chunk_size, "nc").exists()
            and read_trajectory(files.path(case // job.chunk_size, "nc"), case) is not None
        ]  # fmt: skip
    assert kept == [0, 4, 8]


def test_equal_jobs_are_computed_once_unless_asked(jobs):
    first, new = jobs.submit(sweep(4))
    assert new
    again, new = jobs.submit(sweep(4, name="another name"))
    assert not new and again.id == first.id
    other, new = jobs.submit(sweep(4, seed=1), fresh=False)
    assert new and other.id != first.id
    fresh, new = jobs.submit(sweep(4), fresh=True)
    assert new and fresh.id != first.id
    a, b = (table_of(jobs, finished(jobs, job)) for job in (first, fresh))
    assert a.equals(b)


def test_a_key_submits_once(jobs):
    asked = Request("ann", "key-1", "digest")
    first, new = jobs.submit(sweep(3), asked, fresh=True)
    again, repeated = jobs.submit(sweep(3), asked, fresh=True)
    assert new and not repeated and again.id == first.id
    with pytest.raises(KeyReusedError, match="key-1"):
        jobs.submit(sweep(5), Request("ann", "key-1", "other"))
    other, new = jobs.submit(sweep(3), Request("bob", "key-1", "digest"), fresh=True)
    assert new and other.id != first.id


def test_nothing_runs_where_the_document_is_wrong(jobs):
    with pytest.raises(DesignError) as told:
        jobs.submit(listed("/vehicle/components/0/mass", [1.0, -1.0, "x"]))
    assert {p.pointer for p in told.value.problems} == {"/method/rows/1/0", "/method/rows/2/0"}
    assert jobs.store.page() == []


class Held(SerialEngine):
    """An engine that sends nothing beyond `most` chunks until it is let go."""

    workers = 1

    def __init__(self, most: int) -> None:
        super().__init__()
        self.most, self.sent = most, 0

    def submit(self, function, /, *arguments):
        from concurrent.futures import Future

        self.sent += 1
        return super().submit(function, *arguments) if self.sent <= self.most else Future()


def test_cancelling_keeps_what_is_done_and_retrying_goes_on(tmp_path, monkeypatch):
    chunks_of(4, monkeypatch)
    engine = Held(3)
    with running(open_at(tmp_path, engine)) as jobs:
        job, _ = jobs.submit(sweep(40))
        wait_for(lambda: jobs.store.get(job.id).chunks_done == 3, what="three chunks")
        assert jobs.cancel(job.id).state == "cancelling"
        job = finished(jobs, job)
        assert job.state == "cancelled" and job.done == 3 * job.chunk_size == table_of(jobs, job).num_rows
        with pytest.raises(JobStateError, match="was cancelled"):
            jobs.cancel(job.id)
        engine.most = 10_000
        assert jobs.retry(job.id).state == "queued"
        job = finished(jobs, job)
        assert job.state == "succeeded"
        whole = assert_whole(jobs, job)
        other = finished(jobs, jobs.submit(sweep(40), fresh=True)[0])
        assert whole.equals(table_of(jobs, other))


def test_a_program_that_stops_leaves_the_job_to_the_next(tmp_path, monkeypatch):
    chunks_of(4, monkeypatch)
    with running(open_at(tmp_path, Held(3))) as jobs:
        job, _ = jobs.submit(sweep(40))
        wait_for(lambda: jobs.store.get(job.id).chunks_done == 3, what="three chunks")
    left = jobs.store.get(job.id)
    assert left.state == "running" and left.owner is None and left.chunks_done == 3
    engine = Held(10_000)
    with running(open_at(tmp_path, engine)) as jobs:
        job = finished(jobs, job)
        assert job.state == "succeeded" and engine.sent == job.chunks - 3
        assert_whole(jobs, job)


def test_retrying_computes_failed_chunks_only(tmp_path, monkeypatch):
    chunks_of(4, monkeypatch)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(listed(COMMAND, [0.0] * 8 + [0.5]))[0])
        assert job.state == "partial"
        before = {path.name: path.stat().st_mtime_ns for path in jobs.files(job).written()}
        job = finished(jobs, jobs.retry(job.id))
        assert job.state == "partial" and job.failed == 1 and len(jobs.record(job)["failures"]) == 1
        after = {path.name: path.stat().st_mtime_ns for path in jobs.files(job).written()}
        changed = [name for name in before if before[name] != after[name]]
        assert changed == [jobs.files(job).path(8 // job.chunk_size).name]
        good = finished(jobs, jobs.submit(sweep(2))[0])
        with pytest.raises(JobStateError, match="nothing to retry"):
            jobs.retry(good.id)


def test_removing_takes_the_results_along(jobs):
    job = finished(jobs, jobs.submit(sweep(3))[0])
    folder = jobs.files(job).folder
    assert folder.exists()
    jobs.remove(job.id)
    assert not folder.exists()
    with pytest.raises(NotFoundError):
        jobs.store.get(job.id)


def monte_carlo(**stop):
    drawn = {"pointer": POSITION, "distribution": {"kind": "uniform", "low": 0.05, "high": 0.3}}
    return {
        "format": "glider-batch", "version": 1, "kind": "monte_carlo", "design": glider(), "parameters": [drawn],
        "count": 400, "seed": 5, "stop": {"metric": "maximum_depth", "least": 40, "every": 20} | stop,
    }  # fmt: skip


def test_where_to_stop_depends_on_the_cases_alone(tmp_path, monkeypatch):
    """The same number of cases counts for small and large chunks: the first look at which the width is met."""
    stops = []
    for size in (7, 64):
        chunks_of(size, monkeypatch)
        with running(open_at(tmp_path / str(size))) as jobs:
            job = finished(jobs, jobs.submit(monte_carlo(width=0.02))[0])
            assert job.state == "succeeded" and job.stopped_at is not None and job.done == job.counted == job.stopped_at
            record = jobs.record(job)
            assert record["stopped_early"] and f"stopped after {job.stopped_at} of 400" in record["reason"]
            counted = table_of(jobs, job).slice(0, job.stopped_at)
            stops.append((job.stopped_at, counted.column("maximum_depth").to_pylist()))
    assert stops[0] == stops[1]
    from scipy.stats import t

    count, values = stops[0]
    values = np.array(values)
    width = [2 * t.ppf(0.975, n - 1) * values[:n].std(ddof=1) / n**0.5 for n in range(40, count + 1, 20)]
    assert width[-1] <= 0.02 and all(w > 0.02 for w in width[:-1])


def test_a_full_disk_pauses_the_job_and_harms_nothing(tmp_path, monkeypatch):
    """/dev/full refuses every byte as a full disk does; the second chunk is written there."""
    chunks_of(4, monkeypatch)
    os.symlink("/dev/full", tmp_path / "full")

    def on_the_full_disk(path):
        return tmp_path / "full" if path.name.startswith("chunk-000000001.parquet") else part_of(path)

    with running(open_at(tmp_path)) as jobs:
        with monkeypatch.context() as patch:
            patch.setattr("server.jobs.files.part_of", on_the_full_disk)
            job, _ = jobs.submit(sweep(40))
            paused = wait_for(lambda: (j := jobs.store.get(job.id)).state == "paused" and j, what="the pause")
        assert "the disk is full" in paused.reason and "resume" in paused.reason
        assert 1 not in jobs.store.written(job.id) and not jobs.files(job).path(1).exists()
        with pytest.raises(JobStateError, match="paused"):
            jobs.remove(job.id)
        jobs.resume(job.id)
        job = finished(jobs, job)
        assert job.state == "succeeded" and job.reason is None
        undisturbed = finished(jobs, jobs.submit(sweep(40), fresh=True)[0])
        assert undisturbed.id != job.id
        assert assert_whole(jobs, job).equals(assert_whole(jobs, undisturbed))


def test_a_job_pauses_before_the_disk_is_full(tmp_path):
    with running(open_at(tmp_path, reserve=2**60)) as jobs:
        job, _ = jobs.submit(sweep(3))
        paused = wait_for(lambda: (j := jobs.store.get(job.id)).state == "paused" and j, what="the pause")
        assert "MiB are free" in paused.reason
        assert jobs.cancel(job.id).state == "cancelled"


def test_a_worker_of_another_version_is_not_believed(tmp_path, monkeypatch):
    monkeypatch.setattr("server.jobs.manager.KERNEL_HASH", "another")
    with running(open_at(tmp_path)) as jobs:
        job, _ = jobs.submit(sweep(3))
        paused = wait_for(lambda: (j := jobs.store.get(job.id)).state == "paused" and j, what="the pause")
        assert "another version" in paused.reason and paused.done == 0


def test_a_fault_of_one_case_is_that_cases_alone(tmp_path, monkeypatch):
    from server.jobs import chunk

    real = chunk.evaluate

    def faulty(run, metrics):
        if run.design.vehicle.components[1].position[0] > 0.29:
            raise ZeroDivisionError("a slip")
        return real(run, metrics)

    monkeypatch.setattr(chunk, "evaluate", faulty)
    with running(open_at(tmp_path)) as jobs:
        job = finished(jobs, jobs.submit(sweep(6))[0])
        rows = assert_whole(jobs, job).to_pylist()
    assert [row["status"] for row in rows[:5]] == ["completed"] * 5
    assert rows[5]["status"] == "crashed" and "a slip" in rows[5]["reason"]


def test_jobs_take_turns(tmp_path, monkeypatch):
    """A small job does not wait for a large one to end."""
    chunks_of(16, monkeypatch)
    with running(open_at(tmp_path)) as jobs:
        large, _ = jobs.submit(sweep(3000))
        small, _ = jobs.submit(sweep(4))
        assert finished(jobs, small).state == "succeeded"
        assert not jobs.store.get(large.id).over
        jobs.cancel(large.id)
        finished(jobs, large)


def test_chunks_are_sized_by_time_count_and_memory(monkeypatch):
    """About a second each, two for every worker, at most so many, and no more trajectories than fit in memory."""
    from server.jobs import submission
    from server.jobs.plan import make_plan

    def size(count, seconds, workers=2, **more):
        monkeypatch.setattr(submission, "_seconds_a_case", lambda design, limits: seconds)
        spec = parse_spec(sweep(count, **more))
        return submission.chunk_size(make_plan(spec, spec.design, max_cases=10**9), DEFAULT_LIMITS, workers)

    assert size(10**5, 0.01) == 96  # a second's work, in whole lanes
    assert size(10**5, 0.01, workers=500) == 96  # ten seconds' work, but two chunks for every worker
    assert size(8, 0.01) == 2
    assert size(10**5, 100.0) == 5  # no more than 20,000 chunks
    assert size(10**9, 0.001) == 50_000
    kept = size(10**9, 0.001, trajectories="all")
    numbers = (4.0 / 0.05 + 2) * submission.COLUMNS_OF_RUN
    assert kept * numbers <= submission.MOST_NUMBERS < (kept + 16) * numbers
    # of listed cases a chunk keeps no more than there are, so that few do not shrink it
    assert size(10**5, 0.01, trajectories=[0]) == 96
    assert size(10**9, 0.001, trajectories=list(range(kept))) == 50_000
    assert size(10**9, 0.001, trajectories=list(range(kept + 16))) == kept


def test_sending_a_job_does_not_wait_for_the_compiler(monkeypatch):
    from server.jobs import submission
    from server.jobs.plan import make_plan

    def never(*_args, **_options):
        raise AssertionError("flown, though nothing is compiled yet")

    monkeypatch.setattr(submission, "batch_is_compiled", lambda: False)
    monkeypatch.setattr(submission, "warm_batch", never)
    monkeypatch.setattr(submission, "run_batch", never)
    spec = parse_spec(sweep(1000))
    chunk = submission.chunk_size(make_plan(spec, spec.design, max_cases=1000), DEFAULT_LIMITS, 2)
    assert chunk == submission.LANES


def test_composed_metrics_are_measured(jobs):
    deepest = {"name": "deepest early on", "kind": "statistic", "of": "z", "statistic": "maximum",
               "over": {"kind": "time", "begin": 0.0, "end": 2.0}}  # fmt: skip
    share = {"name": "share", "kind": "ratio", "of": ["final_depth", deepest]}
    job = finished(jobs, jobs.submit(sweep(4, metrics=["final_depth", deepest, share]))[0])
    assert job.state == "succeeded"
    for row in assert_whole(jobs, job).to_pylist():
        assert row["share"] == pytest.approx(row["final_depth"] / row["deepest early on"], rel=1e-12)


def test_a_job_that_cannot_begin_fails_and_holds_nobody_up(tmp_path, monkeypatch):
    def broken(document):
        raise RuntimeError("a slip")

    with monkeypatch.context() as patch, running(open_at(tmp_path)) as jobs:
        patch.setattr("server.jobs.manager.plan_of", broken)
        job = finished(jobs, jobs.submit(sweep(3))[0])
        assert job.state == "failed" and "a slip" in job.reason
        patch.undo()
        assert finished(jobs, jobs.submit(sweep(3), fresh=True)[0]).state == "succeeded"


def test_a_parameter_that_changes_nothing_is_told(jobs):
    """The preset declares its mass, so a component's own decides nothing; its place does."""
    idle, moving = "/vehicle/components/1/mass", POSITION
    method = {"kind": "full_factorial", "parameters": [
        {"name": "bellows mass", "pointer": idle, "values": [0.03, 3.0]},
        {"name": "place", "pointer": moving, "values": [0.1, 0.2]}]}  # fmt: skip
    record = jobs.record(finished(jobs, jobs.submit(sweep(method=method))[0]))
    [warning] = record["warnings"]
    assert "bellows mass changes nothing" in warning and idle in warning
    assert jobs.record(finished(jobs, jobs.submit(sweep(3))[0]))["warnings"] == []
