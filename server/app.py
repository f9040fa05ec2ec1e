"""Owns the API application: middleware, error handlers and routes around the settings and the open sessions."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext

import anyio.to_thread
from fastapi import Depends, FastAPI
from starlette.datastructures import State

from server.errors import install_error_handlers
from server.job_events import events_of
from server.job_figures import JobFigures
from server.jobs.service import Jobs
from server.live import LiveSessions
from server.middleware import install_middleware
from server.openapi import DocumentedApi
from server.queries import refuse_unknown_parameters
from server.quotas import Quotas
from server.readiness import Readiness, engine_check
from server.routes import (
    analyses,
    components,
    controllers,
    design_files,
    designs,
    health,
    index,
    job_results,
    presets,
    schemas,
    sessions,
    simulations,
    stored_designs,
)
from server.routes import jobs as job_routes
from server.running import Runner
from server.settings import Settings
from server.stopping import Stopping
from server.store.database import Database, sqlite_url
from server.store.designs import DesignStore
from server.store.errors import UnavailableError
from server.telemetry import Telemetry
from server.version import VERSION

_log = logging.getLogger(__name__)
API = "/api/v1"
NOUNS = (
    index, presets, schemas, designs, design_files, stored_designs, components, sessions, simulations, analyses,
    controllers, job_routes, job_results,
)  # fmt: skip
Lifespan = Callable[[FastAPI], AbstractAsyncContextManager[None]]
DESCRIPTION = (
    "Designs of underwater gliders that steer by buoyancy cells: check, edit, weigh and simulate them. SI units and "
    "radians; body axes x to the nose, y to starboard, z down. Every error is a problem document (RFC 9457)."
)


def open_store(settings: Settings) -> DesignStore:
    """Return the store that the settings name; the database itself is opened at its first use."""
    return DesignStore(Database(settings.database_url or sqlite_url(settings.data / "studio.sqlite")))


def create_app(
    settings: Settings | None = None,
    *,
    live: LiveSessions | None = None,
    store: DesignStore | None = None,
    jobs: Jobs | None = None,
    lifespan: Lifespan | None = None,
) -> FastAPI:
    """Return the API; without `jobs` it answers 503 where they are asked for.

    `lifespan` is entered when the server starts and left when it stops; within it jobs are worked on. Then the store is
    closed.
    """
    settings = settings if settings is not None else Settings()
    app = DocumentedApi(
        title="Glider studio", version=VERSION, description=DESCRIPTION, lifespan=_until_stopped(lifespan),
        openapi_url=f"{API}/openapi.json", docs_url=None, redoc_url=None, separate_input_output_schemas=False,
    )  # fmt: skip
    state = app.state
    state.settings, state.live, state.jobs = settings, live, jobs
    state.store = store if store is not None else open_store(settings)
    state.runner, state.stopping, state.readiness = Runner(), Stopping(), Readiness()
    state.telemetry, state.quotas = Telemetry(), Quotas(settings.quotas)
    state.job_events = events_of(jobs) if jobs is not None else None
    _connect(state)
    install_middleware(app, settings, quotas=state.quotas, telemetry=state.telemetry, stopping=state.stopping)
    install_error_handlers(app)
    app.include_router(health.router)
    app.include_router(index.pages)
    for noun in NOUNS:
        app.include_router(noun.router, prefix=API, dependencies=[Depends(refuse_unknown_parameters)])
    return app


def _until_stopped(lifespan: Lifespan | None) -> Lifespan:
    """Return what an application lives in: its jobs are worked on meanwhile, and its store is closed at the end."""

    @asynccontextmanager
    async def until_stopped(app: FastAPI) -> AsyncIterator[None]:
        jobs: Jobs | None = app.state.jobs
        async with lifespan(app) if lifespan is not None else nullcontext():
            if jobs is not None:
                jobs.start()
            try:
                yield
            finally:
                app.state.stopping.begin()
                if jobs is not None:
                    await anyio.to_thread.run_sync(_end_jobs, jobs)
                app.state.store.database.close()

    return until_stopped


def _end_jobs(jobs: Jobs) -> None:
    """Stop working on jobs, and say how many go on at the next start."""
    jobs.stop()
    try:
        _log.info("stopped; unfinished jobs that are kept for the next start: %d", jobs.store.count_unfinished())
    except UnavailableError as error:
        _log.warning("stopped; how many unfinished jobs are kept for the next start is not known: %s", error)


def _connect(state: State) -> None:
    """Have what an application holds know of each other: what ends when it stops, is watched, and must be ready."""
    state.stopping.on_stop(state.runner.cancel_all)
    state.readiness.add("store", state.store.check)
    waiting = "Previews and analyses that compute or wait to."
    state.telemetry.watch("simulations_running", waiting, lambda: state.runner.under_way)
    if state.jobs is not None:
        listening = "Who is told what becomes of jobs."
        state.readiness.add("engine", engine_check(state.jobs.manager.engine))
        state.telemetry.watch("job_listeners", listening, lambda: state.job_events.listeners)
        state.telemetry.registry.register(JobFigures(state.jobs))
