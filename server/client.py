"""Owns the client: a glider studio's API from Python, typed, with errors that point into what was sent."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx
from pydantic import BaseModel, ValidationError

from models.design import Design, parse_design
from server.format_names import ENDINGS, format_named
from server.schemas import ErrorItem, ProblemDocument
from server.schemas_jobs import CaseItem, CasePage, JobPage, JobRecord, JobSummary, Trajectory
from server.schemas_store import DesignItem, DesignPage, DesignResource

API = "/api/v1"
OPERATIONS: Mapping[str, tuple[str, str]] = {
    "list_designs": ("GET", "/designs"),
    "create_design": ("POST", "/designs"),
    "get_design": ("GET", "/designs/{design_id}"),
    "get_revision": ("GET", "/designs/{design_id}/revisions/{number}"),
    "replace_design": ("PUT", "/designs/{design_id}"),
    "create_job": ("POST", "/jobs"),
    "list_jobs": ("GET", "/jobs"),
    "get_job": ("GET", "/jobs/{job_id}"),
    "get_job_spec": ("GET", "/jobs/{job_id}/spec"),
    "watch_job": ("GET", "/jobs/{job_id}/events"),
    "cancel_job": ("POST", "/jobs/{job_id}:cancel"),
    "retry_job": ("POST", "/jobs/{job_id}:retry"),
    "resume_job": ("POST", "/jobs/{job_id}:resume"),
    "delete_job": ("DELETE", "/jobs/{job_id}"),
    "list_cases": ("GET", "/jobs/{job_id}/cases"),
    "get_case_design": ("GET", "/jobs/{job_id}/cases/{case}/design"),
    "get_trajectory": ("GET", "/jobs/{job_id}/cases/{case}/trajectory"),
    "get_results": ("GET", "/jobs/{job_id}/results"),
    "get_summary": ("GET", "/jobs/{job_id}/summary"),
}
"""Method and path of every operation that the client uses, by its name in the OpenAPI document."""
FORMATS: Mapping[str, str] = {
    "json": "application/json",
    "csv": "text/csv",
    "parquet": "application/vnd.apache.parquet",
    "netcdf": "application/x-netcdf",
    "mat": "application/x-matlab-data",
}
"""Media types of results, by format."""
QUIET = 45.0
"""How long a stream of events may be silent before it is taken for dead, s; the server says something every 15 s."""
RECONNECT = 0.5
"""How long to wait before a broken stream is taken up again, s."""
ModelT = TypeVar("ModelT", bound=BaseModel)
Progress = Callable[[JobRecord], None]


class ProblemError(Exception):
    """The server refused a request.

    Attributes
    ----------
    status : the HTTP status.
    detail : what went wrong, in a sentence.
    errors : what is wrong, place by place: `pointer` leads into what was sent.
    retry_after : seconds after which to try again, where the server says so.

    """

    def __init__(self, problem: ProblemDocument, *, retry_after: float | None = None) -> None:
        self.status, self.retry_after = problem.status, retry_after
        self.detail = problem.detail or problem.title
        self.errors: tuple[ErrorItem, ...] = tuple(problem.errors)
        places = [f"{e.pointer or 'it'}: {e.message}" + (f" ({e.hint})" if e.hint else "") for e in problem.errors]
        super().__init__("; ".join(places) or self.detail)


class Client:
    """A glider studio, by its address; with `token` where it demands one. Close it, or use it in a `with`."""

    def __init__(
        self, base_url: str = "http://127.0.0.1:8000", token: str | None = None, *, timeout: float = 60.0
    ) -> None:
        headers = {"Authorization": f"Bearer {token}"} if token is not None else {}
        self._http = httpx.Client(base_url=base_url.rstrip("/") + API, headers=headers, timeout=timeout)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close all connections."""
        self._http.close()

    # designs

    def designs(self, search: str = "", *, tags: Sequence[str] = ()) -> Iterator[DesignItem]:
        """Yield the stored designs that hold the words of a search, page by page."""
        query: dict[str, Any] = {"search": search, "tag": list(tags), "limit": 200}
        for page in self._pages("list_designs", DesignPage, query):
            yield from page.items

    def create_design(
        self, design: Design | Mapping[str, Any], *,
        name: str | None = None, tags: Sequence[str] = (), comment: str = "",
    ) -> DesignResource:  # fmt: skip
        """Store a design as a new one."""
        sent = {"design": _plain(design), "name": name, "tags": list(tags), "comment": comment}
        return self._ask("create_design", DesignResource, sent)

    def design(self, design_id: str, revision: int | None = None) -> DesignResource:
        """Return a stored design, at its newest revision or at an older one."""
        if revision is None:
            return self._ask("get_design", DesignResource, design_id=design_id)
        return self._ask("get_revision", DesignResource, design_id=design_id, number=revision)

    def put_design(
        self, design_id: str, design: Design | Mapping[str, Any], *, revision: int | None = None, comment: str = ""
    ) -> DesignResource:
        """Make a new revision; refused with 412 where the newest is not `revision`, if that is given."""
        sent = {"design": _plain(design), "comment": comment}
        match = {"If-Match": "*" if revision is None else f'"{revision}"'}
        return self._ask("replace_design", DesignResource, sent, headers=match, design_id=design_id)

    # jobs

    def submit(self, spec: BaseModel | Mapping[str, Any], *, key: str | None = None, fresh: bool = False) -> JobRecord:
        """Submit a batch document.

        With `key`, any text of one's own, the same submission may be sent again without being run twice. Unless
        `fresh`, a job that has computed the same already is answered.
        """
        headers = {"Idempotency-Key": key} if key is not None else {}
        return self._ask("create_job", JobRecord, _plain(spec), query={"fresh": fresh}, headers=headers)

    def jobs(self, *, states: Sequence[str] = (), kinds: Sequence[str] = (), search: str = "") -> Iterator[JobRecord]:
        """Yield the jobs, the newest first, page by page."""
        query: dict[str, Any] = {"state": list(states), "kind": list(kinds), "search": search}
        for page in self._pages("list_jobs", JobPage, query):
            yield from page.items

    def job(self, job_id: str) -> JobRecord:
        """Return a job as it is now."""
        return self._ask("get_job", JobRecord, job_id=job_id)

    def spec(self, job_id: str) -> dict[str, Any]:
        """Return a job's batch document, its design inside."""
        document: dict[str, Any] = json.loads(self._send("get_job_spec", job_id=job_id).content)
        return document

    def cancel(self, job_id: str) -> JobRecord:
        """Have a job end; what is done is kept."""
        return self._ask("cancel_job", JobRecord, job_id=job_id)

    def retry(self, job_id: str) -> JobRecord:
        """Compute again what failed in a job that is over."""
        return self._ask("retry_job", JobRecord, job_id=job_id)

    def resume(self, job_id: str) -> JobRecord:
        """Go on with a job that has paused."""
        return self._ask("resume_job", JobRecord, job_id=job_id)

    def delete(self, job_id: str) -> None:
        """Forget a job that is over, its results with it."""
        self._send("delete_job", job_id=job_id)

    def wait(
        self, job_id: str, progress: Progress | None = None, *, timeout: float | None = None, patience: float = 300.0
    ) -> JobRecord:
        """Return a job once it is over.

        Parameters
        ----------
        job_id
            The job.
        progress
            Called with the job at once and whenever it has changed; a job that pauses tells so here, and is waited for.
        timeout
            How long to wait, s; for ever if not given.
        patience
            How long to try again where the server cannot be reached any more, s.

        Raises
        ------
        TimeoutError
            Where the job is not over in time.

        """
        watch = _Watch(self._http, job_id, timeout)
        lost_at: float | None = None
        while True:
            try:
                for record in watch.events():
                    lost_at = None
                    if progress is not None:
                        progress(record)
                    if record.over:
                        return record
            except (httpx.TransportError, ProblemError) as error:
                lost_at = time.monotonic() if lost_at is None else lost_at
                refused = isinstance(error, ProblemError) and error.status not in (429, 502, 503, 504)
                if refused or not watch.begun or time.monotonic() - lost_at > patience:
                    raise
            watch.check_time()
            time.sleep(RECONNECT)

    # what a job gives

    def cases(self, job_id: str, *, status: Sequence[str] = ()) -> Iterator[CaseItem]:
        """Yield the cases that are done, page by page; with `status` those that ended so."""
        query: dict[str, Any] = {"status": list(status), "limit": 1000}
        for page in self._pages("list_cases", CasePage, query, job_id=job_id):
            yield from page.items

    def case_design(self, job_id: str, case: int) -> Design:
        """Return the design of a case."""
        return parse_design(json.loads(self._send("get_case_design", job_id=job_id, case=case).content))

    def trajectory(
        self, job_id: str, case: int, *, columns: Sequence[str] | None = None, max_points: int | None = None
    ) -> Trajectory:
        """Return the path of a case over time, thinned to `max_points`; kept or not, it is the same."""
        query = {"columns": ",".join(columns) if columns is not None else None, "max_points": max_points}
        return self._ask("get_trajectory", Trajectory, query=query, job_id=job_id, case=case)

    def results(self, job_id: str, format: str = "csv") -> bytes:
        """Return the table of all results in one of `FORMATS`; `download` takes what does not fit in memory."""
        with self._results(job_id, format) as answer:
            return answer.read()

    def download(self, job_id: str, path: Path, format: str | None = None) -> Path:
        """Write all results into a file as they come, whole or not at all; its ending tells the format if not given."""
        part = path.with_name(path.name + ".part")
        try:
            with self._results(job_id, format or _format_of(path)) as answer, part.open("wb") as out:
                for piece in answer.iter_bytes():
                    out.write(piece)
            return part.replace(path)
        finally:
            part.unlink(missing_ok=True)

    def summary(self, job_id: str) -> JobSummary:
        """Return statistics of the metrics, correlations, failures and, of a sensitivity study, its indices."""
        return self._ask("get_summary", JobSummary, job_id=job_id)

    # asking

    @contextmanager
    def _results(self, job_id: str, format: str) -> Iterator[httpx.Response]:
        name = format_named(format)
        if name not in FORMATS:
            raise ValueError(f"there is no format '{format}': use {', '.join(FORMATS)}")
        with self._stream("get_results", headers={"Accept": FORMATS[name]}, job_id=job_id) as answer:
            yield answer

    def _ask(
        self, operation: str, model: type[ModelT], body: Any = None, *, query: Mapping[str, Any] | None = None,
        headers: Mapping[str, str] | None = None, **names: Any,
    ) -> ModelT:  # fmt: skip
        answer = self._send(operation, body, query=query, headers=headers, **names)
        return model.model_validate_json(answer.content)

    def _pages(self, operation: str, model: type[ModelT], query: dict[str, Any], **names: Any) -> Iterator[ModelT]:
        cursor: str | None = None
        while True:
            page = self._ask(operation, model, query=query | {"cursor": cursor}, **names)
            yield page
            cursor = getattr(page, "next", None)
            if cursor is None:
                return

    def _send(self, operation: str, body: Any = None, **options: Any) -> httpx.Response:
        with self._stream(operation, body, **options) as answer:
            answer.read()
        return answer

    @contextmanager
    def _stream(
        self, operation: str, body: Any = None, *, query: Mapping[str, Any] | None = None,
        headers: Mapping[str, str] | None = None, **names: Any,
    ) -> Iterator[httpx.Response]:  # fmt: skip
        method, template = OPERATIONS[operation]
        params = {name: value for name, value in (query or {}).items() if value is not None}
        with self._http.stream(method, template.format(**names), params=params, headers=headers, json=body) as answer:
            _check(answer)
            yield answer


