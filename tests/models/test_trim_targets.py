"""Targets are met to rounding by the nearest extensions within the stops, or a failure says what keeps them away."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from models.assemble import Assembly, assemble
from models.bounded_motion import off_target
from models.design import Design, parse_design
from models.kernel.steady import EXTENSIONS, LOADS, ROWS
from models.mass_properties import mass_balance
from models.presets import load_preset
from models.problems import DesignError
from models.steady_problem import steady_problem
from models.targeted_trim import ActiveBound, Missed, TrimFailure, trim_for
from models.trim import Trim, find_trims, motion_of
from models.trim_targets import driven, targets_of
from tests.models.test_trim import in_even_water
from tests.strategies import designs

DIVE = math.radians(-30.0)
TWO = ("Front bellows", "Rear bellows")
FOUR = ("Front port cell", "Front starboard cell", "Rear port cell", "Rear starboard cell")
MASSES = ("Buoyancy engine", "Battery", "Lower ballast")
WANTED: list[tuple[str, dict[str, float], tuple[str, ...]]] = [
    ("canete-dual-bellows", {"glide_angle": DIVE, "speed": 0.07}, TWO),
    ("canete-dual-bellows", {"glide_angle": -DIVE, "speed": 0.07}, TWO),
    ("canete-dual-bellows", {"pitch": -0.4, "sink_rate": 0.03}, TWO),
    ("canete-dual-bellows", {"glide_angle": -0.5}, TWO),
    ("canete-dual-bellows", {"pitch": 0.4}, TWO),
    ("three-cell-glider", {"glide_angle": DIVE, "speed": 0.12}, ("Middle piston", "Battery slide")),
    ("three-cell-glider", {"glide_angle": DIVE, "speed": 0.12}, ("Middle piston", "Battery slide", *TWO)),
    ("slocum-glide", {"glide_angle": math.radians(-25.0)}, ("Movable mass",)),
    ("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.3}, FOUR),
    ("quad-bellows-glide", {"sink_rate": 0.1}, FOUR),
    ("quad-bellows-glide", {"sink_rate": -0.1, "pitch": 0.5}, FOUR),
    ("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.25, "turn_radius": 25.0}, FOUR),
    ("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.25, "turn_rate": -0.008}, FOUR),
    ("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.25, "roll": 0.2}, FOUR),
    ("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.25, "sink_rate": 0.125}, FOUR),
    ("movable-mass-twin", {"glide_angle": DIVE, "speed": 0.25, "turn_radius": 25.0}, MASSES),
    ("seawing-spiral", {"turn_radius": -150.0}, ("Battery",)),
]


def trimmed(preset: str | Assembly, targets: dict[str, float], free: tuple[str, ...], **options: Any) -> Trim:
    found = trim_for(load_preset(preset) if isinstance(preset, str) else preset, targets, free, **options)
    assert isinstance(found, Trim), str(found)
    return found


@pytest.mark.parametrize(("preset_id", "targets", "free"), WANTED)
def test_targets_are_met_within_the_stops_by_a_balanced_stable_motion(preset_id, targets, free):
    assembly = assemble(load_preset(preset_id))
    trim = trimmed(assembly, targets, free)
    for name, value in targets.items():
        assert getattr(trim, name) == pytest.approx(value, rel=1e-9, abs=1e-9), name
    weight = steady_problem(assembly).weight
    assert max(map(abs, trim.residual.values())) <= 1e-10 * weight
    assert trim.stable
    for part, cell in zip(assembly.params.parts, assembly.cells, strict=True):
        assert part["stop_low"] <= trim.extensions[cell] <= part["stop_high"]
        if cell not in free:
            start = assembly.design.mission.initial.extensions.get(cell, part["neutral"])
            assert trim.extensions[cell] == start


@pytest.mark.parametrize(("preset_id", "targets", "free"), WANTED)
def test_a_trim_for_targets_is_one_that_the_search_finds_at_its_extensions(preset_id, targets, free):
    assembly = assemble(load_preset(preset_id))
    trim = trimmed(assembly, targets, free)
    again = find_trims(assembly, extensions=trim.extensions).solutions
    assert min(np.abs(other.velocity - trim.velocity).max() for other in again) < 1e-7


REACHABLE = {
    "canete-dual-bellows": ("glide_angle", "speed"),
    "three-cell-glider": ("glide_angle", "speed"),
    "quad-bellows-glide": ("glide_angle", "speed", "turn_radius"),
    "movable-mass-twin": ("glide_angle", "speed", "turn_radius"),
    "seawing-spiral": ("turn_radius",),
    "slocum-glide": ("glide_angle",),
}


@pytest.mark.parametrize("preset_id", REACHABLE)
def test_what_some_extensions_reach_is_found_from_other_ones(preset_id):
    assembly, generator = assemble(load_preset(preset_id)), np.random.default_rng(7)
    parts, reached = assembly.params.parts, 0
    for _ in range(12):
        drawn = parts["stop_low"] + generator.uniform(size=len(parts)) * (parts["stop_high"] - parts["stop_low"])
        stable = find_trims(assembly, extensions=dict(zip(assembly.cells, drawn.tolist(), strict=True))).stable
        for trim in stable:
            if abs(trim.angle_of_attack) < 0.5 and abs(trim.roll) < 1.0:
                targets = {name: getattr(trim, name) for name in REACHABLE[preset_id]}
                assert isinstance(trim_for(assembly, targets, assembly.cells), Trim), targets
                reached += 1
    assert reached >= 2


@pytest.mark.parametrize("targets", [{"glide_angle": DIVE, "speed": 0.3}, {"sink_rate": 0.1, "pitch": -0.6}])
def test_straight_targets_of_a_symmetric_design_leave_no_roll_at_all(targets):
    trim = trimmed("quad-bellows-glide", targets, FOUR)
    assert (trim.roll, trim.sideslip, trim.turn_rate) == (0.0, 0.0, 0.0)
    assert trim.extensions[FOUR[0]] == pytest.approx(trim.extensions[FOUR[1]], abs=1e-9)


@pytest.mark.parametrize(
    "targets", [{"sink_rate": 0.1}, {"glide_angle": DIVE, "speed": 0.25}, {"speed": 0.25, "turn_rate": 0.01}]
)
def test_of_what_the_targets_leave_open_the_nearest_extensions_are_taken(targets):
    """No direction along which loads and targets stay as they are comes nearer to the given extensions."""
    given_e = dict.fromkeys(FOUR, 0.04) | {FOUR[0]: 0.044}
    assembly = assemble(load_preset("quad-bellows-glide"))
    trim = trimmed(assembly, targets, FOUR, extensions=given_e)
    problem = steady_problem(assembly, extensions=given_e)
    s = motion_of(trim)
    _f, slope = problem.slopes(s, problem.steps)
    names = [*targets] if "turn_rate" in targets else [*targets, "turn_rate"]
    rows = [*range(LOADS), *(ROWS.index(name) for name in names)]
    scaled = slope[rows] * np.concatenate([np.ones(EXTENSIONS), problem.high - problem.low])
    scaled /= np.abs(scaled).max(axis=1)[:, None]
    _u, values, directions = np.linalg.svd(scaled)
    open_to = directions[int((values > 1e-7 * values[0]).sum()) :, :]
    assert len(open_to) >= 1
    away = (s[EXTENSIONS:] - problem.extensions) / (problem.high - problem.low)
    # the search ends where the rows hold; the distance, flat at its least, is then settled to second order
    assert np.abs(open_to[:, EXTENSIONS:] @ away).max() < 1e-4 * np.linalg.norm(away)


def test_a_radius_to_the_left_takes_the_mirrored_cells():
    turn = {"glide_angle": DIVE, "speed": 0.25}
    right = trimmed("quad-bellows-glide", turn | {"turn_radius": 25.0}, FOUR)
    left = trimmed("quad-bellows-glide", turn | {"turn_radius": -25.0}, FOUR)
    swapped = [left.extensions[FOUR[i]] for i in (1, 0, 3, 2)]
    assert swapped == pytest.approx([right.extensions[name] for name in FOUR], abs=1e-9)


def test_what_the_stops_do_not_allow_names_them_and_the_nearest_motion():
    found = trim_for(load_preset("quad-bellows-glide"), {"glide_angle": DIVE, "speed": 2.5}, FOUR)
    assert isinstance(found, TrimFailure)
    assert {(bound.cell, bound.stop) for bound in found.active} == {(FOUR[0], "lower"), (FOUR[1], "lower")}
    assert found.nearest is not None
    assert max(map(abs, found.nearest.residual.values())) < 1e-9
    missed = {miss.target: miss for miss in found.missed}
    assert missed["speed"].wanted == 2.5
    assert missed["speed"].reached == pytest.approx(found.nearest.speed)
    assert 0.3 < found.nearest.speed < 0.6
    assert found.residual["X"] < -10.0  # far from enough weight along the path
    for word in ("the stops do not allow it", "'Front port cell' is at its lower stop, 0 mm", "nearest", "X -"):
        assert word in str(found)


def test_no_feasible_neighbour_of_the_nearest_motion_misses_less():
    design = load_preset("canete-dual-bellows")
    targets = {"glide_angle": math.radians(-25.0), "speed": 0.7}
    found = trim_for(design, targets, TWO)
    assert isinstance(found, TrimFailure)
    assert found.nearest is not None

    def miss(trim: Trim) -> float:
        return math.hypot(trim.glide_angle - targets["glide_angle"], trim.speed / targets["speed"] - 1.0)

    best = found.nearest.extensions
    for change in np.array([[1, 0], [0, 1], [0, -1], [1, 1], [1, -1]]) * 1e-4:
        moved = {name: best[name] + d for name, d in zip(TWO, change, strict=True)}
        near = find_trims(design, extensions=moved).solutions
        closest = min(near, key=lambda trim: np.abs(trim.velocity - found.nearest.velocity).max())
        assert miss(closest) > miss(found.nearest)


def test_too_few_cells_meet_what_they_can():
    found = trim_for(load_preset("canete-dual-bellows"), {"pitch": -0.4, "sink_rate": 0.03, "speed": 0.07}, TWO)
    assert isinstance(found, TrimFailure)
    assert found.active == ()
    assert "as many free cells (2) cannot meet 3 conditions" in str(found)
    assert {miss.target for miss in found.missed} == {"pitch", "sink_rate", "speed"}


def test_cells_of_one_side_cannot_glide_straight():
    found = trim_for(load_preset("quad-bellows-glide"), {"glide_angle": DIVE, "speed": 0.3}, FOUR[::2])
    assert isinstance(found, TrimFailure)
    assert "no turn" in str(found)


def top_heavy(height: float) -> Design:
    """The quad glider in even water, its trim ballast raised until the metacentric height is as given, m."""
    made = in_even_water("quad-bellows-glide").model_dump(mode="json")
    ballast = next(part for part in made["vehicle"]["components"] if part["name"] == "Trim ballast")
    balance = mass_balance(parse_design(made).vehicle)
    excess = balance.center_of_mass[2] - balance.center_of_buoyancy[2] - height
    ballast["position"][2] -= excess * balance.mass / ballast["mass"]
    return parse_design(made)


def test_a_wanted_roll_of_zero_is_not_met_upside_down():
    """Newton's method passes the vertical there and comes out beyond it without roll: which is upside down.

    The upright glide that is wanted is unstable with the mass above.
    """
    given_e = {name: 0.0262 if name.startswith("Front") else 0.0282 for name in FOUR}
    targets = {"glide_angle": DIVE, "speed": 0.3, "roll": 0.0, "turn_rate": 0.0}
    trim = trimmed(assemble(top_heavy(-0.75e-3)), targets, FOUR, extensions=given_e)
    assert (trim.roll, abs(trim.pitch) < 1.0, trim.stable) == (pytest.approx(0.0, abs=1e-9), True, False)
    assert "-0.00" not in str(trim)


def test_what_is_missed_is_told_of_the_upright_motion():
    """Roll is within a half turn of what is wanted, and pitch within 90 deg of level, whatever way a search went."""
    found = trim_for(top_heavy(-0.75e-3), {"glide_angle": DIVE, "speed": 2.5, "roll": 3.1, "turn_rate": 0.0}, FOUR)
    assert isinstance(found, TrimFailure) and found.nearest is not None
    told = {miss.target: miss.reached for miss in found.missed}
    assert told["speed"] == pytest.approx(found.nearest.speed, rel=1e-9)
    assert told.get("roll", found.nearest.roll) == pytest.approx(found.nearest.roll, abs=1e-9)


def test_angles_off_by_whole_turns_are_not_off():
    rows = np.zeros(len(ROWS))
    rows[ROWS.index("roll")], rows[ROWS.index("pitch")] = math.pi - 1e-3, 2.0 * math.pi
    wanted = np.zeros(len(ROWS))
    wanted[ROWS.index("roll")] = -math.pi + 1e-3
    off = off_target(rows, wanted)
    assert off[ROWS.index("roll")] == pytest.approx(-2e-3) and off[ROWS.index("pitch")] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("depth", [2.0, 30.0])
@pytest.mark.parametrize(
    "targets",
    [
        {"glide_angle": DIVE}, {"glide_angle": -DIVE}, {"glide_angle": DIVE, "turn_radius": 10.0}, {"pitch": -0.4},
        {"glide_angle": DIVE, "turn_radius": -25.0}, {"roll": 0.2, "turn_radius": 30.0}, {"roll": -0.3},
        {"glide_angle": DIVE, "roll": 0.2}, {"turn_rate": 0.01},
    ],
)  # fmt: skip
def test_a_path_alone_from_nearly_neutral_extensions_is_no_crawl(targets, depth):
    """At either depth the given extensions leave 0.3 N of the 8 N that the cells can do: in layers, to either side."""
    trim = trimmed("quad-bellows-glide", targets, FOUR, depth=depth)
    assert trim.speed > 0.08
    for name, value in targets.items():
        assert getattr(trim, name) == pytest.approx(value, rel=1e-9, abs=1e-9), name


def test_targets_that_imply_a_path_are_not_told_to_contradict_another():
    """Speed, turn rate and radius together leave a path of 78 deg: a failure is in words, of what was given."""
    found = trim_for(load_preset("quad-bellows-glide"), {"speed": 5.0, "turn_rate": 0.01, "turn_radius": 100.0}, FOUR)
    assert isinstance(found, TrimFailure)
    assert {miss.target for miss in found.missed} <= {"speed", "turn_rate", "turn_radius"}


@pytest.mark.parametrize("share", [0.5, 0.3])
def test_extensions_that_drive_it_well_are_kept_as_a_start(share):
    """From a third (or more) of what the cells could add, the nearest trim is the one that is taken."""
    assembly = assemble(in_even_water("quad-bellows-glide"))
    given_e = dict.fromkeys(FOUR, (1.0 - share) * 0.05)
    problem = steady_problem(assembly, extensions=given_e)
    wish = targets_of({"glide_angle": DIVE}, spatial=True)
    free = np.arange(EXTENSIONS, EXTENSIONS + 4)
    assert driven(problem, free, wish) is problem
    crawling = steady_problem(assembly, extensions=dict.fromkeys(FOUR, 0.049))
    moved = driven(crawling, free, wish)
    best = steady_problem(assembly, extensions=dict.fromkeys(FOUR, 0.0)).net_weight
    assert moved.net_weight == pytest.approx(0.5 * best, rel=0.02)


@pytest.mark.parametrize("angle", [0.0, -0.0, -1e-5, 1e-5])
def test_no_negative_zero_is_shown(angle):
    trim = trimmed("quad-bellows-glide", {"glide_angle": DIVE, "speed": 0.3}, FOUR)
    shown = str(replace(trim, roll=angle, pitch=angle))
    assert "roll +0.00 deg" in shown and "-0.00" not in shown
    assert "roll +0 deg in place of +1" in str(Missed("roll", math.radians(1.0), -1e-3 * abs(angle) ** 2))
    assert "0 mm" in str(ActiveBound("A", "lower", -0.0, "m")) and "-0" not in str(ActiveBound("A", "lower", -0.0, "m"))


CONTRADICTIONS: list[tuple[dict[str, float], str]] = [
    ({"speed": 0.2, "sink_rate": 0.3}, "sink_rate"),
    ({"glide_angle": 0.3, "sink_rate": 0.1}, "sink_rate"),
    ({"glide_angle": -0.3, "sink_rate": 0.1, "speed": 0.2}, "sink_rate"),
    ({"turn_rate": 0.01, "turn_radius": -20.0}, "turn_radius"),
    ({"turn_rate": 0.1, "turn_radius": 20.0, "speed": 0.3}, "turn_radius"),
    ({"turn_rate": 0.01, "turn_radius": 20.0, "speed": 0.3, "glide_angle": -0.3}, "turn_radius"),
]


@pytest.mark.parametrize(("targets", "name"), CONTRADICTIONS)
def test_contradictions_are_told(targets, name):
    with pytest.raises(DesignError) as error:
        trim_for(load_preset("quad-bellows-glide"), targets, FOUR)
    (problem,) = error.value.problems
    assert problem.pointer == f"/options/targets/{name}"
    assert "contradicts" in problem.message


@pytest.mark.parametrize(
    ("preset_id", "targets", "free", "pointer"),
    [
        ("canete-dual-bellows", {"lift": 1.0}, TWO, "/options/targets/lift"),
        ("canete-dual-bellows", {}, TWO, "/options/targets"),
        ("canete-dual-bellows", {"speed": -0.1}, TWO, "/options/targets/speed"),
        ("canete-dual-bellows", {"speed": math.nan}, TWO, "/options/targets/speed"),
        ("canete-dual-bellows", {"glide_angle": 2.0}, TWO, "/options/targets/glide_angle"),
        ("canete-dual-bellows", {"turn_rate": 0.01}, TWO, "/options/targets/turn_rate"),
        ("quad-bellows-glide", {"turn_radius": 0.0}, FOUR, "/options/targets/turn_radius"),
        ("canete-dual-bellows", {"speed": 0.1}, ("Front bellows", "Wing"), "/options/free/1"),
        ("canete-dual-bellows", {"speed": 0.1}, ("Front bellows", "Front bellows"), "/options/free/1"),
        ("canete-dual-bellows", {"speed": 0.1}, (), "/options/free"),
    ],
)
def test_misuse_is_told_with_its_place(preset_id, targets, free, pointer):
    with pytest.raises(DesignError) as error:
        trim_for(load_preset(preset_id), targets, free)
    assert [problem.pointer for problem in error.value.problems] == [pointer]


@settings(max_examples=25, deadline=None)
@given(designs(ideal=True), st.floats(-0.9, -0.3), st.floats(0.05, 0.3))
def test_any_design_gets_a_trim_that_meets_its_targets_or_a_failure_in_words(design, path, speed):
    free = [part.name for _, part in design.vehicle.actuated]
    assume(free)
    found = trim_for(design, {"glide_angle": path, "speed": speed}, free)
    if isinstance(found, Trim):
        assert found.glide_angle == pytest.approx(path, abs=1e-9)
        assert found.speed == pytest.approx(speed, abs=1e-9)
    else:
        assert len(str(found)) > 20
        assert found.nearest is None or found.missed
