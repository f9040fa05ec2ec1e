"""Owns /analyses: quick answers about a design."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from models.checks import extension_problems
from models.problems import DesignError
from server.answers import json_answer
from server.dependencies import Document, SettingsNow
from server.documents import read_request, under
from server.openapi import operation
from server.schemas import DESIGN_REF, MassProperties, MassRequest
from server.weighing import weigh

router = APIRouter(tags=["analyses"])


@router.post(
    "/analyses:mass", response_model=MassProperties, summary="Weigh a design",
    **operation("analyze_mass", body=MassRequest, bare=DESIGN_REF),
)  # fmt: skip
def analyze_mass(document: Document, settings: SettingsNow) -> Response:
    """Answer mass, centre of mass, inertia, displaced volume, centre of buoyancy and net buoyancy, whole and by part.

    At options.extensions (m, by name), and at the mission's initial extensions where not named.
    """
    design, request, prefix = read_request(document, MassRequest, settings.limits)
    asked = request.options.extensions
    started = {name: e for name, e in design.mission.initial.extensions.items() if name not in asked}
    problems = under(prefix, list(extension_problems(design, started, "/mission/initial/extensions")))
    problems += list(extension_problems(design, asked, "/options/extensions"))
    if problems:
        raise DesignError(problems)
    return json_answer(weigh(design, asked))
