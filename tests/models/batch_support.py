"""Owns the designs that the tests of batches fly: presets cut short, one for each ending, and ones in odd waters."""

from __future__ import annotations

from typing import Any

import numpy as np

from models.assemble import Assembly, assemble
from models.design import Design, parse_design
from models.presets import load_preset
from models.run import Status
from tests.models.support import design_of, schedule
from tests.models.test_sources import angle_table
from tests.models.test_spatial_oracle import moving_design


def fixed(design: Design, *, step: float, duration: float | None = None, interval: float | None = None) -> Design:
    """The design flown by RK4."""
    mission = design.mission
    solver: dict[str, Any] = {"method": "rk4", "step": step}
    if interval is not None:
        solver["output_interval"] = interval
    changes: dict[str, Any] = {"solver": mission.solver.model_copy(update=solver)}
    if duration is not None:
        changes["duration"] = min(duration, mission.duration)
    return design.model_copy(update={"mission": mission.model_copy(update=changes)})


def paired(design: Design) -> Design:
    """The design flown by the adaptive pair."""
    solver = design.mission.solver.model_copy(update={"method": "adaptive", "tolerance": 1e-9})
    return design.model_copy(update={"mission": design.mission.model_copy(update={"solver": solver})})


def short(preset_id: str, method: str = "rk4") -> Design:
    """A preset's first part: by the pair less of it, since variants tumble, and what its steps leave open grows."""
    design = load_preset(preset_id)
    planar, pair = design.mission.solver.model == "planar", method == "adaptive"
    design = fixed(design, step=0.01 if planar else 0.05, duration=20.0 if planar else 60.0 if pair else 150.0)
    return paired(design) if pair else design


def variants(design: Design) -> list[Assembly]:
    """The design, and ones with other positions, water, start, step and schedules."""
    made = []
    for k in range(3):
        changed: dict[str, Any] = design.model_dump(mode="json")
        mission = changed["mission"]
        x, y, z = changed["vehicle"]["components"][0]["position"]
        changed["vehicle"]["components"][0]["position"] = [x + 1e-4 * k, y, z + 1e-4 * k]
        mission["initial"]["pitch"] += 0.02 * k
        mission["solver"]["step"] *= 1.0 - 0.1 * k
        for each in mission["control"]["schedules"]:
            for point in each["points"]:
                point["time"] *= 1.0 + 0.03 * k
        made.append(assemble(parse_design(changed)))
    return made


def rk4(step: float = 0.01, **more: Any) -> dict[str, Any]:
    return {"method": "rk4", "step": step, "output_interval": 0.1, **more}


RISING = {"position": [0.0, 0.0, 0.1], "pitch": 0.6, "velocity": [0.8, 0.0, 0.0]}
SPINNING = {"position": [0.0, 0.0, 100.0], "velocity": [0.3, 0.0, 0.05], "angular_velocity": [0.0, 1.0, 0.0]}
ENDINGS: dict[str, tuple[dict[str, Any], Status]] = {
    "completed": ({}, Status.completed),
    "surface": ({"initial": RISING, "duration": 30.0}, Status.surface),
    "bed": ({"environment": {"bed_depth": 5.1}, "duration": 30.0}, Status.bed),
    "stops": ({"control": schedule("Piston", (1.0, 0.01), (2.0, -0.01), (3.5, 0.01, "ramp"))}, Status.completed),
    "diverged": ({"solver": rk4(1.0), "duration": 500.0, "initial": SPINNING}, Status.diverged),
}  # fmt: skip


def ending(name: str) -> Assembly:
    return assemble(design_of(**{"solver": rk4(), **ENDINGS[name][0]}))


TIMED = {
    "kind": "tabulated", "depths": [0.0, 6.0, 40.0], "times": [0.0, 0.8, 2.0],
    "north": [[0.0, 0.1, 0.1], [0.3, 0.2, 0.0], [-0.1, 0.0, 0.1]],
    "east": [[0.1, 0.0, 0.2], [0.2, 0.3, 0.1], [0.0, -0.1, 0.0]],
}  # fmt: skip
WORLDS: dict[str, dict[str, Any]] = {
    "bed to slide on": {"environment": {"bed_depth": 5.1, "bed_contact": "slide"}},
    "surface to float at": {
        "environment": {"surface": "float"}, "initial": {"position": [0.0, 0.0, 0.6]}, "body": {"volume": 2.2e-3},
    },
    "forces over both angles": {
        "hydrodynamics": angle_table(np.linspace(-180.0, 180.0, 25), np.linspace(0.0, 90.0, 7)),
    },
    "current in time": {"environment": {"current": TIMED}},
    "cell that the depth squeezes": {"initial": {"position": [0.0, 0.0, 38.0]}, "cell": {"bulk_modulus": 2e6}},
}  # fmt: skip
"""What else may bear on a glider: changes to one whose hull yields, with parts that move, in a sheared current."""
FULL = "bed to slide on"
"""The world of which `assorted` has more designs than one vector holds."""


def elsewhere(name: str, k: int = 0, method: str = "rk4") -> Assembly:
    """Return the glider in one of the worlds; others of it start a little otherwise."""
    changed: dict[str, Any] = moving_design({}).model_dump(mode="json")
    world, mission, vehicle = WORLDS[name], changed["mission"], changed["vehicle"]
    mission["environment"] |= world.get("environment", {})
    mission["initial"] |= world.get("initial", {})
    mission["initial"]["pitch"] += 0.02 * k
    vehicle["hydrodynamics"] = world.get("hydrodynamics", vehicle["hydrodynamics"])
    for component, part in zip(vehicle["components"], ("body", "cell"), strict=False):
        component |= world.get(part, {})
    design = fixed(parse_design(changed), step=0.01, interval=0.1)
    return assemble(design if method == "rk4" else paired(design))


def assorted() -> list[Assembly]:
    """Designs of different lengths, steps, endings and kinds, more than there are lanes."""
    assemblies = [ending(name) for name in ENDINGS]
    assemblies += [assemble(design_of(solver=rk4(0.01 / (k + 1)), duration=1.0 + 0.7 * k)) for k in range(9)]
    for method in ("rk4", "adaptive"):
        assemblies += variants(short("quad-bellows-spiral", method)) + variants(short("quad-bellows-heading", method))
        assemblies += [elsewhere(name, k, method) for name in WORLDS for k in range(14 if name == FULL else 3)]
    assemblies += [assemble(design_of(duration=1.0 + 0.7 * k)) for k in range(9)]
    return assemblies
