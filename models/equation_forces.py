"""Owns the right-hand sides in symbols: what the water does, by the design's own source of force, and linear damping.

Laws fitted to data stay functions: P_L, P_D, P_tau of the angle of attack (Canete et al., Eq. 8), C_X ... C_N of both
angles. The formulas are those of docs/physics.md, sections 4 and 5, and docs/spatial.md, sections 2 and 4. Still water.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from models.added_mass import damping_matrix
from models.derivation import DENSITY, Q_DOT, rotation
from models.derivation import Q as COORDINATES
from models.design import Design
from models.equation_symbols import Notation
from models.hydrodynamics import LateralCoefficients, PolarTable, RateTerms
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.quasi_velocities import NU

LATERAL_RATES = {
    "heave_pitch": (2, 1), "pitch_pitch": (4, 1), "sway_roll": (1, 0), "sway_yaw": (1, 2),
    "roll_roll": (3, 0), "roll_yaw": (3, 2), "yaw_roll": (5, 0), "yaw_yaw": (5, 2),
}  # fmt: skip
"""Which force (of six) a rate term gives, by which rate (of three)."""
ADDED_UNITS, DAMPING_UNITS = ("kg", "kg m", "kg m2"), ("N s/m", "N s", "N m s")
"""Units of the blocks: translations alone, both, rotations alone."""
ALPHA, BETA, SPEED = sp.symbols("alpha beta V_w", real=True)
SURGE, HEAVE = sp.symbols("u w", real=True)
LIFT, DRAG, TORQUE = sp.symbols("F_L F_D tau", real=True)


@dataclass(frozen=True)
class Forces:
    """What the water gives: `steps` in the order in which they are computed, (symbol, expression), then the vector.

    `vector` is the generalized force Q (3, 1) of Eq. 5, without the C q' on its left side, or X ... N (6, 1) in body
    axes. `damping` is C (3, 3), or D (6, 6) that is part of the vector.
    """

    steps: tuple[tuple[Any, Any], ...]
    vector: sp.Matrix
    damping: sp.Matrix


def planar_forces(design: Design, notation: Notation, A: sp.Matrix) -> Forces:
    """Return Q of Eqs. 6 to 8, 11 and 12 with the design's source; `A` is the planar added mass (3, 3)."""
    source, scale = design.vehicle.hydrodynamics, _scale(design, notation)
    theta, (x_dot, z_dot, theta_dot) = COORDINATES[2], Q_DOT
    u, w = rotation(theta).T * sp.Matrix([x_dot, z_dot])
    lift, drag, torque = _plane_law(source, notation)
    steps = [
        (SURGE, u), (HEAVE, w), (SPEED, sp.sqrt(x_dot**2 + z_dot**2)), (ALPHA, sp.atan2(HEAVE, SURGE)),
        (LIFT, scale * lift * SPEED**2), (DRAG, scale * drag * SPEED**2), (TORQUE, scale * torque * SPEED**2),
    ]  # fmt: skip
    X_h = LIFT * sp.sin(ALPHA) - DRAG * sp.cos(ALPHA)
    Z_h = -DRAG * sp.sin(ALPHA) - LIFT * sp.cos(ALPHA)
    ref = _reference_point(source, notation, "xz")
    rates = _rates(source, notation, planar=True) * _rate_scale(source) * scale * theta_dot
    D = [_given(notation, design.vehicle.damping, field) for field in ("surge", "heave", "pitch")]
    moment = TORQUE + ref[2] * X_h - ref[0] * Z_h + rates[4, 1]
    if source.includes_munk_moment:
        moment -= (A[1, 1] - A[0, 0]) * SURGE * HEAVE + A[0, 1] * (SURGE**2 - HEAVE**2)
    X, Z = sp.symbols("X Z", real=True)
    steps += [(X, X_h - D[0] * SURGE), (Z, Z_h - D[1] * HEAVE + rates[2, 1])]
    Q = sp.Matrix([*(rotation(theta) * sp.Matrix([X, Z])), moment])
    return Forces(tuple(steps), Q, sp.diag(0, 0, D[2]))


