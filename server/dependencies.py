"""Owns what routes are given: the settings, the open sessions, the runner, and the decoded body."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Request

from server.body import JsonBody, loads
from server.live import LiveSessions
from server.running import Runner
from server.settings import Settings


def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


def _live(request: Request) -> LiveSessions | None:
    live: LiveSessions | None = request.app.state.live
    return live


def _runner(request: Request) -> Runner:
    runner: Runner = request.app.state.runner
    return runner


SettingsNow = Annotated[Settings, Depends(_settings)]
Live = Annotated[LiveSessions | None, Depends(_live)]
SharedRunner = Annotated[Runner, Depends(_runner)]


def _document(body: JsonBody, settings: SettingsNow) -> Any:
    return loads(body, max_values=settings.max_body_values)


Document = Annotated[Any, Depends(_document)]
"""The body as decoded JSON; decoded in a worker thread, for a large one takes a while."""
