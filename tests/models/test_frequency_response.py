"""Frequency responses: beside python-control's, and at rest beside the gain."""

from __future__ import annotations

import json
import math

import control
import numpy as np
import pytest

from models.frequency_response import dc_gain, frequency_response, spanning
from models.linearize import linearize
from models.modes import modes_of
from models.operating_point import point_of
from models.presets import load_preset
from models.problems import DesignError
from models.trim import find_trims


@pytest.fixture(scope="module")
def model():
    design = load_preset("three-cell-glider")
    ends = {s.cell: s.points[-1].extension for s in design.mission.control.schedules}
    return linearize(design, point_of(find_trims(design, extensions=ends).stable[0]))


@pytest.mark.parametrize("output", ["theta", "speed", "alpha", "z", "lift", "extension of Rear bellows"])
def test_it_is_that_of_python_control(model, output):
    system = control.ss(model.A, model.B, model.C, model.D)
    omega = np.logspace(-2, 2, 40)
    for name in model.input_names:
        mine = frequency_response(model, input=name, output=output, frequencies=omega)
        other = system(1j * omega)[model.output_names.index(output), model.input_names.index(name)]
        np.testing.assert_allclose(mine.response, other, rtol=1e-9, atol=1e-12)


def test_at_low_frequency_it_is_the_gain(model):
    for name in model.input_names:
        for output in ("theta", "speed", "alpha", "z_dot", "net_buoyancy"):
            found = frequency_response(model, input=name, output=output, frequencies=np.array([1e-6]))
            assert found.response[0].real == pytest.approx(found.dc_gain, rel=1e-6, abs=1e-9)


def test_the_gain_is_that_of_the_neighbouring_trim(model):
    """A trim at a slightly longer cell lies where the gain says."""
    design = load_preset("three-cell-glider")
    ends = {s.cell: s.points[-1].extension for s in design.mission.control.schedules}
    steps = [find_trims(design, extensions=ends | {"Front bellows": ends["Front bellows"] + h}) for h in (1e-5, -1e-5)]
    slope = (steps[0].stable[0].pitch - steps[1].stable[0].pitch) / 2e-5
    found = frequency_response(model, input="command of Front bellows", output="theta")
    assert found.dc_gain == pytest.approx(slope, rel=1e-3)
    assert found.unit == "rad per m"


def test_depth_runs_away_under_a_constant_command(model):
    assert frequency_response(model, input="command of Middle piston", output="z").dc_gain is None


def test_a_second_order_system_by_its_formula():
    omega0, zeta = 2.0, 0.3
    A = np.array([[0.0, 1.0], [-(omega0**2), -2 * zeta * omega0]])
    assert dc_gain(A, np.array([0.0, omega0**2]), np.array([1.0, 0.0]), 0.0) == pytest.approx(1.0)
    assert spanning(A)[[0, -1]] == pytest.approx([0.2, 20.0])
    # a state that nothing feels takes no part, even where it runs away
    whole = np.zeros((3, 3))
    whole[:2, :2], whole[2, 0] = A, 1.0
    assert dc_gain(whole, np.array([0.0, omega0**2, 0.0]), np.array([1.0, 0.0, 0.0]), 0.0) == pytest.approx(1.0)


def test_frequencies_of_its_own_span_the_modes_and_the_phase_has_no_jumps(model):
    found = frequency_response(model, input="command of Front bellows", output="theta")
    periods = [mode.period for mode in modes_of(model.A, model.state_names).modes if mode.oscillates]
    for period in periods:
        assert found.frequencies[0] < 2 * math.pi / period < found.frequencies[-1]
    assert np.abs(np.diff(found.phase)).max() < math.pi
    np.testing.assert_allclose(found.magnitude_db, 20 * np.log10(np.abs(found.response)))
    np.testing.assert_allclose(np.exp(1j * found.phase) * found.magnitude, found.response, rtol=1e-12)


def test_it_can_be_sent_also_where_nothing_comes_through(model):
    response = frequency_response(
        model, input="command of Front bellows", output="extension of Rear bellows", frequencies=np.array([1.0])
    )
    assert response.magnitude[0] == 0.0 and response.magnitude_db[0] == -math.inf
    assert json.loads(json.dumps(response.as_dict(), allow_nan=False))["magnitude_db"] == [None]


@pytest.mark.parametrize(
    ("changes", "pointer"),
    [
        ({"input": "command of Sail"}, "/input"),
        ({"output": "x"}, "/output"),
        ({"frequencies": np.array([1.0, 0.0])}, "/frequencies/1"),
        ({"frequencies": np.array([np.nan])}, "/frequencies/0"),
        ({"frequencies": np.array([])}, "/frequencies"),
    ],
)
def test_what_is_not_there_is_refused(model, changes, pointer):
    asked = {"input": "command of Front bellows", "output": "theta"} | changes
    with pytest.raises(DesignError) as refused:
        frequency_response(model, **asked)
    assert refused.value.problems[0].pointer == pointer
