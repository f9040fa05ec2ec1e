"""Owns the look for parameters that change nothing, such as a component's mass where the vehicle's is declared."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from models.assemble import Assembly, assemble
from models.design import Design
from models.limits import Limits
from models.problems import DesignError
from models.variation import Varied
from server.jobs.plan import Plan

LOOKED_AT = 64
"""Cases among which two values of a parameter are sought."""
MOST_PARAMETERS = 50


def inert_warnings(plan: Plan, limits: Limits) -> Iterator[str]:
    """Yield a warning for each parameter with which neither the glide nor what it costs changes."""
    rows = plan.rows(0, min(plan.count, LOOKED_AT))
    for k, parameter in enumerate(plan.parameters[:MOST_PARAMETERS]):
        values = [row[k] for row in rows]
        other = next((value for value in values if value != values[0]), None)
        if other is not None and _same(plan, k, values[0], other, limits):
            yield (
                f"{parameter.name} changes nothing: the glide is the same with {values[0]} and with {other} at "
                f"{parameter.pointer}. Something else decides, such as declared mass properties, or a controller."
            )


def _same(plan: Plan, k: int, one: Any, other: Any, limits: Limits) -> bool:
    varied = Varied(plan.design, [plan.targets[k]])
    try:
        a, b = (assemble(varied.design([value]), limits) for value in (one, other))
    except DesignError:  # a design that is refused is no proof
        return False
    return _records(a) == _records(b) and _beside(a.design) == _beside(b.design)


def _records(assembly: Assembly) -> tuple[bytes, ...]:
    return tuple(array.tobytes() for array in (*assembly.params, assembly.initial_state))


def _beside(design: Design) -> tuple[object, ...]:
    """Return what decides a run, its outputs or its bill beside the kernel's records."""
    mission, vehicle = design.mission, design.vehicle
    return mission.duration, mission.solver, vehicle.hotel_power, tuple(c.name for c in vehicle.components)
