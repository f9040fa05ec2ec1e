"""Owns what each hold of a mission amounts to: how the glider floats there, what its cells can still do, and its trim.

Of several trims the stable one nearest to how the run moves at the end of the hold is told, since that is where the
glider went; without a run, the first that the search finds. Up is positive for forces, SI units and radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.components import MovableMass, RollingMass
from models.design import Design
from models.mass_properties import mass_balance
from models.moments import moment_in_words
from models.operating_point import OperatingPoint, down_in_body
from models.problems import DesignError
from models.run import Run
from models.still_water import trim_depth
from models.trim import RestAttitude, Trim, TrimSearch, find_trims
from models.volumes import volume
from models.water import density_at, gravity_of
from studio.holds import Hold

Array = NDArray[np.float64]
COMPILING = "the analyses are still being compiled"
NOTHING_DRIVES = "the glider weighs what it displaces"


@dataclass(frozen=True)
class Reserve:
    """Net buoyancy (N) with the cells as held, and as heavy and as light as their stops allow."""

    now: float
    least: float
    most: float

    @property
    def share(self) -> float:
        """Where the cells are between as heavy (0) and as light (1) as they can be; 0.5 where they change nothing."""
        return (self.now - self.least) / (self.most - self.least) if self.most > self.least else 0.5


@dataclass(frozen=True, eq=False)
class HeldGlide:
    """A hold, how it floats, and its trim; without one `why` says so in words, and `rest` how the glider hangs.

    `offset` (3,) m goes from the centre of buoyancy to that of mass; `others` are the trims beside the one told.
    `searched` is False as long as the search is being compiled, and where the run ended before the hold.
    """

    hold: Hold
    searched: bool
    depth: float
    reserve: Reserve
    offset: Array
    trim: Trim | None
    others: tuple[Trim, ...]
    why: str | None
    rest: RestAttitude | None


def held_glide(assembly: Assembly, hold: Hold, run: Run | None, *, analyses: bool) -> HeldGlide:
    """Return what a hold amounts to; without `analyses` (they are compiled yet) there is no trim."""
    depth = depth_of(assembly.design, hold, run)
    balance = mass_balance(assembly.design.vehicle, hold.extensions)
    searched, unsought = analyses and hold.reached, COMPILING if run is None or hold.reached else _not_reached(run)
    trim, others, why, rest = _trim(assembly, hold, depth, run) if searched else (None, (), unsought, None)
    offset, reserve = balance.center_of_mass - balance.center_of_buoyancy, reserve_of(assembly.design, hold, depth)
    return HeldGlide(hold, searched, depth, reserve, offset, trim, others, why, rest)


def _not_reached(run: Run) -> str:
    return f"not reached, the run ended at {moment_in_words(run.times[-1], run.times[-1])}"


def depth_of(design: Design, hold: Hold, run: Run | None) -> float:
    """Return the depth at which a hold's trim is sought: the run's in the middle of its longest stretch, if immersed.

    Where the bed leaves no depth at which the glider is immersed, it is that of the start.
    """
    try:
        usual = trim_depth(design)
    except DesignError:
        return design.mission.initial.position[2]
    start, end = max(hold.spans, key=lambda span: span[1] - span[0])
    if run is None or run.times[-1] < start:
        return usual
    flown = float(np.interp(0.5 * (start + end), run.times, run.values["z"]))
    bed = design.mission.environment.bed_depth or math.inf
    return flown if usual < flown < bed else usual


def reserve_of(design: Design, hold: Hold, depth: float) -> Reserve:
    """Return the net buoyancy of a hold and its bounds, in water of one depth that compresses nothing."""
    environment = design.mission.environment
    density, gravity = density_at(environment.water, depth), gravity_of(environment)
    now = mass_balance(design.vehicle, hold.extensions).net_buoyancy(density, gravity)
    least = most = now
    for _, part in design.vehicle.actuated:
        if isinstance(part, MovableMass | RollingMass):
            continue
        held = volume(part, hold.extensions[part.name])
        ends = [volume(part, stop) for stop in part.stroke]
        least += density * gravity * (min(ends) - held)
        most += density * gravity * (max(ends) - held)
    return Reserve(now, least, most)


def _trim(
    assembly: Assembly, hold: Hold, depth: float, run: Run | None
) -> tuple[Trim | None, tuple[Trim, ...], str | None, RestAttitude | None]:
    try:
        found: TrimSearch = find_trims(assembly, extensions=hold.extensions, depth=depth)
    except DesignError as error:
        return None, (), str(error.problems[0].message), None
    if not found.solutions:
        # in words: what is left of the weight is a rounding error, and the page tells how it hangs
        return None, (), found.searched if found.rest is None else NOTHING_DRIVES, found.rest
    candidates = found.stable or found.solutions
    chosen = candidates[0] if run is None else min(candidates, key=lambda trim: _way_off(trim, hold, run))
    return chosen, tuple(trim for trim in found.solutions if trim is not chosen), None, None


def _way_off(trim: Trim, hold: Hold, run: Run) -> float:
    """Return how far a trim is from the run at the end of a hold: of the vector down, and of the velocity by speed."""
    point = OperatingPoint.from_run(run, min(max(end for _, end in hold.spans), float(run.times[-1])))
    down = down_in_body(trim.roll, trim.pitch) - down_in_body(point.roll, point.pitch)
    velocity = (trim.velocity - np.array(point.velocity)) / max(trim.speed, point.speed, 1e-9)
    return float(np.abs(down).sum() + np.abs(velocity).sum())


def trim_document(trim: Trim) -> dict[str, Any]:
    """Return a trim as the page shows it."""
    ratio, radius = trim.glide_ratio, trim.turn_radius
    return {
        "kind": trim.kind, "stable": trim.stable, "growth": trim.growth, "pitch": trim.pitch, "roll": trim.roll,
        "glide_angle": trim.glide_angle, "speed": trim.speed, "sink_rate": trim.sink_rate,
        "horizontal_speed": trim.horizontal_speed, "glide_ratio": ratio if math.isfinite(ratio) else None,
        "angle_of_attack": trim.angle_of_attack, "sideslip": trim.sideslip, "turn_rate": trim.turn_rate,
        "turn_radius": radius, "depth": trim.depth, "net_buoyancy": trim.net_buoyancy,
    }  # fmt: skip


def glide_document(glide: HeldGlide) -> dict[str, Any]:
    """Return a hold and what it amounts to, as the page shows it."""
    reserve, rest = glide.reserve, glide.rest
    return {
        "spans": glide.hold.spans, "about": glide.hold.about, "reached": glide.hold.reached,
        "extensions": dict(glide.hold.extensions),
        "depth": glide.depth,
        "reserve": {"now": reserve.now, "least": reserve.least, "most": reserve.most, "share": reserve.share},
        "offset": glide.offset.tolist(),
        "trim": None if glide.trim is None else trim_document(glide.trim),
        "others": len(glide.others), "stable_others": sum(trim.stable for trim in glide.others),
        "why": glide.why,
        "rest": None if rest is None else {"pitch": rest.pitch, "roll": rest.roll, "stiffness": rest.stiffness},
    }  # fmt: skip
