"""Owns the still water in which steady motions are sought: at which depth, and an assembly's constants without current.

A uniform current only carries a motion along, so it is left out. Density, pressure and compression are those of one
depth: where they change with depth, a trim holds where it was found and drifts slowly as the glider sinks or climbs.
"""

from __future__ import annotations

import math

import numpy as np

from models.assemble_spatial import emerging_depth
from models.components import Rigid
from models.design import Design
from models.kernel.params import Params
from models.problems import DesignError, Problem

POINTER = "/options/depth"


def in_still_water(p: Params) -> Params:
    """Return the constants without current; the other records are shared."""
    space = p.space.copy()
    space["levels"] = 1
    return p._replace(space=space, current=np.zeros((1, 9)), current_times=np.zeros(1))


def immersed_depth(design: Design) -> float:
    """Return the depth of the body origin below which every part is immersed at any attitude, m."""
    reach = 0.0
    for component in design.vehicle.components:
        travel = 0.0 if isinstance(component, Rigid) else max(abs(e - component.neutral) for e in component.stroke)
        reach = max(reach, math.hypot(*component.position) + travel)
    return emerging_depth(design) + reach


def trim_depth(design: Design, depth: float | None = None) -> float:
    """Return a depth (m) at which to seek a trim: as given, or the mission's first, made deep enough to be immersed.

    Raises
    ------
    DesignError
        Where a given depth is not below the surface (with all parts immersed, if the glider can float) and above the
        bed, or the bed leaves no such depth.

    """
    environment = design.mission.environment
    immersed = immersed_depth(design)
    bed = math.inf if environment.bed_depth is None else environment.bed_depth
    if depth is None:
        if immersed >= bed:
            message = (
                f"the bed at {bed:g} m leaves no depth at which all parts are immersed: that takes {immersed:.3g} m"
            )
            raise DesignError([Problem(POINTER, message, limit=bed, hint="give a deeper bed")])
        wanted = max(design.mission.initial.position[2], immersed)
        return wanted if wanted < bed else 0.5 * (immersed + bed)
    least = immersed if environment.surface == "float" else 0.0
    if not least <= depth < bed:
        above = f" and {bed:g} m, the bed" if math.isfinite(bed) else ""
        raise DesignError(
            [
                Problem(
                    POINTER, f"depth {depth:g} m is not between {least:.4g} m, where all parts are immersed,{above}"
                    if least else f"depth {depth:g} m is not below the surface{above}",
                    limit=least if not depth >= least else bed, hint="choose a depth in the open water",
                )
            ]
        )  # fmt: skip
    return depth
