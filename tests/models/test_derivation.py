"""The kernel's planar equations against those derived symbolically from T and U (docs/physics.md, section 8.1)."""

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from models import derivation as dv
from models.assemble import assemble
from models.design import DeclaredMass
from models.hydrodynamic_law import build_law
from models.kernel.model import energies
from models.mass_properties import component_center_of_buoyancy, component_center_of_mass
from models.volumes import volume
from models.water import gravity_of
from tests.models.support import slope_at, without_water
from tests.strategies import designs, states

ADDED = dv.added_mass_symbols()
ENTRIES = [ADDED[0, 0], ADDED[0, 1], ADDED[0, 2], ADDED[1, 1], ADDED[1, 2], ADDED[2, 2]]


@cache
def symbolic(count, *, declared, added):
    """M, V, G for `count` parts as a function of q, q' and [g, rho, parts..., added mass]."""
    parts = dv.paper_parts(count) if declared else dv.composite_parts(count)
    symbols = [s for part in parts for s in part if s.is_Symbol]
    equations = dv.equations_of_motion(parts, ADDED if added else None)
    return dv.evaluator(equations, [dv.GRAVITY, dv.DENSITY, *symbols, *(ENTRIES if added else [])])


def values_of(assembly, y, *, added):
    """The numbers of a design at a state, in the order of `symbolic`, taken from the description and not the kernel."""
    design, vehicle = assembly.design, assembly.design.vehicle
    extensions = dict(zip(assembly.cells, y[8:], strict=True))
    environment = design.mission.environment
    values = [gravity_of(environment), environment.water.density]
    declared = vehicle.mass_properties
    for n, part in enumerate(vehicle.components):
        e = extensions.get(part.name, 0.0)
        center = component_center_of_mass(part, e)
        mass = [part.mass, center[0], center[2], part.inertia.yy]
        if isinstance(declared, DeclaredMass):
            l_gx, _, l_gz = declared.center_of_mass
            mass = [declared.mass, l_gx, l_gz, declared.inertia.yy] if n == 0 else []
        buoyancy = component_center_of_buoyancy(part, e)
        # a cell squeezed to nothing has a first moment, but no centre that the symbols could hold
        assume(volume(part, e) > 0.0 or part.kind in ("rigid", "movable_mass"))
        values += [*mass, volume(part, e), buoyancy[0], buoyancy[2]]
    return values + (list(added_mass(design)[np.triu_indices(3)]) if added else [])


def added_mass(design):
    added = design.vehicle.added_mass
    if added is None or not added.enabled:
        return np.zeros((3, 3))
    ratio = design.mission.environment.water.density / added.density
    return np.array(added.matrix)[np.ix_([0, 2, 4], [0, 2, 4])] * ratio


def generalized_force(design, q, v):
    """Q of Eqs. 6 and 7 with R(theta) of Eq. 2, the damping and the Munk excess on the right-hand side."""
    vehicle, R = design.vehicle, np.array(dv.rotation(q[2]), dtype=float)
    table, damping, A = vehicle.hydrodynamics, vehicle.damping, added_mass(design)
    u, w = R.T @ v[:2]
    alpha = math.remainder(math.atan2(v[1], v[0]) + q[2], 2 * math.pi)
    density = design.mission.environment.water.density
    lift, drag, moment = build_law(table)(alpha) * (v[0] ** 2 + v[1] ** 2) * density / table.reference_density
    F_x = -drag * math.cos(alpha) + lift * math.sin(alpha)
    F_z = -drag * math.sin(alpha) - lift * math.cos(alpha)
    moment += table.reference_point[2] * F_x - table.reference_point[0] * F_z
    if table.includes_munk_moment:
        moment -= (A[1, 1] - A[0, 0]) * u * w + A[0, 1] * (u**2 - w**2)
    force = R @ [F_x - damping.surge * u, F_z - damping.heave * w]
    return np.array([*force, moment - damping.pitch * v[2]])


def world(y):
    R = np.array(dv.rotation(y[2]), dtype=float)
    return y[:3], np.array([*(R @ y[3:5]), y[5]])


def world_acceleration(y, dy):
    """q'' from the body-axis accelerations: d/dt (R nu)."""
    s, c, q = math.sin(y[2]), math.cos(y[2]), y[5]
    R, dR = np.array([[c, s], [-s, c]]), q * np.array([[-s, c], [-c, -s]])
    return np.array([*(R @ dy[3:5] + dR @ y[3:5]), dy[5]])


@given(st.data(), designs(most=5, neutral=False))
def test_accelerations_equal_the_symbolic_ones(data, design):
    assembly = assemble(design)
    y = data.draw(states(assembly))
    q, v = world(y)
    equations = symbolic(
        len(design.vehicle.components), declared=design.vehicle.mass_properties.kind == "declared", added=True
    )
    M, V, G = equations(q, v, values_of(assembly, y, added=True))
    force = generalized_force(design, q, v)
    expected = dv.acceleration(M, V, G, force)
    terms = np.abs(np.linalg.inv(M)) @ (np.abs(force) + np.abs(V) + np.abs(G) + 1e-3)
    got = world_acceleration(y, slope_at(assembly.params, y))
    assert np.abs(got - expected).max() <= 1e-11 * terms.max()  # rounding of the terms that cancel


