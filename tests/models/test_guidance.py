"""Guidance and loops as truths: lines of sight, current triangles, waypoints, a station, mirrors, limits and failures.

The quad-bellows glider, its parts rigid, in water of one density without bed, so that a long glide is steady.
"""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

from models.allocation import effectiveness
from models.design import Design, parse_design
from models.presets import load_preset
from models.presets.quad_control import FAST, SLOW, TURN, cascade, controlled_glider, controlled_mission
from models.presets.quad_glider import movable_mass_twin
from models.problems import DesignError
from models.run import Run, Status
from models.simulate import simulate

SINKING: dict[str, Any] = {"kind": "heave", "heave": -FAST.heave}
CELLS = ("Front port cell", "Front starboard cell", "Rear port cell", "Rear starboard cell")


def design_of(controller: dict[str, Any], duration: float, *, twin: bool = False, **mission: Any) -> Design:
    """The glider, or its twin, under a controller; `mission` changes current, yaw and the initial state."""
    document = movable_mass_twin() if twin else controlled_glider("heading")
    current, yaw, initial = (mission.get(name, default) for name, default in (("current", (0.0, 0.0)), ("yaw", 0.0),
                                                                              ("initial", {})))  # fmt: skip
    document["mission"] = controlled_mission(copy.deepcopy(controller), duration=duration, current=current, yaw=yaw)
    changed = document["mission"]
    changed["environment"] |= {"water": {"kind": "uniform", "density": 999.3}, "bed_depth": None, "surface": "end"}
    changed["initial"] |= initial
    for part in document["vehicle"]["components"]:
        if part.get("bulk_modulus"):
            part["bulk_modulus"] = None
    return parse_design(document)


def flown(controller: dict[str, Any], duration: float, **mission: Any) -> Run:
    return simulate(design_of(controller, duration, **mission))


def sinking(guidance: dict[str, Any] | None, **changes: Any) -> dict[str, Any]:
    """One long dive, every command obeyed."""
    return cascade(guidance, vertical=SINKING, deadband=0.0) | changes


def along_the_axis(integral: float = 0.0) -> dict[str, Any]:
    """North along y = 0 by line of sight; the first point is reached at once, so that it may start beside the leg."""
    points = [[0.0, 0.0], [9000.0, 0.0]]
    return {"kind": "waypoints", "points": points, "radius": 60.0, "lookahead": 50.0, "integral": integral}


def through_water(run: Run, current: tuple[float, float]) -> float:
    """Horizontal speed through the water at the end, m/s."""
    return math.hypot(run.final["x_dot"] - current[0], run.final["y_dot"] - current[1])


def test_line_of_sight_in_still_water_ends_on_the_line():
    run = flown(sinking(along_the_axis()), 2000.0, initial={"position": [0.0, 50.0, 2.0]})
    assert run.values["y"].max() == pytest.approx(50.0, abs=5.0)
    assert abs(run.final["y"]) < 0.01 and abs(run.final["psi"]) < 1e-3


def test_line_of_sight_in_a_current_settles_where_its_lean_is_the_drift_angle():
    """Straight along the line means U sin(lean) = current, and the lean is atan(e / lookahead): e = lookahead tan."""
    current = (0.0, 0.06)
    run = flown(sinking(along_the_axis()), 3000.0, current=current)
    lean = math.asin(current[1] / through_water(run, current))
    assert run.final["y"] == pytest.approx(50.0 * math.tan(lean), rel=1e-4)
    assert run.final["psi"] == pytest.approx(-lean, abs=1e-4)


def test_the_integral_takes_that_offset_away():
    run = flown(sinking(along_the_axis(0.2)), 5000.0, current=(0.0, 0.06))
    assert abs(run.final["y"]) < 0.05
    assert run.values["y"].max() < 12.0


def test_a_heading_held_across_a_current_gives_the_track_of_the_current_triangle():
    heading, current = 0.8, (-0.07, 0.07)
    still, carried = (
        flown(sinking({"kind": "heading", "heading": heading}), 1500.0, current=c) for c in ((0.0, 0.0), current)
    )
    assert carried.final["psi"] == pytest.approx(heading, abs=1e-4)
    late = slice(-200, None)
    (x, y), (dx, dy) = ([float(np.ptp(run.values[n][late])) for n in "xy"] for run in (carried, still))
    track, way, time = math.atan2(y, x), math.hypot(dx, dy), float(np.ptp(still.times[late]))
    # sideslip is nil in a straight glide, so it goes through the water where it points
    expected = math.atan2(way * math.sin(heading) + current[1] * time, way * math.cos(heading) + current[0] * time)
    assert track == pytest.approx(expected, abs=1e-4)
    assert track - heading > math.radians(15.0)


