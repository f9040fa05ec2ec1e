"""The kernel's glides against DOP853 on a second implementation in world coordinates (`reference`)."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings

from models.assemble import assemble
from models.kernel.integrate import COMPLETED
from models.kernel.params import U, W
from models.presets import load_preset
from tests.models.reference import ReferenceGlider, ReferenceLaw, simulate_reference, world_state
from tests.models.support import run_kernel
from tests.strategies import designs

# an example takes a second: a failing one is told as it is, not shrunk for minutes
few = settings(max_examples=8, phases=[Phase.explicit, Phase.generate])


def solved_by(design, **solver):
    mission = design.mission.model_copy(update={"solver": design.mission.solver.model_copy(update=solver)})
    return design.model_copy(update={"mission": mission})


@pytest.fixture(scope="module")
def paper_glide():
    """The paper's preset by the reference: its states at 0, 10 and 20 s."""
    design = load_preset("canete-dual-bellows")
    marks, states = simulate_reference(design)
    assert marks == [0.0, 10.0, 20.0]
    return design, states


@pytest.mark.parametrize("solver", [{"tolerance": 1e-12}, {"method": "rk4", "step": 5e-4}], ids=["adaptive", "rk4"])
def test_the_papers_glide_agrees(paper_glide, solver):
    design, expected = paper_glide
    assembly = assemble(solved_by(design, output_interval=10.0, **solver))
    run = run_kernel(assembly)
    assert run.code == COMPLETED
    assert run.times.tolist() == [0.0, 10.0, 20.0]
    for mine, theirs in zip(run.states, expected, strict=True):
        np.testing.assert_allclose(world_state(mine), theirs, rtol=0, atol=1e-8)  # m, rad, m/s, rad/s


@few
@given(designs(ideal=True))
def test_random_glides_agree(design):
    """Any mix of components that follow their commands at once, steps and ramps."""
    marks, expected = simulate_reference(design)
    run = run_kernel(assemble(solved_by(design, tolerance=1e-12, output_interval=10.0)))
    assert run.code == COMPLETED
    assert run.times[-1] == marks[-1]
    np.testing.assert_allclose(world_state(run.states[-1]), expected[-1], rtol=0, atol=1e-8)


@few
@given(designs(most=3, ideal=True, law="polynomial"))
def test_random_glides_agree_by_rk4(design):
    """Smooth laws: the false corners of others are no test of a fixed step's order.

    The polynomials' lift jumps at 90 deg of attack: a step across it is off by a share of h times the jump.
    """
    _, expected = simulate_reference(design)
    run = run_kernel(assemble(solved_by(design, method="rk4", step=5e-4, output_interval=0.01)))
    assert run.code == COMPLETED
    past = np.abs(np.arctan2(run.states[:, W], run.states[:, U])) > np.pi / 2
    tolerance = 1e-8 if past.all() or not past.any() else 1e-5
    np.testing.assert_allclose(world_state(run.states[-1]), expected[-1], rtol=0, atol=tolerance)


def test_the_oracle_would_notice_a_wrong_sign(paper_glide):
    """Turning lift's sign in the reference moves the glide by far more than the agreement asked for."""
    design, expected = paper_glide
    glider = ReferenceGlider(design)
    law = ReferenceLaw(design.vehicle.hydrodynamics)
    q, v = expected[1][:3], expected[1][3:]
    balance = glider.balance({c.name: c.neutral for _, c in design.vehicle.actuated})
    right = glider.acceleration(q, v, balance)
    glider.law = lambda alpha: law(alpha) * [-1.0, 1.0, 1.0]
    assert np.abs(glider.acceleration(q, v, balance) - right).max() > 1e-3
