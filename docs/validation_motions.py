"""Owns check 4 of docs/validation.md: terminal speed by the balance of weight and drag, and rest that stays rest."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.design import Design, parse_design
from models.hydrodynamic_law import build_law
from models.presets import load_preset
from models.run import Run
from models.simulate import simulate
from tests.models.support import document, polar

Array = NDArray[np.float64]
GRAVITY, MASS, DENSITY = 9.8, 1.0, 1000.0
NET_WEIGHTS = tuple(float(sign * W) for sign in (1, -1) for W in np.logspace(-3, 0, 7))
"""Weight less buoyancy, N; negative rises."""
LENGTHS = 50.0
"""Length of a run in units of m / sqrt(W P_D), in which the speed comes as tanh: the rest is e^-100."""
DEMANDED = {"terminal": 1e-9, "approach": 1e-8, "rest": 1e-12}
"""Relative difference of speed; the approach as a share of the terminal speed; speeds left at rest, m/s."""


class Fall(NamedTuple):
    """One fall: net weight (N), V = sqrt(|W| / P_D) with its sign (m/s), and the run."""

    net_weight: float
    expected: float
    run: Run

    @property
    def speed(self) -> float:
        """The simulated terminal speed, down, m/s."""
        return float(self.run.values["z_dot"][-1])

    @property
    def time_unit(self) -> float:
        """The unit of time m / sqrt(W P_D), s."""
        return MASS / (abs(self.net_weight) / abs(self.expected))

    @property
    def approach(self) -> tuple[Array, Array]:
        """Time in its unit, and speed as a share of the terminal one."""
        return self.run.times / self.time_unit, self.run.values["z_dot"] / self.expected


def falling(net_weight: float) -> tuple[Design, float]:
    """Return a level body without lift or moment that falls broadside from rest, and its terminal speed."""
    body = {
        "kind": "rigid", "name": "Body", "mass": MASS, "volume": (MASS - net_weight / GRAVITY) / DENSITY,
        "position": [0.0, 0.0, 0.0], "center_of_mass": [0.0, 0.0, 0.1], "inertia": {"xx": 0.01, "yy": 0.02, "zz": 0.02},
    }  # fmt: skip
    changed: dict[str, Any] = document(initial={"position": [0.0, 0.0, 100.0]})
    changed["vehicle"] |= {"components": [body]}
    changed["vehicle"]["hydrodynamics"] = polar(row_lift=[0.0] * 10, row_moment=[0.0] * 10)
    drag = float(build_law(parse_design(changed).vehicle.hydrodynamics)(math.pi / 2)[1])
    length = LENGTHS * MASS / math.sqrt(abs(net_weight) * drag)
    changed["mission"] |= {
        "environment": {"water": {"density": DENSITY}, "gravity": GRAVITY}, "duration": length,
        "solver": {"model": "spatial", "tolerance": 1e-12, "output_interval": length / 1000.0},
    }  # fmt: skip
    return parse_design(changed), math.copysign(math.sqrt(abs(net_weight) / drag), net_weight)


@cache
def falls() -> tuple[Fall, ...]:
    """Let the body fall or rise with every net weight."""
    results = []
    for net_weight in NET_WEIGHTS:
        design, expected = falling(net_weight)
        results.append(Fall(net_weight, expected, simulate(design)))
    return tuple(results)


@cache
def resting_speeds() -> dict[str, float]:
    """Return the largest velocity (m/s or rad/s) that neutral gliders pick up from rest, by model and glider.

    A body of binary-exact numbers for 1000 s; the paper's glider, trimmed to rounding, without commands.
    """
    exact = {"kind": "rigid", "name": "Body", "mass": 1.0, "volume": 0.125, "position": [0.0, 0.0, 0.0],
             "center_of_mass": [0.0, 0.0, 0.5], "inertia": {"xx": 0.02, "yy": 0.02, "zz": 0.02}}  # fmt: skip
    speeds = {}
    for model in ("planar", "spatial"):
        changed = document(
            initial={"position": [0.0, 0.0, 5.0]}, environment={"water": {"density": 8.0}}, duration=1000.0,
            solver={"model": model},
        )  # fmt: skip
        changed["vehicle"]["components"] = [exact]
        paper = load_preset("canete-dual-bellows").model_dump(mode="json")
        paper["mission"]["control"] = {"schedules": []}
        paper["mission"]["solver"]["model"] = model
        for name, made in (("exact", changed), ("paper", paper)):
            run = simulate(parse_design(made))
            names = [n for n in "uvwpqr" if n in run.values]
            speeds[f"{model} {name}"] = max(float(np.abs(run.values[n]).max()) for n in names)
    return speeds
