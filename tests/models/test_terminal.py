"""Motions with known ends: rest, terminal speed (section 8.5), and the steady glide as a fixed point."""

import math

import numpy as np
import pytest
from scipy.optimize import root

from models.assemble import assemble
from models.design import parse_design
from models.hydrodynamic_law import build_law
from models.kernel.integrate import COMPLETED
from models.presets import load_preset
from models.simulate import simulate
from models.water import gravity_of
from tests.models.support import BODY, PISTON, design_of, document, polar, run_kernel, slope_at

STILL = {"position": [0.0, 0.0, 5.0]}
EXACT = {"tolerance": 1e-12}


def centered(**changes):
    """The neutral test glider with both centres on the z axis, so that it hangs level."""
    body = BODY | {"position": [0.0, 0.0, 0.0], "center_of_mass": [0.0, 0.0, 0.004]} | changes
    return {"body": body}, PISTON | {"position": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0]}


def test_a_neutral_aligned_glider_at_rest_stays_at_rest_exactly():
    # the body weighs 1 kg in binary-exact numbers and displaces it alone: no force is left by rounding
    body = {"kind": "rigid", "name": "Body", "mass": 1.0, "volume": 0.125, "position": [0.0, 0.0, 0.0],
            "center_of_mass": [0.0, 0.0, 0.5], "inertia": {"yy": 0.02}}  # fmt: skip
    changed = document(initial=STILL, environment={"water": {"density": 8.0}}, duration=1000.0)
    changed["vehicle"]["components"] = [body]
    run = run_kernel(assemble(parse_design(changed)))
    assert run.code == COMPLETED
    expected = np.zeros(8)
    expected[1] = 5.0
    assert (run.states == expected).all()


def test_the_papers_glider_without_commands_stays_within_rounding():
    design = load_preset("canete-dual-bellows")
    control = design.mission.control.model_copy(update={"schedules": ()})
    quiet = design.model_copy(update={"mission": design.mission.model_copy(update={"control": control})})
    run = run_kernel(assemble(quiet))
    start = run.states[0]
    assert np.abs(run.states[:, 1:6] - start[1:6]).max() <= 1e-12  # trimmed to rounding: 1e-15 N for 20 s


@pytest.mark.parametrize("heavier", [0.01, -0.01])
@pytest.mark.parametrize("law", ["pchip", "polynomial"])
def test_terminal_speed_without_lift(heavier, law):
    """Level and broadside the flow comes at +-90 deg, where lift is zero: V = sqrt(net weight / P_D)."""
    body, piston = centered(mass=0.95 * (1.0 + heavier), center_of_mass=[0.0, 0.0, 0.1])
    changed = document(piston, **body, initial={"position": [0.0, 0.0, 20.0]}, duration=40.0, solver=EXACT)
    changed["vehicle"]["hydrodynamics"] = polar(law=law, row_lift=[0.0] * 10, row_moment=[0.0] * 10)
    design = parse_design(changed)
    run = run_kernel(assemble(design))
    assert run.code == COMPLETED
    environment = design.mission.environment
    net_weight = 0.95 * heavier * gravity_of(environment)
    P_D = build_law(design.vehicle.hydrodynamics)(math.pi / 2)[1]
    expected = math.copysign(math.sqrt(abs(net_weight) / P_D), net_weight)
    final = run.states[-1]
    assert final[4] == pytest.approx(expected, rel=1e-10)  # 100 time constants m / (2 P_D V) have passed
    assert np.abs(final[[0, 2, 3, 5]]).max() <= 1e-12


def test_the_way_to_terminal_speed_is_a_hyperbolic_tangent():
    """m w' = W - P_D w^2 from rest: w = V tanh(t sqrt(W P_D) / m)."""
    body, piston = centered(mass=0.97, center_of_mass=[0.0, 0.0, 0.1])
    changed = document(piston, **body, initial=STILL, duration=4.0, solver=EXACT)
    changed["vehicle"]["hydrodynamics"] = polar(row_lift=[0.0] * 10, row_moment=[0.0] * 10)
    run = run_kernel(assemble(parse_design(changed)))
    W, P_D, m = 0.02 * 9.8, 32.0, 1.02
    expected = math.sqrt(W / P_D) * np.tanh(run.times * math.sqrt(W * P_D) / m)
    assert np.abs(run.states[:, 4] - expected).max() <= 1e-10  # m/s: a hundred steps of 1e-12
    depth = 5.0 + m / P_D * np.log(np.cosh(run.times * math.sqrt(W * P_D) / m))
    assert np.abs(run.states[:, 1] - depth).max() <= 1e-10


