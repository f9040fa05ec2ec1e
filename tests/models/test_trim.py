"""Trims are fixed points, mirror as designs do, agree with closed forms and long simulations, and say if stable."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.optimize import brentq

from docs import validation_seawing as seawing
from models.assemble import Assembly, assemble
from models.assemble_spatial import emerging_depth
from models.design import Design, parse_design
from models.glide_polar import glide_polar
from models.kernel import steady
from models.linearize import motion_matrix
from models.mass_properties import mass_balance
from models.modes import NEUTRAL
from models.motion_growth import matrix_by_down, matrix_in_plane
from models.presets import load_preset
from models.problems import DesignError
from models.simulate import simulate
from models.steady_problem import steady_problem
from models.still_water import trim_depth
from models.targeted_trim import TrimFailure, trim_for
from models.trim import Trim, design_from, find_trims, motion_of
from models.trim_search import Search
from models.water import surface_density
from tests.models.support import document, polar
from tests.strategies import designs, spatial_designs

DOWN = {"Front bellows": 0.0144, "Rear bellows": 0.0158}
SPIRAL = {
    "Front port cell": 0.048724, "Front starboard cell": 0.00789114,
    "Rear port cell": 0.0614842, "Rear starboard cell": 0.0206514,
}  # fmt: skip
STRAIGHT = {name: 0.0112088 if name.startswith("Front") else 0.0275419 for name in SPIRAL}
OTHER_SIDE = {"port": "starboard", "starboard": "port"}
SWAPPED = {name: SPIRAL[" ".join(OTHER_SIDE.get(word, word) for word in name.split())] for name in SPIRAL}
BATTERY = {"Battery": -0.7}
CASES = {
    "two bellows": ("canete-dual-bellows", DOWN),
    "three cells": (
        "three-cell-glider",
        {"Middle piston": -0.012, "Battery slide": 0.012, "Front bellows": 0.0157, "Rear bellows": 0.0163},
    ),
    "four cells, straight": ("quad-bellows-glide", STRAIGHT),
    "four cells, spiral": ("quad-bellows-glide", SPIRAL),
    "moving masses, spiral": ("movable-mass-twin", {"Buoyancy engine": -0.03, "Battery": 0.012, "Lower ballast": -0.4}),
    "Seawing": ("seawing-spiral", BATTERY),
}


def in_even_water(preset_id: str, **solver: Any) -> Design:
    """A preset in water of one density, nothing compressible and far from surface and bed: motions can be steady."""
    design = load_preset(preset_id)
    made = design.model_dump(mode="json")
    environment = made["mission"]["environment"]
    density = surface_density(design.mission.environment.water)
    environment |= {"water": {"kind": "uniform", "density": density}, "surface": "end", "bed_depth": None}
    made["mission"]["initial"]["position"] = [0.0, 0.0, 500.0]
    made["mission"]["solver"] |= {"tolerance": 1e-12, "output_interval": 1.0, **solver}
    for component in made["vehicle"]["components"]:
        if "bulk_modulus" in component:
            component["bulk_modulus"] = None
    return parse_design(made)


def held(design: Design, trim: Trim, duration: float, **initial: Any) -> Any:
    """Simulate from a trim, perhaps with another initial value."""
    made = design_from(trim, design).model_dump(mode="json")
    made["mission"]["initial"] |= initial
    made["mission"]["duration"] = duration
    return simulate(parse_design(made))


def mirrored(design: Design) -> Design:
    """The design with port for starboard; a mass rolls by the same angle about the mirrored axis, turned round."""
    made = copy.deepcopy(design.model_dump(mode="json"))
    for component in made["vehicle"]["components"]:
        for name in ("position", "center_of_mass", "pivot"):
            if component.get(name):
                component[name][1] *= -1.0
        for name in ("xy", "yz"):
            component["inertia"][name] *= -1.0
        if "axis" in component:
            sign = -1.0 if component["kind"] == "rolling_mass" else 1.0
            x, y, z = component["axis"]
            component["axis"] = [sign * x, -sign * y, sign * z]
    return parse_design(made)


@pytest.mark.parametrize("case", CASES)
def test_a_stable_trim_is_a_fixed_point(case):
    preset_id, extensions = CASES[case]
    design = in_even_water(preset_id)
    (trim,) = find_trims(design, extensions=extensions).stable
    run = held(design, trim, 90.0)
    states = {"theta": trim.pitch, "speed": trim.speed, "alpha": trim.angle_of_attack}
    if run.model == "spatial":
        states |= {"phi": trim.roll, "turn_rate": trim.turn_rate, "beta": trim.sideslip}
    for name, value in states.items():
        assert np.abs(run.values[name] - value).max() <= 1e-6 * max(abs(value), 1e-3), name
    assert run.values["z"][-1] - run.values["z"][0] == pytest.approx(90.0 * trim.sink_rate, rel=1e-6)
    assert (trim.kind == "spiral") == ("spiral" in case or case == "Seawing")


@pytest.mark.parametrize("case", CASES)
def test_an_unstable_trim_is_one_too_but_a_small_disturbance_leaves_it(case):
    preset_id, extensions = CASES[case]
    design = in_even_water(preset_id)
    unstable = [trim for trim in find_trims(design, extensions=extensions).solutions if not trim.stable]
    assert unstable
    for trim in unstable:
        still = held(design, trim, min(3.0 / trim.growth, 20.0), roll=trim.roll)
        assert abs(still.values["speed"] / trim.speed - 1.0).max() < 1e-6
        run = held(design, trim, 20.0 / trim.growth, pitch=trim.pitch + 1e-3)
        v = np.column_stack([run.values[name] for name in ("u", "w")])
        assert np.abs(v - trim.velocity[[0, 2]]).max() > 0.05 * trim.speed


@pytest.mark.parametrize("case", ["two bellows", "four cells, spiral", "Seawing"])
def test_a_stable_trim_is_returned_to_as_fast_as_its_slowest_eigenvalue_says(case):
    preset_id, extensions = CASES[case]
    design = in_even_water(preset_id)
    trim = find_trims(design, extensions=extensions).stable[0]
    time = 6.0 / -trim.growth
    run = held(design, trim, 2.0 * time, pitch=trim.pitch + 0.02)
    off = np.abs(run.values["speed"] / trim.speed - 1.0)
    middle = len(off) // 2
    assert off[-1] < 1e-3 * off.max() < off[1]
    assert off[middle:].max() < 0.05 * off[:middle].max()


def test_the_seawings_spiral_by_trim_is_the_simulated_one():
    final, trim = seawing.spiral().final, find_trims(seawing.spiral_design()).stable[0]
    assert trim.kind == "spiral"
    found = {
        "speed": trim.speed, "theta": trim.pitch, "phi": trim.roll, "turn_rate": trim.turn_rate,
        "turn_radius": trim.turn_radius, "alpha": trim.angle_of_attack, "beta": trim.sideslip,
    }  # fmt: skip
    for name, value in found.items():
        assert value == pytest.approx(final[name], rel=1e-6), name


@pytest.mark.parametrize("case", ["four cells, spiral", "moving masses, spiral", "Seawing"])
def test_a_mirrored_design_makes_the_mirrored_turn(case):
    preset_id, extensions = CASES[case]
    design = load_preset(preset_id)
    found = find_trims(design, extensions=extensions).stable[0]
    image = find_trims(mirrored(design), extensions=extensions).stable[0]
    assert image.turn_rate == pytest.approx(-found.turn_rate, rel=1e-9)
    assert image.roll == pytest.approx(-found.roll, rel=1e-9)
    assert image.velocity == pytest.approx(found.velocity * [1.0, -1.0, 1.0], rel=1e-8)
    assert image.turn_radius == pytest.approx(-found.turn_radius, rel=1e-9)


def test_cells_swapped_from_side_to_side_turn_the_other_way():
    design = load_preset("quad-bellows-glide")
    right, left = (find_trims(design, extensions=e).stable[0] for e in (SPIRAL, SWAPPED))
    assert right.turn_radius > 0.0
    assert left.turn_radius == pytest.approx(-right.turn_radius, rel=1e-9)


def test_a_straight_glide_of_a_symmetric_design_has_no_roll_at_all():
    trim = find_trims(load_preset("quad-bellows-glide"), extensions=STRAIGHT).stable[0]
    assert (trim.roll, trim.sideslip, trim.turn_rate, trim.turn_radius, trim.kind) == (0.0, 0.0, 0.0, None, "glide")


@pytest.mark.parametrize("model", ["planar", "spatial"])
def test_without_lift_it_sinks_at_the_root_of_weight_over_drag(model):
    drag = 2.0
    made = document(solver={"model": model})
    made["vehicle"]["hydrodynamics"] = polar(row_lift=[0.0] * 10, row_drag=[drag] * 10, row_moment=[0.0] * 10)
    if model == "spatial":  # nothing else resists there
        made["vehicle"]["damping"] |= {"sway": 0.5, "roll": 0.02, "yaw": 0.02}
    design = parse_design(made)
    e = -0.004
    found = find_trims(design, extensions={"Piston": e}).stable
    balance = mass_balance(design.vehicle, {"Piston": e})
    weight = -balance.net_buoyancy(1000.0, 9.8)
    assert weight > 0.0
    assert len(found) == 1
    assert found[0].speed == pytest.approx(math.sqrt(weight / drag), rel=1e-10)
    assert found[0].glide_angle == pytest.approx(-0.5 * math.pi, abs=1e-6)
    assert found[0].net_buoyancy == pytest.approx(-weight, rel=1e-10)
    across = balance.mass * balance.center_of_mass - 1000.0 * balance.volume * balance.center_of_buoyancy
    assert math.tan(found[0].pitch) == pytest.approx(-across[0] / across[2], rel=1e-9)


def closed_form(
    assembly: Assembly, extensions: dict[str, float], low: float, high: float
) -> tuple[float, float, float]:
    """Angle of attack, path angle and speed of a dive from the curves of lift, drag and moment (no added mass)."""
    design, law = assembly.design, assembly.law
    assert law is not None
    balance = mass_balance(design.vehicle, extensions)
    weight = -balance.net_buoyancy(1000.0, 9.8)
    across = 9.8 * (balance.mass * balance.center_of_mass - 1000.0 * balance.volume * balance.center_of_buoyancy)

    def glide(alpha: float) -> tuple[float, float, float]:
        lift, drag, moment = law(alpha)
        path, squared = -math.atan2(drag, lift), weight / math.hypot(lift, drag)
        pitch = path + alpha
        return path, math.sqrt(squared), moment * squared - across[0] * math.cos(pitch) - across[2] * math.sin(pitch)

    alpha = float(brentq(lambda a: glide(a)[2], low, high, xtol=1e-15))
    return alpha, *glide(alpha)[:2]


def test_a_straight_glide_is_that_of_the_curves_of_lift_drag_and_moment():
    assembly = assemble(load_preset("canete-dual-bellows"))
    trim = find_trims(assembly, extensions=DOWN).stable[0]
    alpha, path, speed = closed_form(assembly, DOWN, 1e-4, 0.1)
    assert trim.angle_of_attack == pytest.approx(alpha, rel=1e-9)
    assert trim.glide_angle == pytest.approx(path, rel=1e-9)
    assert trim.speed == pytest.approx(speed, rel=1e-9)
    assert trim.pitch == pytest.approx(path + alpha, rel=1e-9)
    assert trim.glide_ratio == pytest.approx(1.0 / math.tan(-path), rel=1e-9)


@pytest.mark.parametrize(("preset_id", "pitch"), [("canete-dual-bellows", 0.0), ("quad-bellows-glide", 0.0)])
def test_a_neutral_glider_has_no_glide_but_an_attitude_of_rest(preset_id, pitch):
    design = in_even_water(preset_id)
    made = design.model_dump(mode="json")
    neutral = {c.name: c.neutral for _, c in design.vehicle.actuated}
    displaced = mass_balance(design.vehicle, neutral).volume
    mass = mass_balance(design.vehicle, neutral).mass
    made["mission"]["environment"]["water"]["density"] = mass / displaced
    found = find_trims(parse_design(made), extensions=neutral)
    assert found.solutions == ()
    assert "no steady glide" in found.searched
    assert found.rest is not None
    assert found.rest.pitch == pytest.approx(pitch, abs=1e-3)
    assert found.rest.stiffness > 0.0


@pytest.mark.parametrize("case", ["two bellows", "four cells, spiral", "Seawing"])
def test_growth_is_the_same_with_and_without_euler_angles(case):
    """The matrices for attitudes that Euler angles do not reach have the spectrum of the one for those that they do."""
    preset_id, extensions = CASES[case]
    assembly = assemble(load_preset(preset_id))
    problem = steady_problem(assembly, extensions=extensions)
    s = motion_of(find_trims(assembly, extensions=extensions).stable[0])
    y = np.zeros(len(assembly.initial_state))
    steady.write_steady(s, problem.depth, y, problem.params)
    _names, A = motion_matrix(assembly, problem.params, y)
    other = matrix_by_down(problem.params, y) if problem.spatial else matrix_in_plane(problem.params, y)
    spectra = [np.sort_complex(np.linalg.eigvals(matrix)) for matrix in (A, other)]
    assert spectra[0] == pytest.approx(spectra[1], rel=1e-5, abs=1e-7)


def test_what_rounding_cannot_tell_from_neutral_is_not_stable():
    trim = find_trims(load_preset("seawing-spiral")).stable[0]
    assert not replace(trim, growth=-0.5 * NEUTRAL).stable
    assert replace(trim, growth=-2.0 * NEUTRAL).stable


@pytest.mark.parametrize("preset_id", ["quad-bellows-yo-yo", "quad-bellows-glide", "seawing-spiral"])
def test_by_default_a_trim_is_deep_enough_for_all_parts_to_be_immersed(preset_id):
    design = load_preset(preset_id)
    depth = trim_depth(design)
    assert depth >= max(design.mission.initial.position[2], emerging_depth(design))
    reach = max(math.hypot(*c.position) for c in design.vehicle.components)
    assert depth - reach >= emerging_depth(design) - 1e-12
    assert trim_depth(design, depth) == depth


def test_a_bed_above_which_no_part_would_be_immersed_is_refused():
    made = load_preset("quad-bellows-yo-yo").model_dump(mode="json")
    made["mission"]["environment"]["bed_depth"] = 0.5
    with pytest.raises(DesignError, match="leaves no depth"):
        trim_depth(parse_design(made))


def test_without_gravity_nothing_glides():
    made = load_preset("canete-dual-bellows").model_dump(mode="json")
    made["mission"]["environment"]["gravity"] = 0.0
    design = parse_design(made)
    assert find_trims(design, extensions=DOWN).solutions == ()
    assert isinstance(trim_for(design, {"speed": 0.1}, tuple(DOWN)), TrimFailure)
    assert glide_polar(design, points=5).points == ()


def test_extensions_are_by_default_those_with_which_the_mission_starts():
    made = load_preset("canete-dual-bellows").model_dump(mode="json")
    made["mission"]["initial"]["extensions"] = DOWN
    by_mission, given = find_trims(parse_design(made)), find_trims(load_preset("canete-dual-bellows"), extensions=DOWN)
    assert [t.speed for t in by_mission.solutions] == [t.speed for t in given.solutions]


def test_a_uniform_current_changes_nothing():
    design = in_even_water("quad-bellows-glide")
    made = design.model_dump(mode="json")
    made["mission"]["environment"]["current"] = {"kind": "uniform", "velocity": [0.3, -0.2]}
    still, carried = (find_trims(d, extensions=SPIRAL).stable[0] for d in (design, parse_design(made)))
    assert carried.velocity == pytest.approx(still.velocity, rel=1e-12)
    assert carried.growth == pytest.approx(still.growth, rel=1e-6)


@pytest.mark.parametrize(
    ("preset_id", "options", "pointer"),
    [
        ("canete-dual-bellows", {"extensions": {"Wing": 0.0}}, "/options/extensions/Wing"),
        ("canete-dual-bellows", {"extensions": {"Front bellows": 0.05}}, "/options/extensions/Front bellows"),
        ("quad-bellows-glide", {"depth": 0.01}, "/options/depth"),
        ("quad-bellows-glide", {"depth": 120.0}, "/options/depth"),
        ("canete-dual-bellows", {"depth": -1.0}, "/options/depth"),
        ("canete-dual-bellows", {"depth": math.nan}, "/options/depth"),
    ],
)
def test_misuse_is_told_with_its_place(preset_id, options, pointer):
    with pytest.raises(DesignError) as error:
        find_trims(load_preset(preset_id), **options)
    assert [problem.pointer for problem in error.value.problems] == [pointer]


@pytest.mark.parametrize(
    ("options", "pointer"), [({"angle_step": 0.0}, "angle_step"), ({"banks": (0.1, 2.0)}, "banks/1")]
)
def test_a_search_has_bounds(options, pointer):
    with pytest.raises(DesignError) as error:
        Search(**options)
    assert error.value.problems[0].pointer == f"/options/search/{pointer}"


def assert_balanced(design: Design) -> None:
    assembly = assemble(design)
    weight = mass_balance(design.vehicle).mass * float(assembly.params.space[0]["gravity"])
    size = max(0.05, *(math.hypot(*c.position) for c in design.vehicle.components))
    for trim in find_trims(assembly).solutions:
        assert max(abs(trim.residual[axis]) for axis in "XYZ") <= 1e-11 * weight
        assert max(abs(trim.residual[axis]) for axis in "KMN") <= 1e-11 * weight * size
        assert trim.speed > 0.0
        assert math.isfinite(trim.growth)
        assert abs(trim.sink_rate) <= trim.speed * (1.0 + 1e-12)
        assert -math.sin(trim.glide_angle) * trim.speed == pytest.approx(trim.sink_rate, abs=1e-9 * trim.speed)


@settings(max_examples=40, deadline=None)
@given(designs(ideal=True))
def test_every_trim_of_any_planar_design_is_balanced(design):
    assert_balanced(design)


@settings(max_examples=40, deadline=None)
@given(spatial_designs())
def test_every_trim_of_any_spatial_design_is_balanced(design):
    assert_balanced(design)
