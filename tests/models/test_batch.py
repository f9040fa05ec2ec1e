"""Many runs at once: each is what it is alone, in every bit whoever flies beside it, and what a single run gives."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from models import batch
from models.assemble import Assembly, assemble
from models.batch import can_share_lanes, run_batch
from models.design import Design, parse_design
from models.kernel.lanes import fly_lanes
from models.limits import Limits
from models.presets import load_preset, preset_ids
from models.run import Run, Status
from models.simulate import Control, run_assembly
from tests.models.support import PISTON, design_of, document, schedule
from tests.strategies import designs, spatial_designs

AGREEMENT = 1e-9
"""By how much a run in lanes may differ from a single one, as a share of a value's size over the run or of 1: they
round alike but where the compiler fuses a product and a sum in one and not in the other."""


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


def short(preset_id: str, method: str = "rk4") -> Design:
    """A preset's first part: by the pair less of it, since variants tumble, and what its steps leave open grows."""
    design = load_preset(preset_id)
    planar, pair = design.mission.solver.model == "planar", method == "adaptive"
    design = fixed(design, step=0.01 if planar else 0.05, duration=20.0 if planar else 60.0 if pair else 150.0)
    if not pair:
        return design
    solver = design.mission.solver.model_copy(update={"method": method, "tolerance": 1e-9})
    return design.model_copy(update={"mission": design.mission.model_copy(update={"solver": solver})})


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


def assert_same(run: Run, alone: Run) -> None:
    """The same to rounding by RK4; by the pair within what its tolerance leaves open, which a tumbling glide magnifies.

    Where an error is 1 to rounding, the pair may take a step in lanes and reject it alone: a few of hundreds differ.
    """
    solver = alone.design.mission.solver
    agreement = AGREEMENT if solver.method == "rk4" else 1e5 * solver.tolerance
    assert run.status == alone.status
    assert run.trouble == alone.trouble
    assert [(e.kind, e.cell) for e in run.events] == [(e.kind, e.cell) for e in alone.events]
    np.testing.assert_allclose([e.time for e in run.events], [e.time for e in alone.events], rtol=agreement)
    np.testing.assert_allclose(run.times, alone.times, rtol=agreement)
    counted = [{k: v for k, v in r.statistics.items() if k != "elapsed"} for r in (run, alone)]
    if solver.method == "rk4":
        assert counted[0] == counted[1]
    else:
        assert counted[0] == pytest.approx(counted[1], rel=0.02, abs=30)
    for kind in ("values", "cell_values"):
        assert getattr(run, kind).keys() == getattr(alone, kind).keys()
        for name, expected in getattr(alone, kind).items():
            size = np.max(np.abs(expected), initial=1.0, where=np.isfinite(expected))
            np.testing.assert_allclose(
                getattr(run, kind)[name] / size, expected / size, rtol=0.0, atol=agreement, err_msg=name
            )


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
    assert all(can_share_lanes(assembly) for assembly in assemblies)
    for run, assembly in zip(run_batch(assemblies), assemblies, strict=True):
        assert_same(run, run_assembly(assembly))


@pytest.mark.slow
@settings(max_examples=40)
@given(designs(neutral=False))
def test_random_planar_designs_fly_in_lanes_as_alone(design):
    assert_flies_as_alone(fixed(design, step=0.01, duration=1.0, interval=0.1))


@pytest.mark.slow
@settings(max_examples=40)
@given(spatial_designs())
def test_random_spatial_designs_fly_in_lanes_as_alone(design):
    assert_flies_as_alone(fixed(design, step=0.01, duration=1.0, interval=0.1))


def assert_flies_as_alone(design: Design) -> None:
    assembly = assemble(design)
    (run,) = run_batch([assembly])
    assert_same(run, run_assembly(assembly))


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


def assorted() -> list[Assembly]:
    """Designs of different lengths, steps, endings and kinds, more than there are lanes."""
    assemblies = [ending(name) for name in ENDINGS]
    assemblies += [assemble(design_of(solver=rk4(0.01 / (k + 1)), duration=1.0 + 0.7 * k)) for k in range(9)]
    for method in ("rk4", "adaptive"):
        assemblies += variants(short("quad-bellows-spiral", method)) + variants(short("quad-bellows-heading", method))
    assemblies += [assemble(design_of(duration=1.0 + 0.7 * k)) for k in range(9)]
    return assemblies


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


def test_what_cannot_share_lanes_flies_alone_and_the_order_is_kept(monkeypatch):
    adaptive = assemble(design_of(duration=3.0))
    monkeypatch.setattr(batch, "can_share_lanes", lambda assembly: assembly is not adaptive)
    assemblies = [ending("surface"), adaptive, *variants(short("slocum-glide")), adaptive, ending("bed")]
    runs = list(run_batch(assemblies))
    for run, assembly in zip(runs, assemblies, strict=True):
        assert run.design is assembly.design
    for k in (1, 5):
        assert_identical(runs[k], run_assembly(adaptive))
    assert (runs[0].status, runs[-1].status) == (Status.surface, Status.bed)


SCRIPT = """
from models.assemble import assemble
from models.batch import can_share_lanes, run_batch
from tests.models.support import design_of
assembly = assemble(design_of(duration=0.2))
(run,) = run_batch([assembly])
print(can_share_lanes(assembly), run.status.name)
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
    runs = list(run_batch(assorted(), control=control))
    assert {run.status for run in runs} == {Status.cancelled}
    assert all(run.statistics["steps"] <= 1 for run in runs)


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