def test_pitch_damping_alone_slows_a_spin_exponentially():
    """Neutral, both centres at the origin, no velocity: I q' = -C33 q."""
    body, piston = centered(center_of_mass=[0.0, 0.0, 0.0])
    changed = document(
        piston, **body, initial=STILL | {"angular_velocity": [0.0, 1.0, 0.0]}, duration=3.0, solver=EXACT
    )
    changed["vehicle"]["damping"] = {"pitch": 0.02}
    run = run_kernel(assemble(parse_design(changed)))
    assert np.abs(run.states[:, 5] - np.exp(-run.times)).max() <= 1e-10  # I = C33: one second
    assert np.abs(run.states[:, 3:5]).max() <= 1e-15


def steady_design(added_mass, duration=120.0):
    """A glider that dives steadily: nose cell pulled in, mass low enough, well damped and stable in pitch."""
    body = BODY | {"center_of_mass": [-0.15 * 0.05 / 0.95, 0.0, 0.002]}
    changed = document(
        body=body, duration=duration, solver={"tolerance": 1e-11},
        initial={"position": [0.0, 0.0, 1.0], "extensions": {"Piston": -0.005}},
    )  # fmt: skip
    changed["vehicle"]["damping"] = {"pitch": 0.2}
    if added_mass:
        A = np.diag([0.05, 0.5, 1.5, 0.01, 0.05, 0.01])
        changed["vehicle"]["added_mass"] = {"matrix": A.tolist()}
    return parse_design(changed)


@pytest.mark.parametrize("added_mass", [False, True])
def test_a_steady_glide_stays_steady(added_mass):
    assembly = assemble(steady_design(added_mass))

    def residual(unknowns):
        y = assembly.initial_state.copy()
        y[2:5] = unknowns
        return slope_at(assembly.params, y)[3:6]

    found = root(residual, [-0.5, 0.3, 0.02], tol=1e-14)
    assert np.abs(residual(found.x)).max() <= 1e-13
    y = assembly.initial_state.copy()
    y[2:5] = found.x
    run = run_kernel(assembly, y)
    assert run.code == COMPLETED
    assert np.abs(run.states[:, 2:6] - y[2:6]).max() <= 1e-10  # a fixed point: nothing but rounding and its decay
    slope = slope_at(assembly.params, y)
    assert slope[1] > 0.02 and slope[0] > 0.05  # it does glide: down and forward
    np.testing.assert_allclose(run.states[:, 0], slope[0] * run.times, rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.states[:, 1], 1.0 + slope[1] * run.times, rtol=0, atol=1e-8)


@pytest.mark.parametrize("added_mass", [False, True])
def test_a_glider_released_at_rest_finds_the_steady_glide(added_mass):
    design = steady_design(added_mass, duration=400.0)
    final = simulate(design).final
    assembly = assemble(design)
    y = assembly.initial_state.copy()
    y[2:6] = final["theta"], final["u"], final["w"], final["q"]
    assert np.abs(slope_at(assembly.params, y)[3:6]).max() <= 1e-9
    lift_to_drag = final["lift"] / final["drag"]
    assert final["x_dot"] / final["z_dot"] == pytest.approx(abs(lift_to_drag), rel=1e-7)  # glide ratio = L / D


def test_stable_means_denser_than_water_at_the_nose():
    """The front cell pulled in makes it heavy by rho g A e, and that is what drives the glide."""
    assembly = assemble(design_of(initial={"position": [0.0, 0.0, 5.0], "extensions": {"Piston": -0.01}}))
    slope = slope_at(assembly.params, assembly.initial_state)
    run = simulate(assembly.design)
    assert float(run.data["net_buoyancy"][0]) == pytest.approx(-9.8 * 1000.0 * 1e-3 * 0.01, rel=1e-12)
    assert slope[5] < 0.0  # nose down
