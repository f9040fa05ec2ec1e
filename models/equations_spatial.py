"""Owns the equations of one spatial design: T and U of its components, and M, V, G by Lagrange in quasi-velocities."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy as sp

from models import quasi_velocities as qv
from models.added_mass import added_mass
from models.derivation import DENSITY, GRAVITY, Equations
from models.design import Design
from models.equation_forces import Forces, added_mass_symbols, spatial_forces
from models.equation_parts import AXES, Composition, compose
from models.equation_sections import Derived, Display, Section, Written, buoyancies, definitions, laws_section
from models.equation_symbols import Notation

LEVEL = {"x": (0, -sp.pi / 2), "y": (sp.pi / 2, 0), "z": (0, 0)}
"""Roll and pitch at which each axis of the body points down."""


def derive(design: Design, notation: Notation, extensions: Mapping[str, float] | None) -> Derived:
    """Derive M nu' + V + G = forces of the water for exactly this design."""
    composition = compose(design, notation, extensions)
    buoyancy = buoyancies(composition, notation)
    body = _composed_mass(composition, notation)
    net = _composed_buoyancy(composition, buoyancy, notation)
    A = added_mass_symbols(notation, added_mass(design), range(1, 7))
    forces = spatial_forces(design, notation, A)
    rigid, added = _rigid_equations(body, net), _added_equations(sp.ImmutableMatrix(A))
    whole = Equations(rigid.M + added.M, rigid.V + added.V, rigid.G)
    sections = (
        _coordinates(), _energies(composition, buoyancy), laws_section(notation.groups), _composites(notation),
        _equations_section(rigid, added, A), _force_section(forces),
    )  # fmt: skip
    return Derived(sections, whole, forces, (qv.DEPTH, qv.ROLL, qv.PITCH), tuple(qv.NU))


def _composed_mass(composition: Composition, notation: Notation) -> sp.ImmutableMatrix:
    """Return M_RB (6, 6) in composite symbols, each an entry of d2T/dnu2 of the components."""
    M = qv.inertia(sp.expand(qv.kinetic_energy(composition.parts)))
    m = M[0, 0] if M[0, 0].is_Symbol and "" in composition.indices else notation.defined("m", "mass", "kg", M[0, 0])
    S = [
        notation.defined(f"S_{axis}", f"first moment of mass, {axis}", "kg m", form) if form != 0 else form
        for axis, form in zip(AXES, (M[1, 5], M[2, 3], M[0, 4]), strict=True)
    ]
    inertia = sp.zeros(3, 3)
    for i in range(3):
        for j in range(i, 3):
            name, form = f"I_O{AXES[i]}{AXES[j]}", M[3 + i, 3 + j]
            if form != 0:
                words = f"inertia about the origin, {AXES[i]}{AXES[j]}"
                inertia[i, j] = inertia[j, i] = notation.defined(name, words, "kg m2", form)
    skew = sp.Matrix([[0, -S[2], S[1]], [S[2], 0, -S[0]], [-S[1], S[0], 0]])
    return sp.ImmutableMatrix(sp.BlockMatrix([[m * sp.eye(3), -skew], [skew, inertia]]).as_explicit())


def _composed_buoyancy(
    composition: Composition, buoyancy: Mapping[str, Any], notation: Notation
) -> tuple[Any, Any, Any, Any]:
    """Return F_b and tau_b, read off U: -tau_b of an axis is U at depth 0 with that axis pointing down."""
    afloat = [
        qv.SpatialPart(volume=buoyancy[n] / (DENSITY * GRAVITY), l_b=part.l_b)
        for n, part in zip(composition.indices, composition.parts, strict=True)
        if n in buoyancy
    ]
    U = sp.sympify(qv.potential_energy(afloat))
    F_b = notation.defined("F_b", "buoyancy", "N", sp.expand(U.diff(qv.DEPTH)))
    moments = []
    for axis, (roll, pitch) in LEVEL.items():
        form = sp.expand(-U.subs({qv.DEPTH: 0, qv.ROLL: roll, qv.PITCH: pitch}))
        moments.append(notation.defined(f"tau_b{axis}", f"-F_b times its arm along {axis}", "N m", form))
    return (F_b, *moments)


@cache
def _rigid_equations(body: sp.ImmutableMatrix, net: tuple[Any, ...]) -> Equations:
    m, S = body[0, 0], sp.Matrix([body[1, 5], body[2, 3], body[0, 4]])
    F_b, tau = net[0], sp.Matrix(net[1:])
    U = (F_b - m * GRAVITY) * qv.DEPTH - (GRAVITY * S + tau).dot(qv.down())
    M, V, G = qv.equations_of_motion(qv.energy_of_matrix(sp.Matrix(body)), U)
    angles = [sp.sin(qv.PITCH), sp.cos(qv.PITCH) * sp.sin(qv.ROLL), sp.cos(qv.PITCH) * sp.cos(qv.ROLL)]
    return Equations(M, _by_inertia(V, body), G.applyfunc(lambda entry: sp.collect(sp.expand(entry), angles)))


