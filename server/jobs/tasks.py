"""Owns how a job becomes tasks: its plan read back from the batch document, and the chunks' work cut from it."""

from __future__ import annotations

import json
import sys

from models.limits import Limits
from server.jobs.plan import Plan, make_plan
from server.jobs.spec import parse_spec
from server.jobs.task import ChunkTask, ColumnInfo


def plan_of(document: str) -> Plan:
    """Return the plan of a job from its batch document, the design inside it; how many cases it has was checked before.

    Raises
    ------
    DesignError
        Where the document is no longer one that this program reads.

    """
    spec = parse_spec(json.loads(document))
    assert spec.design is not None
    return make_plan(spec, spec.design, max_cases=sys.maxsize)


def columns_of(plan: Plan) -> tuple[ColumnInfo, ...]:
    """Return the columns of the case table that are a job's own."""
    parameters = [ColumnInfo(p.name, p.unit, p.meaning, "parameter", p.numeric) for p in plan.parameters]
    return (*parameters, *(ColumnInfo(m.name, m.unit, m.meaning, "metric") for m in plan.metrics))


class TaskMaker:
    """Cuts tasks from a plan; what all have in common is prepared once."""

    def __init__(self, plan: Plan, limits: Limits) -> None:
        self._plan, self._limits = plan, limits
        self._design = plan.design.model_dump_json()
        spec = plan.spec
        self._metrics = json.dumps(spec.model_dump(mode="json", include={"metrics"})["metrics"])
        self._columns = columns_of(plan)
        self._keep = spec.trajectories if isinstance(spec.trajectories, str) else frozenset(spec.trajectories)

    def task(self, job: str, chunk: int, first: int, last: int) -> ChunkTask:
        """Return the work on cases `first` to `last` - 1."""
        keep = self._keep
        if not isinstance(keep, str):
            keep = frozenset(case for case in keep if first <= case < last)
        return ChunkTask(
            job=job, chunk=chunk, first=first, design=self._design, targets=self._plan.targets,
            rows=tuple(self._plan.rows(first, last)), metrics=self._metrics, columns=self._columns, keep=keep,
            limits=self._limits,
        )  # fmt: skip
