"""Owns the HTTP of a session's slower analyses, asked for when they are opened: modes, glide polar, error, trims.

They run beside the event loop, a few at a time, and are stopped when nobody waits or they take too long.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, HTTPException, Query, Request
from fastapi.responses import Response
from pydantic import ValidationError

from models.assemble import Assembly, assemble
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem, problems_from_validation
from models.run import Run
from models.simulate import Control
from models.warm import warm_analyses
from server.analyses import options_sent_at, trim_answer
from server.answers import series_answer
from server.running import Runner
from server.schemas_analyses import TrimOptions
from server.time_limits import TimeLimits
from studio.access import Admitted, SettingsNow
from studio.consequences import Consequences, consequences_document, consequences_of
from studio.error_estimate import error_estimate
from studio.glide_polar_document import glide_polar_document
from studio.mode_motion import modes_document
from studio.operations import Document
from studio.run_operations import run_kept_as

router = APIRouter(prefix="/s/{session_id}", include_in_schema=False)
NO_RUN = "there is no run yet: the physics is still being compiled"
_TIME_LIMITS = TimeLimits()


class Analyst:
    """Does the analyses of one request: few at a time, and no longer than a preview may take."""

    def __init__(self, request: Request, opened: Admitted, settings: SettingsNow) -> None:
        self._request, self.opened, self.settings = request, opened, settings
        self._runner: Runner = request.app.state.runner

    async def answer(self, work: Callable[[Control], dict[str, Any]]) -> Response:
        """Answer what `work` returns; its control is cancelled when the client leaves or time is up."""

        def limited(control: Control) -> Response:
            with _TIME_LIMITS.within(self.settings.preview_seconds, control.cancel):
                return series_answer(work(control))

        answer = await self._runner.run(self._request, limited)
        answer.headers["Cache-Control"] = "no-store"
        return answer

    @property
    def run(self) -> Run:
        """The session's last run; answers 409 before the first."""
        run = self.opened.session.run
        if run is None:
            raise HTTPException(409, NO_RUN)
        return run


OneAnalyst = Annotated[Analyst, Depends()]


@router.get("/modes")
async def get_modes(
    analyst: OneAnalyst, hold: Annotated[int, Query(ge=0)] = 0, time: Annotated[float | None, Query(ge=0.0)] = None
) -> Response:
    """Answer the modes at the trim of a hold, by its place in the consequences, or at a time of the run."""
    session = analyst.opened.session
    found, run = session.consequences.found, analyst.run

    def work(_: Control) -> dict[str, Any]:
        warm_analyses()
        if time is None:
            return modes_document(*_trimmed(found, hold))
        return modes_document(assemble(run.design, session.limits), OperatingPoint.from_run(run, time))

    return await analyst.answer(work)


def _trimmed(found: Consequences | None, hold: int) -> tuple[Assembly, OperatingPoint]:
    if found is None:
        raise HTTPException(409, NO_RUN)
    if hold >= len(found.glides):
        message = f"hold {hold} is none of the {len(found.glides)} that the schedule has"
        hint = "choose one of the list, or a time"
        raise DesignError([Problem("/hold", message, len(found.glides) - 1, hint)])
    glide = found.glides[hold]
    if glide.trim is None:
        hint = "look at the modes at the clock, or change what is held so that a glide exists"
        raise DesignError([Problem("/hold", f"there is no trim at this hold: {glide.why}", None, hint)])
    return found.assembly, point_of(glide.trim)


@router.get("/glide-polar")
async def get_glide_polar(analyst: OneAnalyst) -> Response:
    """Answer speed against path angle over the strokes of the cells, and the best points."""
    assembly = analyst.opened.session.assembly

    def work(_: Control) -> dict[str, Any]:
        warm_analyses()
        return glide_polar_document(assembly)

    return await analyst.answer(work)


@router.get("/error-estimate")
async def get_error_estimate(analyst: OneAnalyst) -> Response:
    """Answer how far the last run is from the same mission flown more carefully."""
    run, limits = analyst.run, analyst.opened.session.limits
    return await analyst.answer(lambda control: error_estimate(run, limits, control))


@router.get("/runs/{run_id}/consequences")
async def get_kept_consequences(analyst: OneAnalyst, run_id: str) -> Response:
    """Answer the consequences of a kept run, to compare with."""
    session = analyst.opened.session
    run = run_kept_as(run_id, session)

    def work(_: Control) -> dict[str, Any]:
        warm_analyses()
        return consequences_document(consequences_of(assemble(run.design, session.limits), run))

    return await analyst.answer(work)


@router.post("/trim-for")
async def find_trim(analyst: OneAnalyst, document: Document) -> Response:
    """Answer the trim that meets targets by moving cells, or what keeps them from it and the nearest there is."""
    try:
        options = TrimOptions.model_validate(document)
    except ValidationError as error:
        raise DesignError(problems_from_validation(error, document)) from None
    assembly = analyst.opened.session.assembly

    def work(_: Control) -> dict[str, Any]:
        with options_sent_at(""):
            return trim_answer(assembly, options).model_dump()

    return await analyst.answer(work)
