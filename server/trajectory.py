"""Owns the trajectory of one case of a job: from the file that keeps it, or simulated again. It knows no HTTP."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr

from models.assemble import assemble
from models.batch import run_batch
from models.design import Design
from models.limits import Limits
from models.problems import Problem
from models.run import Run, Status
from models.simulate import Control
from models.variation import Varied
from server.jobs.files import TRAJECTORIES, JobFiles
from server.jobs.plan import Plan
from server.jobs.tasks import plan_of
from server.jobs.trajectories import read_trajectory
from server.store.job_records import Job
from server.time_limits import TimeLimits
from server.version import VERSION

LONGEST = 30.0
"""Longest that a case is computed again for one who waits, s."""
_TIME_LIMITS = TimeLimits()
planned = lru_cache(maxsize=8)(plan_of)
"""Returns the plan of a batch document; those asked for lately are kept, since a large one takes a while to check."""


class TooLongError(Exception):
    """A case takes longer to compute again than anyone should wait for."""


@dataclass(frozen=True)
class CaseRun:
    """The run of a case; one that was `kept` lacks events and statistics, which no file of a job holds."""

    run: Run
    kept: bool
    warnings: tuple[Problem, ...] = ()


def case_design(plan: Plan, case: int) -> Design:
    """Return the design of a case; raises `DesignError` where its values make none."""
    [row] = plan.rows(case, case + 1)
    return Varied(plan.design, plan.targets).design(row)


def case_run(job: Job, case: int, files: JobFiles, limits: Limits, control: Control) -> CaseRun:
    """Return the run of a case, with the numbers that its metrics were computed from.

    Raises
    ------
    DesignError
        Where the case was refused: its values make no design that can be simulated.
    TooLongError
        Where it was not kept, and takes too long to compute again.

    """
    design = case_design(planned(job.spec), case)
    path = files.path(case // job.chunk_size, TRAJECTORIES)
    kept = _kept_run(path, case, design) if path.exists() else None
    if kept is not None:
        return CaseRun(kept, kept=True)
    with _TIME_LIMITS.within(LONGEST, control.cancel):
        [run] = run_batch([assemble(design, limits)], limits=limits, control=control)
    if run.status is Status.cancelled:
        raise TooLongError(
            f"the trajectory of case {case} was not kept, and takes longer than {LONGEST:g} s to compute again: "
            f'run it by itself with "trajectories": [{case}], or simulate its design'
        )
    return CaseRun(run, kept=False, warnings=tuple(_changes(job, run)))


def _changes(job: Job, run: Run) -> Iterator[Problem]:
    """Yield why the numbers may not be those of the job."""
    before = json.loads(job.about)["engine"]
    if before["kernel"] != run.kernel:
        then, now = f"{before['version']}, kernel {before['kernel']}", f"{VERSION}, kernel {run.kernel}"
        message = f"the job ran on version {then}; the case was simulated again by version {now}"
        yield Problem("", f"{message}: the numbers may differ a little", hint="run the job again to compare")


def _kept_run(path: Path, case: int, design: Design) -> Run | None:
    found = read_trajectory(path, case)
    if found is None:
        return None
    times, values, tables, cells = found
    names = [part.name for _, part in design.vehicle.actuated]
    own = np.array([cells.index(name) for name in names], dtype=np.int64)
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as stored:
        status = str(stored["status"].values[stored["case"].values == case][0])
        kernel = str(stored.attrs["kernel"])
    return Run(
        design=design, times=times, values=values, cells=tuple(names),
        cell_values={name: table[:, own] for name, table in tables.items()},
        status=Status[status], events=(), statistics={}, kernel=kernel,
    )  # fmt: skip
