"""Owns what a batch leaves in its folder beside the job itself: the table of its cases, and the summary."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from server.format_names import ENDINGS
from server.jobs.formats import file_blocks, mat_file, netcdf_file, parquet_file, stream_csv, stream_json
from server.jobs.record import told_in_files
from server.jobs.results import Results
from server.jobs.service import Jobs
from server.jobs.spec import Sensitivity, parse_spec
from server.jobs.summary import DRAWN, summarize
from server.store.job_records import Job


def write_results(jobs: Jobs, job: Job, folder: Path, formats: Sequence[str]) -> dict[str, Any]:
    """Write cases.* and summary.json, each whole or not at all; return the summary."""
    results = Results(jobs.files(job), cases=job.counted, chunk_size=job.chunk_size)
    for format in dict.fromkeys(formats):
        _write(folder / f"cases.{ENDINGS[format]}", _blocks(jobs, job, results, format))
    spec = parse_spec(json.loads(job.spec))
    study = spec if isinstance(spec, Sensitivity) else None
    summary = summarize(results, study=study, drawn=job.kind == DRAWN)
    _write(folder / "summary.json", [json.dumps(summary, indent=1, ensure_ascii=False).encode() + b"\n"])
    return summary


def _blocks(jobs: Jobs, job: Job, results: Results, format: str) -> Iterator[bytes]:
    if format == "csv":
        return stream_csv(results)
    if format == "json":
        return stream_json(results)
    about = told_in_files(job, jobs.record(job))
    if format == "parquet":
        return file_blocks(parquet_file(results, about))
    return file_blocks(netcdf_file(results, about) if format == "netcdf" else mat_file(results, about))


def _write(path: Path, blocks: Iterable[bytes]) -> None:
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as out:
            out.writelines(blocks)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    print(f"written     {path}")


def print_summary(summary: dict[str, Any]) -> None:
    """Print a line for each metric, and for each index of a sensitivity study."""
    for name, told in summary["metrics"].items():
        if told["count"]:
            low, high = (told["percentiles"][p] for p in ("5", "95"))
            unit = "" if told["unit"] == "1" else f" {told['unit']}"
            print(f"metric      {name}: mean {told['mean']:.5g}{unit}, 5 to 95 % {low:.5g} to {high:.5g}{unit}")
    for name, found in (summary["indices"] or {}).items():
        print(f"indices     {name}: {_indices(found)}")


def _indices(found: dict[str, Any]) -> str:
    if found["reason"] is not None:
        return str(found["reason"])
    shown = found["total"] if "total" in found else found["mu_star"]
    what = "total" if "total" in found else "mean effect"
    ranked = sorted(shown.items(), key=lambda item: -item[1]["value"])
    return f"{what} " + ", ".join(f"{name} {told['value']:.3g}" for name, told in ranked)
