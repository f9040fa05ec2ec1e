"""Many runs at once: each is what it is alone, in every bit whoever flies beside it, and what a single run gives."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from models import batch
from models.assemble import Assembly, assemble
from models.batch import lanes_exist, run_batch
from models.design import Design, parse_design
from models.kernel.lanes import fly_lanes
from models.limits import DEFAULT_LIMITS, Limits
from models.presets import load_preset, preset_ids
from models.run import Run, Status
from models.simulate import Control, run_assembly
from tests.models.batch_support import (
    ENDINGS,
    SPINNING,
    WORLDS,
    assorted,
    elsewhere,
    ending,
    fixed,
    paired,
    rk4,
    short,
    variants,
)
from tests.models.support import PISTON, design_of, document, schedule
from tests.strategies import designs, spatial_designs

STAGES = 6
"""Evaluations that a step of the pair costs."""
MEANINGLESS = 1e-2
"""Rounding that has grown to this share of a value decides where the glider goes: nothing is left to compare."""
AGREEMENT = 1e-9
"""By how much a run in lanes may differ from a single one, as a share of a value's size over the run or of 1: they
round alike but where the compiler fuses a product and a sum in one and not in the other."""


def departures(run: Run, other: Run) -> dict[str, float]:
    """Return by how much each variable of a run departs from another's, as a share of its size over that, or of 1."""
    found = {}
    for kind in ("values", "cell_values"):
        for name, expected in getattr(other, kind).items():
            rows = getattr(run, kind)[name]
            size = np.max(np.abs(expected), initial=1.0, where=np.isfinite(expected))
            unlike = (rows != expected) & ~(np.isnan(rows) & np.isnan(expected))
            apart = np.subtract(rows, expected, out=np.zeros_like(expected), where=unlike)
            found[f"{kind}: {name}"] = float(np.max(np.abs(apart) / size, initial=0.0))
    return found


def magnified_rounding(assembly: Assembly, alone: Run, *, limits: Limits = DEFAULT_LIMITS) -> float:
    """Return what rounding may grow to within a run: infinite where it decides how the run goes.

    A design that tumbles or is stiff magnifies every error. By how much is told by a run whose start is moved by a few
    roundings; since each step rounds anew, and what it rounds is magnified no more than that, they may add up.
    """
    start = assembly.initial_state.copy()
    motion = slice(0, 13 if alone.design.mission.solver.model == "spatial" else 6)  # extensions may be at their stops
    start[motion] *= 1.0 + 1e-15 * np.resize([1.0, -1.0], start[motion].size)  # what is 0 has no rounding
    moved = run_assembly(replace(assembly, initial_state=start), limits=limits)
    if len(moved.times) != len(alone.times) or moved.status != alone.status:
        return math.inf
    return float(alone.statistics["steps"]) * max(departures(moved, alone).values())


def assert_same(run: Run, alone: Run, *, rounding: float = 0.0) -> None:
    """The same to rounding by RK4; by the pair within what its tolerance leaves open, which a tumbling glide magnifies.

    Where an error is 1 to rounding, the pair may take a step in lanes and reject it alone: a few of hundreds differ.
    `rounding` is what it grows to within the run, where that is more.
    """
    solver = alone.design.mission.solver
    agreement = max(rounding, AGREEMENT if solver.method == "rk4" else 1e5 * solver.tolerance)
    assert run.status == alone.status
    assert run.trouble == alone.trouble
    assert [(e.kind, e.cell) for e in run.events] == [(e.kind, e.cell) for e in alone.events]
    np.testing.assert_allclose([e.time for e in run.events], [e.time for e in alone.events], rtol=agreement)
    np.testing.assert_allclose(run.times, alone.times, rtol=agreement)
    counted = [{k: v for k, v in r.statistics.items() if k != "elapsed"} for r in (run, alone)]
    if solver.method == "rk4":
        assert counted[0] == counted[1]
    else:
        for name, count in counted[1].items():
            steps = 30 * (STAGES if name == "evaluations" else 1)
            assert counted[0][name] == pytest.approx(count, rel=0.02, abs=steps), name
    assert (run.values.keys(), run.cell_values.keys()) == (alone.values.keys(), alone.cell_values.keys())
    assert {name: share for name, share in departures(run, alone).items() if not share <= agreement} == {}


def assert_identical(run: Run, other: Run) -> None:
    """The same in every bit."""
    assert (run.status, run.events) == (other.status, other.events)
    np.testing.assert_array_equal(run.times, other.times)
    for kind in ("values", "cell_values"):
        for name, rows in getattr(other, kind).items():
            np.testing.assert_array_equal(getattr(run, kind)[name], rows, err_msg=name)