def spatial_forces(design: Design, notation: Notation, A: sp.Matrix) -> Forces:
    """Return X ... N of the source and of damping, body axes, at rest relative to the world's water."""
    source, scale = design.vehicle.hydrodynamics, _scale(design, notation)
    u, v, w = NU[:3]
    steps: list[tuple[Any, Any]] = [
        (SPEED, sp.sqrt(u**2 + v**2 + w**2)), (ALPHA, sp.atan2(w, u)), (BETA, sp.atan2(v, sp.sqrt(u**2 + w**2))),
    ]  # fmt: skip
    if isinstance(source, PolarTable):
        force, moment = _polar(source, notation, steps)
    elif isinstance(source, AngleTable):
        laws = [sp.Function(f"C_{name}", real=True)(ALPHA, BETA) * SPEED**2 for name in "XYZKMN"]
        force, moment = sp.Matrix(laws[:3]), sp.Matrix(laws[3:])
    else:
        force, moment = _coefficients(source, notation, steps)
    named = sp.Matrix(sp.symbols("X_h Y_h Z_h", real=True))
    steps += list(zip(named, force, strict=True))
    arm = _reference_point(source, notation, "xyz").cross(named)
    moment = moment + (sp.Matrix([0, arm[1], 0]) if isinstance(source, PolarTable) else arm)
    rates = _rates(source, notation, planar=False) * _rate_scale(source)
    turning = rates * sp.Matrix(NU[3:])
    D = _matrix(notation, "D", "linear damping", DAMPING_UNITS, damping_matrix(design), range(1, 7))
    total = scale * (sp.Matrix([*named, *moment]) + turning) - D * NU
    return Forces(tuple(steps), total + _munk(source, A), D)


def _scale(design: Design, notation: Notation) -> Any:
    notation.begin("Forces of the water")
    reference = design.vehicle.hydrodynamics.reference_density
    return DENSITY / notation.given("rhoref", "density at which the forces were taken", "kg/m3", reference)


def _given(notation: Notation, owner: Any, field: str) -> Any:
    """Return the symbol of one of the design's coefficients, 0 where that is 0."""
    value, meta = getattr(owner, field), type(owner).model_fields[field]
    if value == 0.0:
        return sp.Integer(0)
    extra: Any = meta.json_schema_extra
    words = (meta.description or "").rstrip(".")
    return notation.given(extra["symbol"], words[:1].lower() + words[1:], extra["unit"], value)


def _plane_law(source: Any, notation: Notation) -> tuple[Any, Any, Any]:
    """Return lift, drag and moment per squared speed."""
    if isinstance(source, CoefficientForm):
        lift = _given(notation, source, "lift_zero") + _given(notation, source, "lift_attack") * ALPHA
        drag = _given(notation, source, "drag_zero") + _given(notation, source, "drag_attack") * ALPHA**2
        pitch = _given(notation, source, "pitch_zero") + _given(notation, source, "pitch_attack") * ALPHA
        return lift, drag, pitch
    return tuple(sp.Function(f"P_{name}", real=True)(ALPHA) for name in ("L", "D", "tau"))


def _polar(source: PolarTable, notation: Notation, steps: list[tuple[Any, Any]]) -> tuple[sp.Matrix, sp.Matrix]:
    """Return force and moment of a table over the angle of attack with its lateral coefficients."""
    u, v, w = NU[:3]
    lift, drag, torque = _plane_law(source, notation)
    in_plane = u**2 + w**2
    steps += [(LIFT, lift * in_plane), (DRAG, drag * in_plane)]
    X = LIFT * sp.sin(ALPHA) - DRAG * sp.cos(ALPHA)
    Z = -DRAG * sp.sin(ALPHA) - LIFT * sp.cos(ALPHA)
    across = []
    for name in ("sway", "roll", "yaw"):
        linear, crossed = (
            _given(notation, source.lateral, f"{name}_{what}") if source.lateral else sp.Integer(0)
            for what in ("sideslip", "crossflow")
        )
        across.append(linear * SPEED * v + crossed * v * sp.Abs(v))
    return sp.Matrix([X, across[0], Z]), sp.Matrix([across[1], torque * in_plane, across[2]])


