"""Owns /simulations: a capped run that is answered at once, as JSON, CSV or NetCDF."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from models.simulate import Control
from server.answers import CSV, JSON, NETCDF, negotiate, series_answer
from server.dependencies import Document, SettingsNow, SharedRunner
from server.documents import design_sent_at, read_request
from server.openapi import operation
from server.preview import as_mapping, check_columns, run_preview, thinned
from server.schemas import DESIGN_REF, Preview, PreviewRequest
from server.settings import Settings

router = APIRouter(tags=["simulations"])
FILES: dict[int | str, dict[str, Any]] = {
    200: {"content": {CSV: {"schema": {"type": "string"}}, NETCDF: {"schema": {"type": "string", "format": "binary"}}}}
}


@router.post(
    "/simulations:preview", response_model=Preview, summary="Simulate a design at once", responses=FILES,
    **operation("preview_simulation", 406, body=PreviewRequest, bare=DESIGN_REF),
)  # fmt: skip
async def preview_simulation(
    request: Request, document: Document, settings: SettingsNow, runner: SharedRunner
) -> Response:
    """Simulate a design's mission within the limits of a preview; Accept chooses JSON, CSV or NetCDF.

    A JSON answer has at most options.max_points samples (2000 if not given), chosen so that the first, the last and
    the extremes of every column survive; files have all samples unless max_points is given. A run that ends early is
    an answer too: its status says how, its message what to try. A run that computes too long is stopped and kept.
    """
    media = negotiate(request.headers.get("accept"), (JSON, CSV, NETCDF))
    return await runner.run(request, lambda control: _answer(document, media, settings, control))


def _answer(document: Any, media: str, settings: Settings, control: Control) -> Response:
    design, sent, prefix = read_request(document, PreviewRequest, settings.limits)
    columns, max_points = check_columns(sent.options.columns), sent.options.max_points
    with design_sent_at(prefix):
        preview = run_preview(design, settings, control)
    if media == JSON:
        return series_answer(as_mapping(preview, columns, max_points))
    run = thinned(preview.run, max_points)
    return Response(run.to_csv() if media == CSV else run.to_netcdf(), media_type=media)
