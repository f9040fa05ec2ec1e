"""Owns /analyses: quick answers about a design."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response
from pydantic import BaseModel

from models.assemble import Assembly, assemble
from models.checks import extension_problems
from models.limits import Limits
from models.problems import DesignError
from models.simulate import Control
from server.analyses import allocation_answer, linearize_answer, polar_answer, stability_answer, trim_answer
from server.answers import json_answer
from server.dependencies import Document, SettingsNow, SharedRunner
from server.documents import design_sent_at, read_request, under
from server.openapi import operation
from server.preview import PreviewRun, run_preview
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


Work = Callable[[Assembly, Any, Control], BaseModel]
"""What an analysis does: from an assembled design, options, and a handle to stop it, to an answer."""


class Analyst:
    """Does analyses for one request, a few at a time, and tells errors by their places in what was sent."""

    def __init__(self, request: Request, document: Document, settings: SettingsNow, runner: SharedRunner) -> None:
        self._request, self._document, self._settings, self._runner = request, document, settings, runner

    @property
    def limits(self) -> Limits:
        """The limits of a design."""
        return self._settings.limits

    async def answer(self, model: type[Any], work: Work) -> Response:
        """Read what was sent as a `model`, and do the work on its design and options beside the event loop."""
        return await self._runner.run(self._request, lambda control: self._worked(model, work, control))

    def _worked(self, model: type[Any], work: Work, control: Control) -> Response:
        design, sent, prefix = read_request(self._document, model, self.limits)
        with design_sent_at(prefix, beside="/options"):
            return json_answer(work(assemble(design, self.limits), sent.options, control))

    def flight(self, assembly: Assembly, control: Control) -> Callable[[], PreviewRun]:
        """Return what flies the mission of a design within the limits of a preview."""
        return lambda: run_preview(assembly.design, self._settings, control)


OneAnalyst = Annotated[Analyst, Depends()]


@router.post(
    "/analyses:trim", response_model=TrimAnswer, summary="Find steady motions",
    **operation("analyze_trim", body=TrimAnalysisRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_trim(analyst: OneAnalyst) -> Response:
    """Answer all steady glides, turns and spirals at given extensions, or the one that meets targets.

    Each is marked stable or not. Targets that cannot be met are an answer too: what would be out of balance, which
    cells are at a stop, and the nearest motion there is.
    """
    return await analyst.answer(TrimAnalysisRequest, lambda assembly, options, _: trim_answer(assembly, options))


@router.post(
    "/analyses:polar", response_model=PolarAnswer, summary="Draw the glide polar",
    **operation("analyze_polar", body=PolarRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_polar(analyst: OneAnalyst) -> Response:
    """Answer speed against glide angle over the strokes of the cells, dives and climbs.

    With the flattest path, the least energy for the way, the slowest sink and the tightest turn as points on it.
    """
    return await analyst.answer(PolarRequest, lambda assembly, options, _: polar_answer(assembly, options))


@router.post(
    "/analyses:linearize", response_model=LinearizeAnswer, summary="Linearise and show the modes",
    **operation("analyze_linearize", body=LinearizeRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_linearize(analyst: OneAnalyst) -> Response:
    """Answer A, B, C, D about a trim or an instant of the mission, with named states, inputs and outputs.

    Also the modes and what the cells can move; on demand frequency responses, and a root locus over any number of the
    design, which is trimmed anew at each value.
    """
    return await analyst.answer(
        LinearizeRequest,
        lambda assembly, options, control: linearize_answer(
            assembly, options, analyst.flight(assembly, control), limits=analyst.limits, control=control
        ),
    )


@router.post(
    "/analyses:stability", response_model=StabilityAnswer, summary="Follow stability along the mission",
    **operation("analyze_stability", body=StabilityRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_stability(analyst: OneAnalyst) -> Response:
    """Simulate the mission and answer its static margins and the growth of small motions along it.

    The worst of each and when; whatever stability is lost is a warning. Where the run was cut off, the message says so.
    """
    return await analyst.answer(
        StabilityRequest,
        lambda assembly, options, control: stability_answer(assembly, options, analyst.flight(assembly, control)),
    )


@router.post(
    "/analyses:allocation", response_model=AllocationAnswer, summary="See what the cells can do together",
    **operation("analyze_allocation", body=AllocationRequest, bare=DESIGN_REF),
)  # fmt: skip
async def analyze_allocation(analyst: OneAnalyst) -> Response:
    """Answer what each cell does to heave, pitch and roll, which of these the cells can hold apart, and how strongly.

    With options.wanted also the extensions that make it, and what is missing where the stops do not allow it.
    """
    return await analyst.answer(AllocationRequest, lambda assembly, options, _: allocation_answer(assembly, options))
