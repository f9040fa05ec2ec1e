"""Owns the estimate of a run's integration error: its mission flown again with a tighter tolerance or half the step.

The difference between the two is about the error of the coarser one, since that of the tighter is much smaller.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from models.assemble import assemble
from models.design import Design, parse_design
from models.limits import Limits
from models.problems import DesignError, Problem
from models.run import Run, Status
from models.simulate import Control, run_assembly

TIGHTER = 0.01
"""What a tolerance is multiplied by."""
SMALLEST_TOLERANCE = 1e-13
QUANTITIES = ("x", "y", "z", "theta", "phi", "speed")
UNITS = {"x": "m", "y": "m", "z": "m", "theta": "rad", "phi": "rad", "speed": "m/s"}


@dataclass(frozen=True)
class Difference:
    """How far two runs are apart in one quantity: at the end, and at most, at `time` (s)."""

    name: str
    unit: str
    end: float
    largest: float
    time: float


def tightened(design: Design) -> tuple[Design, str]:
    """Return the design with a more careful integration, and in words what is more careful.

    Raises
    ------
    DesignError
        Where the solver is as careful as it can be.

    """
    solver = design.mission.solver
    if solver.method == "adaptive":
        tolerance = max(TIGHTER * solver.tolerance, SMALLEST_TOLERANCE)
        changed, words, same = {"tolerance": tolerance}, f"tolerance {tolerance:.0e}", tolerance >= solver.tolerance
    else:
        changed, words, same = {"step": 0.5 * solver.step}, f"step {500.0 * solver.step:g} ms", False
    if same:
        message = f"the tolerance {solver.tolerance:.0e} leaves nothing tighter to compare with"
        hint = f"compare at a tolerance above {SMALLEST_TOLERANCE:.0e}"
        raise DesignError([Problem("/mission/solver/tolerance", message, SMALLEST_TOLERANCE, hint)])
    mission = design.mission.model_copy(update={"solver": solver.model_copy(update=changed)})
    return parse_design(design.model_copy(update={"mission": mission}).model_dump(mode="json")), words


def error_estimate(run: Run, limits: Limits, control: Control) -> dict[str, Any]:
    """Return how far a run is from the same mission flown more carefully, a call that `control` can stop.

    Raises
    ------
    DesignError
        Where there is nothing more careful, or it does not come to an end in time.

    """
    design, words = tightened(run.design)
    finer = run_assembly(assemble(design, limits), limits=limits, control=control)
    if finer.status is Status.cancelled:
        message = f"the run with {words} was stopped at {finer.times[-1]:.4g} s, as it takes too long"
        hint = "shorten the mission to estimate its error"
        raise DesignError([Problem("/mission/duration", message, float(finer.times[-1]), hint)])
    return {
        "with": words,
        "differences": [asdict(one) for one in differences(run, finer)],
        "residual": run.relative_residual, "finer_residual": finer.relative_residual,
        "end": float(run.times[-1]), "finer_end": float(finer.times[-1]),
        "elapsed_ms": 1e3 * finer.statistics["elapsed"],
    }  # fmt: skip


def differences(run: Run, other: Run) -> list[Difference]:
    """Return how far two runs are apart at the times that both have: those of the output interval, to a nanosecond."""
    shared, mine, its = np.intersect1d(np.round(run.times, 9), np.round(other.times, 9), return_indices=True)
    told = []
    for name in QUANTITIES:
        if name not in run.values:
            continue
        apart = other.values[name][its] - run.values[name][mine]
        if UNITS[name] == "rad":
            apart = (apart + math.pi) % (2.0 * math.pi) - math.pi
        worst = int(np.abs(apart).argmax())
        told.append(Difference(name, UNITS[name], float(apart[-1]), float(apart[worst]), float(shared[worst])))
    return told
