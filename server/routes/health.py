"""Owns /healthz: whether the program is up, and whether it can simulate at once."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from models.warm import kernel_is_ready
from server.answers import json_answer
from server.openapi import operation
from server.schemas import Health
from server.version import VERSION

router = APIRouter(tags=["health"])


@router.get("/healthz", response_model=Health, summary="Ask whether the program is up", **operation("get_health"))
async def get_health() -> Response:
    """Answer at once, also while the kernel compiles; needs no token."""
    kernel = "ready" if kernel_is_ready() else "compiling"
    return json_answer({"status": "ok", "kernel": kernel, "version": VERSION})
