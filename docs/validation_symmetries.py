"""Owns check 3 of docs/validation.md: the plane in space, the mirror, the turned start, the current that carries."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models.design import Design, parse_design
from models.presets import load_preset, preset_ids
from models.run import Run
from models.simulate import simulate
from tests.models.test_spatial_oracle import moving_design
from tests.models.test_spatial_truths import mirrored

Array = NDArray[np.float64]
YAW = math.radians(40.0)
CURRENT = (0.08, -0.05)
"""The constant current, m/s north and east."""
TEST_GLIDER = "test glider"
DRAWN = "seawing-spiral"
DEMANDED = {"plane": 2e-7, "off plane": 0.0, "mirror": 1e-9, "yaw": 2e-6, "current": 2e-6}
"""Largest differences, m and rad: of the plane at tolerance 1e-12, relative to 1 plus the largest value.

Turned and carried, the steps of the integrator differ, so truncation does: over hours and kilometres about 1e-7.
"""
PLANE_NAMES = ("x", "z", "theta", "u", "w", "q", "alpha")


class PlaneCase(NamedTuple):
    """A preset flown by both models: runs, the largest difference of its states, and of what must stay zero."""

    preset_id: str
    planar: Run
    spatial: Run
    difference: float
    off_plane: float


class MovedCase(NamedTuple):
    """A spatial design, and its mirrored, turned and carried runs with their largest differences from the original.

    `places` are m, `angles` rad: of the path once it is mapped back, and of roll, pitch and heading.
    """

    name: str
    original: Run
    runs: dict[str, Run]
    places: dict[str, float]
    angles: dict[str, float]


def changed(design: Design, *, solver: dict[str, Any], environment: dict[str, Any] | None = None,
            initial: dict[str, Any] | None = None) -> Design:  # fmt: skip
    """Return the design with its mission changed."""
    document = design.model_dump(mode="json")
    mission = document["mission"]
    mission["solver"] |= solver
    mission["environment"] |= environment or {}
    mission["initial"] |= initial or {}
    return parse_design(document)


@cache
def plane_cases() -> tuple[PlaneCase, ...]:
    """Fly every planar preset by both models."""
    cases = []
    for preset_id in preset_ids():
        design = load_preset(preset_id)
        if design.mission.solver.model != "planar":
            continue
        planar, spatial = (
            simulate(changed(design, solver={"model": model, "tolerance": 1e-12})) for model in ("planar", "spatial")
        )
        difference = max(
            float(np.abs(spatial.values[n] - planar.values[n]).max() / (1.0 + np.abs(planar.values[n]).max()))
            for n in PLANE_NAMES
        )
        off_plane = max(float(np.abs(spatial.values[n]).max()) for n in ("y", "phi", "psi", "v", "p", "r", "beta"))
        cases.append(PlaneCase(preset_id, planar, spatial, difference, off_plane))
    return tuple(cases)


def path(run: Run) -> Array:
    """Return the path, (samples, 3) m."""
    return np.column_stack([run.values[name] for name in "xyz"])


def mapped_back(kind: str, run: Run) -> Array:
    """Return the path of a mirrored, turned or carried run where it lies on that of the original, (samples, 3) m."""
    if kind == "mirror":
        return path(run) * [1.0, -1.0, 1.0]
    if kind == "yaw":
        return np.asarray(Rotation.from_euler("z", -YAW).apply(path(run)))
    return path(run) - np.outer(run.times, [*CURRENT, 0.0])


def attitude(kind: str, run: Run) -> Array:
    """Return roll, pitch and heading as the original should have them, (samples, 3) rad."""
    phi, theta, psi = (run.values[name] for name in ("phi", "theta", "psi"))
    if kind == "mirror":
        return np.column_stack([-phi, theta, -psi])
    return np.column_stack([phi, theta, psi - (YAW if kind == "yaw" else 0.0)])


def moved_case(name: str, design: Design) -> MovedCase:
    """Fly a design in still water, mirrored, with its start turned, and carried by a current."""
    exact = {"tolerance": 1e-11}
    still = changed(design, solver=exact, environment={"current": None})
    turned = still.mission.initial.yaw + YAW
    designs = {
        "mirror": mirrored(still),
        "yaw": changed(still, solver={}, initial={"yaw": math.remainder(turned, 2.0 * math.pi)}),
        "current": changed(still, solver={}, environment={"current": {"kind": "uniform", "velocity": CURRENT}}),
    }
    original = simulate(still)
    runs = {kind: simulate(other) for kind, other in designs.items()}
    places, angles = {}, {}
    for kind, run in runs.items():
        places[kind] = float(np.abs(mapped_back(kind, run) - path(original)).max())
        apart = attitude(kind, run) - attitude("original", original)
        angles[kind] = float(np.abs((apart + math.pi) % (2.0 * math.pi) - math.pi).max())
    return MovedCase(name, original, runs, places, angles)


@cache
def moved_cases() -> tuple[MovedCase, ...]:
    """Fly the test glider and every spatial preset that goes by the clock.

    What is wanted under control is a heading or a place in the world; `tests/models/test_guidance.py` mirrors those.
    """
    cases = [moved_case(TEST_GLIDER, moving_design({}))]
    for preset_id in preset_ids():
        design = load_preset(preset_id)
        if design.mission.solver.model == "spatial" and design.mission.control.controller is None:
            cases.append(moved_case(preset_id, design))
    return tuple(cases)
