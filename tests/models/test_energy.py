"""The work-energy balance of every run (section 8.6): T + U - works = constant, and that this is not trivially so."""

import numpy as np
import pytest
from hypothesis import given, settings

from models.assemble import assemble
from models.design import parse_design
from models.kernel.outputs import COLUMNS, outputs
from models.kernel.params import WORK_ACTUATORS, WORK_WATER
from models.presets import load_preset, preset_ids
from models.run import Status
from models.simulate import run_assembly, simulate
from tests.models.support import PISTON, document, run_kernel, schedule
from tests.strategies import designs

RESIDUAL = COLUMNS.index("energy_residual")
SLIDE = {
    "kind": "movable_mass", "name": "Slide", "mass": 0.2, "position": [0.0, 0.0, 0.01],
    "extension_range": [-0.05, 0.05], "neutral_extension": 0.0, "axis": [1.0, 0.0, 0.2],
}  # fmt: skip


def with_solver(design, **solver):
    mission = design.mission.model_copy(update={"solver": design.mission.solver.model_copy(update=solver)})
    return design.model_copy(update={"mission": mission})


@pytest.mark.parametrize("preset_id", preset_ids())
def test_presets_close_their_balance(preset_id):
    run = simulate(load_preset(preset_id))
    assert run.status is Status.completed
    assert run.relative_residual < 1e-6
    assert run.energy_exchanged > 1e-3  # there was something to balance, J


@given(designs())
def test_random_designs_close_their_balance(design):
    """Any mix of cells and movable masses with rate limits, lags, steps and ramps, with and without added mass."""
    run = simulate(design)
    assert run.status in (Status.completed, Status.bed, Status.surface)
    scale = max(run.energy_exchanged, 1e-3)  # J: below that the states' own tolerance is all there is
    assert float(np.abs(run.data["energy_residual"]).max()) < 1e-6 * scale


@pytest.mark.parametrize("part", [PISTON, SLIDE], ids=["cell", "slide"])
@pytest.mark.parametrize("moving", [{}, {"rate_limit": 0.004}, {"lag": 0.4}, {"rate_limit": 0.004, "lag": 0.4}],
                         ids=["instant", "rate", "lag", "rate and lag"])  # fmt: skip
@pytest.mark.parametrize("shape", ["step", "ramp"])
def test_every_way_to_move_closes_the_balance(part, moving, shape):
    control = schedule(part["name"], (0.0, 0.005), (1.3, -0.009, shape), (3.1, 0.008, shape))
    changed = document(part | moving, control=control)
    run = simulate(parse_design(changed))
    assert run.relative_residual < 1e-6
    work = run.data["actuator_work"].values
    assert np.abs(work).max() > 1e-4  # the actuator did work


@pytest.mark.parametrize("preset_id", preset_ids())
def test_residual_falls_with_the_tolerance(preset_id):
    design = load_preset(preset_id)
    residuals = [simulate(with_solver(design, tolerance=10.0**-k)).relative_residual for k in (4, 6, 8, 10)]
    assert residuals[-1] < 1e-9
    falls = np.diff(np.log10(residuals))
    assert falls.mean() < -1.0  # at least a decade for two of tolerance, on average


def test_residual_falls_with_the_fourth_power_of_rk4s_step():
    design = load_preset("canete-dual-bellows")
    coarse, fine = (
        simulate(with_solver(design, method="rk4", step=h)).relative_residual for h in (0.02, 0.005)
    )  # fmt: skip
    assert fine < coarse / 4**3  # order 3 at least: the corners in curvature of 'pchip' cost part of the fourth


@pytest.mark.parametrize("state", [WORK_ACTUATORS, WORK_WATER])
def test_a_wrong_work_shows_up(state):
    assembly = assemble(load_preset("canete-dual-bellows"))
    run = run_kernel(assembly)
    spoilt = run.states.copy()
    spoilt[1:, state] *= 1.01
    out, cells = np.zeros((len(run.times), len(COLUMNS))), np.zeros((len(run.times), 2))
    outputs(run.times, spoilt, assembly.params, out, cells, cells.copy())
    largest = np.abs(run.states[:, state]).max()
    assert np.abs(out[:, RESIDUAL]).max() > 0.5 * 0.01 * largest


def test_wrong_dynamics_show_up():
    """A run of one glider judged by the constants of another does not balance."""
    assembly = assemble(load_preset("three-cell-glider"))
    run = run_kernel(assembly)
    other = assembly.params._replace(body=assembly.params.body.copy())
    other.body["a33"] *= 1.01
    out = np.zeros((len(run.times), len(COLUMNS)))
    cells = np.zeros((len(run.times), len(assembly.cells)))
    outputs(run.times, run.states, other, out, cells, cells.copy())
    # a hundredth of the heave added mass: 0.5 * 0.046 kg * w^2 with w of the order of 0.02 m/s
    assert np.abs(out[:, RESIDUAL]).max() > 1e-6


def test_water_only_takes_energy_from_a_glider_without_added_mass():
    """In still water drag dissipates: the work of the water never rises where the moment is damping alone."""
    changed = document(control=schedule("Piston", (0.0, -0.009), (2.0, 0.009)), duration=6.0)
    changed["vehicle"]["hydrodynamics"]["row_moment"] = [0.0] * 10
    run = simulate(parse_design(changed))
    assert np.diff(run.data["water_work"].values).max() <= 1e-12


def test_an_instant_step_is_charged_at_once():
    """A step at depth z costs rho g dV z, less what the cell's own arm gives: the jump of U, no efficiency."""
    changed = document(control=schedule("Piston", (1.0, 0.01)), solver={"output_interval": 0.5})
    run = run_assembly(assemble(parse_design(changed)))
    work = run.data["actuator_work"].values
    assert work[:2].tolist() == [0.0, 0.0]
    after = run.data.isel(time=2)
    s, c = np.sin(float(after["theta"])), np.cos(float(after["theta"]))
    # dV at the piston's position plus the whole stack's shift of half the growth along x
    dV, x = 1e-5, 0.15 + 0.005
    expected = 9.8 * 1000.0 * (dV * float(after["z"]) - s * dV * x + c * 0.0)
    assert work[2] == pytest.approx(expected, rel=1e-12)


@settings(max_examples=10)
@given(designs(most=4))
def test_the_balance_does_not_depend_on_the_sampling(design):
    coarse, fine = (simulate(with_solver(design, output_interval=dt)) for dt in (0.5, 0.01))
    for name in ("actuator_work", "water_work"):
        assert coarse.final[name] == fine.final[name]
