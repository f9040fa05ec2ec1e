"""A polar's points are the trims of the curves of lift and drag; its best points are the best by other searches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.optimize import minimize_scalar

from models.assemble import Assembly, assemble
from models.design import parse_design
from models.energy import energy_bill
from models.glide_polar import GLIDING, GlidePolar, PolarCurve, glide_polar, polar_curve
from models.mass_properties import mass_balance
from models.presets import load_preset
from models.problems import DesignError
from models.simulate import simulate
from models.trim import design_from, find_trims
from tests.models.test_trim import in_even_water
from tests.strategies import designs

HEAVE = -0.15


@pytest.fixture(scope="module")
def canete() -> Assembly:
    return assemble(load_preset("canete-dual-bellows"))


@pytest.fixture(scope="module")
def curve(canete) -> PolarCurve:
    return polar_curve(canete, HEAVE)


@pytest.fixture(scope="module")
def quad() -> GlidePolar:
    return glide_polar(in_even_water("quad-bellows-glide"), points=30, cycle_depth=150.0)


def test_every_point_is_the_glide_of_lift_and_drag_at_its_angle_of_attack(canete, curve):
    """Tan gamma = -D / L and V^2 = W / sqrt(L^2 + D^2), by the law of the angle of attack alone."""
    weight = -(mass_balance(canete.design.vehicle).net_buoyancy(1000.0, 9.8) + HEAVE)
    assert len(curve.points) >= 40
    for trim in curve.points:
        lift, drag, _moment = canete.law(trim.angle_of_attack)
        assert trim.net_buoyancy == pytest.approx(-weight, rel=1e-5)  # allocation weighs effort by 1e-6
        assert trim.glide_angle == pytest.approx(-math.atan2(drag, lift), abs=1e-8)
        assert trim.speed == pytest.approx(math.sqrt(-trim.net_buoyancy / math.hypot(lift, drag)), rel=1e-8)


def test_points_that_have_no_solution_are_counted(curve):
    assert len(curve.points) == len(curve.moments)
    assert len(curve.points) + sum(curve.left_out.values()) == 50


def test_each_point_is_among_the_trims_of_its_extensions(canete, curve):
    for trim in curve.points[::9]:
        again = find_trims(canete, extensions=trim.extensions).solutions
        assert min(np.abs(other.velocity - trim.velocity).max() for other in again) < 1e-7


def test_squared_speed_is_proportional_to_the_net_weight(canete):
    """Where forces go with squared speed, a polar keeps its shape."""
    light, heavy = (polar_curve(canete, heave, points=200) for heave in (-0.1, -0.3))
    a, b = ({round(t.angle_of_attack, 3): t for t in c.points} for c in (light, heavy))
    ratios = [
        (np.interp(t.angle_of_attack, *_by_attack(light)) / t.speed) ** 2
        for t in heavy.points
        if t.angle_of_attack < 0.15
    ]
    assert len(a) > 100 < len(b)
    assert np.array(ratios) == pytest.approx(1.0 / 3.0, rel=2e-3)  # by interpolation between the points


def _by_attack(curve: PolarCurve) -> tuple[list[float], list[float]]:
    return [t.angle_of_attack for t in curve.points], [t.speed for t in curve.points]


def test_the_best_range_is_the_best_ratio_of_lift_to_drag(canete):
    def path(alpha: float) -> float:
        lift, drag, _moment = canete.law(alpha)
        return math.atan2(drag, lift)

    found = glide_polar(canete, points=200).best_range
    best = minimize_scalar(path, bounds=(0.01, 0.4), method="bounded").fun
    assert found is not None
    assert found.stable
    # a stable one within the strokes cannot be flatter, and need not be as flat
    assert best - 1e-9 <= abs(found.glide_angle)
    whole = min(abs(t.glide_angle) for t in glide_polar(canete, points=200).points)
    assert whole == pytest.approx(best, rel=2e-3)


def test_best_points_are_the_best_of_the_stable_points(quad):
    stable = [trim for trim in quad.points if trim.stable]
    assert abs(quad.best_range.glide_angle) == min(abs(t.glide_angle) for t in stable)
    assert quad.slowest_sink.sink_rate == min(t.sink_rate for t in stable if t.sink_rate > 0.0)
    assert quad.best_range.roll == 0.0


def test_energy_per_kilometre_is_the_stated_formula(quad):
    design = in_even_water("quad-bellows-glide")
    density, gravity, depth = design.mission.environment.water.density, 9.8, 150.0
    efficiency = next(part.efficiency for _, part in design.vehicle.actuated)
    gravity = float(assemble(design).params.space[0]["gravity"])

    def per_km(trim):
        way = 2.0 * depth / math.tan(abs(trim.glide_angle))
        pump = density * gravity * depth * 2.0 * abs(trim.net_buoyancy) / (density * gravity) / efficiency
        return 1e3 * (design.vehicle.hotel_power / (trim.speed * math.cos(trim.glide_angle)) + pump / way)

    best = quad.best_energy
    assert best.per_km == pytest.approx(per_km(best.trim), rel=1e-9)
    assert best.per_km == pytest.approx(min(per_km(t) for t in quad.points if t.stable), rel=1e-9)
    assert "150 m" in quad.energy


def test_the_hotel_share_is_what_a_simulated_glide_is_billed(quad):
    design = in_even_water("quad-bellows-glide")
    made = design_from(quad.best_energy.trim, design)
    made = made.model_copy(update={"mission": made.mission.model_copy(update={"duration": 200.0})})
    bill = energy_bill(simulate(made))
    assert bill is not None
    assert bill.whole.per_km == pytest.approx(quad.best_energy.hotel, rel=1e-6)


def test_the_tightest_turn_turns_with_a_cell_at_a_stop_or_the_roll_used_up(quad):
    turn = quad.tightest_turn
    assert turn is not None
    assert turn.kind == "spiral"
    design = in_even_water("quad-bellows-glide")
    at_stop = [
        part.name for _, part in design.vehicle.actuated
        if min(abs(turn.extensions[part.name] - stop) for stop in part.stroke) < 1e-6
    ]  # fmt: skip
    assert at_stop
    run = simulate(design_from(turn, design).model_copy())
    assert run.values["turn_radius"][5] == pytest.approx(abs(turn.turn_radius), rel=1e-6)
    assert abs(turn.angle_of_attack) <= GLIDING


def test_the_seawing_turns_tightest_with_its_battery_at_the_stop():
    polar = glide_polar(load_preset("seawing-spiral"))
    assert polar.tightest_turn is not None
    assert abs(polar.tightest_turn.extensions["Battery"]) == pytest.approx(0.5 * math.pi, rel=1e-6)
    assert [len(curve.points) for curve in polar.curves] == [1]  # its battery rolls only: one pitching moment


def test_without_net_weight_every_point_is_left_out_and_told_why(canete):
    found = polar_curve(canete, 0.0, points=9)
    assert found.points == ()
    assert found.left_out == {"the glider weighs what it displaces: nothing drives a glide": 9}


def test_where_all_sink_upright_none_is_the_cheapest():
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    rear = document["vehicle"]["components"][2]
    document["vehicle"]["mass_properties"] = {"kind": "composite"}
    rear["mass"] /= 10.0
    rear["extension_range"] = [0.0, rear["extension_range"][1]]
    polar = glide_polar(parse_design(document), points=3)
    assert polar.points and all(trim.horizontal_speed < 1e-9 for trim in polar.points)
    assert polar.best_energy is None and polar.best_range is not None


def test_a_planar_design_has_no_turn(canete):
    polar = glide_polar(canete, points=10)
    assert polar.tightest_turn is None
    assert len(polar.curves) == 8
    assert {math.copysign(1.0, c.heave) for c in polar.curves} == {-1.0, 1.0}
    for c in polar.curves:
        assert all(math.copysign(1.0, trim.net_buoyancy) == math.copysign(1.0, c.heave) for trim in c.points)


def test_chosen_cells_leave_the_others_where_they_are():
    design = load_preset("three-cell-glider")
    found = polar_curve(design, -0.15, cells=("Middle piston", "Battery slide"), extensions={"Front bellows": 0.017})
    assert found.points
    assert {trim.extensions["Front bellows"] for trim in found.points} == {0.017}
    assert {trim.extensions["Rear bellows"] for trim in found.points} == {0.016}


@pytest.mark.parametrize(
    ("options", "pointer"),
    [
        ({"points": 1}, "/options/points"),
        ({"cells": ("Wing",)}, "/options/cells/0"),
        ({"cells": ("Front bellows", "Front bellows")}, "/options/cells/1"),
        ({"cycle_depth": 0.0}, "/options/cycle_depth"),
        ({"levels": (0.5, 1.5)}, "/options/levels/1"),
        ({"extensions": {"Wing": 0.0}}, "/options/extensions/Wing"),
        ({"depth": -1.0}, "/options/depth"),
    ],
)
def test_misuse_is_told_with_its_place(canete, options, pointer):
    with pytest.raises(DesignError) as error:
        glide_polar(canete, **options)
    assert [problem.pointer for problem in error.value.problems] == [pointer]


@settings(max_examples=15, deadline=None)
@given(designs(ideal=True))
def test_any_design_has_a_polar_of_balanced_points(design):
    assembly = assemble(design)
    polar = glide_polar(assembly, points=8, levels=(0.5, 1.0))
    weight = mass_balance(design.vehicle).mass * float(assembly.params.space[0]["gravity"])
    for curve in polar.curves:
        assert len(curve.points) + sum(curve.left_out.values()) == 8
        for trim in curve.points:
            assert max(map(abs, trim.residual.values())) <= 1e-10 * weight
