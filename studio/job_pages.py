"""Owns the pages of jobs: their list, the page of one, and the chart library that the latter loads.

Both pages are the same for every job and hold nothing of any: what they show comes from the API, which guards it.
"""

from __future__ import annotations

import gzip
import hashlib
from dataclasses import dataclass
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

from fastapi import APIRouter, Request
from fastapi.responses import Response

from studio.access import PAGE_HEADERS
from studio.page_files import file_page

HEADERS = PAGE_HEADERS | {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
}
"""No inline style either: the chart library takes its few rules from a file of ours."""
LIBRARY = "plotly/package_data/plotly.min.js"
A_WEEK = "public, max-age=604800"
router = APIRouter(include_in_schema=False)


@dataclass(frozen=True, slots=True)
class Library:
    """A script as it is sent: whole, compressed, and the tag by which a browser knows that it has it."""

    plain: bytes
    compressed: bytes
    tag: str


@cache
def chart_library() -> Library:
    """Return plotly.js as the installed Python package ships it; read and compressed once."""
    plain = Path(str(distribution("plotly").locate_file(LIBRARY))).read_bytes()
    tag = f'"{hashlib.sha256(plain).hexdigest()[:32]}"'
    return Library(plain, gzip.compress(plain, compresslevel=6, mtime=0), tag)


@router.get("/jobs")
def get_jobs() -> Response:
    """Answer the list of jobs."""
    return file_page("jobs.html", HEADERS)


@router.get("/jobs/{job_id}")
def get_job(job_id: str) -> Response:
    """Answer the page of a job, whether there is one or not: the page asks the API, and says so."""
    return file_page("job.html", HEADERS)


@router.get("/vendor/plotly.min.js")
def get_chart_library(request: Request) -> Response:
    """Answer the chart library, compressed where the browser takes that, once a week at most."""
    library = chart_library()
    headers = {"Cache-Control": A_WEEK, "ETag": library.tag, "Vary": "Accept-Encoding"}
    if library.tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    accepted = (part.split(";")[0].strip() for part in request.headers.get("accept-encoding", "").lower().split(","))
    compress = "gzip" in accepted
    content = library.compressed if compress else library.plain
    return Response(
        content, media_type="text/javascript", headers=headers | ({"Content-Encoding": "gzip"} if compress else {})
    )
