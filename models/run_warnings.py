"""Owns what a run gives reason to doubt: data left behind, or a balance of energy that does not close."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from models.problems import Problem
from models.run import Run

POINTER = "/vehicle/hydrodynamics"
LARGEST_RESIDUAL = 1e-3
"""Share of the energy exchanged above which a run is not to be trusted."""


def run_warnings(run: Run) -> Iterator[Problem]:
    """Yield everything about a run that its reader should know, each with the number that shows it."""
    yield from inaccurate(run)
    yield from outside_data(run)


def inaccurate(run: Run) -> Iterator[Problem]:
    """Yield a warning where the balance of energy leaves too much unexplained."""
    residual = run.relative_residual
    if not residual <= LARGEST_RESIDUAL:
        fixed = run.design.mission.solver.method == "rk4"
        yield Problem(
            f"/mission/solver/{'step' if fixed else 'tolerance'}",
            f"the run is not accurate: {100.0 * residual:.2g} % of the energy exchanged is unexplained",
            limit=LARGEST_RESIDUAL,
            hint="use a smaller step, or the adaptive method" if fixed else "use a smaller tolerance",
        )


def outside_data(run: Run) -> Iterator[Problem]:
    """Yield a warning for each way in which samples left the data: angle of attack past 90 deg, speed off the range."""
    table = run.design.vehicle.hydrodynamics
    speed, moving = run.values["speed"], run.values["speed"] > 0.0
    past = np.abs(run.values["alpha"]) > np.pi / 2
    if past.any():
        largest = np.rad2deg(np.abs(run.values["alpha"]).max())
        yield Problem(
            f"{POINTER}/row_alpha_deg",
            f"{_share(past)} of the run is past 90 deg of attack (up to {largest:.0f} deg), where nothing was "
            "measured: the data are reflected",
            limit=90.0,
        )
    low, high = table.speeds[0], table.speeds[-1]
    for off, what, bound in (
        (moving & (speed < low), "slower than", low),
        (speed > high, "faster than", high),
    ):
        if off.any():
            yield Problem(
                f"{POINTER}/row_speed",
                f"{_share(off)} of the run is {what} the data's {bound:g} m/s: coefficients are held there",
                limit=bound,
            )


def _share(flags: NDArray[np.bool_]) -> str:
    return f"{100.0 * float(np.mean(flags)):.0f} %"
