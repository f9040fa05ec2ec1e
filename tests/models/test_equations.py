"""The printed equations of a design are those that the kernel solves: accelerations at random states, in numbers."""

import json
import math
import re
from functools import cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from models.assemble import assemble
from models.derivation import Q_DOT, Q
from models.design import parse_design
from models.equation_text import latex_blocks, render
from models.equations import derive_equations
from models.hydrodynamic_grid import build_grid_law
from models.hydrodynamic_law import law_of
from models.mass_properties import mass_balance
from models.presets import load_preset
from models.problems import DesignError
from models.quasi_velocities import NU, PITCH, ROLL
from tests.models.support import PISTON, design_of, slope_at
from tests.models.test_derivation import world, world_acceleration
from tests.strategies import designs, spatial_designs, spatial_states, states

PLANAR = ("canete-dual-bellows", "three-cell-glider", "slocum-glide")
SPATIAL = ("quad-bellows-glide", "movable-mass-twin", "seawing-spiral")


def in_still_uniform_water(design, **water_forces):
    """The design in what the equations know: one density, no current, no compression, no surface to float at."""
    document = json.loads(design.to_json())
    for component in document["vehicle"]["components"]:
        if "bulk_modulus" in component:
            component["bulk_modulus"] = None
    document["vehicle"] |= water_forces
    document["mission"]["environment"] = {"water": {"density": 998.0}, "gravity": 9.81}
    return parse_design(document)


@cache
def preset(name):
    design = load_preset(name)
    return in_still_uniform_water(design) if design.mission.solver.model == "spatial" else design


def forces_at(equations, position, velocity):
    """The vector of the water's forces, step by step, its laws by the numbers of the design."""
    source = equations.design.vehicle.hydrodynamics
    law = law_of(source)
    at = dict(zip((*equations.position, *equations.velocity), (*position, *velocity), strict=True))
    at |= equations.values

    def number(form):
        if isinstance(form, sp.atan2):
            return math.atan2(*map(number, form.args))  # at rest as well
        values = {s: sp.Float(float(at[s])) for s in form.free_symbols}
        for call in form.atoms(sp.core.function.AppliedUndef):
            name, angles = type(call).__name__, [float(at[angle]) for angle in call.args]
            kind, _, index = name.partition("_")
            by = law(*angles) if kind == "P" else build_grid_law(source)(*angles)
            values[call] = sp.Float(float(by[("L", "D", "tau").index(index) if kind == "P" else "XYZKMN".index(index)]))
        return float(form.xreplace(values).evalf())

    for symbol, form in equations.forces.steps:
        at[symbol] = number(form)
    return np.array([number(sp.sympify(entry)) for entry in equations.forces.vector])


def assert_accelerates(equations, got, position, velocity, right):
    M, V, G = equations.evaluate(position, velocity)
    terms = np.abs(np.linalg.inv(M)) @ (np.abs(right) + np.abs(V) + np.abs(G) + 1e-3)
    expected = np.linalg.solve(M, right - V - G)
    assert np.abs(got - expected).max() <= 1e-10 * terms.max()  # rounding of the terms that cancel


def drawn(data, strategy, u, w):
    """Draw a state away from 90 and 180 deg of attack: laws may jump there, and rounding says on which side."""
    y = data.draw(strategy)
    attack = abs(math.atan2(y[w], y[u]))
    assume(y[u] == y[w] == 0.0 or min(abs(attack - 0.5 * math.pi), math.pi - attack) > 1e-6)
    return y


def check_planar(design, y):
    assembly = assemble(design)
    q, v = world(y)
    equations = derive_equations(design, dict(zip(assembly.cells, y[8:], strict=True)))
    damping = np.array([float(entry.xreplace(equations.values)) for entry in equations.forces.damping.diagonal()])
    got = world_acceleration(y, slope_at(assembly.params, y))
    assert_accelerates(equations, got, q, v, forces_at(equations, q, v) - damping * v)


def check_spatial(design, y):
    assembly = assemble(design)
    moving = len(assembly.cells)
    equations = derive_equations(design, dict(zip(assembly.cells, y[16 : 16 + moving], strict=True)))
    k = Rotation.from_quat(y[3:7], scalar_first=True).as_matrix()[2]
    position = [y[2], math.atan2(k[1], k[2]), math.asin(np.clip(-k[0], -1.0, 1.0))]
    nu = y[7:13]
    assert_accelerates(equations, slope_at(assembly.params, y)[7:13], position, nu, forces_at(equations, position, nu))


@pytest.mark.parametrize("name", PLANAR)
@settings(max_examples=4)
@given(st.data())
def test_planar_presets_accelerate_as_printed(name, data):
    check_planar(preset(name), drawn(data, states(assemble(preset(name))), 3, 4))


@settings(max_examples=8)
@given(st.data(), designs(most=5, neutral=False))
def test_any_planar_design_accelerates_as_printed(data, design):
    check_planar(design, drawn(data, states(assemble(design)), 3, 4))


@pytest.mark.parametrize("name", SPATIAL)
@settings(max_examples=4)
@given(st.data())
def test_spatial_presets_accelerate_as_printed(name, data):
    check_spatial(preset(name), drawn(data, spatial_states(assemble(preset(name))), 7, 9))


@settings(max_examples=8)
@given(st.data(), spatial_designs(most=4).map(in_still_uniform_water))
def test_any_spatial_design_accelerates_as_printed(data, design):
    check_spatial(design, drawn(data, spatial_states(assemble(design)), 7, 9))


