"""Owns /analyses: quick answers about a design."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel

from models.assemble import assemble
from models.checks import extension_problems
from models.design import Design
from models.problems import DesignError
from models.simulate import Control
from server.analyses import allocation_answer, linearize_answer, polar_answer, stability_answer, trim_answer
from server.answers import json_answer
from server.dependencies import Document, SettingsNow, SharedRunner
from server.documents import design_sent_at, read_request, under
from server.openapi import operation
from server.schemas import DESIGN_REF, MassProperties, MassRequest
from server.schemas_analyses import (
    AllocationAnswer,
    AllocationRequest,
    PolarAnswer,
    PolarRequest,
    TrimAnalysisRequest,
    TrimAnswer,
)
from server.schemas_linear import LinearizeAnswer, LinearizeRequest, StabilityAnswer, StabilityRequest
from server.settings import Settings
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


def answer(document: Any, model: type[Any], settings: Settings, work: Callable[[Design, Any], BaseModel]) -> Response:
    """Read a request, do the work on its design and options, and tell errors by their places in what was sent."""
    design, request, prefix = read_request(document, model, settings.limits)
    with design_sent_at(prefix, beside="/options"):
        return json_answer(work(design, request.options))


@router.post(
    "/analyses:trim", response_model=TrimAnswer, summary="Find steady motions",
    **operation("analyze_trim", body=TrimAnalysisRequest, bare=DESIGN_REF),
)  # fmt: skip
def analyze_trim(document: Document, settings: SettingsNow) -> Response:
    """Answer all steady glides, turns and spirals at given extensions, or the one that meets targets.

    Each is marked stable or not. Targets that cannot be met are an answer too: what would be out of balance, which
    cells are at a stop, and the nearest motion there is.
    """
    return answer(
        document, TrimAnalysisRequest, settings,
        lambda design, options: trim_answer(assemble(design, settings.limits), options),
    )  # fmt: skip


@router.post(
    "/analyses:polar", response_model=PolarAnswer, summary="Draw the glide polar",
    **operation("analyze_polar", body=PolarRequest, bare=DESIGN_REF),
)  # fmt: skip
def analyze_polar(document: Document, settings: SettingsNow) -> Response:
    """Answer speed against glide angle over the strokes of the cells, dives and climbs.

    With the flattest path, the least energy for the way, the slowest sink and the tightest turn as points on it.
    """
    return answer(
        document, PolarRequest, settings,
        lambda design, options: polar_answer(assemble(design, settings.limits), options),
    )  # fmt: skip


@router.post(
    "/analyses:linearize", response_model=LinearizeAnswer, summary="Linearise and show the modes",
    **operation("analyze_linearize", body=LinearizeRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_linearize(
    request: Request, document: Document, settings: SettingsNow, runner: SharedRunner
) -> Response:
    """Answer A, B, C, D about a trim or an instant of the mission, with named states, inputs and outputs.

    Also the modes and what the cells can move; on demand frequency responses, and a root locus over any number of the
    design, which is trimmed anew at each value.
    """

    def work(control: Control) -> Response:
        return answer(
            document, LinearizeRequest, settings,
            lambda design, options: linearize_answer(design, options, settings, control),
        )  # fmt: skip

    return await runner.run(request, work)


@router.post(
    "/analyses:stability", response_model=StabilityAnswer, summary="Follow stability along the mission",
    **operation("analyze_stability", body=StabilityRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_stability(
    request: Request, document: Document, settings: SettingsNow, runner: SharedRunner
) -> Response:
    """Simulate the mission and answer its static margins and the growth of small motions along it.

    The worst of each and when; every change of sign is a warning.
    """

    def work(control: Control) -> Response:
        return answer(
            document, StabilityRequest, settings,
            lambda design, options: stability_answer(design, options, settings, control),
        )  # fmt: skip

    return await runner.run(request, work)


@router.post(
    "/analyses:allocation", response_model=AllocationAnswer, summary="See what the cells can do together",
    **operation("analyze_allocation", body=AllocationRequest, bare=DESIGN_REF),
)  # fmt: skip
def analyze_allocation(document: Document, settings: SettingsNow) -> Response:
    """Answer what each cell does to heave, pitch and roll, which of these the cells can hold apart, and how strongly.

    With options.wanted also the extensions that make it, and what is missing where the stops do not allow it.
    """
    return answer(
        document, AllocationRequest, settings,
        lambda design, options: allocation_answer(design, options, settings.limits),
    )  # fmt: skip
