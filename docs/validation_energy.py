"""Owns checks 6 and 10 of docs/validation.md: the work-energy balance of every preset, and the bill of a piston."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.design import Design, parse_design
from models.presets import load_preset, preset_ids
from models.run import Run
from models.simulate import simulate
from tests.models.support import document

Array = NDArray[np.float64]
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
DEFAULT_TOLERANCE = 1e-8
DEMANDED = {"balance": 1e-6, "bill": 1e-9}
"""Of the energy exchanged at the default tolerance; of the energy taken, relative."""
MOST_STEPS = 1_000_000
"""A preset that takes more steps (some 10 s of computing) at the default tolerance is left out of the others."""
GRAVITY, DENSITY, AREA, STROKE, HOTEL = 9.81, 1025.0, 2e-3, 0.05, 0.5
DEPTHS = (5.0, 20.0, 50.0, 100.0, 200.0)


class Balance(NamedTuple):
    """The residual of one preset: its run at the default tolerance, and the relative residual at each that was run."""

    preset_id: str
    run: Run
    relative: dict[float, float]

    @property
    def whole(self) -> bool:
        """Whether every tolerance was run."""
        return len(self.relative) == len(TOLERANCES)


class Bill(NamedTuple):
    """What one piston's expansion took from the battery, J, beside p dV / efficiency, and what it gave back."""

    depth: float
    efficiency: float
    recovery: float
    expected: float
    taken: float

    @property
    def difference(self) -> float:
        """Relative difference."""
        return abs(self.taken / self.expected - 1.0)


def _at(design: Design, tolerance: float) -> Design:
    solver = design.mission.solver.model_copy(update={"tolerance": tolerance})
    return design.model_copy(update={"mission": design.mission.model_copy(update={"solver": solver})})


@cache
def balances() -> tuple[Balance, ...]:
    """Fly every preset at every tolerance."""
    results = []
    for preset_id in preset_ids():
        design = load_preset(preset_id)
        run = simulate(_at(design, DEFAULT_TOLERANCE))
        relative = {DEFAULT_TOLERANCE: run.relative_residual}
        if run.statistics["steps"] <= MOST_STEPS:
            relative |= {tol: simulate(_at(design, tol)).relative_residual for tol in TOLERANCES if tol not in relative}
        results.append(Balance(preset_id, run, dict(sorted(relative.items(), reverse=True))))
    return tuple(results)


def largest_over_time(run: Run, windows: int = 120) -> tuple[Array, Array]:
    """Return time (s) and the largest residual of each window, share of the energy exchanged; zeros are left out."""
    shares = np.abs(run.values["energy_residual"]) / run.energy_exchanged
    groups = np.array_split(np.arange(1, len(shares)), min(windows, len(shares) - 1))
    times = np.array([run.times[group[-1]] for group in groups])
    largest = np.array([shares[group].max() for group in groups])
    return times[largest > 0.0], largest[largest > 0.0]


def piston_design(depth: float, efficiency: float, recovery: float) -> Design:
    """Return a neutral level body with two pistons, to starboard and to port, of which one fills as the other empties.

    Their volumes and first moments always add up to the same, so the glider stays at its depth and level.
    """
    cells: list[dict[str, Any]] = [
        {
            "kind": "piston", "name": name, "mass": 0.0, "position": [0.0, 0.0, 0.0], "axis": [0.0, side, 0.0],
            "volume": 2e-4, "volume_range": [0.0, 4e-4], "area": AREA, "efficiency": efficiency,
            "recovery": recovery if name == "Emptying" else 0.0,
        }
        for name, side in (("Filling", 1.0), ("Emptying", -1.0))
    ]  # fmt: skip
    body = {
        "kind": "rigid", "name": "Body", "mass": DENSITY * 2e-3, "volume": 2e-3 - 4e-4, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [0.0, 0.0, 0.02], "inertia": {"xx": 0.02, "yy": 0.02, "zz": 0.02},
    }  # fmt: skip
    changed: dict[str, Any] = document(initial={"position": [0.0, 0.0, depth]})
    changed["vehicle"] |= {"components": [body, *cells], "hotel_power": HOTEL}
    changed["mission"] |= {
        "environment": {"water": {"density": DENSITY}, "gravity": GRAVITY}, "duration": 20.0,
        "solver": {"model": "spatial", "tolerance": 1e-12},
        "control": {"schedules": [
            {"cell": name, "points": [
                {"time": 2.0, "extension": 0.0, "shape": "step"}, {"time": 12.0, "extension": end, "shape": "ramp"},
            ]}
            for name, end in (("Filling", STROKE), ("Emptying", -STROKE))
        ]},
    }  # fmt: skip
    return parse_design(changed)


def closed_bill(depth: float, efficiency: float, recovery: float) -> float:
    """Return p dV / efficiency with p = rho g z, less what comes back, J."""
    work = DENSITY * GRAVITY * depth * AREA * STROKE
    return work / efficiency - recovery * work


@cache
def bills() -> tuple[Bill, ...]:
    """Simulate the expansion at every depth with three pumps, and with one that gets energy back."""
    results = []
    for efficiency, recovery in ((1.0, 0.0), (0.5, 0.0), (0.25, 0.0), (0.5, 0.4)):
        for depth in DEPTHS:
            run = simulate(piston_design(depth, efficiency, recovery))
            taken = float(run.cell_values["energy"][-1].sum())
            results.append(Bill(depth, efficiency, recovery, closed_bill(depth, efficiency, recovery), taken))
    return tuple(results)


@cache
def hotel_bill() -> tuple[float, float, float]:
    """Return the hotel load's energy as kept and by power times time (J), and how far the depth moved meanwhile (m)."""
    run = simulate(piston_design(DEPTHS[0], 1.0, 0.0))
    load = float(run.values["battery_energy"][-1] - run.cell_values["energy"][-1].sum())
    return load, HOTEL * float(run.times[-1]), float(np.ptp(run.values["z"]))