@pytest.mark.parametrize("twin", [False, True])
@pytest.mark.parametrize(("sense", "turns_towards"), [("opposite", True), ("same", False)])
def test_on_climbs_the_bank_that_turns_to_starboard_is_to_port(twin, sense, turns_towards):
    """Lift points down on a climb, so that banking it to port pulls to starboard; the other sense runs away."""
    controller = cascade({"kind": "heading", "heading": 0.8})
    controller["vertical"]["first"] = "climb"
    controller["lateral"]["climb_bank"] = sense
    run = flown(controller, 300.0, twin=twin, yaw=0.4, initial={"position": [0.0, 0.0, 85.0]})
    assert np.all(run.values["phase"] == 1.0)
    error = 0.8 - run.final["psi"]
    assert (abs(error) < 0.02) if turns_towards else (error > 1.0)


def round_trip(*, repeat: bool, duration: float) -> tuple[Run, list[list[float]]]:
    points = [[150.0, 0.0], [150.0, 150.0], [0.0, 0.0]]
    guidance = {"kind": "waypoints", "points": points, "radius": 25.0, "lookahead": 40.0, "repeat": repeat}
    return flown(cascade(guidance), duration), points


@pytest.fixture(scope="module")
def rounds() -> tuple[Run, list[list[float]]]:
    return round_trip(repeat=True, duration=5400.0)


def test_waypoints_are_visited_in_order_and_within_their_radius(rounds):
    run, points = rounds
    times = [event.time for event in run.events if event.kind == "waypoint"]
    assert len(times) > 4
    for k, time in enumerate(times):
        place = [float(np.interp(time, run.times, run.values[name])) for name in "xy"]
        assert math.dist(place, points[k % 3]) <= 25.0 + 1e-3
    legs = run.values["leg"][np.flatnonzero(np.diff(run.values["leg"])) + 1]
    np.testing.assert_array_equal(legs, [(k + 1) % 3 for k in range(len(legs))])


def test_without_repeat_the_last_leg_goes_on(rounds):
    run, _ = round_trip(repeat=False, duration=5400.0)
    times = [event.time for event in run.events if event.kind == "waypoint"]
    assert times[:2] == [event.time for event in rounds[0].events if event.kind == "waypoint"][:2]
    assert len(times) == 3 and run.values["leg"][-1] == 3.0  # the last is reached once, and passed
    assert run.final["x"] < -100.0 and run.final["y"] == pytest.approx(run.final["x"], abs=5.0)


def test_a_station_is_kept_for_an_hour_within_the_bound():
    """The radius, two radii of the turn back, and what the current carries it in half a turn."""
    document = load_preset("quad-bellows-station").model_dump(mode="json")
    document["mission"]["duration"] = 3600.0
    run = simulate(parse_design(document))
    v, station = run.values, document["mission"]["control"]["controller"]["lateral"]["guidance"]
    spiral = np.isfinite(v["roll_target"]) & np.isnan(v["heading_target"])
    rate = float(np.median(np.abs(v["turn_rate"][spiral])))
    through = np.hypot(v["x_dot"] - v["current_x"], v["y_dot"] - v["current_y"])
    turn_radius = float(np.median(through[spiral])) / rate
    bound = station["radius"] + 2.0 * turn_radius + 0.05 * math.pi / rate
    away = np.hypot(v["x"], v["y"])
    assert station["radius"] < away.max() < bound < 170.0
    assert 0.2 < spiral.mean() < 0.9
    assert run.status is Status.completed


def mirrored(document: dict[str, Any]) -> Design:
    """Port for starboard in the vehicle (one plane of symmetry) and in what is wanted."""
    for part in document["vehicle"]["components"]:
        part["position"][1] *= -1.0
        for shape in part["shapes"]:
            shape["offset"][1] *= -1.0
    mission = document["mission"]
    mission["initial"]["yaw"] *= -1.0
    if mission["environment"]["current"]:
        mission["environment"]["current"]["velocity"][1] *= -1.0
    guidance = mission["control"]["controller"]["lateral"]["guidance"]
    for name in ("heading", "bank", "roll"):
        if name in guidance:
            guidance[name] *= -1.0
    for point in guidance.get("points", []):
        point[1] *= -1.0
    return parse_design(document)