@given(st.data(), designs(most=5, neutral=False))
def test_inertia_coriolis_and_gravity_each_equal_the_symbolic_ones(data, design):
    """G from rest without water, V from motion without weight, M from the response to unit generalized forces."""
    assembly = assemble(design)
    p = without_water(assembly.params)
    y = data.draw(states(assembly))
    q, v = world(y)
    declared = design.vehicle.mass_properties.kind == "declared"
    equations = symbolic(len(design.vehicle.components), declared=declared, added=True)
    M, V, G = equations(q, v, values_of(assembly, y, added=True))
    rest = y.copy()
    rest[3:6] = 0.0
    np.testing.assert_allclose(
        M @ world_acceleration(rest, slope_at(p, rest)), -G, rtol=0, atol=1e-11 * (1.0 + np.abs(G).max())
    )
    weightless = p._replace(body=p.body.copy())
    weightless.body["gravity"] = 0.0
    moving = world_acceleration(y, slope_at(weightless, y))
    np.testing.assert_allclose(M @ moving, -V, rtol=0, atol=1e-11 * (1.0 + np.abs(V).max()))


@given(st.data(), designs(most=5, neutral=False))
def test_inertia_matrix_is_that_of_the_body_turned_to_the_world(data, design):
    """M(q) = J^T (M_RB + A) J, the body-axis matrix read off the kernel's kinetic energy."""
    assembly = assemble(design)
    y = data.draw(states(assembly))
    q, v = world(y)
    body = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for sign in (1.0, -1.0):
                probe = y.copy()
                probe[3:6] = 0.0
                probe[3 + i] += 1.0
                probe[3 + j] += sign
                body[i, j] += 0.5 * sign * energies(0.0, probe, assembly.params)[0]
    J = np.array(dv.body_jacobian().subs(dv.Q[2], q[2]), dtype=float)
    declared = design.vehicle.mass_properties.kind == "declared"
    equations = symbolic(len(design.vehicle.components), declared=declared, added=True)
    M, _, _ = equations(q, v, values_of(assembly, y, added=True))
    np.testing.assert_allclose(J.T @ body @ J, M, rtol=0, atol=1e-13 * np.abs(M).max())


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_the_paper_prints_what_follows_from_its_energies(count):
    """M13, M23, M33, V and the row of G of Eq. 5 for any number of components, tau_bx with each force's own arm."""
    derived = dv.equations_of_motion(dv.paper_parts(count))
    for mine, printed in zip(derived, dv.printed_equations(count), strict=True):
        assert sp.simplify(mine - printed).is_zero_matrix


def test_the_printed_arm_of_the_body_is_a_slip():
    """The paper's tau_bx = -F_b1 l_b0x - ... differs from the derived one wherever the body's centre is off x = 0."""
    parts = dv.paper_parts(3)
    tau_bx = dv.equations_of_motion(parts).G[2].expand().coeff(sp.cos(dv.Q[2]))
    slip = dv.DENSITY * dv.GRAVITY * parts[1].volume * parts[0].l_bx
    own = dv.DENSITY * dv.GRAVITY * parts[0].volume * parts[0].l_bx
    assert tau_bx.coeff(parts[0].l_bx) * parts[0].l_bx == -own
    assert sp.simplify(own - slip) != 0


def test_drag_opposes_level_motion_with_the_rotation_of_eq_2_only():
    """At theta = alpha the motion is level and Q must be [-F_D, -F_L]; the printed first matrix of Eq. 7 turns it."""
    a, F_D, F_L = sp.symbols("alpha F_D F_L", positive=True)
    inner = sp.Matrix([[sp.cos(a), -sp.sin(a)], [sp.sin(a), sp.cos(a)]]) * sp.Matrix([-F_D, -F_L])
    assert sp.simplify(dv.rotation(a) * inner) == sp.Matrix([-F_D, -F_L])
    assert sp.simplify(dv.rotation(a).T * inner) != sp.Matrix([-F_D, -F_L])


def test_added_mass_alone_gives_kirchhoffs_equations():
    """With T = nu^T A nu / 2 the world form equals P' + omega x P in body axes (P = A nu), moment w P_x - u P_z."""
    equations = dv.equations_of_motion([], ADDED)
    theta, J = dv.Q[2], dv.body_jacobian()
    nu = sp.Matrix(sp.symbols("u w q", real=True))
    P = ADDED * nu
    gyroscopic = sp.Matrix([nu[2] * P[1], -nu[2] * P[0], nu[1] * P[0] - nu[0] * P[1]])
    to_body = dict(zip(dv.Q_DOT, J.T * nu, strict=True))
    # nu' = J q'' + J' q'; at q'' = 0 the world form leaves V = J^T (A J' q' + gyroscopic)
    drift = (J.diff(theta) * nu[2]) * (J.T * nu)
    expected = J.T * (ADDED * drift + gyroscopic)
    assert sp.simplify(equations.V.subs(to_body, simultaneous=True) - expected).is_zero_matrix


def test_extension_dependent_centres_stay_symbols():
    """A movable mass at home + e enters M through the expression of its extension."""
    e, m, home = sp.symbols("e m home", real=True)
    M = dv.simplified(dv.equations_of_motion([dv.Part(mass=m, l_gx=home + e)])).M
    assert sp.simplify(M[2, 2] - m * (home + e) ** 2) == 0