@cache
def _added_equations(A: sp.ImmutableMatrix) -> Equations:
    T = qv.energy_of_matrix(sp.Matrix(A))
    return Equations(qv.inertia(T), _by_inertia(qv.coriolis(T), A), sp.zeros(6, 1))


def _by_inertia(vector: sp.Matrix, matrix: sp.ImmutableMatrix) -> sp.Matrix:
    """Return a vector whose entries are collected by the entries of an inertia matrix."""
    symbols = sorted(matrix.free_symbols, key=str)
    return vector.applyfunc(lambda entry: sp.collect(sp.expand(entry), symbols))


def _coordinates() -> Section:
    k = Display(sp.Symbol("k"), qv.down(), "words")
    nu = Display(sp.Symbol("nu"), sp.Matrix(qv.NU), "words")
    rates = Written(
        "z' = k . v,  phi' = p + (q sin phi + r cos phi) tan theta,  theta' = q cos phi - r sin phi",
        r"\dot{z} = k \cdot v,\quad \dot{\phi} = p + (q \sin\phi + r \cos\phi) \tan\theta,\quad "
        r"\dot{\theta} = q \cos\phi - r \sin\phi",
    )
    words = (
        "Velocity v = [u, v, w] of the body origin and angular velocity omega = [p, q, r], body axes: x to the nose, y "
        "to starboard, z down through the keel. Roll phi, pitch theta nose up; k points down. Yaw and place do not "
        "matter. The extensions e are held: M, V and G follow them, but the momentum of the parts' own motion is left "
        "out. Left out too are currents, stratification, compression, surface and bed: still water of the surface's "
        "density everywhere."
    )
    return Section("Coordinates", words, (nu, k, Display(rates, None, "words")))


def _energies(composition: Composition, buoyancy: Mapping[str, Any]) -> Section:
    """Write T and U as sums over the components."""
    T: Any = sp.Integer(0)
    U: Any = sp.Integer(0)
    for n, part in zip(composition.indices, composition.parts, strict=True):
        speed, spin, low, middle = sp.symbols(f"v_g{n} E_{n} z_g{n} z_b{n}", real=True)
        T += part.mass * speed**2 / 2 + (0 if part.inertia.is_zero_matrix else spin)
        U += buoyancy.get(n, 0) * middle - part.mass * GRAVITY * low
    displays = (
        Display(sp.Symbol("T"), T, "words"),
        Display(Written(
            "v_gn = v + omega x l_gn,  E_n = omega^T I_n omega / 2",
            r"v_{gn} = v + \omega \times l_{gn},\quad E_n = \tfrac{1}{2}\,\omega^T I_n\, \omega",
        ), None, "words"),
        Display(sp.Symbol("U"), U, "words"),
        Display(Written("z_gn = z + k . l_gn,  z_bn = z + k . l_bn",
                        r"z_{gn} = z + k \cdot l_{gn},\quad z_{bn} = z + k \cdot l_{bn}"), None, "words"),
    )  # fmt: skip
    words = "One term a component: l_g is its centre of mass, l_b its centre of buoyancy, I its inertia about l_g."
    return Section("Energies", words, displays)


def _composites(notation: Notation) -> Section:
    whole = next(group for group in notation.groups if group.title == "Whole vehicle")
    words = "Read off T and U by differentiation; each force with its own arm."
    return Section("Sums over the components", words, definitions([e.symbol for e in whole.entries], [whole]))


def _equations_section(rigid: Equations, added: Equations, A: sp.Matrix) -> Section:
    M, V, G = sp.symbols("M V G")
    words = (
        "M is d2T/dnu2; V is omega x P, and omega x Pi + v x P, with the momenta P = dT/dv, Pi = dT/domega; G is what "
        "weight and buoyancy lack of balance, by dU/dt = G . nu for every motion."
    )
    if A.is_zero_matrix:
        return Section("M, V, G", words, (Display(M, rigid.M), Display(V, rigid.V), Display(G, rigid.G)))
    M_RB, M_A, V_RB, V_A = sp.symbols("M_RB M_A V_RB V_A")
    displays = (
        Display(M_RB, rigid.M), Display(M_A, added.M), Display(V_RB, rigid.V), Display(V_A, added.V),
        Display(G, rigid.G),
    )  # fmt: skip
    words += " RB is what the components give, A what the added mass does; M = M_RB + M_A, V = V_RB + V_A."
    return Section("M, V, G", words, displays)


def _force_section(forces: Forces) -> Section:
    steps = tuple(Display(symbol, form) for symbol, form in forces.steps)
    whole = Written("M nu' + V + G = tau", r"M\,\dot{\nu} + V(\nu) + G(\phi,\theta) = \tau")
    words = (
        "V_w is the speed through the water, alpha the angle of attack, beta the sideslip. P_L, P_D, P_tau over alpha "
        "and C_X ... C_N over both angles, where they stand, are the laws fitted to the design's table."
    )
    displays = (*steps, Display(sp.Symbol("tau"), forces.vector), Display(whole, None, "words"))
    return Section("Forces of the water", words, displays)