@pytest.mark.parametrize("method", ["rk4", "adaptive"])
@pytest.mark.parametrize("preset_id", preset_ids())
def test_every_preset_flies_in_lanes_as_alone(preset_id, method):
    assemblies = variants(short(preset_id, method))
    assert lanes_exist()
    for run, assembly in zip(run_batch(assemblies), assemblies, strict=True):
        assert_same(run, run_assembly(assembly))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "adaptive"])
@settings(max_examples=30)
@given(designs(neutral=False))
def test_random_planar_designs_fly_in_company_as_alone(method, design):
    assert_fly_as_alone(fixed(design, step=0.01, duration=1.0, interval=0.1), method)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "adaptive"])
@settings(max_examples=30)
@given(spatial_designs())
def test_random_spatial_designs_fly_in_company_as_alone(method, design):
    """For a moment: made-up coefficients may feed a motion, which then grows beyond any measure."""
    assert_fly_as_alone(fixed(design, step=0.002, duration=0.2, interval=0.02), method)


def assert_fly_as_alone(design: Design, method: str) -> None:
    """Variants of a design fly together as each does alone, but for ones whose course rounding decides."""
    assemblies, limits = variants(design if method == "rk4" else paired(design)), Limits(steps=5000)
    for run, assembly in zip(run_batch(assemblies, limits=limits), assemblies, strict=True):
        alone = run_assembly(assembly, limits=limits)
        rounding = magnified_rounding(assembly, alone, limits=limits)
        if rounding < MEANINGLESS:
            assert_same(run, alone, rounding=rounding)


@pytest.mark.parametrize("method", ["rk4", "adaptive"])
@pytest.mark.parametrize("name", WORLDS)
def test_whatever_bears_on_a_glider_does_in_lanes_too(name, method):
    assemblies = [elsewhere(name, k, method) for k in range(3)]
    for run, assembly in zip(run_batch(assemblies), assemblies, strict=True):
        alone = run_assembly(assembly)
        assert alone.status == Status.completed
        assert_same(run, alone, rounding=magnified_rounding(assembly, alone))


def test_the_worlds_bear_on_the_glider():
    """It meets the bed and the surface and stays there; without what else a world holds it would be elsewhere."""
    slides, floats = (run_assembly(elsewhere(name)) for name in ("bed to slide on", "surface to float at"))
    assert slides.values["z"][-10:] == pytest.approx(5.1, abs=0.05)
    assert abs(floats.final["z"]) < 0.2
    ends = [run_assembly(elsewhere(name)).final["x"] for name in WORLDS]
    assert len({round(end, 6) for end in ends}) == len(ends)


@pytest.mark.parametrize("name", ENDINGS)
def test_runs_end_as_they_do_alone(name):
    assembly = ending(name)
    run, beside = run_batch([assembly, ending("completed")])
    assert run.status == ENDINGS[name][1]
    assert beside.status == Status.completed
    assert_same(run, run_assembly(assembly))


def test_stops_are_events_in_lanes_too():
    (run,) = run_batch([ending("stops")])
    assert [e.kind for e in run.events] == ["end_of_stroke"] * 3


def test_a_lane_ends_at_the_limit_of_steps():
    assembly, limits = ending("completed"), Limits(steps=123)
    (run,) = run_batch([assembly], limits=limits)
    assert run.status == Status.too_many_steps
    assert run.statistics["steps"] == 123
    assert_same(run, run_assembly(assembly, limits=limits))


def test_the_pair_ends_at_the_limit_of_steps_rejected_ones_included():
    limits = Limits(steps=40)
    assemblies = [assemble(design_of(duration=500.0, initial={**SPINNING, "pitch": 0.1 * k})) for k in range(5)]
    for run, assembly in zip(run_batch(assemblies, limits=limits), assemblies, strict=True):
        assert run.status == Status.too_many_steps
        assert run.statistics["steps"] + run.statistics["rejected_steps"] == limits.steps
        assert_same(run, run_assembly(assembly, limits=limits))


def slow_piston(rate: float, lag: float) -> dict[str, Any]:
    return {**PISTON, "rate_limit": rate, "lag": lag}


def test_rate_limits_and_lags_are_each_lanes_own():
    parts = [slow_piston(0.001 * (k + 1), 0.2 * (k % 3)) for k in range(11)]
    moves = schedule("Piston", (0.5, 0.008), (2.2, -0.006, "ramp"), (3.1, 0.0))
    assemblies = [assemble(design_of(part, control=moves, solver=rk4(), duration=6.0)) for part in parts]
    for run, assembly in zip(run_batch(assemblies), assemblies, strict=True):
        assert_same(run, run_assembly(assembly))


