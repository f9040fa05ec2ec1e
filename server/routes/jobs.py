"""Owns /jobs: long work is submitted, listed, watched, cancelled, gone on with, and forgotten."""

from __future__ import annotations

import hashlib
from collections.abc import AsyncIterable, AsyncIterator, Iterable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.responses import Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from server.access import principal_of
from server.answers import JSON, json_answer
from server.body import JsonBody
from server.dependencies import Document, OneJob, SharedEvents, SharedJobs
from server.job_events import Listener
from server.jobs.service import Jobs
from server.jobs.submission import Request as Asked
from server.openapi import operation
from server.quotas import Principal
from server.routes import segments  # noqa: F401
from server.schemas_jobs import BATCH_SCHEMA, JobPage, JobRecord, Kind, State
from server.store.job_records import Job
from server.store.paging import DEFAULT_A_PAGE, LONGEST_CURSOR, MOST_A_PAGE, read_cursor, write_cursor

router = APIRouter(tags=["jobs"])
ONE = "/jobs/{job_id:segment}"
ORDER = "-created"
RECORD = {"contentMediaType": JSON, "contentSchema": {"$ref": "#/components/schemas/JobRecord"}}
STREAM: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/event-stream": {"itemSchema": {"properties": {"data": RECORD}}}}}
}
"""What FastAPI says of a stream, and of its events' data."""
READS = (404, 422, 503)
CHANGES = (403, 404, 409, 422, 503)
Cursor = Annotated[str | None, Query(max_length=LONGEST_CURSOR, description="`next` of the page before.")]
Limit = Annotated[int, Query(ge=1, le=MOST_A_PAGE, description="Most entries in the answer.")]
Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key", min_length=1, max_length=255, pattern=r"^[\x21-\x7e]+$",
        description="A key of the client's own: the same request with the same key submits nothing twice.",
    ),
]  # fmt: skip
LastEvent = Annotated[str | None, Header(alias="Last-Event-ID", description="`id` of the last event that was seen.")]


def _job_answer(jobs: Jobs, job: Job, path: str) -> Response:
    """Return the answer to what was asked of a job and goes on from here."""
    answer = json_answer(jobs.record(job), 202)
    answer.headers["Location"], answer.headers["Retry-After"] = path, "1"
    return answer


@router.post(
    "/jobs", status_code=202, response_model=JobRecord, summary="Submit a job",
    **operation("create_job", 503, files={JSON: BATCH_SCHEMA}),
)  # fmt: skip
def create_job(
    request: Request,
    body: JsonBody,
    document: Document,
    jobs: SharedJobs,
    key: Key = None,
    fresh: Annotated[bool, Query(description="Whether to compute anew what an equal job has computed.")] = False,
) -> Response:
    """Queue what a batch document asks for; Location says where to watch it. All is checked before anything runs.

    With the Idempotency-Key of an earlier request that one's job is answered, marked Idempotent-Replayed; the same key
    with another body is refused. A job whose inputs equal those of one that succeeded, or is under way, is that one,
    unless `fresh`. Pointers of errors lead into the batch document.
    """
    principal, quotas = principal_of(request.scope), request.app.state.quotas

    def admit(cases: int) -> None:
        unfinished = jobs.store.unfinished(principal.name) if principal.limited else ()
        quotas.check_job(principal, _ends_of(unfinished), cases=cases)

    asked = Asked(principal.name, key, hashlib.sha256(body).hexdigest())
    job, is_new = jobs.submit(document, asked, fresh=fresh, admit=admit)
    answer = _job_answer(jobs, job, f"{request.url.path}/{job.id}")
    if key is not None and not is_new and (job.principal, job.idempotency_key) == (asked.principal, key):
        answer.headers["Idempotent-Replayed"] = "true"
    return answer


@router.get("/jobs", response_model=JobPage, summary="List the jobs", **operation("list_jobs", 422, 503))
def list_jobs(
    jobs: SharedJobs,
    state: Annotated[list[State] | None, Query(description="A state; several: any of them.")] = None,
    kind: Annotated[list[Kind] | None, Query(description="A kind; several: any of them.")] = None,
    search: Annotated[
        str, Query(max_length=200, pattern=r"^[^\x00]*$", description="What the name must hold, in either case.")
    ] = "",
    cursor: Cursor = None,
    limit: Limit = DEFAULT_A_PAGE,
) -> Response:
    """List jobs, the newest first, a page at a time; what is submitted meanwhile neither repeats nor hides an entry."""
    before = tuple(read_cursor(cursor, ORDER, float, str)) if cursor is not None else None
    found = jobs.store.page(states=state or (), kinds=kind or (), search=search, before=before, limit=limit + 1)
    shown = found[:limit]
    following = write_cursor(ORDER, shown[-1].created, shown[-1].id) if len(found) > limit else None
    return json_answer({"items": jobs.records(shown), "next": following})


