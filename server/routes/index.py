"""Owns where one begins: /api/v1, what there is and where; /docs, a page of all operations for people."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.answers import json_answer
from server.openapi import operation
from server.operations_page import operations_page
from server.schemas import ApiIndex
from server.version import VERSION

PLACES = ("presets", "schemas/design", "schemas/batch", "designs", "jobs")
"""What can be asked for without knowing more, by its address below that of the index."""
PAGE_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
router = APIRouter(tags=["index"])
pages = APIRouter(include_in_schema=False)


@router.get("", response_model=ApiIndex, summary="See what there is", **operation("get_index"))
def get_index(request: Request) -> Response:
    """Answer where the OpenAPI document, the page of all operations, and the first things to ask for are."""
    base, root = request.url.path, request.scope.get("root_path", "")
    links = {"openapi": f"{base}/openapi.json", "docs": f"{root}/docs"}
    return json_answer(ApiIndex(version=VERSION, links=links | {place: f"{base}/{place}" for place in PLACES}))


@pages.get("/docs")
def get_docs(request: Request) -> Response:
    """Answer the page of all operations; it says what every installation is the same in, so it needs no token."""
    return HTMLResponse(operations_page(request.app.openapi()), headers={"Content-Security-Policy": PAGE_POLICY})