@pytest.mark.parametrize("task", ["heading", "waypoints", "station"])
def test_the_mirrored_mission_gives_the_mirrored_path(task):
    document = load_preset(f"quad-bellows-{task}").model_dump(mode="json")
    document["mission"]["duration"] = 3600.0
    run, other = simulate(parse_design(document)), simulate(mirrored(document))
    for name in ("x", "z", "theta", "pitch_moment_wanted"):
        np.testing.assert_allclose(other.values[name], run.values[name], atol=1e-9, err_msg=name)
    for name in ("y", "phi", "psi", "roll_moment_wanted", "roll_target"):
        np.testing.assert_allclose(other.values[name], -run.values[name], atol=1e-9, err_msg=name)


def test_a_band_may_begin_with_a_climb():
    controller = cascade(None)
    controller["vertical"]["first"] = "climb"
    run = flown(controller, 1500.0, initial={"position": [0.0, 0.0, 40.0]})
    kinds = [event.kind for event in run.events if event.kind in ("dive", "climb")]
    assert kinds[:2] == ["dive", "climb"]
    assert run.values["phase"][0] == 1.0
    first_dive = next(event.time for event in run.events if event.kind == "dive")
    assert np.all(run.values["z"][run.times < first_dive] < 43.0)  # the cells rest at neutral, it is level: it rises


def test_back_calculation_shortens_the_recovery_from_what_the_cells_cannot_do():
    """Held nose up at the start, with cells near their stops, the loop asks for more than there is for a while."""
    settled = []
    for unwind in (20.0, 1e6):
        controller = sinking(None, unwind_time=unwind, allocation={"weights": {"heave": 100.0}})
        controller["vertical"] = {"kind": "heave", "heave": -6.5}
        controller["pitch"] = {"dive": -0.4, "loop": {"proportional": 1.0, "integral": 0.05, "derivative": 4.0}}
        run = flown(controller, 400.0, initial={"pitch": 1.0})
        assert np.abs(run.values["pitch_moment_missing"]).max() > 0.1
        off = np.flatnonzero(np.abs(run.values["theta"] + 0.4) > 0.02)
        settled.append(float(run.times[off[-1]]))
    assert settled[0] < 0.5 * settled[1] < 0.5 * 400.0


def test_back_calculation_gives_back_what_a_loops_limit_cuts_off():
    """A bank that takes nearly all of the limit: while the limit cuts off, the integral must not wind up."""
    overshoot = []
    for unwind in (5.0, 1e6):
        controller = sinking({"kind": "roll", "roll": 0.1}, unwind_time=unwind)
        loop = {"proportional": 8.0, "integral": 0.3, "derivative": 8.0, "limit": 0.45}
        controller["lateral"]["roll_loop"] = loop
        run = flown(controller, 600.0)
        assert run.final["phi"] == pytest.approx(0.1, abs=1e-4)
        overshoot.append(float(run.values["phi"].max()) - 0.1)
    assert overshoot[0] < 1e-3 < 0.2 * overshoot[1]


def test_past_its_last_place_it_holds_on_along_the_leg():
    """Without a lookahead it heads straight for the place; once there it goes on, and does not circle."""
    guidance = {"kind": "waypoints", "points": [[60.0, 0.0]], "radius": 10.0}
    run = flown(sinking(guidance), 900.0)
    (reached,) = [event.time for event in run.events if event.kind == "waypoint"]
    assert run.final["x"] > 120.0 and abs(run.final["y"]) < 1.0
    assert np.abs(run.values["psi"][run.times > reached]).max() < 0.05


@pytest.mark.parametrize("heave", [-FAST.heave, FAST.heave])
def test_a_held_heave_is_a_dive_or_a_climb_by_its_sign(heave):
    """Lift points down on a climb: the heading is held only if the bank's sense follows."""
    controller = cascade({"kind": "heading", "heading": 0.8}) | {"deadband": 0.0}
    controller["vertical"] = {"kind": "heave", "heave": heave}
    controller["pitch"]["dive"] = math.copysign(0.5, heave)
    run = flown(controller, 300.0, initial={"position": [0.0, 0.0, 85.0]}, yaw=0.4)
    assert np.all(run.values["phase"] == (1.0 if heave > 0.0 else 0.0))
    assert run.final["psi"] == pytest.approx(0.8, abs=0.02)
    assert run.final["theta"] == pytest.approx(math.copysign(0.5, heave), abs=0.1)  # P and D alone


