"""Closed-loop runs: guidance and loops do what they say, and a run is the glide that its commands make."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from models.assemble import assemble
from models.controllers import Noise
from models.design import Design, parse_design
from models.own_controller import simulate_with
from models.presets import load_preset
from models.problems import DesignError
from models.run import Run, Status
from models.run_warnings import run_warnings
from models.simulate import simulate

YOYO = {"kind": "depth_band", "top": 5.0, "bottom": 25.0, "dive_heave": -4.0, "climb_heave": 4.0}
PITCH = {"dive": -0.35, "loop": {"proportional": 2.0, "integral": 0.05, "derivative": 4.0, "limit": 3.0}}
HEADING = {
    "guidance": {"kind": "heading", "heading": 1.0},
    "roll_loop": {"proportional": 1.0, "integral": 0.02, "derivative": 1.0, "limit": 1.0},
    "heading_loop": {"proportional": 0.6, "derivative": 3.0, "limit": 0.35},
}


def controlled(duration: float = 900.0, *, preset: str = "quad-bellows-glide", **fields: Any) -> Design:
    """Return a preset under control instead of its schedules."""
    document = load_preset(preset).model_dump(mode="json")
    controller = {"kind": "cascade", "sample_time": 2.0, "vertical": YOYO, "pitch": PITCH} | fields
    document["mission"]["control"] = {"schedules": [], "controller": controller}
    document["mission"]["duration"] = duration
    document["mission"]["solver"]["output_interval"] = 1.0
    return parse_design(document)


@pytest.fixture(scope="module")
def yo_yo() -> Run:
    """A yo-yo on a heading, with noisy instruments and a delay."""
    noise = {"attitude": 0.005, "depth": 0.05, "rate": 0.001, "seed": 3}
    return simulate(controlled(lateral=HEADING, noise=noise, delay=0.5))


@pytest.mark.parametrize(
    ("controller", "says"),
    [
        ({"kind": "cascade", "lateral": HEADING | {"guidance": {
            "kind": "waypoints", "points": [[0.0, 50.0], [9.0, 50.0], [9.0, 50.0]]}}},
         "points 2 and 3 are the same place: remove one"),
        ({"kind": "state_feedback", "cells": ["Front bellows"], "states": ["theta"], "points": [
            {"value": 0.0, "extensions": [0.01], "state": [0.0], "gains": [[1.0]]},
            {"value": 1.0, "extensions": [], "state": [0.0], "gains": [[1.0]]}]},
         "point 2 has 0 extensions, 1 states"),
    ],
)  # fmt: skip
def test_points_are_counted_from_one_where_they_are_told(controller, says):
    document = load_preset("quad-bellows-glide").model_dump(mode="json")
    document["mission"]["control"] = {"schedules": [], "controller": controller}
    with pytest.raises(DesignError, match=says):
        parse_design(document)


def test_a_yo_yo_turns_at_the_edges_of_its_band(yo_yo):
    turns = [event for event in yo_yo.events if event.kind in ("dive", "climb")]
    assert [event.kind for event in turns[:3]] == ["climb", "dive", "climb"]
    for event in turns:
        z = np.interp(event.time, yo_yo.times, yo_yo.values["z"])
        wanted = 25.0 if event.kind == "climb" else 5.0
        # within what it sinks in one sample, and three deviations of the depth's noise
        assert abs(z - wanted) < 2.0 * 0.3 + 0.15
    assert yo_yo.status is Status.completed
    assert yo_yo.relative_residual < 1e-6


def test_pitch_and_heading_settle_on_their_targets(yo_yo):
    dive = (yo_yo.values["phase"] == 0.0) & (yo_yo.times > 150.0) & (yo_yo.times < 220.0)
    assert yo_yo.values["theta"][dive].mean() == pytest.approx(-0.35, abs=0.02)
    assert yo_yo.values["psi"][yo_yo.times > 600.0].mean() == pytest.approx(1.0, abs=0.02)


def test_a_run_is_the_glide_of_its_own_commands(yo_yo):
    """The commands that were held, given as a schedule, make the same glide: control adds nothing else."""
    document = yo_yo.design.model_dump(mode="json")
    document["mission"]["duration"] = 120.0
    short = simulate(parse_design(document | {"name": "Under control"}))
    changes = np.flatnonzero(np.any(np.diff(short.cell_values["command"], axis=0) != 0.0, axis=1)) + 1
    assert len(changes) > 10
    controller = document["mission"]["control"].pop("controller")
    held, step = controller["delay"], controller["sample_time"]
    document["mission"]["control"]["schedules"] = [
        {
            "cell": cell,
            "points": [
                # a command reaches the cells half a second after its sample, and is first seen at the next second
                {"time": step * np.floor(short.times[k] / step) + held, "extension": short.cell_values["command"][k, i]}
                for k in changes
            ],
        }
        for i, cell in enumerate(short.cells)
    ]  # fmt: skip
    again = simulate(parse_design(document))
    for name in ("x", "y", "z", "theta", "phi", "psi"):
        np.testing.assert_allclose(again.values[name], short.values[name], atol=2e-6)


def test_files_keep_what_the_controller_asked_for(yo_yo, tmp_path):
    yo_yo.to_netcdf(tmp_path / "run.nc")
    yo_yo.to_csv(tmp_path / "run.csv")
    back, table = Run.from_netcdf(tmp_path / "run.nc"), Run.read_csv(tmp_path / "run.csv")
    assert back.events == yo_yo.events
    for name in ("phase", "pitch_target", "roll_moment_missing"):
        np.testing.assert_array_equal(back.values[name], yo_yo.values[name])
        np.testing.assert_array_equal(table[name].values, yo_yo.values[name])


def test_the_same_seed_gives_the_same_run_and_another_seed_another():
    runs = [
        simulate(controlled(60.0, noise={"attitude": 0.01, "seed": seed})).cell_values["command"] for seed in (1, 1, 2)
    ]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.abs(runs[0] - runs[2]).max() > 1e-4


def test_noise_has_the_stated_deviation_and_no_memory():
    from numba import njit

    from models.kernel.noise import normal

    @njit
    def draw(seed, count, channel):
        numbers = np.zeros(count)
        for k in range(count):
            numbers[k] = normal(seed, k, channel)
        return numbers

    numbers = np.array([draw(seed, 20_000, 3) for seed in (0, 1)])
    # four deviations of the estimates of 20,000 draws
    np.testing.assert_allclose(numbers.mean(axis=1), 0.0, atol=4.0 / np.sqrt(20_000))
    np.testing.assert_allclose(numbers.std(axis=1), 1.0, atol=4.0 / np.sqrt(40_000))
    assert abs(np.corrcoef(numbers)[0, 1]) < 4.0 / np.sqrt(20_000)
    assert abs(np.corrcoef(numbers[0, 1:], numbers[0, :-1])[0, 1]) < 4.0 / np.sqrt(20_000)


def test_a_deadband_leaves_actuators_in_peace():
    busy, calm = (
        simulate(controlled(300.0, noise={"attitude": 0.01, "seed": 1}, deadband=d)).cell_values["command"]
        for d in (0.0, 0.1)
    )
    moves = [int(np.sum(np.any(np.diff(c, axis=0) != 0.0, axis=1))) for c in (busy, calm)]
    assert moves[1] < 0.3 * moves[0]


def test_a_planar_glider_holds_its_pitch():
    pitch = {"dive": -0.5, "loop": {"proportional": 0.02, "integral": 0.004, "derivative": 0.05, "limit": 0.07}}
    vertical = {"kind": "heave", "heave": -0.15}
    run = simulate(controlled(60.0, preset="three-cell-glider", vertical=vertical, pitch=pitch, sample_time=0.5))
    assert run.model == "planar"
    late = run.times > 0.8 * run.times[-1]
    assert run.values["theta"][late].mean() == pytest.approx(-0.5, abs=0.02)


def test_state_feedback_with_no_gains_holds_its_trim():
    cells = ["Front port cell", "Rear starboard cell"]
    point = {"value": 0.0, "extensions": [0.03, 0.06], "state": [0.0], "gains": [[0.0], [0.0]]}
    document = controlled(150.0).model_dump(mode="json")
    document["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "cells": cells, "states": ["theta"], "points": [point],
    }  # fmt: skip
    run = simulate(parse_design(document))
    final = dict(zip(run.cells, run.cell_values["extension"][-1], strict=True))
    assert [final[name] for name in cells] == pytest.approx([0.03, 0.06], abs=1e-6)


def test_an_integral_stops_at_a_stop_and_comes_back():
    """A cell driven against its stop by the integral: it leaves the stop as soon as the error turns round."""
    point = {"value": 0.0, "extensions": [0.05], "state": [-20.0], "gains": [[0.0, 2e-4]]}
    ends = [point, point | {"value": 1.0, "state": [20.0]}]
    document = controlled(400.0).model_dump(mode="json")
    document["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "cells": ["Front port cell"], "states": ["z"], "integrals": 1, "points": ends,
        "set_points": [{"time": 0.0, "value": 1.0}, {"time": 200.0, "value": 1.0}, {"time": 200.5, "value": 0.0}],
    }  # fmt: skip
    run = simulate(parse_design(document))
    command = run.cell_values["command"][:, run.cells.index("Front port cell")]
    assert np.isnan(run.values["phase"]).all() and run.values["set_point"][0] == 1.0
    assert command.max() == 0.1  # the depth stays below 20 m, so the integral drives the cell out to its stop
    first = int(np.argmax(command == 0.1))
    assert np.all(command[first : int(np.searchsorted(run.times, 200.0))] == 0.1)
    # then the error has the other sign; the integral stood still a step beyond the stop, not the worth of 200 s
    turned = run.times[first + int(np.argmax(command[first:] < 0.1))]
    assert 200.5 < turned < 205.0


def test_a_planar_glider_has_no_noise_across_its_plane():
    pitch = {"dive": -0.5, "loop": {"proportional": 0.02, "derivative": 0.05, "limit": 0.07}}
    noise = {"attitude": 0.01, "place": 1.0, "seed": 4}
    seen = []
    design = controlled(20.0, preset="three-cell-glider", vertical={"kind": "heave", "heave": -0.15}, pitch=pitch)
    control = design.mission.control.model_copy(update={"controller": None})
    open_loop = design.model_copy(update={"mission": design.mission.model_copy(update={"control": control})})
    simulate_with(open_loop, lambda m: seen.append(m) or {}, sample_time=1.0, noise=Noise.model_validate(noise))
    assert {m.roll for m in seen} == {m.yaw for m in seen} == {m.east for m in seen} == {0.0}
    assert len({m.pitch - s.pitch for m, s in pairwise(seen)}) > 10


def test_noise_also_runs_as_plain_python():
    script = "from models.kernel.noise import normal; print([normal(7, k, 2) for k in range(3)])"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script], cwd=Path(__file__).parents[2], capture_output=True, text=True,
        check=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    from models.kernel.noise import normal

    assert json.loads(done.stdout) == pytest.approx([normal(7, k, 2) for k in range(3)], rel=1e-14)


def test_set_points_blend_the_table():
    point = {"state": [0.0], "gains": [[0.0]]}
    points = [point | {"value": 0.0, "extensions": [0.04]}, point | {"value": 1.0, "extensions": [0.06]}]
    document = controlled(100.0).model_dump(mode="json")
    document["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "sample_time": 2.0, "cells": ["Front port cell"], "states": ["theta"],
        "points": points, "set_points": [{"time": 0.0, "value": 0.0}, {"time": 100.0, "value": 1.0}],
    }  # fmt: skip
    run = simulate(parse_design(document))
    commands = run.cell_values["command"][:, run.cells.index("Front port cell")]
    sampled = 2.0 * np.floor(run.times[:-1] / 2.0)  # the run ends before the sample at its end
    np.testing.assert_allclose(commands[:-1], 0.04 + 2e-4 * sampled, atol=1e-12)


@pytest.mark.parametrize(
    ("fields", "pointer", "words"),
    [
        ({"delay": 1000.0}, "/mission/control/controller/delay", "64|63 samples"),
        (
            {"allocation": {"cells": ["Tail"]}}, "/mission/control/controller/allocation/cells/0",
            "no component that moves is named 'Tail'",
        ),
        (
            {"allocation": {"effort": {"Nose": 2.0}}}, "/mission/control/controller/allocation/effort/Nose",
            "'Nose' is not under control",
        ),
    ],
)  # fmt: skip
def test_misuse_is_refused_at_the_door(fields, pointer, words):
    with pytest.raises(DesignError, match=words) as error:
        assemble(controlled(**fields))
    assert error.value.problems[0].pointer == pointer


def test_a_cell_cannot_follow_both_schedule_and_controller():
    document = controlled().model_dump(mode="json")
    document["mission"]["control"]["schedules"] = [
        {"cell": "Front port cell", "points": [{"time": 1.0, "extension": 0.05}]}
    ]
    with pytest.raises(DesignError, match="has a schedule and is under control"):
        assemble(parse_design(document))


def test_a_planar_glider_has_no_bank():
    with pytest.raises(DesignError, match="no bank and no heading"):
        assemble(controlled(preset="three-cell-glider", lateral=HEADING))


def test_what_a_controller_cannot_get_is_warned_of():
    band = {"kind": "depth_band", "top": 5.0, "bottom": 500.0, "dive_heave": -50.0, "climb_heave": 4.0}
    warnings = {w.pointer.rpartition("/")[2]: w.message for w in assemble(controlled(vertical=band)).warnings}
    assert "at or below the bed at 120 m" in warnings["bottom"]
    assert "-50 N are asked of cells that make -7.67 to +7.67 N" in warnings["dive_heave"]
    assert "climb_heave" not in warnings


def test_a_controllers_samples_are_bounded():
    with pytest.raises(DesignError, match="samples of the controller exceed the limit") as error:
        assemble(controlled(6000.0, sample_time=0.001))
    assert error.value.problems[0].pointer == "/mission/control/controller/sample_time"


def test_a_run_tells_what_its_cells_could_not_make():
    asked = simulate(controlled(200.0, vertical={"kind": "heave", "heave": -12.0}))
    (told,) = [w for w in run_warnings(asked) if w.pointer.endswith("/allocation") and "less heave" in w.message]
    assert "of 12 N" in told.message
    calm = simulate(controlled(200.0, vertical={"kind": "heave", "heave": -4.0}))
    assert not [w for w in run_warnings(calm) if "less heave" in w.message]


def test_a_table_stays_within_the_stops_and_set_points_within_the_table():
    points = [{"value": v, "extensions": [e], "state": [0.0], "gains": [[0.0]]} for v, e in ((0.0, -0.7), (1.0, 0.05))]
    document = controlled().model_dump(mode="json")
    document["mission"]["control"]["controller"] = {
        "kind": "state_feedback", "cells": ["Front port cell"], "states": ["theta"], "points": points,
        "set_points": [{"time": 0.0, "value": 99.0}],
    }  # fmt: skip
    with pytest.raises(DesignError) as error:
        assemble(parse_design(document))
    at = "/mission/control/controller"
    assert [p.pointer for p in error.value.problems] == [f"{at}/points/0/extensions/0", f"{at}/set_points/0/value"]
