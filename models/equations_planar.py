"""Owns Eq. 5 of one planar design: T and U of its components, and M, V, G, Q that follow by Euler-Lagrange."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy as sp

from models import derivation as dv
from models.added_mass import added_mass
from models.design import Design
from models.equation_forces import Forces, added_mass_symbols, planar_forces
from models.equation_parts import Composition, compose
from models.equation_sections import Derived, Display, Section, Written, buoyancies, definitions, laws_section
from models.equation_symbols import Notation

THETA, (X_DOT, Z_DOT, THETA_DOT) = dv.Q[2], dv.Q_DOT
S, C = sp.sin(THETA), sp.cos(THETA)
PLANE = (0, 2, 4)


def derive(design: Design, notation: Notation, extensions: Mapping[str, float] | None) -> Derived:
    """Derive Eq. 5 for exactly this design."""
    composition = compose(design, notation, extensions)
    buoyancy = buoyancies(composition, notation)
    body = _composed_mass(composition, notation)
    net = _composed_buoyancy(composition, buoyancy, notation)
    A = added_mass_symbols(notation, added_mass(design)[PLANE, :][:, PLANE], (1, 3, 5))
    forces = planar_forces(design, notation, A)
    rigid, added = _rigid_equations(body, net), _added_equations(sp.ImmutableMatrix(A))
    whole = dv.Equations(rigid.M + added.M, rigid.V + added.V, rigid.G)
    sections = (
        _coordinates(), _energies(composition, buoyancy), laws_section(notation.groups),
        _composites(notation), _equations_section(rigid, added, A), _force_section(forces), _whole_section(forces),
    )  # fmt: skip
    return Derived(sections, whole, forces, tuple(dv.Q), tuple(dv.Q_DOT))


def _parts(composition: Composition) -> list[dv.Part]:
    return [
        dv.Part(part.mass, part.l_g[0], part.l_g[2], part.inertia[1, 1], part.volume, part.l_b[0], part.l_b[2])
        for part in composition.parts
    ]


def _composed_mass(composition: Composition, notation: Notation) -> sp.ImmutableMatrix:
    """Return M_RB in body axes (3, 3), its entries read off the components' T by differentiation.

    Declared properties stay in the paper's symbols M, l_gx, l_gz, I; others get m, S_x, S_z, I_O.
    """
    T = sp.expand(dv.kinetic_energy(_parts(composition)).subs(THETA, 0))
    m, S_z, S_x, I_O = T.diff(X_DOT, 2), T.diff(X_DOT, THETA_DOT), -T.diff(Z_DOT, THETA_DOT), T.diff(THETA_DOT, 2)
    if "" not in composition.indices:
        m = notation.defined("m", "mass", "kg", m)
        S_x, S_z = (
            notation.defined(f"S_{axis}", f"first moment of mass, {axis}", "kg m", form)
            for axis, form in (("x", S_x), ("z", S_z))
        )
        I_O = notation.defined("I_O", "pitch inertia about the origin", "kg m2", I_O)
    return sp.ImmutableMatrix([[m, 0, S_z], [0, m, -S_x], [S_z, -S_x, I_O]])


def _composed_buoyancy(
    composition: Composition, buoyancy: Mapping[str, Any], notation: Notation
) -> tuple[Any, Any, Any]:
    """Return F_b, tau_bx, tau_bz, read off the components' U: tau_b is dU/dtheta at 0 and at 90 deg."""
    afloat = [
        dv.Part(volume=buoyancy[n] / (dv.DENSITY * dv.GRAVITY), l_bx=part.l_b[0], l_bz=part.l_b[2])
        for n, part in zip(composition.indices, composition.parts, strict=True)
        if n in buoyancy
    ]
    U = sp.sympify(dv.potential_energy(afloat))
    turning = U.diff(THETA)
    return (
        notation.defined("F_b", "buoyancy", "N", sp.expand(U.diff(dv.Q[1]))),
        notation.defined("tau_bx", "moment of buoyancy, level", "N m", sp.expand(turning.subs(THETA, 0))),
        notation.defined("tau_bz", "moment of buoyancy, nose up", "N m", sp.expand(turning.subs(THETA, sp.pi / 2))),
    )


@cache
def _rigid_equations(body: sp.ImmutableMatrix, net: tuple[Any, Any, Any]) -> dv.Equations:
    """Return M, V, G of the components in composite symbols."""
    m, S_x, S_z = body[0, 0], -body[1, 2], body[0, 2]
    F_b, tau_bx, tau_bz = net
    U = -m * dv.GRAVITY * dv.Q[1] + F_b * dv.Q[1] + (S_x * dv.GRAVITY + tau_bx) * S - (S_z * dv.GRAVITY + tau_bz) * C
    equations = dv.equations_from(dv.kinetic_energy((), sp.Matrix(body)), U)
    G = equations.G.applyfunc(lambda entry: sp.collect(sp.expand(entry), [S, C]))
    return dv.Equations(_short(equations.M), _short(equations.V), G)