def test_integrals_are_given_back_within_a_sample_at_most():
    """A give-back faster than the samples would swing: the gain of a step is one at most."""
    pitch = {"dive": -0.5, "loop": {"proportional": 0.5, "integral": 0.01, "derivative": 2.0, "limit": 0.6}}
    runs = [flown(sinking(None, sample_time=10.0, unwind_time=unwind, pitch=pitch), 900.0) for unwind in (0.1, 10.0)]
    np.testing.assert_array_equal(runs[0].values["theta"], runs[1].values["theta"])


def test_a_way_of_one_place_cannot_repeat():
    guidance = {"kind": "waypoints", "points": [[0.0, 50.0]], "repeat": True}
    with pytest.raises(DesignError, match="repeat needs two places or more"):
        design_of(sinking(guidance), 100.0)


@pytest.mark.parametrize(
    ("gains", "delay", "swings"),
    [((0.5, 2.0), 0.0, False), ((0.5, 2.0), 2.0, False), ((3.0, 10.0), 0.0, False), ((3.0, 10.0), 2.0, True)],
)
def test_a_delay_unsettles_a_fast_loop_and_not_a_slow_one(gains, delay, swings):
    controller = sinking(None, sample_time=1.0, delay=delay)
    controller["pitch"]["loop"] = {"proportional": gains[0], "derivative": gains[1], "limit": 4.0}
    run = flown(controller, 600.0)
    late = run.values["theta"][run.times > 400.0]
    assert (np.ptp(late) > 0.2) if swings else (np.ptp(late) < 1e-3)


def made_by_cells(run: Run, cells: tuple[str, ...] = CELLS) -> np.ndarray:
    """Heave, pitch and roll that the extensions make by the matrix of the allocation, (3, samples)."""
    does = effectiveness(run.design, cells)
    columns = [run.cells.index(name) for name in cells]
    return does.matrix @ (run.cell_values["command"][:, columns] - does.neutral).T


def test_an_impossible_bank_is_told():
    run = flown(sinking({"kind": "roll", "roll": 1.2}), 400.0)
    wanted, missing = (
        np.array([run.final[f"{axis}_{what}"] for axis in ("heave", "pitch_moment", "roll_moment")])
        for what in ("wanted", "missing")
    )
    assert missing[2] > 0.1 and run.final["phi"] < 0.5
    np.testing.assert_allclose(made_by_cells(run)[:, -1], wanted - missing, atol=1e-9)


def test_three_cells_of_four_still_hold_pitch():
    left = CELLS[1:]
    run = flown(cascade(None, SLOW, deadband=0.0, allocation={"cells": left}), 1800.0)
    late = run.times > 200.0
    for phase, target in ((0.0, SLOW.dive), (1.0, SLOW.climb)):
        assert np.median(run.values["theta"][late & (run.values["phase"] == phase)]) == pytest.approx(target, abs=0.03)
    assert np.median(np.abs(run.values["phi"][late])) < 1e-3  # it banks for a while where it turns
    assert np.median(np.abs(run.values["heave_missing"][late])) < 1e-4
    assert np.all(run.cell_values["command"][:, run.cells.index(CELLS[0])] == run.cell_values["command"][0, 0])


def test_three_cells_of_four_say_what_they_cannot_do():
    """A fast dive is too much for one side's rear cell; with pitch first it is held, and heave is short."""
    rule = {"cells": CELLS[1:], "weights": {"pitch": 100.0, "roll": 100.0}}
    run = flown(sinking(None, allocation=rule), 400.0)
    assert run.final["theta"] == pytest.approx(FAST.dive, abs=0.05)
    assert abs(run.final["phi"]) < 0.01
    wanted, missing = run.final["heave_wanted"], run.final["heave_missing"]
    assert missing < -0.5  # it wants more weight than there is
    assert made_by_cells(run, CELLS[1:])[0, -1] == pytest.approx(wanted - missing, abs=1e-6)


def test_the_heading_loops_limit_unwinds_its_integral():
    overshoots = []
    for unwind in (20.0, 1e6):
        controller = sinking({"kind": "heading", "heading": 2.5}, unwind_time=unwind)
        controller["lateral"]["heading_loop"] = TURN | {"integral": 0.01}
        overshoots.append(float(flown(controller, 900.0).values["psi"].max()) - 2.5)
    assert overshoots[0] < 0.5 * overshoots[1]
