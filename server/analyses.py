"""Owns the analyses of a design: from options to answers, through the library. It knows no HTTP."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from models.allocation import AXES, allocate, authority, effectiveness
from models.assemble import Assembly
from models.controllability import HoldingPower, controllability
from models.frequency_response import frequency_response
from models.glide_polar import glide_polar
from models.limits import Limits
from models.linearize import linearize
from models.modes import modes_of
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem, pointer_to
from models.root_locus import root_locus
from models.run import Status
from models.simulate import Control
from models.stability import stability_over
from models.targeted_trim import TrimFailure, trim_for
from models.trim import Trim, TrimSearch, find_trims
from models.trim_search import Search
from models.warm import warm_analyses
from server import schemas_analyses as wire
from server import schemas_linear as small
from server.preview import PreviewRun

Fly = Callable[[], PreviewRun]
"""Flies the mission of the design under analysis."""
OF_THE_DESIGN = ("/vehicle", "/mission", "/name", "/notes", "/format", "/version")


@contextmanager
def options_sent_at(pointer: str = "/options") -> Iterator[None]:
    """Move the pointers of a `DesignError` that are not into the design under the options."""
    try:
        yield
    except DesignError as error:
        moved = (
            p if p.pointer.startswith((*OF_THE_DESIGN, pointer)) else replace(p, pointer=pointer + p.pointer)
            for p in error.problems
        )
        raise DesignError(moved) from None


def trim_item(trim: Trim) -> wire.TrimItem:
    """Return a trim as it goes on the wire."""
    names = [name for name in wire.TrimItem.model_fields if name not in ("velocity", "residual", "extensions")]
    values: dict[str, Any] = {name: getattr(trim, name) for name in names}
    if not math.isfinite(trim.glide_ratio):
        values["glide_ratio"] = None
    values |= {"velocity": trim.velocity.tolist(), "residual": dict(trim.residual), "extensions": dict(trim.extensions)}
    return wire.TrimItem.model_validate(values)


def failure_item(failure: TrimFailure) -> wire.FailureItem:
    """Return why targets cannot be met, as it goes on the wire."""
    return wire.FailureItem(
        message=str(failure), residual=dict(failure.residual),
        missed=[wire.MissedItem(target=m.target, wanted=m.wanted, reached=m.reached) for m in failure.missed],
        active=[
            wire.BoundItem.model_validate({"cell": bound.cell, "stop": bound.stop, "extension": bound.extension})
            for bound in failure.active
        ],
        nearest=None if failure.nearest is None else trim_item(failure.nearest),
    )  # fmt: skip


def search_of(options: wire.SearchOptions) -> Search:
    """Return what is searched; raises `DesignError` where steps or banks are not what they may be."""
    usual = Search()
    return Search(
        angle_step=usual.angle_step if options.angle_step is None else options.angle_step,
        banks=usual.banks if options.banks is None else tuple(options.banks),
    )


def sought(assembly: Assembly, options: wire.TrimOptions) -> TrimSearch | Trim | TrimFailure:
    """Return all trims, or the one that meets targets, or why there is none; waits for the compiler first."""
    warm_analyses()
    targets = options.targets.given()
    with options_sent_at():
        if not targets:
            return find_trims(
                assembly, extensions=options.extensions, depth=options.depth, search=search_of(options.search)
            )
        return trim_for(
            assembly, targets, options.free or assembly.cells, extensions=options.extensions, depth=options.depth
        )


def trim_answer(assembly: Assembly, options: wire.TrimOptions) -> wire.TrimAnswer:
    """Return the steady motions that the options ask for."""
    found = sought(assembly, options)
    if isinstance(found, Trim):
        return wire.TrimAnswer(trims=[trim_item(found)], searched=None, rest=None, failure=None)
    if isinstance(found, TrimFailure):
        return wire.TrimAnswer(trims=[], searched=None, rest=None, failure=failure_item(found))
    rest = found.rest
    return wire.TrimAnswer(
        trims=[trim_item(trim) for trim in found.solutions], searched=found.searched, failure=None,
        rest=None if rest is None else wire.RestItem(roll=rest.roll, pitch=rest.pitch, stiffness=rest.stiffness),
    )  # fmt: skip


def first_trim(assembly: Assembly, options: wire.TrimOptions) -> Trim:
    """Return the first trim that the options lead to, stable ones first; raises `DesignError` where there is none."""
    found = sought(assembly, options)
    if isinstance(found, Trim):
        return found
    if isinstance(found, TrimFailure):
        raise DesignError([Problem("/options/targets", str(found), hint="free more cells, or ask for less")])
    if not found.solutions:
        hint = (
            "say which motion by options.targets (--target speed=0.3), name an instant of the mission by options.time "
            "(--time), or give extensions that make the glider heavier or lighter than water"
        )
        raise DesignError([Problem("/options/extensions", f"there is no trim: {found.searched}", hint=hint)])
    return found.solutions[0]


def polar_answer(assembly: Assembly, options: wire.PolarOptions) -> wire.PolarAnswer:
    """Return the glide polar and its best points; waits for the compiler first."""
    warm_analyses()
    with options_sent_at():
        polar = glide_polar(
            assembly, points=options.points, cells=options.cells, cycle_depth=options.cycle_depth,
            extensions=options.extensions, depth=options.depth,
        )  # fmt: skip
    best = polar.best_energy
    named = {name: getattr(polar, name) for name in ("best_range", "slowest_sink", "tightest_turn")}
    return wire.PolarAnswer(
        cells=list(polar.cells), cycle_depth=polar.cycle_depth, energy=polar.energy,
        curves=[
            wire.PolarCurve(
                heave=curve.heave, trims=[trim_item(trim) for trim in curve.points], moments=curve.moments.tolist(),
                left_out=dict(curve.left_out),
            )
            for curve in polar.curves
        ],
        best_energy=None if best is None else wire.EnergyItem(
            trim=trim_item(best.trim), hotel=best.hotel, pump=best.pump, per_km=best.per_km
        ),
        **{name: None if trim is None else trim_item(trim) for name, trim in named.items()},
    )  # fmt: skip


def linearize_answer(
    assembly: Assembly, options: small.LinearizeOptions, fly: Fly, *, limits: Limits, control: Control
) -> small.LinearizeAnswer:
    """Return the linear model at a trim or at an instant of the mission, with what is asked of it.

    A root locus assembles its designs within the limits, and `control` stops it between two values.
    """
    warm_analyses()
    trim = None
    if options.time is None:
        trim = first_trim(assembly, options)
        point = point_of(trim)
    else:
        point = _instant(fly(), options.time)
    with options_sent_at():
        model = linearize(assembly, point)
    asked = enumerate(options.responses)
    strokes = [part.stroke[1] - part.stroke[0] for _, part in assembly.design.vehicle.actuated]
    return small.LinearizeAnswer.model_validate(
        {
            "trim": None if trim is None else trim_item(trim), "model": model.as_dict(),
            "modes": modes_of(model.A, model.state_names).as_dict(),
            "controllability": controllability(model, strokes).as_dict(),
            "responses": [_response(model, wanted, k, options.frequencies) for k, wanted in asked],
            "locus": _locus(assembly, options, point, limits, control),
        }
    )  # fmt: skip


def _instant(flown: PreviewRun, time: float) -> OperatingPoint:
    last = float(flown.run.times[-1])
    cut_off = flown.run.status is Status.cancelled
    if time > last or cut_off:
        hint = "shorten the mission to what is looked at" if cut_off else "give an earlier instant"
        raise DesignError([Problem("/options/time", f"the run ends at {last:g} s: {flown.message}", last, hint)])
    return OperatingPoint.from_run(flown.run, time)


def _response(model: Any, wanted: small.ResponseOptions, k: int, frequencies: Sequence[float] | None) -> dict[str, Any]:
    omega = None if frequencies is None else np.array(frequencies)
    try:
        return frequency_response(model, input=wanted.input, output=wanted.output, frequencies=omega).as_dict()
    except DesignError as error:
        of_one = ("/input", "/output")
        at = (f"/options/responses/{k}" if p.pointer in of_one else "/options" for p in error.problems)
        moved = (replace(p, pointer=where + p.pointer) for p, where in zip(error.problems, at, strict=True))
        raise DesignError(moved) from None


def _locus(
    assembly: Assembly, options: small.LinearizeOptions, point: OperatingPoint, limits: Limits, control: Control
) -> dict[str, Any] | None:
    """Return the root locus asked for, at the extensions of the point, or for the targets that led to it."""
    locus, targets = options.locus, options.targets.given() if options.time is None else {}
    if locus is None:
        return None
    moving = [cell for cell in assembly.cells if pointer_to("extensions", cell) != locus.pointer]
    try:
        return root_locus(
            assembly.design, locus.pointer, locus.values, extensions=point.extensions, depth=point.depth,
            targets=targets or None, free=(options.free or moving) if targets else None, limits=limits,
            progress=lambda _done, _all: not control.cancelled,
        ).as_dict()  # fmt: skip
    except DesignError as error:
        raise DesignError(replace(p, pointer=_of_locus(p.pointer, locus)) for p in error.problems) from None


def _of_locus(pointer: str, locus: small.LocusOptions) -> str:
    """Return where in the options a problem of a locus lies; a pointer into the design or the options stays."""
    if pointer.startswith("/values"):
        return f"/options/locus{pointer}"
    if pointer != locus.pointer and pointer.startswith((*OF_THE_DESIGN, "/options")):
        return pointer
    return "/options/locus/pointer"


def stability_answer(assembly: Assembly, options: small.StabilityOptions, fly: Fly) -> small.StabilityAnswer:
    """Return the margins along the mission, thinned to what is asked for, and the worst of each over all samples."""
    warm_analyses()
    flown = fly()
    run = flown.run
    history = stability_over(run, options.samples, assembly=assembly).as_dict()
    count = min(len(run.times), options.max_points)
    kept = np.unique(np.linspace(0, len(run.times) - 1, count).round().astype(int)).tolist()
    thinned = {
        name: [history[name][k] for k in kept]
        for name in (
            "times", "offset", "hydrostatic_margin", "pitch_stiffness", "roll_stiffness", "pitch_margin", "yaw_margin",
        )
    }  # fmt: skip
    told = {"status": run.status.name, "message": flown.message}
    return small.StabilityAnswer.model_validate({**history, **thinned, **told})


def allocation_answer(assembly: Assembly, options: wire.AllocationOptions) -> wire.AllocationAnswer:
    """Return what the cells do, and the extensions for what is wanted."""
    design = assembly.design
    with options_sent_at():
        cells = effectiveness(design, options.cells, depth=options.depth)
    held = HoldingPower(cells.cells, authority(cells))
    unknown = [name for name in options.effort if name not in cells.cells]
    if unknown:
        hint = f"those are: {', '.join(cells.cells) or 'none'}"
        raise DesignError(
            Problem(pointer_to("options", "effort", name), f"'{name}' is not among the cells", hint=hint)
            for name in unknown
        )
    allocation = None
    if options.wanted is not None:
        weights, wanted = options.weights, [getattr(options.wanted, axis) for axis in AXES]
        found = allocate(cells, wanted, (weights.heave, weights.pitch, weights.roll), effort=options.effort)
        allocation = wire.AllocationItem(
            extensions=found.extensions, at_stop=list(found.at_stop), short=list(found.short), message=str(found),
            reached=wire.Wish(**dict(zip(AXES, found.reached.tolist(), strict=True))),
            missing=wire.Wish(**dict(zip(AXES, found.missing.tolist(), strict=True))),
        )  # fmt: skip
    told = held.as_dict()
    return wire.AllocationAnswer(
        **told, units=list(cells.units), matrix=cells.matrix.tolist(), allocation=allocation,
    )  # fmt: skip
