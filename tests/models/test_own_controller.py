"""A controller written in Python: the same law gives the kernel's run, and what it tells is held or refused."""

from __future__ import annotations

import math
import re
import runpy
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from models.controllers import Noise
from models.design import Design, parse_design
from models.own_controller import Measurement, simulate_with
from models.presets import load_preset
from models.problems import DesignError
from models.run import Run, Status
from models.simulate import Control, simulate

PRESET = "quad-bellows-glide"
CELLS = ("Front port cell", "Front starboard cell", "Rear port cell", "Rear starboard cell")
SLOPES = np.array([[-0.05, 0.02, 0.1], [-0.05, -0.02, 0.1], [0.05, 0.02, -0.1], [0.05, -0.02, -0.1]])
"""Of each cell's command by theta (m/rad), phi (m/rad) and q (m s/rad): made up."""
AT_TRIM = np.array([0.02, 0.02, 0.035, 0.035])
PITCH = -0.3


def law(seen: Measurement) -> dict[str, float]:
    """State feedback e = e0 - K (x - x0) within the stops."""
    departure = np.array([seen.pitch - PITCH, seen.roll, seen.angular_velocity[1]])
    return dict(zip(CELLS, AT_TRIM - SLOPES @ departure, strict=True))


def glide(duration: float = 60.0, *, schedules: bool = False, preset: str = PRESET, **solver: object) -> Design:
    """Return a preset with a short mission, without its schedules."""
    document = load_preset(preset).model_dump(mode="json")
    if not schedules:
        document["mission"]["control"] = {}
    document["mission"]["duration"] = duration
    document["mission"]["initial"]["roll"] = 0.2
    document["mission"]["solver"] |= {"output_interval": 0.5} | solver
    return parse_design(document)


def under_kernel(design: Design, *, sample_time: float, delay: float) -> Run:
    """Return the run of the same law in the kernel."""
    document = design.model_dump(mode="json")
    point = {"value": 0.0, "extensions": AT_TRIM.tolist(), "state": [PITCH, 0.0, 0.0], "gains": SLOPES.tolist()}
    document["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "cells": list(CELLS), "states": ["theta", "phi", "q"], "points": [point],
        "sample_time": sample_time, "delay": delay,
    }  # fmt: skip
    return simulate(parse_design(document))


@pytest.mark.parametrize("delay", [0.0, 0.3, 0.7, 1.4, 2.0])
@pytest.mark.parametrize("solver", [{"method": "adaptive"}, {"method": "rk4", "step": 0.05}])
def test_the_same_law_in_python_gives_the_kernels_run(solver, delay):
    design = glide(**solver)
    ours, kernels = (
        simulate_with(design, law, sample_time=0.7, delay=delay),
        under_kernel(design, sample_time=0.7, delay=delay),
    )
    assert np.abs(np.diff(ours.cell_values["command"], axis=0)).max() > 1e-4
    np.testing.assert_array_equal(ours.times, kernels.times)
    for name in ours.variables:
        np.testing.assert_allclose(ours.values[name], kernels.values[name], rtol=1e-9, atol=1e-9, err_msg=name)
    for name in ours.cell_variables:
        np.testing.assert_allclose(ours.cell_values[name], kernels.cell_values[name], rtol=1e-9, atol=1e-9)
    assert [event.kind for event in ours.events] == [event.kind for event in kernels.events]
    assert ours.statistics["steps"] == kernels.statistics["steps"]


def test_a_run_under_ones_own_controller_is_whole(tmp_path):
    run = simulate_with(glide(method="adaptive"), law, sample_time=1.0)
    assert run.status is Status.completed and run.times[-1] == 60.0
    assert "phase" not in run.variables and set(run.values) == set(run.variables)
    assert run.relative_residual < 1e-6
    run.to_netcdf(tmp_path / "run.nc")
    back = Run.from_netcdf(tmp_path / "run.nc")
    np.testing.assert_array_equal(back.cell_values["command"], run.cell_values["command"])


def test_samples_come_in_order_and_commands_are_held_until_the_delay_is_over():
    times: list[float] = []

    def count(seen: Measurement) -> dict[str, float]:
        times.append(seen.time)
        return {CELLS[0]: 0.05 + 0.001 * len(times)}

    run = simulate_with(glide(10.0, output_interval=0.25), count, sample_time=1.0, delay=1.5)
    assert times == [float(k) for k in range(10)]
    commands = run.cell_values["command"][:, 0]
    told = np.floor(run.times - 1.5) + 1.0  # how many samples have reached the cell
    np.testing.assert_allclose(commands[:-1], (0.05 + 0.001 * np.maximum(told, 0.0))[:-1], atol=1e-15)


def test_what_is_never_told_follows_its_schedule_and_what_is_left_out_keeps_its_command():
    design = glide(50.0, schedules=True)

    def once(seen: Measurement) -> dict[str, float]:
        return {CELLS[0]: 0.03} if seen.time == 0.0 else {}

    run, scheduled = simulate_with(design, once, sample_time=5.0), simulate(design)
    np.testing.assert_array_equal(run.cell_values["command"][:, 0], 0.03)
    np.testing.assert_array_equal(run.cell_values["command"][:, 1:], scheduled.cell_values["command"][:, 1:])


