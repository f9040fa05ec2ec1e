"""Modes: counted and named, their numbers by closed forms, and shares that add up."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.linalg import block_diag

from models.linearize import linearize
from models.modes import Mode, modes_of, name_of
from models.operating_point import OperatingPoint, point_of
from models.presets import load_preset
from models.simulate import simulate
from models.trim import find_trims
from tests.models.linear_support import GRAVITY, INERTIA, MASS, REST, resting_design

LONGITUDINAL = ("z", "theta", "u", "w", "q")


def oscillator(omega, zeta):
    return np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])


def test_a_block_diagonal_system_is_named_and_counted():
    states = ("theta", "q", "phi", "p", "z", "psi", "u", "w", "v", "r", "extension of Bow", "extension of Stern")
    matrix = block_diag(oscillator(2.0, 0.1), oscillator(3.0, -0.2), 0.0, 0.0, -0.1, -0.7, -0.5, -0.6, -4.0, -5.0)
    modes = modes_of(matrix, states)
    assert sorted(mode.name for mode in modes.modes) == sorted([
        "pitch oscillation", "roll oscillation", "depth", "heading", "surge", "heave subsidence", "sway subsidence",
        "yaw subsidence", "actuator lag of 'Bow'", "actuator lag of 'Stern'",
    ])  # fmt: skip
    (pitch,) = modes.named("pitch oscillation")
    assert pitch.damping_ratio == pytest.approx(0.1)
    assert pitch.period == pytest.approx(2.0 * math.pi / (2.0 * math.sqrt(1.0 - 0.01)))
    assert pitch.time_constant == pytest.approx(1.0 / 0.2)
    assert pitch.time_to_half == pytest.approx(math.log(2.0) / 0.2) and pitch.time_to_double is None
    (roll,) = modes.named("roll oscillation")
    assert roll.time_to_double == pytest.approx(math.log(2.0) / 0.6) and roll.time_to_half is None
    assert modes.leading == roll and modes.growth == pytest.approx(0.6) and not modes.stable
    (depth,) = modes.named("depth")
    assert depth.period is depth.damping_ratio is depth.time_constant is None


@pytest.mark.parametrize(
    ("states", "name"),
    [(("u", "theta"), "phugoid"), (("w", "q"), "short period"), (("z", "w"), "bobbing"), (("v", "r"), "dutch roll"),
     (("phi", "p"), "roll oscillation"), (("phi", "v"), "roll-sway oscillation"), (("phi", "r"), "lateral phugoid")],
)  # fmt: skip
def test_oscillations_are_named_by_the_two_states_that_take_part(states, name):
    (mode,) = modes_of(oscillator(1.0, 0.2), states).modes
    assert mode.name == name


def test_single_states_give_their_names():
    assert name_of(np.array([0.2, 0.8]), ("phi", "p"), False) == "roll subsidence"
    assert name_of(np.array([0.8, 0.2]), ("phi", "p"), False) == "spiral"
    assert name_of(np.array([0.3, 0.7]), ("u", "extension of Bow"), False) == "actuator lag of 'Bow'"


def test_shares_of_a_mode_add_up_and_do_not_hang_on_units():
    random = np.random.default_rng(3)
    for _ in range(20):
        A = random.normal(size=(5, 5))
        scale = 10.0 ** random.uniform(-3, 3, 5)
        modes, scaled = modes_of(A, LONGITUDINAL), modes_of(A * scale / scale[:, None], LONGITUDINAL)
        np.testing.assert_allclose(modes.participation.sum(axis=0), 1.0, rtol=1e-12)
        np.testing.assert_allclose(scaled.participation, modes.participation, atol=1e-9)
        assert sum(1 + mode.oscillates for mode in modes.modes) == 5
        for mode in modes.modes:  # each is an eigenvector, its largest entry 1
            np.testing.assert_allclose(A @ mode.eigenvector, mode.eigenvalue * mode.eigenvector, atol=1e-12)
            assert np.abs(mode.eigenvector).max() == pytest.approx(1.0)


def test_modes_with_one_name_are_numbered():
    modes = modes_of(np.diag([-1.0, -2.0]) + np.array([[0.0, 0.1], [0.1, 0.0]]), ("other", "other2"))
    assert [mode.name for mode in modes.modes] == ["other", "other2"]
    repeated = modes_of(np.diag([-1.0, -2.0]), ("u", "extension of A"))
    assert len(repeated.named("surge")) == 1
    both = modes_of(block_diag(oscillator(1.0, 0.1), oscillator(2.0, 0.1)), ("theta", "q", "theta2", "q2"))
    assert len({mode.name for mode in both.modes}) == 2


def test_a_pendulum_at_rest_swings_in_roll_and_pitch():
    model = linearize(resting_design(added={3: 0.002}), REST)
    modes = modes_of(model.A, model.state_names)
    (roll,), (pitch,) = modes.named("roll oscillation"), modes.named("pitch oscillation")
    for mode, inertia in ((roll, INERTIA["xx"] + 0.002), (pitch, INERTIA["yy"])):
        assert mode.eigenvalue.imag == pytest.approx(math.sqrt(MASS * GRAVITY * 0.004 / inertia), rel=1e-6)
    at = model.state_names.index
    assert roll.shares[at("phi")] == pytest.approx(0.5, abs=1e-3)
    assert roll.shares[at("p")] == pytest.approx(0.5, abs=1e-3)


def test_upside_down_it_grows():
    model = linearize(resting_design(below=-0.004), REST)
    modes = modes_of(model.A, model.state_names)
    assert modes.growth == pytest.approx(math.sqrt(MASS * GRAVITY * 0.004 / INERTIA["xx"]), rel=1e-6)
    assert not modes.stable


def test_the_seawings_spiral_has_its_modes():
    design = load_preset("seawing-spiral")
    model = linearize(design, point_of(find_trims(design).stable[0]))
    modes = modes_of(model.A, model.state_names)
    assert {mode.name for mode in modes.modes} == {
        "heading", "depth", "phugoid", "roll-sway oscillation", "pitch subsidence", "heave subsidence",
        "yaw subsidence", "roll subsidence",
    }  # fmt: skip
    assert modes.stable and modes.leading.name == "phugoid"


def test_growth_is_what_a_run_shows():
    """The slowest mode of the Slocum's glide is its surge: a small start dies out with that time constant."""
    design = load_preset("slocum-glide")
    trim = find_trims(design).stable[0]
    model = linearize(design, point_of(trim))
    leading = modes_of(model.A, model.state_names).leading
    document = design.model_dump(mode="json")
    initial = document["mission"]["initial"]
    initial |= {"pitch": trim.pitch, "velocity": [trim.velocity[0] * 1.01, 0.0, trim.velocity[2]]}
    document["mission"]["solver"]["tolerance"] = 1e-11
    run = simulate(type(design).model_validate(document))
    off = np.abs(run.values["u"] - trim.velocity[0])
    a, b = np.searchsorted(run.times, [100.0, 200.0])
    assert math.log(off[b] / off[a]) / (run.times[b] - run.times[a]) == pytest.approx(leading.growth, rel=1e-2)


def test_modes_can_be_sent():
    model = linearize(load_preset("three-cell-glider"), OperatingPoint(depth=1.0, velocity=(0.2, 0.0, 0.01)))
    modes = modes_of(model.A, model.state_names)
    sent = json.loads(json.dumps(modes.as_dict(), allow_nan=False))
    assert len(sent["modes"]) == len(modes.modes)
    assert all(len(mode["shares"]) == len(sent["states"]) for mode in sent["modes"])
    assert isinstance(modes.modes[0], Mode)