def test_a_table_over_both_angles_enters_as_printed():
    grid = [[-0.5 - 0.1 * i, 0.2 * j, 0.3 * i - 0.1] for i, j in ((0, 1), (1, 2), (2, 0))]
    angles = {"kind": "angle_table", "provenance": {"title": "Made up", "source": "For a test."},
              "alpha_deg": [-180.0, 0.0, 170.0], "beta_deg": [-90.0, 0.0, 90.0], "reference_point": [0.1, 0.02, -0.03],
              "rates": {"scaling": "speed", "yaw_yaw": -0.7, "heave_pitch": 0.4},
              } | {name: grid for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")}  # fmt: skip
    design = in_still_uniform_water(preset("movable-mass-twin"), hydrodynamics=angles)
    y = assemble(design).initial_state.copy()
    y[7:13] = 0.4, 0.1, -0.05, 0.02, -0.1, 0.2
    check_spatial(design, y)


def test_an_empty_cell_keeps_its_first_moment():
    """V = 0 leaves a piston without a centre, and G without a division by it."""
    empty = PISTON | {"volume_range": [0.0, 6e-5]}
    design = design_of(empty)
    y = assemble(design).initial_state.copy()
    y[8] = -0.05
    assert mass_balance(design.vehicle, {"Piston": -0.05}).volume == pytest.approx(0.95e-3)
    check_planar(design, y)


@pytest.mark.parametrize("name", PLANAR + SPATIAL)
def test_inertia_is_positive_and_coriolis_does_no_work_but_its_own(name):
    """M is symmetric positive definite, and d/dt (q'^T M q' / 2) = q'^T (M q'' + V): v^T V = v^T (dM/dt) v / 2."""
    equations = derive_equations(preset(name))
    M, V, G = equations.equations
    assert M == M.T
    velocity = Q_DOT if name in PLANAR else NU
    rate = M.diff(Q[2]) * Q_DOT[2] if name in PLANAR else sp.zeros(6, 6)  # in body axes M is constant
    work = velocity.dot(V) - (velocity.T * rate * velocity)[0] / 2
    assert sp.simplify(sp.expand(work, trig=name in PLANAR)) == 0
    position = [3.0, -0.4, 0.7]
    assert np.linalg.eigvalsh(equations.evaluate(position, np.ones(len(velocity))).M).min() > 0.0
    free = {str(s) for s in M.free_symbols | V.free_symbols | G.free_symbols}
    assert free <= {str(s) for s in (*equations.values, *velocity, ROLL, PITCH)}


@pytest.mark.parametrize("name", PLANAR + SPATIAL)
def test_sums_are_those_of_the_mass_balance(name):
    design = preset(name)
    equations = derive_equations(design)
    balance = mass_balance(design.vehicle)
    by_name = {str(symbol): value for symbol, value in equations.values.items()}
    assert len(by_name) == len(equations.values) == sum(len(group.entries) for group in equations.legend)
    at = design.mission.initial.extensions
    balance = mass_balance(design.vehicle, at)
    weight = by_name["rho"] * by_name["g"]
    assert by_name["F_b"] == pytest.approx(weight * balance.volume, rel=1e-12)
    arm = balance.center_of_buoyancy
    for axis, across in zip("xz", arm[[0, 2]], strict=True):
        assert by_name[f"tau_b{axis}"] == pytest.approx(-weight * balance.volume * across, abs=1e-12 * weight)
    M = equations.evaluate([0.0, 0.0, 0.0], np.zeros(len(equations.velocity))).M
    added = design.vehicle.added_mass
    if added is None:
        assert M[2, 2] == pytest.approx(balance.inertia_about_origin[1, 1], rel=1e-12)


@pytest.mark.parametrize("numbers", [False, True])
@pytest.mark.parametrize("name", PLANAR + SPATIAL)
def test_every_component_is_in_the_legend_and_latex_balances(name, numbers):
    equations = derive_equations(preset(name))
    equations = equations.with_numbers() if numbers else equations
    text, latex = render(equations, "text"), render(equations, "latex")
    for n, component in enumerate(preset(name).vehicle.components):
        assert f"\n{n} {component.name} (" in text and rf"\textbf{{{n} {component.name} (" in latex
    assert max(map(len, text.splitlines())) <= 120
    blocks = [block for section in equations.sections for block in latex_blocks(section.displays)]
    for piece in (latex, *blocks):
        bare = re.sub(r"\\[{}]", "", piece)
        assert bare.count("{") == bare.count("}") and min(np.cumsum([(c == "{") - (c == "}") for c in bare])) >= 0
        assert piece.count(r"\left") == piece.count(r"\right")
        begun, ended = (sorted(re.findall(rf"\\{word}{{(\w+)}}", piece)) for word in ("begin", "end"))
        assert begun == ended


def test_numbers_leave_only_the_motion_and_its_forces():
    equations = derive_equations(preset("quad-bellows-glide")).with_numbers()
    shown = {str(d.left): d.right for section in equations.sections for d in section.displays}
    assert shown["M_RB"][0, 0] == pytest.approx(30.71542496, rel=1e-5) and not shown["M_A"].free_symbols
    assert shown["V_RB"].free_symbols <= set(NU)
    assert shown["G"].free_symbols <= {ROLL, PITCH}


def test_the_paper_is_printed_in_its_own_symbols():
    G = derive_equations(preset("canete-dual-bellows")).equations.G
    assert {str(s) for s in G[2].free_symbols} == {"tau_bx", "tau_bz", "M", "g", "l_gx", "l_gz", "theta"}


def test_an_extension_beyond_its_stops_is_refused_by_its_pointer():
    with pytest.raises(DesignError, match="/extensions/Front bellows"):
        derive_equations(preset("canete-dual-bellows"), {"Front bellows": 5.0})
