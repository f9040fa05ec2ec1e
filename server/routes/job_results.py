"""Owns what a job gives: its cases with their designs and trajectories, the whole table as a file, and its summary."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Path, Query, Request
from fastapi.responses import Response, StreamingResponse
from pydantic import BeforeValidator
from starlette.exceptions import HTTPException

from models.design import Design
from models.problems import DesignError, Problem
from models.run_warnings import run_warnings
from models.simulate import Control
from server.answers import CSV, JSON, NETCDF, json_answer, negotiate, series_answer
from server.dependencies import OneJob, SharedJobs, SharedRunner
from server.format_names import ENDINGS, format_named
from server.jobs.files import DiskFullError
from server.jobs.formats import file_blocks, mat_file, netcdf_file, parquet_file, stream_csv, stream_json
from server.jobs.matlab import TooLargeError
from server.jobs.record import told_in_files
from server.jobs.results import LostResultsError, Results
from server.jobs.spec import Sensitivity
from server.jobs.summary import DRAWN, summarize
from server.openapi import operation
from server.preview import PreviewRun, as_mapping, check_columns, thinned
from server.routes.jobs import ONE, Cursor
from server.schemas import COLUMN_NAMES, MOST_POINTS
from server.schemas_jobs import CaseItem, CasePage, CaseTable, Format, JobSummary, Status, Trajectory
from server.store.job_records import Job
from server.store.paging import read_cursor, write_cursor
from server.trajectory import CaseRun, TooLongError, case_design, case_run, planned

router = APIRouter(tags=["job results"])
PARQUET, MAT = "application/vnd.apache.parquet", "application/x-matlab-data"
MEDIA: dict[str, str] = {"json": JSON, "csv": CSV, "parquet": PARQUET, "netcdf": NETCDF, "mat": MAT}
ENDING_OF = {media: ENDINGS[name] for name, media in MEDIA.items()}
TEXT, BINARY = {"schema": {"type": "string"}}, {"schema": {"type": "string", "format": "binary"}}
TABLES: dict[int | str, dict[str, Any]] = {200: {"content": {CSV: TEXT, PARQUET: BINARY, NETCDF: BINARY, MAT: BINARY}}}
FILES: dict[int | str, dict[str, Any]] = {200: {"content": {CSV: TEXT, NETCDF: BINARY}}}
CASE = f"{ONE}/cases/{{case}}"
READS = (404, 422, 503)
MOST_CASES_A_PAGE, DEFAULT_CASES = 1000, 100
LONGEST_SLUG = 60


async def _results(job: OneJob, jobs: SharedJobs) -> Results:
    return Results(jobs.files(job), cases=job.counted, chunk_size=job.chunk_size)


Number = Annotated[int, Path(ge=0, le=2**53, description="Number of a case, from 0.")]


async def _case(job: OneJob, case: Number) -> int:
    if case >= job.counted:
        raise HTTPException(404, f"there is no case {case}: the job has cases 0 to {job.counted - 1}")
    return case


CaseTableNow = Annotated[Results, Depends(_results)]
OneCase = Annotated[int, Depends(_case)]
Accept = Annotated[str | None, Header(include_in_schema=False)]
STATUS: dict[type[Exception], int] = {
    LostResultsError: 404, TooLargeError: 406, TooLongError: 409, DiskFullError: 503,
}  # fmt: skip


@contextmanager
def _told() -> Iterator[None]:
    """Tell what results cannot give as the error of HTTP that it is."""
    try:
        yield
    except tuple(STATUS) as error:
        headers = {"Retry-After": "60"} if isinstance(error, DiskFullError) else None
        raise HTTPException(STATUS[type(error)], str(error), headers) from None


@router.get(f"{ONE}/cases", response_model=CasePage, summary="List a job's cases", **operation("list_cases", *READS))
def list_cases(
    results: CaseTableNow,
    status: Annotated[list[Status] | None, Query(description="How it ended; several: any of them.")] = None,
    cursor: Cursor = None,
    limit: Annotated[int, Query(ge=1, le=MOST_CASES_A_PAGE, description="Most entries in the answer.")] = DEFAULT_CASES,
) -> Response:
    """List the cases that are done, in the order of their numbers; a job need not be over.

    With `status` a page may hold fewer than asked, though more follow: then `next` says so.
    """
    after = read_cursor(cursor, "case", int)[0] if cursor is not None else -1
    with _told():
        items, following = results.page(max(-1, after), limit, status)
    return json_answer({"items": items, "next": None if following is None else write_cursor("case", following)})


@router.get(CASE, response_model=CaseItem, summary="Get a case", **operation("get_case", *READS))
def get_case(job: OneJob, case: OneCase, results: CaseTableNow) -> Response:
    """Answer what a case was given, how it ended, and what it measured."""
    with _told():
        found = results.case(case)
    if found is None:
        raise HTTPException(404, f"case {case} is not done: the job is {job.state}")
    return json_answer(found)


@router.get(
    f"{CASE}/design", response_model=Design, summary="Get the design of a case", **operation("get_case_design", *READS)
)
def get_case_design(job: OneJob, case: OneCase) -> Response:
    """Answer the document of a case, ready for the studio; 422 where the case's values make no design."""
    return json_answer(case_design(planned(job.spec), case))