class _Watch:
    """The events of one job, over as many connections as it takes."""

    def __init__(self, http: httpx.Client, job_id: str, timeout: float | None) -> None:
        self._http, self._job_id = http, job_id
        self._timeout, self._deadline = timeout, None if timeout is None else time.monotonic() + timeout
        self._seen: str | None = None

    @property
    def begun(self) -> bool:
        """Whether anything was ever heard."""
        return self._seen is not None

    def check_time(self) -> None:
        """Raise `TimeoutError` where it is late."""
        if self._deadline is not None and time.monotonic() > self._deadline:
            raise TimeoutError(f"job {self._job_id} is not over after {self._timeout:g} s; it goes on")

    def events(self) -> Iterator[JobRecord]:
        """Yield what becomes of the job until the connection ends; a later call goes on from there."""
        method, template = OPERATIONS["watch_job"]
        headers = {"Last-Event-ID": self._seen} if self._seen is not None else {}
        quiet = QUIET if self._deadline is None else max(0.1, min(QUIET, self._deadline - time.monotonic()))
        timeout = httpx.Timeout(quiet, connect=10.0)
        path = template.format(job_id=self._job_id)
        with self._http.stream(method, path, headers=headers, timeout=timeout) as answer:
            _check(answer)
            fields: dict[str, str] = {}
            for line in answer.iter_lines():
                self.check_time()
                if line:
                    name, _, value = line.partition(":")
                    fields[name] = value.removeprefix(" ")
                elif "data" in fields:
                    self._seen = fields.get("id", self._seen)
                    yield JobRecord.model_validate_json(fields["data"])
                    fields = {}


def _format_of(path: Path) -> str:
    name = format_named(path.suffix.removeprefix("."))
    if name not in FORMATS:
        endings = ", ".join(f".{ending}" for ending in ENDINGS.values())
        raise ValueError(f"'{path.name}' tells no format: let it end in {endings}, or give the format")
    return name


def _plain(document: BaseModel | Mapping[str, Any]) -> Any:
    return document.model_dump(mode="json") if isinstance(document, BaseModel) else document


def _check(answer: httpx.Response) -> None:
    """Raise the problem that an answer tells, where it is one."""
    if answer.is_success:
        return
    answer.read()
    after = answer.headers.get("retry-after", "")
    try:
        problem = ProblemDocument.model_validate_json(answer.content)
    except ValidationError:  # something between us and the studio answered
        title, status = answer.reason_phrase, answer.status_code
        problem = ProblemDocument(type="about:blank", title=title, status=status, detail=answer.text[:500], errors=[])
    raise ProblemError(problem, retry_after=float(after) if after.isdecimal() else None)
