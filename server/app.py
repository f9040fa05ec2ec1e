"""Owns the API application: middleware, error handlers and routes around the settings and the open sessions."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext

import anyio.to_thread
from fastapi import FastAPI

from server.errors import install_error_handlers
from server.job_events import events_of
from server.jobs.service import Jobs
from server.live import LiveSessions
from server.middleware import install_middleware
from server.openapi import DocumentedApi
from server.quotas import Quotas
from server.readiness import Readiness
from server.routes import (
    analyses,
    components,
    controllers,
    design_files,
    designs,
    health,
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
from server.telemetry import Telemetry
from server.version import VERSION

API = "/api/v1"
NOUNS = (
    presets, schemas, designs, design_files, stored_designs, components, sessions, simulations, analyses, controllers,
    job_routes, job_results,
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
    store = store if store is not None else open_store(settings)
    runner, stopping, telemetry, quotas = Runner(), Stopping(), Telemetry(), Quotas(settings.quotas)
    stopping.on_stop(runner.cancel_all)
    telemetry.watch("simulations_running", "Previews and analyses that compute or wait to.", lambda: runner.under_way)

    @asynccontextmanager
    async def until_stopped(app: FastAPI) -> AsyncIterator[None]:
        async with lifespan(app) if lifespan is not None else nullcontext():
            if jobs is not None:
                jobs.start()
            try:
                yield
            finally:
                stopping.begin()
                if jobs is not None:
                    await anyio.to_thread.run_sync(jobs.stop)
                store.database.close()

    app = DocumentedApi(
        title="Glider studio", version=VERSION, description=DESCRIPTION, lifespan=until_stopped,
        openapi_url=f"{API}/openapi.json", docs_url=None, redoc_url=None, separate_input_output_schemas=False,
    )  # fmt: skip
    app.state.settings, app.state.live, app.state.runner, app.state.store = settings, live, runner, store
    app.state.quotas, app.state.telemetry = quotas, telemetry
    app.state.stopping, app.state.readiness = stopping, Readiness()
    app.state.readiness.add("store", store.check)
    app.state.jobs, app.state.job_events = jobs, events_of(jobs) if jobs is not None else None
    if jobs is not None:
        app.state.readiness.add("engine", jobs.manager.engine.check)
        telemetry.watch("job_listeners", "Who is told what becomes of jobs.", lambda: app.state.job_events.listeners)
    install_middleware(app, settings, quotas=quotas, telemetry=telemetry, stopping=stopping)
    install_error_handlers(app)
    app.include_router(health.router)
    for noun in NOUNS:
        app.include_router(noun.router, prefix=API)
    return app