@router.get(
    f"{CASE}/trajectory", response_model=Trajectory, responses=FILES, summary="Get the trajectory of a case",
    **operation("get_trajectory", 406, 409, *READS),
)  # fmt: skip
async def get_trajectory(
    request: Request,
    job: OneJob,
    case: OneCase,
    jobs: SharedJobs,
    runner: SharedRunner,
    columns: Annotated[
        str | None,
        Query(max_length=2000, description="Columns of a JSON answer beside t, with commas; all by default."),
    ] = None,
    max_points: Annotated[
        int | None, Query(ge=2, le=MOST_POINTS, description="Most samples; JSON: 2000 if not given; files: all.")
    ] = None,
    accept: Accept = None,
) -> Response:
    """Answer a case over time, as a preview does: from the job's files where it was kept, else simulated again.

    The numbers are the same, on the same kind of processor and with the same version of the program; else a warning
    says so. Accept chooses JSON, CSV or NetCDF.
    """
    media, shown = negotiate(accept, (JSON, CSV, NETCDF)), _columns(columns)

    def work(control: Control) -> Response:
        with _told():
            found = case_run(job, case, jobs.files(job), jobs.limits, control)
        if media == JSON:
            return series_answer(_trajectory(found, case, shown, max_points))
        run = thinned(found.run, max_points)
        content = run.to_csv() if media == CSV else run.to_netcdf()
        return Response(content, media_type=media, headers=_attached(job, media, f"-case-{case}"))

    return await runner.run(request, work)


def _columns(asked: str | None) -> tuple[str, ...]:
    if asked is None:
        return COLUMN_NAMES
    try:
        return check_columns([name.strip() for name in asked.split(",") if name.strip()])
    except DesignError as error:
        problems = [Problem("", f"query parameter 'columns': {p.message}", p.limit, p.hint) for p in error.problems]
        raise DesignError(problems) from None


def _trajectory(found: CaseRun, case: int, columns: tuple[str, ...], max_points: int | None) -> dict[str, Any]:
    warnings = (*found.warnings, *run_warnings(found.run))
    shown = as_mapping(PreviewRun(found.run, found.run.message, warnings), columns, max_points)
    return shown | {"case": case, "kept": found.kept}


def _named(given: Any) -> Any:
    return format_named(given) if isinstance(given, str) else given


@router.get(
    f"{ONE}/results", response_model=CaseTable, responses=TABLES, summary="Get all results of a job",
    **operation("get_results", 406, *READS),
)  # fmt: skip
def get_results(
    job: OneJob,
    jobs: SharedJobs,
    results: CaseTableNow,
    format: Annotated[
        Format | None, BeforeValidator(_named), Query(description="Format, for links; if not given, Accept chooses.")
    ] = None,
    accept: Accept = None,
) -> Response:
    """Stream the case table of what is done: JSON, CSV, Parquet, NetCDF (kept trajectories with it) or a MATLAB file.

    Parquet, NetCDF and MATLAB files hold the batch document too, so that whoever has one can run it again.
    """
    media = MEDIA[format] if format is not None else negotiate(accept, tuple(MEDIA.values()))
    with _told():
        content = _content(results, media, told_in_files(job, jobs.record(job)))
    return StreamingResponse(content, media_type=media, headers=_attached(job, media))


def _content(results: Results, media: str, about: dict[str, Any]) -> Iterator[bytes]:
    if media == JSON:
        return stream_json(results)
    if media == CSV:
        return stream_csv(results)
    if media == PARQUET:
        return file_blocks(parquet_file(results, about))
    return file_blocks(netcdf_file(results, about) if media == NETCDF else mat_file(results, about))


def _attached(job: Job, media: str, what: str = "") -> dict[str, str]:
    slug = re.sub(r"[^A-Za-z0-9]+", "-", job.name)[:LONGEST_SLUG].strip("-").lower() or "job"
    return {"Content-Disposition": f'attachment; filename="{slug}-{job.id}{what}.{ENDING_OF[media]}"'}


@router.get(
    f"{ONE}/summary", response_model=JobSummary, summary="Summarise a job's results",
    **operation("get_summary", *READS),
)  # fmt: skip
def get_summary(job: OneJob, results: CaseTableNow) -> Response:
    """Answer percentiles, correlations, failures by reason, intervals of means of draws, and sensitivity indices.

    They are of the cases that are done by now, those that failed left out.
    """
    spec = planned(job.spec).spec if job.kind == "sensitivity" else None
    study = spec if isinstance(spec, Sensitivity) else None
    with _told():
        return json_answer(summarize(results, study=study, drawn=job.kind == DRAWN, keep=job.over))
