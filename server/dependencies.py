"""Owns what routes are given: settings, open sessions, the runner, stored designs, jobs, and the decoded body.

What only looks something up is `async`, though it awaits nothing: else each would be passed to a thread and back.
"""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Request

from models.problems import echo
from server.body import JsonBody, loads
from server.job_events import JobEvents
from server.jobs.service import Jobs
from server.live import LiveSessions
from server.running import Runner
from server.settings import Settings
from server.store.designs import DesignStore
from server.store.errors import NotFoundError, UnavailableError
from server.store.identifiers import is_id
from server.store.job_records import Job


async def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


async def _live(request: Request) -> LiveSessions | None:
    live: LiveSessions | None = request.app.state.live
    return live


async def _runner(request: Request) -> Runner:
    runner: Runner = request.app.state.runner
    return runner


async def _store(request: Request) -> DesignStore:
    store: DesignStore = request.app.state.store
    return store


async def _jobs(request: Request) -> Jobs:
    jobs: Jobs | None = request.app.state.jobs
    if jobs is None:
        raise UnavailableError("this server keeps no jobs: start it as glider-studio does")
    return jobs


async def _job_events(request: Request, jobs: SharedJobs) -> JobEvents:
    events: JobEvents = request.app.state.job_events
    return events


def _one_job(job_id: str, jobs: SharedJobs) -> Job:
    if not is_id(job_id):  # what cannot be an identifier is not asked for: PostgreSQL refuses some characters
        raise NotFoundError(f"there is no job {echo(job_id)}")
    return jobs.store.get(job_id)


SettingsNow = Annotated[Settings, Depends(_settings)]
Live = Annotated[LiveSessions | None, Depends(_live)]
SharedRunner = Annotated[Runner, Depends(_runner)]
Store = Annotated[DesignStore, Depends(_store)]
SharedJobs = Annotated[Jobs, Depends(_jobs)]
SharedEvents = Annotated[JobEvents, Depends(_job_events)]
OneJob = Annotated[Job, Depends(_one_job)]
"""The job that a path names."""


def _document(body: JsonBody, settings: SettingsNow) -> Any:
    return loads(body, max_values=settings.max_body_values)


Document = Annotated[Any, Depends(_document)]
"""The body as decoded JSON; decoded in a worker thread, for a large one takes a while."""
