"""Owns /controllers: the design of controllers."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from models.simulate import Control
from server.answers import JSON, json_answer, negotiate
from server.controlling import answer_of, design_for, file_of
from server.dependencies import Document, SettingsNow, SharedRunner
from server.documents import design_sent_at, read_request
from server.openapi import operation
from server.preview import preview_limits
from server.schemas import DESIGN_REF
from server.schemas_control import ControllerDesignRequest, DesignedController
from server.settings import Settings

MAT, PYTHON = "application/x-matlab-data", "text/x-python"
ENDINGS = {MAT: ".mat", PYTHON: ".py"}
FILES: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {
            MAT: {"schema": {"type": "string", "format": "binary"}}, PYTHON: {"schema": {"type": "string"}},
        }
    }
}  # fmt: skip
router = APIRouter(tags=["controllers"])


@router.post(
    "/controllers:design", response_model=DesignedController, summary="Design a controller", responses=FILES,
    **operation("design_controller", 406, body=ControllerDesignRequest, bare=DESIGN_REF),
)  # fmt: skip
async def design_controller(
    request: Request, document: Document, settings: SettingsNow, runner: SharedRunner
) -> Response:
    """Design state feedback about a trim or a table of them, or first gains for guidance and loops.

    The answer holds the document for mission.control.controller, the modes, margins and, on demand, a step response of
    the linear model and flown on the non-linear one. Accept chooses JSON, a MATLAB file, or a Python script that
    rebuilds the loop.
    """
    media = negotiate(request.headers.get("accept"), (JSON, MAT, PYTHON))
    return await runner.run(request, lambda control: _answer(document, media, settings, control))


def _answer(document: Any, media: str, settings: Settings, control: Control) -> Response:
    design, sent, prefix = read_request(document, ControllerDesignRequest, settings.limits)
    with design_sent_at(prefix, beside="/options"):
        result = design_for(
            design, sent.options, settings.limits, flown_within=preview_limits(settings), control=control
        )
        if media == JSON:
            return json_answer(answer_of(result))
        return Response(file_of(result, ENDINGS[media]), media_type=media)
