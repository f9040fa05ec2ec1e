"""Owns what machines ask: /healthz, whether the program is up; /readyz, whether it can work; /metrics, its figures."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from models.problems import Problem
from models.warm import kernel_is_ready
from server.answers import json_answer
from server.errors import problem_response
from server.openapi import operation
from server.readiness import OK, Readiness
from server.schemas import Health, Ready
from server.telemetry import Telemetry
from server.version import VERSION

router = APIRouter(tags=["health"])


@router.get("/healthz", response_model=Health, summary="Ask whether the program is up", **operation("get_health"))
async def get_health() -> Response:
    """Answer at once, also while the kernel compiles; needs no token."""
    kernel = "ready" if kernel_is_ready() else "compiling"
    return json_answer({"status": "ok", "kernel": kernel, "version": VERSION})


@router.get(
    "/readyz", response_model=Ready, summary="Ask whether the program can work", **operation("get_readiness", 503)
)
async def get_readiness(request: Request) -> Response:
    """Run every check within its time limit; 503 names those that fail. Needs no token."""
    readiness: Readiness = request.app.state.readiness
    checks = await readiness.ask()
    failed = [Problem("", f"{name}: {state}") for name, state in checks.items() if state != OK]
    if failed:
        detail = f"not ready: {', '.join(name for name, state in checks.items() if state != OK)}"
        return problem_response(503, "Service Unavailable", detail=detail, errors=failed, headers={"Retry-After": "5"})
    return json_answer({"status": "ready", "checks": checks})


@router.get("/metrics", include_in_schema=False)
def get_metrics(request: Request) -> Response:
    """Answer the figures in Prometheus's own form; with the token where one is set, unless metrics_open."""
    telemetry: Telemetry = request.app.state.telemetry
    content, media_type = telemetry.exposition(request.headers.get("accept", ""))
    return Response(content, headers={"Content-Type": media_type})
