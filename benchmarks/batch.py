"""What a batch costs beside the kernel, on all cores: `python -m benchmarks.batch`.

Bare kernel calls of the same cases on one core take turns with the jobs, so that a busy machine slows both. The pool is
warm. Jobs include everything: varying, checking and assembling the designs, dispatch, metrics, and files. What a chunk
takes of the processor in this process, beside bare calls, is told as well: other programs spoil that least.
"""

from __future__ import annotations

import json
import os
import resource
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bare import recorded_run, with_solver
from benchmarks.timing import print_ratio
from models.assemble import assemble
from models.design import Design
from models.limits import DEFAULT_LIMITS
from models.presets import load_preset
from models.variation import Target, Varied
from server.jobs.chunk import run_chunk
from server.jobs.engines import ProcessEngine
from server.jobs.service import Jobs
from server.jobs.tasks import TaskMaker, plan_of
from server.store.database import Database, sqlite_url
from server.store.job_records import Job

POSITION = "/vehicle/components/1/position/0"
PITCH = "/mission/initial/pitch"
BARE_CASES = 100
CHUNK = 128
TURNS = 20
MEMORY_GOAL = 600.0


def planar(**solver: object) -> Design:
    """Return the paper's glider."""
    return with_solver(load_preset("canete-dual-bellows"), **solver)


def spatial(**solver: object) -> Design:
    """Return the glider with four cells, some minutes of its spiral."""
    design = load_preset("quad-bellows-spiral")
    design = design.model_copy(update={"mission": design.mission.model_copy(update={"duration": 240.0})})
    return with_solver(design, output_interval=1.0, **solver)


def short(**solver: object) -> Design:
    """Return a glide of a few seconds, for very many cases."""
    design = planar(output_interval=0.2, **solver)
    control = design.mission.control.model_copy(update={"schedules": ()})
    return design.model_copy(
        update={"mission": design.mission.model_copy(update={"duration": 4.0, "control": control})}
    )


def places(design: Design) -> tuple[float, float]:
    """Return between which places the first cell is moved, m."""
    x = design.vehicle.components[1].position[0]
    return x - 0.2 * abs(x), x + 0.2 * abs(x)


def sweep_of(design: Design, cases: int) -> dict[str, Any]:
    """Return a batch document: the first cell's place and the initial pitch drawn at random."""
    low, high = places(design)
    drawn = [
        {"pointer": POSITION, "distribution": {"kind": "uniform", "low": low, "high": high}},
        {"pointer": PITCH, "distribution": {"kind": "uniform", "low": -0.2, "high": 0.2}},
    ]
    return {
        "format": "glider-batch", "version": 1, "kind": "monte_carlo", "design": design.model_dump(mode="json"),
        "parameters": drawn, "count": cases,
    }  # fmt: skip


def bare_rate(design: Design) -> float:
    """Return the single-core rate of bare kernel calls over variants of a design, cases a second."""
    runs = bare_runs(design, BARE_CASES)
    runs[0]()
    began = time.perf_counter()
    for run in runs:
        run()
    return BARE_CASES / (time.perf_counter() - began)


def bare_runs(design: Design, cases: int) -> Sequence[Callable[[], object]]:
    """Return bare kernel calls of variants of a design."""
    low, high = places(design)
    varied = Varied(design, [[Target(POSITION)], [Target(PITCH)]])
    rows = np.random.default_rng(1).uniform([low, -0.2], [high, 0.2], (cases, 2)).tolist()
    return [recorded_run(assemble(varied.design(row))) for row in rows]


def processor_time(work: Callable[[], object]) -> float:
    """Return what some work takes of the processor, s."""
    began = time.process_time()
    work()
    return time.process_time() - began


def report_chunk(label: str, design: Design) -> None:
    """Print the processor time of a case in a chunk, and of a bare call: the least of some turns."""
    task = TaskMaker(plan_of(json.dumps(sweep_of(design, CHUNK))), DEFAULT_LIMITS).task("", 0, 0, CHUNK)
    bare = bare_runs(design, CHUNK // 4)
    run_chunk(task)
    turns = [
        (processor_time(lambda: run_chunk(task)), processor_time(lambda: [run() for run in bare]))
        for _ in range(TURNS)
    ]  # fmt: skip
    chunk, alone = np.min(turns, axis=0) / (CHUNK, len(bare))
    print(f"{label}: {1e3 * chunk:.2f} ms of the processor a case in a chunk; bare {1e3 * alone:.2f} ms")


def run_job(jobs: Jobs, document: dict[str, Any]) -> tuple[Job, float]:
    """Return a job that is over and how long it took from submission to the end, s."""
    began = time.perf_counter()
    job, _ = jobs.submit(document, fresh=True)
    while not (job := jobs.store.get(job.id)).over:
        time.sleep(0.02)
    return job, time.perf_counter() - began


def compare(jobs: Jobs, label: str, design: Design, cases: int, *, target: str) -> None:
    """Print the rate of a job over the rate of bare calls before and after it."""
    run_job(jobs, sweep_of(design, 64))
    before = bare_rate(design)
    job, seconds = run_job(jobs, sweep_of(design, cases))
    bare = 0.5 * (before + bare_rate(design))
    rate = cases / seconds
    told = f"{rate:.0f} a second ({job.failed} failed); bare {bare:.0f} a second"
    print(f"{label}: {cases} cases in {seconds:.1f} s, {told}")
    print_ratio(
        f"{label}: job on {jobs.manager.engine.workers} cores over bare calls on one", rate / bare, target=target
    )


def report_growth(jobs: Jobs) -> None:
    """Print the time a case for a thousand and for a hundred thousand, and the memory that the server takes."""
    run_job(jobs, sweep_of(short(), 64))
    times = {}
    for cases in (1_000, 100_000):
        _, seconds = run_job(jobs, sweep_of(short(), cases))
        times[cases] = seconds / cases
        print(f"metrics only: {cases} cases in {seconds:.1f} s, {1e3 * seconds / cases:.2f} ms a case")
    print_ratio("time a case: 100,000 cases over 1,000", times[100_000] / times[1_000], target="about 1x")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"largest memory of the server so far: {peak:.0f} MB   to reach: below {MEMORY_GOAL:.0f} MB")


def main() -> None:
    """Run everything and print the ratios."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        jobs = Jobs(Database(sqlite_url(root / "studio.sqlite")), ProcessEngine(os.cpu_count()), root / "jobs")
        jobs.start()
        try:
            report_growth(jobs)
            rk4 = {"method": "rk4"}
            compare(jobs, "planar, RK4 at 1 ms", planar(**rk4, step=1e-3), 10_000, target="at least 1.8x")
            compare(jobs, "spatial, RK4 at 20 ms", spatial(**rk4, step=0.02), 2_000, target="at least 1.8x")
            for label, design, cases in (
                ("planar, 20 s", planar(), 10_000),
                ("planar, 130 s", load_preset("three-cell-glider"), 10_000),
                ("spatial, 240 s", spatial(), 2_000),
            ):
                compare(jobs, f"{label}, adaptive", design, cases, target="at least 1.8x")
                report_chunk(f"{label}, adaptive", design)
        finally:
            jobs.stop()


if __name__ == "__main__":
    main()