def test_no_bit_depends_on_company_or_place():
    assemblies = assorted()
    together = list(run_batch(assemblies))
    order = np.random.default_rng(1).permutation(len(assemblies))
    shuffled = dict(zip(order, run_batch([assemblies[k] for k in order]), strict=True))
    for k, (run, assembly) in enumerate(zip(together, assemblies, strict=True)):
        (alone,) = run_batch([assembly])
        assert_identical(run, alone)
        assert_identical(run, shuffled[k])


def test_no_bit_depends_on_the_windows(monkeypatch):
    assemblies = assorted()
    together = list(run_batch(assemblies))
    monkeypatch.setattr(batch, "TOGETHER", 4)
    for run, other in zip(run_batch(assemblies), together, strict=True):
        assert_identical(run, other)
    monkeypatch.setattr(batch, "NUMBERS_TOGETHER", 1)
    for run, other in zip(run_batch(assemblies), together, strict=True):
        assert_identical(run, other)


def feedback_of(*states: str) -> Assembly:
    """Return the glider with four cells under state feedback of these states."""
    changed: dict[str, Any] = load_preset("quad-bellows-heading").model_dump(mode="json")
    parts = [part for _, part in load_preset("quad-bellows-heading").vehicle.actuated]
    point = {
        "value": 0.0, "extensions": [part.neutral for part in parts], "state": [0.0] * len(states),
        "gains": [[0.001] * len(states)] * len(parts),
    }  # fmt: skip
    changed["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "sample_time": 2.0, "cells": [part.name for part in parts], "states": list(states),
        "points": [point],
    }  # fmt: skip
    changed["mission"] |= {"duration": 8.0}
    return assemble(fixed(parse_design(changed), step=0.02))


def test_controllers_of_all_kinds_fly_in_one_batch():
    """What they need of the kernel differs in size, so they share no lanes, but a batch all the same."""
    cascade = assemble(fixed(load_preset("quad-bellows-heading"), step=0.02, duration=8.0))
    assemblies = [cascade, feedback_of("theta"), feedback_of("theta", "q"), cascade, feedback_of("theta")]
    for run, assembly in zip(run_batch(assemblies), assemblies, strict=True):
        assert_same(run, run_assembly(assembly))


SCRIPT = """
from models.assemble import assemble
from models.batch import lanes_exist, run_batch
from tests.models.support import design_of
assembly = assemble(design_of(duration=0.2))
(run,) = run_batch([assembly])
print(lanes_exist(), run.status.name)
"""


def test_without_compilation_a_batch_flies_one_by_one():
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    assert done.stdout.split() == ["False", "completed"]


def test_an_empty_batch_has_no_runs():
    assert list(run_batch([])) == []


def test_a_design_without_parts_that_move_flies_in_lanes():
    changed = document(solver=rk4())
    changed["vehicle"]["components"] = changed["vehicle"]["components"][:1]
    assembly = assemble(parse_design(changed))
    (run,) = run_batch([assembly])
    assert_same(run, run_assembly(assembly))


def test_a_batch_that_is_cancelled_before_it_begins_takes_a_step_each():
    control = Control()
    control.cancel()
    assemblies = assorted()
    for run, assembly in zip(run_batch(assemblies, control=control), assemblies, strict=True):
        assert run.status == Status.cancelled and run.statistics["steps"] <= 1
        assert_same(run, run_assembly(assembly, control=control))


def test_a_batch_stops_within_its_lanes_when_it_is_cancelled():
    control = Control()
    long = [assemble(fixed(load_preset("slocum-glide"), step=2e-4, interval=100.0)) for _ in range(40)]
    threading.Timer(0.3, control.cancel).start()
    began = time.perf_counter()
    runs = list(run_batch(long, limits=Limits(steps=10**9), control=control))
    assert [run.status for run in runs] == [Status.cancelled] * len(runs)
    assert runs[0].statistics["steps"] > 1
    assert time.perf_counter() - began < 10.0


def test_the_time_flown_is_told():
    control = Control()
    runs = list(run_batch([ending("completed"), ending("stops")], control=control))
    assert control.time_reached == pytest.approx(sum(run.times[-1] for run in runs))


def test_one_signature_is_compiled_of_the_lanes():
    list(run_batch(assorted()))
    for preset_id in preset_ids():
        list(run_batch([assemble(fixed(load_preset(preset_id), step=0.05, duration=1.0))]))
    assert len(fly_lanes.signatures) == 1