def test_a_command_beyond_a_stop_is_held_at_the_stop():
    run = simulate_with(glide(5.0), lambda seen: {CELLS[0]: 7, CELLS[1]: np.float32(-1.0)}, sample_time=1.0)
    np.testing.assert_array_equal(run.cell_values["command"][:, :2], [[0.1, 0.0]] * len(run.times))


def test_measurements_are_those_of_the_run():
    seen: list[Measurement] = []

    def watch(now: Measurement) -> Mapping[str, float]:
        seen.append(now)
        return law(now)

    run = simulate_with(glide(20.0), watch, sample_time=0.5)
    for k, now in enumerate(seen):
        state = {name: column[k] for name, column in run.values.items()}
        told = [now.depth, now.roll, now.pitch, now.yaw, *now.velocity, *now.angular_velocity, now.north, now.east]
        names = ("z", "phi", "theta", "psi", "u", "v", "w", "p", "q", "r", "x", "y")
        np.testing.assert_allclose(told, [state[name] for name in names], atol=1e-12)
        np.testing.assert_allclose([now.extensions[name] for name in run.cells], run.cell_values["extension"][k])


def test_noise_has_its_deviation_and_its_seed():
    def rolls(seed: int) -> list[float]:
        seen: list[float] = []
        noise = Noise(attitude=0.1, seed=seed)
        simulate_with(glide(20.0), lambda now: seen.append(now.roll) or {}, sample_time=0.02, noise=noise)
        return seen

    calm = simulate(glide(20.0, output_interval=0.02)).values["phi"]
    errors = np.array(rolls(1)) - calm[:-1]
    assert errors.std() == pytest.approx(0.1, rel=4.0 / math.sqrt(2.0 * len(errors)))  # four of its own deviations
    assert rolls(1) == rolls(1) != rolls(2)


@pytest.mark.parametrize(
    ("told", "error", "words"),
    [
        ({"Tail": 0.03}, ValueError, "at 2 s the controller told 'Tail' 0.03: no part of this name moves"),
        ({CELLS[0]: math.nan}, ValueError, "at 2 s the controller told 'Front port cell' nan.*from 0 to 0.1"),
        ({CELLS[0]: -math.inf}, ValueError, "'Front port cell' -inf"),
        ({CELLS[0]: "0.03"}, TypeError, "told 'Front port cell' '0.03': return one number"),
        ([0.03], TypeError, r"at 2 s the controller returned \[0.03\]"),
    ],
)
def test_commands_that_make_no_sense_are_refused(told, error, words):
    with pytest.raises(error, match=words):
        simulate_with(glide(5.0), lambda seen: told if seen.time >= 2.0 else {}, sample_time=1.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"sample_time": 0.0}, "sample_time 0 s"),
        ({"sample_time": math.nan}, "sample_time nan s"),
        ({"sample_time": 1.0, "delay": -1.0}, "delay -1 s"),
    ],
)
def test_times_that_make_no_sense_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        simulate_with(glide(5.0), law, **arguments)


def test_a_design_with_a_controller_is_refused():
    document = under_kernel(glide(1.0), sample_time=1.0, delay=0.0).design
    with pytest.raises(DesignError, match="has a controller already"):
        simulate_with(document, law, sample_time=1.0)


def test_the_bed_ends_the_run_and_a_cancelled_one_is_kept():
    document = glide(600.0).model_dump(mode="json")
    document["mission"]["environment"]["bed_depth"] = 10.0
    sinking = simulate_with(parse_design(document), lambda seen: dict.fromkeys(CELLS, 0.0), sample_time=1.0)
    assert sinking.status is Status.bed and sinking.values["z"][-1] == pytest.approx(10.0, abs=1e-6)

    control = Control()

    def cancel(seen: Measurement) -> dict[str, float]:
        if seen.time >= 3.0:
            control.cancel()
        return {}

    run = simulate_with(glide(), cancel, sample_time=1.0, control=control)
    assert run.status is Status.cancelled and 3.0 < run.times[-1] < 4.0


def test_a_planar_glider_obeys_too():
    design = load_preset("three-cell-glider")
    name = design.vehicle.actuated[0][1].name
    stroke = design.vehicle.actuated[0][1].stroke
    run = simulate_with(design, lambda seen: {name: stroke[0] if seen.depth < 3.0 else stroke[1]}, sample_time=0.5)
    assert run.model == "planar" and set(run.values) == set(run.variables)
    np.testing.assert_array_equal(np.unique(run.cell_values["command"][:, run.cells.index(name)])[0], stroke[0])


def test_the_example_reaches_its_heading(capsys):
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / "own_controller.py"))
    headings = re.findall(r"heading +([-\d.]+) deg", capsys.readouterr().out)
    assert float(headings[-1]) == pytest.approx(60.0, abs=2.0)
