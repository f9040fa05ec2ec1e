"""Owns the summary of a job's results: statistics of metrics, correlations, failures by reason, sensitivity indices.

Metrics of failed cases are left out: they say how far a run got before it went wrong. Count, mean, standard deviation
and extremes are of all other cases; of very many, percentiles and correlations are those of a random part, told in
`sampled`. A mean has an interval only where cases are drawn independently of each other: a grid has no chance in it,
and the points of a Latin hypercube or of Sobol fill their ranges better than chance, by how much one plan cannot tell.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pydantic_core import to_json

from server.jobs.case_table import FIXED, CaseRow
from server.jobs.correlations import correlations
from server.jobs.files import write_whole
from server.jobs.intervals import MOST_RESAMPLED, Interval, interval_of_mean, normal_interval
from server.jobs.moments import Moments
from server.jobs.results import Results
from server.jobs.sensitivity import indices
from server.jobs.spec import Sensitivity
from server.jobs.task import FINE, ColumnInfo

Array = NDArray[np.float64]
PERCENTILES = (5, 25, 50, 75, 95)
MOST_VALUES = 4_000_000
"""Most numbers held of the table (32 MB); of more cases a random part is held."""
MOST_GROUPS = 50
"""Most groups of failures that are told."""
SEED = 20_250_102
VERSION = 2
"""Of what is kept in a file; a file of another version is not used."""
DRAWN = "monte_carlo"
"""The kind of job whose cases are drawn independently of each other."""


def summarize(
    results: Results, *, study: Sensitivity | None = None, drawn: bool = False, keep: bool = False
) -> dict[str, Any]:
    """Return the summary, ready for JSON.

    Parameters
    ----------
    results
        The case table.
    study
        The batch document of a sensitivity study, which has indices.
    drawn
        Whether the cases are drawn independently of each other: then means have intervals.
    keep
        Whether the job is over: then the summary is kept in its folder, and used until a chunk changes.

    """
    if not keep:
        return _summary(results, study, drawn=drawn)
    path, state = results.files.folder / "summary.json", _state(results)
    with suppress(OSError, ValueError, KeyError, TypeError):
        kept = json.loads(path.read_bytes())
        if kept["of"] == state:
            return dict(kept["summary"])
    summary = _summary(results, study, drawn=drawn)
    with suppress(OSError):  # what cannot be kept is computed again
        write_whole(path, to_json({"of": state, "summary": summary}))
    return summary


def _state(results: Results) -> str:
    """Return a digest that changes with any chunk that is written or removed."""
    digest = hashlib.sha256(f"{VERSION} {results.cases}".encode())
    for path in results.files.written():
        about = path.stat()
        digest.update(f" {path.name} {about.st_size} {about.st_mtime_ns}".encode())
    return digest.hexdigest()


def _summary(results: Results, study: Sensitivity | None, *, drawn: bool) -> dict[str, Any]:
    columns = [column for column in results.columns() if column.numeric]
    parameters = [column.name for column in columns if column.role == "parameter"]
    metrics = [column for column in columns if column.role == "metric"]
    names = [column.name for column in metrics]
    table = _read(results, parameters, names)
    groups = sorted(table.failures.values(), key=lambda group: (-group["count"], group["case"]))
    return {
        "cases": table.cases,
        "failed": sum(group["count"] for group in groups),
        "sampled": len(table.metrics) if table.is_part else None,
        "metrics": {column.name: _of_metric(column, table, k, drawn=drawn) for k, column in enumerate(metrics)},
        "correlations": correlations(table.parameters, table.metrics, parameters, names),
        "failures": groups[:MOST_GROUPS],
        "indices": None if study is None else _indices(results, study, parameters, names),
    }


@dataclass(frozen=True, slots=True)
class _Table:
    """Values (cases, columns), NaN for none; of all `cases`, or of a part. `moments` and `failures` are of all."""

    cases: int
    parameters: Array
    metrics: Array
    is_part: bool
    moments: Moments
    failures: dict[str, dict[str, Any]]


def _read(results: Results, parameters: Sequence[str], metrics: Sequence[str]) -> _Table:
    chunks = results.chunks()
    cases, split = results.count(chunks), len(parameters)
    most = MOST_VALUES // max(1, split + len(metrics))
    generator = np.random.default_rng(SEED)
    moments, failures, held = Moments(len(metrics)), dict[str, dict[str, Any]](), list[Array]()
    for block in results.blocks([*FIXED, *parameters, *metrics], chunks=chunks):
        fine = np.isin(np.asarray(block.column(1).to_pylist()), FINE)
        _count_failures(block.filter(pa.array(~fine)), failures)
        values = np.empty((block.num_rows, split + len(metrics)))
        for k, column in enumerate(block.columns[len(FIXED) :]):
            values[:, k] = column.to_numpy(zero_copy_only=False)
        values[~fine, split:] = np.nan
        moments.add(values[:, split:])
        held.append(values if cases <= most else values[generator.random(len(values)) < most / cases])
    values = np.concatenate(held) if held else np.empty((0, split + len(metrics)))
    return _Table(cases, values[:, :split], values[:, split:], cases > most, moments, failures)


def _count_failures(failed: pa.RecordBatch, failures: dict[str, dict[str, Any]]) -> None:
    for case, status, reason in zip(*(column.to_pylist() for column in failed.columns[: len(FIXED)]), strict=True):
        group = CaseRow(case, status, reason, (), ()).group
        failures.setdefault(group, {"reason": group, "count": 0, "case": case})["count"] += 1


def _of_metric(column: ColumnInfo, table: _Table, k: int, *, drawn: bool) -> dict[str, Any]:
    moments = table.moments
    count, mean, sd = int(moments.count[k]), moments.mean[k], moments.sd[k]
    values = table.metrics[:, k]
    values = values[np.isfinite(values)]
    interval = _interval(table, values, mean=mean, sd=sd, count=count) if drawn else None
    found = np.percentile(values, PERCENTILES) if len(values) else np.full(len(PERCENTILES), np.nan)
    return {
        "unit": column.unit, "meaning": column.meaning,
        "count": count, "missing": table.cases - count,
        "mean": _finite(mean), "sd": _finite(sd), "least": _finite(moments.least[k]), "most": _finite(moments.most[k]),
        "percentiles": {str(p): _finite(value) for p, value in zip(PERCENTILES, found, strict=True)},
        "interval": None if interval is None else {
            "of": "mean", "confidence": interval.confidence, "low": _finite(interval.low),
            "high": _finite(interval.high), "method": interval.method,
        },
    }  # fmt: skip


def _interval(table: _Table, values: Array, *, mean: float, sd: float, count: int) -> Interval | None:
    if not table.is_part and count <= MOST_RESAMPLED:
        return interval_of_mean(values)
    return normal_interval(mean, sd, count) if count > 1 else None


def _indices(
    results: Results, study: Sensitivity, parameters: Sequence[str], metrics: Sequence[str]
) -> dict[str, dict[str, Any]]:
    """Return the indices, one metric after another: only its values are held."""
    chunks, found = results.chunks(), dict[str, dict[str, Any]]()
    for metric in metrics:
        parts = [np.zeros(0)]
        for block in results.blocks(["status", metric], chunks=chunks):
            fine = np.isin(np.asarray(block.column(0).to_pylist()), FINE)
            parts.append(np.where(fine, block.column(1).to_numpy(zero_copy_only=False), np.nan))
        found |= indices(study, parameters, {metric: np.concatenate(parts).tolist()})
    return found


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