@cache
def _added_equations(A: sp.ImmutableMatrix) -> dv.Equations:
    """Return M and V of the added mass, (nu^T A nu) / 2."""
    if A.is_zero_matrix:
        return dv.Equations(sp.zeros(3, 3), sp.zeros(3, 1), sp.zeros(3, 1))
    equations = dv.equations_from(dv.kinetic_energy((), sp.Matrix(A)), sp.Integer(0))
    entries = sorted(A.free_symbols, key=str)
    V = equations.V.applyfunc(lambda form: sp.collect(sp.expand(sp.trigsimp(sp.expand(form))), entries, sp.factor))
    return dv.Equations(_short(equations.M), V, equations.G)


def _short(matrix: sp.Matrix) -> sp.Matrix:
    return matrix.applyfunc(lambda entry: sp.factor_terms(sp.trigsimp(sp.expand(entry))))


def _coordinates() -> Section:
    q = sp.Matrix(dv.Q)
    displays = (
        Display(sp.Symbol("q"), q, "words"),
        Display(sp.Function("R")(THETA), dv.rotation(THETA), "words"),
    )
    words = (
        "x forward, z down, theta nose up, all of the body origin; R turns body axes to the world (Eqs. 1, 2). Body "
        "axes: x to the nose, z through the keel. The extensions e are held: M, V and G follow them, but the momentum "
        "of the parts' own motion is left out, as in the paper."
    )
    return Section("Coordinates", words, displays)


def _energies(composition: Composition, buoyancy: Mapping[str, Any]) -> Section:
    """Write T and U as sums over the components."""
    T: Any = sp.Integer(0)
    U: Any = sp.Integer(0)
    for n, part in zip(composition.indices, composition.parts, strict=True):
        speed, low, middle = sp.symbols(f"v_g{n} z_g{n} z_b{n}", real=True)
        T += part.mass * speed**2 / 2 + part.inertia[1, 1] * THETA_DOT**2 / 2
        U += buoyancy.get(n, 0) * middle - part.mass * dv.GRAVITY * low
    n = "" if "" in composition.indices else "n"
    speed, low, middle, l_gx, l_gz, l_bx, l_bz = sp.symbols(f"v_g{n} z_g{n} z_bn l_g{n}x l_g{n}z l_bnx l_bnz")
    across, along = -l_gx * S + l_gz * C, -(l_gx * C + l_gz * S)
    displays = (
        Display(sp.Symbol("T"), T, "words"),
        Display(speed**2, (X_DOT + across * THETA_DOT) ** 2 + (Z_DOT + along * THETA_DOT) ** 2, "words"),
        Display(sp.Symbol("U"), U, "words"),
        Display(low, dv.Q[1] - l_gx * S + l_gz * C, "words"),
        Display(middle, dv.Q[1] - l_bx * S + l_bz * C, "words"),
    )
    words = "One term a component (Eqs. 3, 4): l_g is its centre of mass, l_b its centre of buoyancy, in body axes."
    return Section("Energies", words, displays)


def _composites(notation: Notation) -> Section:
    whole = next(group for group in notation.groups if group.title == "Whole vehicle")
    words = "Read off T and U by differentiation; each force with its own arm."
    return Section("Sums over the components", words, definitions([e.symbol for e in whole.entries], [whole]))


def _equations_section(rigid: dv.Equations, added: dv.Equations, A: sp.Matrix) -> Section:
    """Show M, V, G: what stands before q'', what is left at q'' = 0, and at rest."""
    M, V = Written("M(q)", "M(q)"), Written("V(q, q')", r"V(q,\dot{q})")  # the paper's M is the mass, too
    G = Written("G(q)", "G(q)")
    if A.is_zero_matrix:
        alone = (Display(M, rigid.M), Display(V, rigid.V), Display(G, rigid.G))
        return Section("M, V, G", "From d/dt dL/dq' - dL/dq with L = T - U.", alone)
    M_RB, M_A, V_RB, V_A = sp.symbols("M_RB M_A V_RB V_A")
    words = (
        "From d/dt dL/dq' - dL/dq with L = T - U. RB is what the components give, A what the added mass does, whose "
        "energy is nu^T A nu / 2 with nu = [u, w, theta'] in body axes; M = M_RB + M_A, V = V_RB + V_A."
    )
    displays = (
        Display(M_RB, rigid.M), Display(M_A, added.M), Display(V_RB, rigid.V), Display(V_A, added.V),
        Display(G, rigid.G),
    )  # fmt: skip
    return Section("M, V, G", words, displays)


def _force_section(forces: Forces) -> Section:
    steps = tuple(Display(symbol, form) for symbol, form in forces.steps)
    words = (
        "V_w is the speed through the water, alpha the angle of attack; lift acts across the flow, drag along it "
        "(Eqs. 6 to 8, 11, 12). P_L, P_D, P_tau, where they stand, are the laws fitted to the design's table."
    )
    return Section("Forces of the water", words, (*steps, Display(sp.Symbol("Q"), forces.vector)))


def _whole_section(forces: Forces) -> Section:
    whole = Written("M q'' + V + C q' + G = Q", r"M(q)\,\ddot{q} + V(q,\dot{q}) + C\,\dot{q} + G(q) = Q")
    displays = (Display(sp.Symbol("C"), forces.damping), Display(whole, None, "words"))
    return Section("Equation 5", "C is the damping in pitch; that in surge and heave is in X and Z.", displays)
