"""Owns the way of a batch document into the queue: checked whole, its cases laid out, its chunks sized."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from models.assemble import assemble
from models.batch import run_batch
from models.design import Design
from models.kernel import KERNEL_HASH
from models.limits import Limits
from models.problems import DesignError, Problem
from models.warm import batch_is_compiled, warm_batch
from server.jobs.inert import inert_warnings
from server.jobs.plan import Plan, make_plan
from server.jobs.spec import JobSpec, checksum, parse_spec
from server.store.identifiers import new_id
from server.store.job_records import Job, NewJob
from server.version import VERSION

CHUNK_SECONDS = 1.0
"""About how long a chunk should take: short enough to cancel, watch and lose, long enough to be worth sending."""
KEPT_BUSY = 50
"""Workers that one manager keeps busy with such chunks: it writes and counts some ten times as many in a second."""
LARGEST_CHUNK = 1024
MOST_CHUNKS = 20_000
"""Chunks of a job beyond which they grow instead: each is a file or two, and a row."""
LANES = 16
"""Chunks are multiples of this, so that the kernel's lanes are full."""
UNTIMED = CHUNK_SECONDS / LANES
"""Guess of how long a case takes where none can be flown yet, s."""
PROBE_STEPS = 20_000
MOST_NUMBERS = 20_000_000
"""Most numbers in the trajectories that one chunk keeps."""
COLUMNS_OF_RUN = 70
"""About how many numbers a sample of a run holds."""
KIND_NAMES = {
    "simulate": "Simulation", "sweep": "Sweep", "monte_carlo": "Monte Carlo", "sensitivity": "Sensitivity",
}  # fmt: skip
"""How a kind of job is called in the name of one that was given none."""
FindDesign = Callable[[str, int | None], tuple[Design, int]]


@dataclass(frozen=True, slots=True)
class Request:
    """Who asks: the principal, their idempotency key, a digest of what was sent."""

    principal: str = "local"
    key: str | None = None
    digest: str = ""


def prepare(
    document: Any, request: Request, *, find_design: FindDesign, limits: Limits, max_cases: int, workers: int
) -> NewJob:
    """Return the job that a batch document asks for.

    Raises
    ------
    DesignError
        With everything that is wrong; pointers lead into the batch document.

    """
    spec = parse_spec(document)
    design, revision = _design_of(spec, find_design)
    plan = make_plan(spec, design, max_cases=max_cases)
    inlined = spec.model_copy(update={"design": design, "design_id": None, "revision": None})
    about = _about(plan, spec.design_id, revision, warnings=list(inert_warnings(plan, limits)))
    return NewJob(
        id=new_id(), kind=spec.kind, name=spec.name or _default_name(spec, design), spec=inlined.model_dump_json(),
        about=json.dumps(about), checksum=checksum(inlined, design, engine_version()), principal=request.principal,
        idempotency_key=request.key, request_digest=request.digest, cases=plan.count,
        chunk_size=chunk_size(plan, limits, workers),
    )  # fmt: skip


def engine_version() -> str:
    """Return what, beside the inputs, decides the numbers: the program's version and its kernel's hash."""
    return f"{VERSION} {KERNEL_HASH}"


def restamped(job: Job, plan: Plan) -> dict[str, str] | None:
    """Return what to keep of a job that another version of the program queued; None where this one did."""
    about = json.loads(job.about)
    ours = {"version": VERSION, "kernel": KERNEL_HASH}
    if about["engine"] == ours:
        return None
    return {
        "about": json.dumps(about | {"engine": ours}), "checksum": checksum(plan.spec, plan.design, engine_version())
    }  # fmt: skip


def _design_of(spec: JobSpec, find_design: FindDesign) -> tuple[Design, int | None]:
    if spec.design is not None:
        return spec.design, None
    assert spec.design_id is not None
    return find_design(spec.design_id, spec.revision)


def _default_name(spec: JobSpec, design: Design) -> str:
    return f"{KIND_NAMES[spec.kind]} of {design.name}"[:200]


def _about(plan: Plan, design_id: str | None, revision: int | None, *, warnings: list[str]) -> dict[str, Any]:
    keep = plan.spec.trajectories
    return {
        "design": {
            "name": plan.design.name, "identity": plan.design.identity, "id": design_id, "revision": revision,
        },
        "parameters": [{"name": p.name, "unit": p.unit, "pointer": p.pointer} for p in plan.parameters],
        "metrics": [{"name": m.name, "unit": m.unit, "meaning": m.meaning} for m in plan.metrics],
        "engine": {"version": VERSION, "kernel": KERNEL_HASH},
        "warnings": warnings,
        "trajectories": keep if isinstance(keep, str) else ("some" if keep else "none"),
    }  # fmt: skip


def chunk_size(plan: Plan, limits: Limits, workers: int) -> int:
    """Return how many cases make a chunk: about a second's work, and enough chunks for every worker."""
    wanted = CHUNK_SECONDS * max(1.0, workers / KEPT_BUSY)
    size = math.ceil(wanted / max(_seconds_a_case(plan.design, limits), 1e-4))
    size = min(size, LARGEST_CHUNK, math.ceil(plan.count / (2 * workers)))
    size = max(size, math.ceil(plan.count / MOST_CHUNKS))
    fitting = _runs_that_fit(plan.design)
    if _kept(plan) > fitting:  # otherwise all that are kept fit into one chunk
        size = min(size, fitting)
    return max(1, size if size < LANES else size // LANES * LANES)


def _kept(plan: Plan) -> int:
    """Return how many cases keep their trajectories."""
    keep = plan.spec.trajectories
    if isinstance(keep, str):
        return plan.count if keep == "all" else 0
    return len(set(keep))


def _runs_that_fit(design: Design) -> int:
    """Return how many trajectories one chunk may keep."""
    mission = design.mission
    samples = mission.duration / mission.solver.output_interval + 2
    return max(1, int(MOST_NUMBERS / (COLUMNS_OF_RUN * samples)))


def _seconds_a_case(design: Design, limits: Limits) -> float:
    """Return about how long one case takes, by the beginning of the design's own glide; a guess where it has none."""
    try:
        assembly = assemble(design, limits)
    except DesignError:  # its cases may be better
        return UNTIMED
    if not batch_is_compiled():  # a machine's first job waits in the queue for that, whoever sent it does not
        return UNTIMED
    warm_batch()
    for _ in range(2):  # the first run in a process also loads what it needs
        began = time.perf_counter()
        [run] = run_batch([assembly], limits=replace(limits, steps=min(limits.steps, PROBE_STEPS)))
        took = time.perf_counter() - began
    reached = float(run.times[-1])
    whole = run.status.name != "too_many_steps" or reached <= 0.0
    return took if whole else took * design.mission.duration / reached


def no_store(design_id: str, revision: int | None) -> tuple[Design, int]:
    """Stands for a store where there is none: only documents that hold their design can be run."""
    message = "there is no store of designs here"
    raise DesignError([Problem("/design_id", message, hint="give the design itself as 'design'")])
