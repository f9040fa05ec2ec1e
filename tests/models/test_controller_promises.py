"""What a designed controller promises, beside other ways to know it: margins, names of modes, the way back."""

from __future__ import annotations

from dataclasses import replace

import control
import numpy as np
import pytest

from models.assemble import assemble
from models.controller_design import ControllerDesign, design_controller
from models.controller_options import ControllerOptions
from models.design import Design, parse_design
from models.gain_table import design_table
from models.limits import DEFAULT_LIMITS
from models.modes import OSCILLATIONS
from models.problems import DesignError
from models.run import Status
from models.sampled_model import sampled_model
from tests.models.design_support import DIVE, designed, planar_problem, uniform

PLANE = ("theta", "u", "w", "q")


@pytest.fixture(scope="module")
def quad() -> Design:
    return uniform()


@pytest.fixture(scope="module")
def held(quad: Design) -> ControllerDesign:
    """Least quadratic cost with all states, and the defaults."""
    return designed(quad)


def test_what_changes_sign_at_every_sample_is_named_an_oscillation():
    """A real negative eigenvalue of the sampled loop swings at half the sampling frequency; names are numbered."""
    F = np.diag([-0.5, -0.3, 0.9, 0.9])
    model = sampled_model(np.zeros((4, 4)), np.eye(4), states=PLANE, cells=tuple("abcd"), sample_time=2.0)
    modes = model.modes(F).modes
    assert len({mode.name for mode in modes}) == len(modes) == 4
    for mode in modes:
        assert mode.oscillates == (mode.name.split(" #")[0] in OSCILLATIONS)
    assert [mode.period for mode in modes if mode.oscillates] == pytest.approx([4.0, 4.0])
    result = planar_problem(trim={"depth": 20.0}, deviations={"theta": 5e-3}, share=1.0)
    names = [mode.name for mode in result.closed_loop.modes]
    assert len(set(names)) == len(names) and "pitch oscillation #2" in names


def test_margins_are_those_of_python_control():
    """Of one loop: by its frequency response at many frequencies, where ours looks for the unit circle."""
    result = planar_problem(trim={"depth": 20.0}, delay=0.7, deviations={"theta": 0.01}, share=0.5)
    problem, model, margins = result.problem, result.problem.whole(), result.margins
    loop = control.ss(model.F, model.G, model.feedback(problem.widened(result.gains)), 0.0, model.sample_time)
    omega = np.pi / model.sample_time * np.logspace(-3.0, 0.0, 5001)[:-1]
    data = control.frd(loop, omega, smooth=True)
    gain, phase, return_difference, _, crossing, worst = control.stability_margins(data)
    cell = margins.cells[0]
    assert (cell.gain_high, margins.gain_high) == pytest.approx((gain, gain), rel=1e-6)
    assert np.degrees(cell.phase) == pytest.approx(phase, rel=1e-6)
    assert cell.frequency == pytest.approx(crossing, rel=1e-6)
    assert margins.return_difference == pytest.approx(return_difference, rel=1e-4)
    assert margins.worst_frequency == pytest.approx(worst, rel=1e-2)
    assert margins.disk == pytest.approx(control.disk_margins(loop, omega)[0], rel=1e-4)


def test_the_way_back_from_departures_is_flown(quad: Design):
    """Those asked for in the options are those of the method, and end in the trim."""
    by = {"theta": 8e-3, "q": 1e-3}
    result = designed(quad, departures=by, recovery_duration=60.0)
    assert result.response is None and result.recovery.state == "theta"
    np.testing.assert_allclose(result.recovery.flown_state, result.departure(by, duration=60.0).flown_state)
    assert result.recovery.linear[0, result.recovery.states.index("q")] == pytest.approx(
        1e-3 + result.recovery.goal_states[result.recovery.states.index("q")]
    )
    assert abs(result.recovery.flown.error) < 1e-2
    assert set(result.as_dict()["recovery"]) == set(designed(quad, step={"amount": 1e-3}).as_dict()["response"])


@pytest.mark.parametrize(
    ("by", "says"),
    [
        ({}, "no departure"),
        ({"theta": 0.0}, "is no departure"),
        ({"theta": 0.01, "q": 0.0}, "is no departure"),
        ({"theta": np.nan}, "is no departure"),
        ({"theta": np.inf}, "is no departure"),
        ({"theta": 4.0}, "less than or equal"),
        ({"psi": -3.5}, "greater than or equal"),
        ({"z": 1.0}, "no state of the motion"),
    ],
)
def test_what_is_no_departure_is_refused(held: ControllerDesign, by: dict[str, float], says: str):
    with pytest.raises(DesignError, match=says) as error:
        held.departure(by)
    assert all(problem.pointer.startswith("/options/departures") for problem in error.value.problems)


def test_gains_are_for_the_design_as_it_was_assembled():
    """Whoever may have more parts than usual says so once: nothing assembles it again within other limits."""
    document = uniform().model_dump(mode="json")
    parts = document["vehicle"]["components"]
    rigid = next(part for part in parts if part["kind"] == "rigid")
    parts += [rigid | {"name": f"Part {k}", "mass": 0.0, "volume": 0.0} for k in range(266 - len(parts))]
    many, limits = parse_design(document), replace(DEFAULT_LIMITS, components=512)
    with pytest.raises(DesignError, match="266 components"):
        designed(many)
    options = ControllerOptions(trim=DIVE, states=PLANE, step={"amount": 1e-3, "duration": 5.0})
    result = design_controller(assemble(many, limits), options, limits=limits)
    assert result.response.run.status is Status.completed
    table = {"target": "glide_angle", "values": (-0.5, -0.48)}
    options = ControllerOptions(trim={"targets": {"speed": 0.2}, "depth": 50.0}, states=PLANE, table=table)
    assert len(design_table(assemble(many, limits), options).designs) == 2