def _coefficients(
    source: CoefficientForm, notation: Notation, steps: list[tuple[Any, Any]]
) -> tuple[sp.Matrix, sp.Matrix]:
    """Return force and moment of the coefficient form, turned from the flow frame to the body."""
    p, q, r = NU[3:]
    lift, drag, pitch = _plane_law(source, notation)
    sideslip = {name: _given(notation, source, f"{name}_sideslip") for name in ("drag", "side", "roll", "yaw")}
    rate = {name: _given(notation, source, f"{name}_rate") for name in ("roll", "pitch", "yaw")}
    square = _given(notation, source, "pitch_rate_square")
    scale, v2 = _rate_scale(source), SPEED**2
    SF, K, M, N = sp.symbols("SF K_f M_f N_f", real=True)
    steps += [
        (DRAG, (drag + sideslip["drag"] * BETA**2) * v2), (SF, sideslip["side"] * BETA * v2), (LIFT, lift * v2),
        (K, sideslip["roll"] * BETA * v2 + rate["roll"] * p * scale),
        (M, pitch * v2 + (rate["pitch"] + square * sp.Abs(q)) * q * scale),
        (N, sideslip["yaw"] * BETA * v2 + rate["yaw"] * r * scale),
    ]  # fmt: skip
    sa, ca, sb, cb = sp.sin(ALPHA), sp.cos(ALPHA), sp.sin(BETA), sp.cos(BETA)
    turn = sp.Matrix([[ca * cb, -ca * sb, -sa], [sb, cb, 0], [sa * cb, -sa * sb, ca]])
    return turn * sp.Matrix([-DRAG, SF, -LIFT]), turn * sp.Matrix([K, M, N])


def _reference_point(source: Any, notation: Notation, axes: str) -> sp.Matrix:
    """Return the point about which moments were taken; a coordinate that is 0 gets no symbol."""
    entries = [
        notation.given(f"r_ref{axis}", f"point of the moments, {axis}", "m", value) if value and axis in axes else 0
        for axis, value in zip("xyz", source.reference_point, strict=True)
    ]
    return sp.Matrix(entries)


def _rates(source: Any, notation: Notation, *, planar: bool) -> sp.Matrix:
    """Return the forces by the rates of turning (6, 3), before their scaling; the coefficient form has its own."""
    matrix = sp.zeros(6, 3)
    if isinstance(source, CoefficientForm):
        if planar:
            square = _given(notation, source, "pitch_rate_square") * sp.Abs(Q_DOT[2])
            matrix[4, 1] = _given(notation, source, "pitch_rate") + square
        return matrix
    terms = _rate_terms(source)
    for field, place in LATERAL_RATES.items():
        if not planar or field.endswith("_pitch"):
            matrix[place] = _given(notation, terms, field)
    return matrix


def _rate_terms(source: Any) -> RateTerms:
    if isinstance(source, AngleTable):
        return source.rates
    lateral: LateralCoefficients | None = source.lateral
    return lateral.rates if lateral is not None else RateTerms()


def _rate_scale(source: Any) -> Any:
    scaling = source.rate_scaling if isinstance(source, CoefficientForm) else _rate_terms(source).scaling
    return {"none": sp.Integer(1), "speed": SPEED, "speed_squared": SPEED**2}[scaling]


def _munk(source: Any, A: sp.Matrix) -> sp.Matrix:
    """Return v x (A11 v), where the source holds that moment already, as a force (6, 1)."""
    v = sp.Matrix(NU[:3])
    whole = v.cross(A[:3, :3] * v)
    u, w = v[0], v[2]
    in_plane = w * (A[0, 0] * u + A[0, 2] * w) - u * (A[2, 0] * u + A[2, 2] * w)
    if not isinstance(source, PolarTable):
        return sp.Matrix([0, 0, 0, *whole]) if source.includes_munk_moment else sp.zeros(6, 1)
    lateral = source.lateral is not None and source.lateral.includes_munk_moment
    pitch = in_plane if source.includes_munk_moment else sp.Integer(0)
    return sp.Matrix([0, 0, 0, whole[0] if lateral else 0, pitch, whole[2] if lateral else 0])


def _matrix(
    notation: Notation, base: str, words: str, units: tuple[str, str, str], values: Any, numbers: Any
) -> sp.Matrix:
    """Return a matrix of symbols, one for each entry that is not 0; entries that are equal by symmetry share theirs."""
    numbers = list(numbers)
    matrix = sp.zeros(len(numbers), len(numbers))
    symmetric = bool(np.allclose(values, np.transpose(values), rtol=1e-12, atol=0.0))
    for i, a in enumerate(numbers):
        for j, b in enumerate(numbers):
            if symmetric and j < i:
                matrix[i, j] = matrix[j, i]
            elif values[i, j] != 0.0:
                unit = units[(a > 3) + (b > 3)]
                matrix[i, j] = notation.given(f"{base}_{a}{b}", f"{words}, {a}{b}", unit, values[i, j])
    return matrix


def added_mass_symbols(notation: Notation, values: Any, numbers: Any) -> sp.Matrix:
    """Return the added mass in symbols, numbered as in six degrees of freedom; zeros where the design has none."""
    if np.any(values):
        notation.begin("Added mass")
    return _matrix(notation, "A", "added mass", ADDED_UNITS, values, numbers)
