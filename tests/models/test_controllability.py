"""Controllability: known systems, layouts that lack an axis, and mirrored ones."""

from __future__ import annotations

import json

import numpy as np
import pytest

from models.controllability import controllability, holding_power
from models.design import parse_design
from models.linear_model import LinearModel, Signal
from models.linearize import linearize
from models.operating_point import OperatingPoint, point_of
from models.presets import load_preset
from models.trim import find_trims
from tests.models.test_spatial_truths import changed, mirrored


def system(A, B, states=None):
    """A linear model of bare matrices."""
    n, m = B.shape
    names = states or tuple("uvwpqr"[:n])
    signals = tuple(Signal(name, "1", "", 0.0) for name in names)
    inputs = tuple(Signal(f"command of {k}", "m", "", 0.0) for k in range(m))
    return LinearModel("spatial", OperatingPoint(), signals, inputs, signals, A, B, np.eye(n), np.zeros((n, m)),
                       np.zeros(n), ())  # fmt: skip


def test_a_mode_without_an_input_is_found():
    A, B = np.diag([-1.0, -2.0, -3.0]), np.array([[1.0], [0.0], [1.0]])
    found = controllability(system(A, B))
    assert found.unmoved == ("sway subsidence",) and found.rank == 2
    assert str(found) == "no cell moves sway subsidence: 2 of 3 states can be reached"
    by_name = {each.mode.name: each for each in found.modes}
    assert by_name["surge"].cosines.tolist() == pytest.approx([2**-0.5])
    assert by_name["sway subsidence"].cosines.tolist() == [0.0]


def test_the_rank_is_that_of_kalmans_matrix():
    random = np.random.default_rng(11)
    for lost in (0, 1, 2):
        T = random.normal(size=(5, 5))
        A, B = np.diag([-0.5, -1.0, -1.7, -2.4, -3.1]), random.normal(size=(5, 2))
        B[:lost] = 0.0
        model = system(T @ A @ np.linalg.inv(T), T @ B)
        kalman = np.hstack([np.linalg.matrix_power(model.A, k) @ model.B for k in range(5)])
        assert np.linalg.matrix_rank(kalman, tol=1e-8) == 5 - lost == controllability(model).rank


def test_of_an_eigenvalue_met_twice_only_what_is_lost_is_told():
    A, B = np.zeros((2, 2)), np.array([[1.0], [0.0]])
    found = controllability(system(A, B, ("z", "psi")))
    assert found.unmoved == ("heading",) and found.rank == 1


def test_the_distance_is_how_far_a_system_is_from_one_that_cannot_be_moved():
    A, B = np.diag([-1.0, -2.0]), np.array([[1e-3], [1.0]])
    found = controllability(system(A, B))
    surge = next(each for each in found.modes if each.mode.name == "surge")
    assert surge.movable and surge.distance < 1e-3


def test_four_cells_hold_heave_pitch_and_roll_apart():
    power = holding_power(load_preset("quad-bellows-spiral"))
    assert power.authority.holds == ("heave", "pitch", "roll") and power.authority.rank == 3
    assert str(power) == "heave, pitch and roll can each be held apart from the others"


@pytest.mark.parametrize("preset_id", ["canete-dual-bellows", "three-cell-glider"])
def test_cells_along_the_hull_cannot_hold_roll(preset_id):
    power = holding_power(load_preset(preset_id))
    assert "roll" not in power.authority.holds and power.authority.rank == 2
    assert "roll cannot be held apart" in str(power)


def test_of_the_four_two_rear_cells_cannot_hold_heave_and_pitch_apart():
    power = holding_power(load_preset("quad-bellows-spiral"), ["Rear port cell", "Rear starboard cell"])
    assert power.authority.holds == ("roll",)


def settled_point(design, **extensions):
    ends = {s.cell: s.points[-1].extension for s in design.mission.control.schedules}
    return point_of(find_trims(design, extensions=ends | extensions).stable[0])


@pytest.fixture(scope="module")
def two_cells_in_space():
    design = changed(load_preset("canete-dual-bellows"), solver={"model": "spatial"})
    glide = OperatingPoint(depth=1.0, pitch=-0.4, velocity=(0.1, 0.0, 0.005))
    return linearize(design, glide)


def test_cells_along_the_hull_move_no_lateral_mode(two_cells_in_space):
    model = two_cells_in_space
    found = controllability(model, [0.01] * len(model.inputs))
    lateral = [model.state_names.index(name) for name in ("phi", "psi", "v", "p", "r")]
    for each in found.modes:
        assert each.movable == (each.mode.shares[lateral].sum() < 0.5), each.mode.name
    assert found.rank == len(model.states) - 5


def test_four_cells_move_every_mode():
    design = load_preset("quad-bellows-glide")
    found = controllability(linearize(design, settled_point(design)))
    assert found.unmoved == () and found.rank == 14
    assert str(found) == "the cells can move every mode (14 of 14 states)"
    json.dumps(found.as_dict(), allow_nan=False)
    json.dumps(holding_power(design).as_dict(), allow_nan=False)


def test_a_mirrored_layout_moves_the_same_modes_with_the_other_side():
    design = load_preset("quad-bellows-spiral")
    other = mirrored(parse_design(design.model_dump(mode="json") | {"name": "Mirrored"}))
    point = OperatingPoint(
        depth=2.0, roll=0.1, pitch=-0.3, velocity=(0.2, 0.03, 0.01), angular_velocity=(0.01, 0.0, 0.04)
    )
    image = OperatingPoint(
        depth=2.0, roll=-0.1, pitch=-0.3, velocity=(0.2, -0.03, 0.01), angular_velocity=(-0.01, 0.0, -0.04)
    )
    models = linearize(design, point), linearize(other, image)
    sign = np.array([-1.0 if name in ("phi", "psi", "v", "p", "r") else 1.0 for name in models[0].state_names])
    np.testing.assert_allclose(sign[:, None] * models[1].A * sign, models[0].A, atol=2e-7)
    np.testing.assert_allclose(sign[:, None] * models[1].B, models[0].B, atol=2e-6)
    mine, its = (controllability(model) for model in models)
    for a, b in zip(mine.modes, its.modes, strict=True):
        assert a.mode.eigenvalue == pytest.approx(b.mode.eigenvalue, abs=1e-6)
        assert a.distance == pytest.approx(b.distance, rel=1e-4)
