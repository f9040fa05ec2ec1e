"""Owns the record of a job as everyone sees it: state, progress, what it is about, and why cases failed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from server.store.job_records import Failure, Job


def record_of(job: Job, *, failures: Sequence[Failure]) -> dict[str, Any]:
    """Return a job's record, ready for JSON."""
    about = json.loads(job.about)  # jobs that an earlier version kept lack the warnings
    return {
        "id": job.id, "name": job.name, "kind": job.kind, "state": job.state, "reason": job.reason,
        "created": moment(job.created), "started": moment(job.started), "finished": moment(job.finished),
        "progress": {
            "cases": job.counted, "done": job.done, "failed": job.failed,
            "chunks": job.chunks, "chunks_done": job.chunks_done,
            "rate": job.rate_now, "seconds_left": job.seconds_left,
        },
        "design": about["design"], "parameters": about["parameters"], "metrics": about["metrics"],
        "engine": about["engine"] | {"processors": job.processors.splitlines()},
        "checksum": job.checksum, "trajectories": about["trajectories"],
        "failures": [{"reason": f.reason, "count": f.count, "case": f.case} for f in failures],
        "stopped_early": job.stopped_at is not None, "warnings": about.get("warnings", []),
    }  # fmt: skip


def told_in_files(job: Job, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a file of results says of its job."""
    shown = ("id", "kind", "state", "created", "finished", "checksum", "design", "engine", "stopped_early")
    return {"title": job.name} | {name: record[name] for name in shown} | {"batch_document": job.spec}


def moment(seconds: float | None) -> str | None:
    """Return a time since 1970 in ISO 8601, UTC."""
    return None if seconds is None else datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")
