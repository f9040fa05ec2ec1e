"""Owns the API application: middleware, error handlers and routes around the settings and the open sessions."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext

from fastapi import FastAPI

from server.access import TokenGate
from server.body import BodyLimit
from server.errors import install_error_handlers
from server.live import LiveSessions
from server.openapi import DocumentedApi
from server.routes import analyses, controllers, designs, health, presets, schemas, sessions, simulations
from server.running import Runner
from server.settings import Settings
from server.version import VERSION

API = "/api/v1"
Lifespan = Callable[[FastAPI], AbstractAsyncContextManager[None]]
DESCRIPTION = (
    "Designs of underwater gliders that steer by buoyancy cells: check, edit, weigh and simulate them. SI units and "
    "radians; body axes x to the nose, y to starboard, z down. Every error is a problem document (RFC 9457)."
)


def create_app(
    settings: Settings | None = None, *, live: LiveSessions | None = None, lifespan: Lifespan | None = None
) -> FastAPI:
    """Return the API; `lifespan` is entered when the server starts and left when it stops."""
    settings = settings if settings is not None else Settings()
    runner = Runner()

    @asynccontextmanager
    async def until_stopped(app: FastAPI) -> AsyncIterator[None]:
        async with lifespan(app) if lifespan is not None else nullcontext():
            try:
                yield
            finally:
                runner.cancel_all()

    app = DocumentedApi(
        title="Glider studio", version=VERSION, description=DESCRIPTION, lifespan=until_stopped,
        openapi_url=f"{API}/openapi.json", docs_url=None, redoc_url=None, separate_input_output_schemas=False,
    )  # fmt: skip
    app.state.settings, app.state.live, app.state.runner = settings, live, runner
    # the last one added is the first that a request meets
    app.add_middleware(BodyLimit, max_bytes=settings.max_body_bytes)
    if settings.demands_token and settings.token is not None:
        app.add_middleware(TokenGate, token=settings.token.get_secret_value())
    install_error_handlers(app)
    app.include_router(health.router)
    for noun in (presets, schemas, designs, sessions, simulations, analyses, controllers):
        app.include_router(noun.router, prefix=API)
    return app