@router.get(ONE, response_model=JobRecord, summary="Get a job", **operation("get_job", *READS))
def get_job(job: OneJob, jobs: SharedJobs) -> Response:
    """Answer a job as it is now: its state, how far it is, and why cases failed."""
    return json_answer(jobs.record(job))


@router.delete(ONE, status_code=204, summary="Delete a job", **operation("delete_job", *CHANGES))
def delete_job(job: OneJob, jobs: SharedJobs) -> Response:
    """Forget a job that is over, its results with it."""
    jobs.remove(job.id)
    return Response(status_code=204)


@router.post(
    f"{ONE}:cancel", status_code=202, response_model=JobRecord, summary="Cancel a job",
    **operation("cancel_job", *CHANGES),
)  # fmt: skip
def cancel_job(request: Request, job: OneJob, jobs: SharedJobs) -> Response:
    """Have a job end as soon as what is being computed is; all that is done is kept."""
    return _job_answer(jobs, jobs.cancel(job.id), _parent(request))


@router.post(
    f"{ONE}:retry", status_code=202, response_model=JobRecord, summary="Retry a job's failed cases",
    **operation("retry_job", *CHANGES),
)  # fmt: skip
def retry_job(request: Request, job: OneJob, jobs: SharedJobs) -> Response:
    """Compute again what failed in a job that is over, and what a cancelled one has left out.

    It counts as one of the unfinished jobs of whoever submitted it, its cases not again.
    """
    _require_room(request, job, jobs)
    return _job_answer(jobs, jobs.retry(job.id), _parent(request))


@router.post(
    f"{ONE}:resume", status_code=202, response_model=JobRecord, summary="Resume a paused job",
    **operation("resume_job", *CHANGES),
)  # fmt: skip
def resume_job(request: Request, job: OneJob, jobs: SharedJobs) -> Response:
    """Go on with a job that paused by itself, once its reason is done away with: it says why in `reason`."""
    _require_room(request, job, jobs)
    return _job_answer(jobs, jobs.resume(job.id), _parent(request))


def _require_room(request: Request, job: Job, jobs: Jobs) -> None:
    """Raise `QuotaError` where a job may not go on beside the other unfinished ones of the principal it counts for."""
    others = [other for other in jobs.store.unfinished(job.principal) if other.id != job.id]
    limited = principal_of(request.scope).limited
    request.app.state.quotas.check_running(Principal(job.principal, limited=limited), _ends_of(others))


def _ends_of(unfinished: Iterable[Job]) -> list[float | None]:
    """Return the seconds until each of some jobs ends, None where that is not known."""
    return [job.seconds_left for job in unfinished]


def _parent(request: Request) -> str:
    return request.url.path.rpartition(":")[0]


@router.get(
    f"{ONE}/spec", response_model=dict[str, Any], summary="Get a job's batch document",
    **operation("get_job_spec", *READS),
)  # fmt: skip
def get_job_spec(job: OneJob) -> Response:
    """Answer the batch document, its design inside: sent again, or run from the command line, it gives the same."""
    return Response(job.spec, media_type=JSON)


async def _listening(job: OneJob, events: SharedEvents, last: LastEvent = None) -> AsyncIterator[Listener]:
    seen = int(last) if last is not None and last.isascii() and last.isdecimal() and len(last) < 10 else None
    with events.listening(job.id, seen) as listener:
        yield listener


@router.get(
    f"{ONE}/events", response_class=EventSourceResponse, responses=STREAM, summary="Watch a job",
    **operation("watch_job", *READS),
)  # fmt: skip
async def watch_job(listener: Annotated[Listener, Depends(_listening)]) -> AsyncIterable[ServerSentEvent]:
    """Stream server-sent events: `job`, its data the record, at once and after every change, until the job is over.

    The id of an event counts the job's changes; with Last-Event-ID the stream begins with the newest record if the job
    has changed since. A comment every 15 s keeps the connection open.
    """
    while (news := await listener.next()) is not None:
        yield ServerSentEvent(event="job", id=str(news.sequence), raw_data=news.record)
