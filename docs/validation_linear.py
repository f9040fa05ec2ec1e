"""Owns check 11 of docs/validation.md: step responses of linear models against those of the full equations.

From a trim one cell's command steps by a size that halves twice. The linear response is exact (matrix exponential), so
what is left is of second order in the step.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.design import Design, parse_design
from models.linear_model import LinearModel
from models.linearize import linearize
from models.operating_point import point_of
from models.presets import load_preset
from models.run import Run
from models.simulate import simulate
from models.trim import Trim, design_from, find_trims
from models.water import density_at

Array = NDArray[np.float64]
CASES: tuple[tuple[str, str, dict[str, float]], ...] = (
    ("three-cell-glider", "Front bellows", {}),
    ("quad-bellows-spiral", "Front port cell", {}),
    ("slocum-glide", "Movable mass", {}),
    ("seawing-spiral", "Battery", {"Battery": 0.4}),
)
"""Presets, the part that steps, and extensions of the trim where they are not those that the schedules end with."""
STEPS = (4e-4, 2e-4, 1e-4)
"""Steps of the command, m or rad: so small that no rate limit is met."""
DURATION = 12.0
ALLOWED = 0.1
"""How far the order may be from 2."""
DEMANDED = 5e-3
"""Largest difference at the smallest step, as a share of the largest response."""


class StepResponse(NamedTuple):
    """One preset: the part that steps, largest differences by step (rad, m/s, rad/s, m), and as a share at the last."""

    preset_id: str
    model: str
    part: str
    differences: tuple[float, ...]
    share: float

    @property
    def orders(self) -> Array:
        """Observed orders between steps that halve."""
        found = np.array(self.differences)
        return np.log2(found[:-1] / found[1:])


def in_one_density(preset_id: str) -> Design:
    """Return a preset in water of one density, that at its start, with parts that keep their volume; to rounding.

    There a trim is one at every depth. Else a glider that sinks by a metre meanwhile would answer a little differently.
    """
    design = load_preset(preset_id)
    document = design.model_dump(mode="json")
    mission = document["mission"]
    depth = mission["initial"]["position"][2]
    density = float(np.asarray(density_at(design.mission.environment.water, np.array([depth])))[0])
    mission["environment"] |= {"water": {"kind": "uniform", "density": density}, "surface": "end", "bed_depth": None}
    for part in document["vehicle"]["components"]:
        if "bulk_modulus" in part:
            part["bulk_modulus"] = None
    mission["initial"]["position"][2] = 50.0
    mission["solver"] |= {"tolerance": 1e-12, "output_interval": 0.25}
    mission["duration"] = DURATION
    return parse_design(document)


def settled_extensions(design: Design) -> dict[str, float]:
    """Return the extensions that the schedules end with."""
    return {s.cell: s.points[-1].extension for s in design.mission.control.schedules}


def stepped(trim: Trim, design: Design, part: str, step: float) -> Design:
    """Return the design started in the trim, the command of one part raised by a step at time zero."""
    document = design_from(trim, design).model_dump(mode="json")
    point = {"time": 0.0, "extension": trim.extensions[part] + step, "shape": "step"}
    document["mission"]["control"] = {"schedules": [{"cell": part, "points": [point]}]}
    return parse_design(document)


def largest_difference(model: LinearModel, run: Run, linear: Array) -> float:
    """Return the largest difference of a run from the linear departures (times, states), in rad, m, m/s, rad/s."""
    apart = [0.0]
    for k, signal in enumerate(model.states):
        if signal.name in run.values:
            values = run.values[signal.name]
            whole = np.unwrap(values) if signal.unit == "rad" else values
            apart.append(float(np.abs(whole - signal.value - linear[:, k]).max()))
    return max(apart)


def step_response(preset_id: str, part: str, extensions: dict[str, float]) -> StepResponse:
    """Step one part of a preset from its first stable trim, by every size, and compare."""
    design = in_one_density(preset_id)
    trim = find_trims(design, extensions=settled_extensions(design) | extensions).stable[0]
    model = linearize(design, point_of(trim))
    command = np.array([float(name == f"command of {part}") for name in model.input_names])
    differences = []
    for step in STEPS:
        run = simulate(stepped(trim, design, part, step))
        linear = model.step_response(step * command, run.times)
        differences.append(largest_difference(model, run, linear))
    share = differences[-1] / float(np.abs(linear - model.step_response(0.0 * command, run.times)).max())
    return StepResponse(preset_id, model.model, part, tuple(differences), share)


@cache
def step_responses() -> tuple[StepResponse, ...]:
    """Step every case."""
    return tuple(step_response(*case) for case in CASES)
