"""Owns the symbolic derivation of the planar equations from T and U; for developers, tests and docs, never in a run.

Canete et al., Eqs. 1 to 5, for any number of parts: q = [x, z, theta] in the world (z down), Euler-Lagrange from
L = T - U by differentiation. Extensions are held: a part's volume and centres may be expressions of them, but are
constant in time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]

Q = sp.Matrix(sp.symbols("x z theta", real=True))
Q_DOT = sp.Matrix(sp.symbols("x_dot z_dot theta_dot", real=True))
Q_DDOT = sp.Matrix(sp.symbols("x_ddot z_ddot theta_ddot", real=True))
GRAVITY, DENSITY = sp.symbols("g rho", positive=True)


class Part(NamedTuple):
    """One part in numbers, symbols or expressions: mass, centre of mass, inertia about it, volume, its centre."""

    mass: Any = sp.Integer(0)
    l_gx: Any = sp.Integer(0)
    l_gz: Any = sp.Integer(0)
    inertia: Any = sp.Integer(0)
    volume: Any = sp.Integer(0)
    l_bx: Any = sp.Integer(0)
    l_bz: Any = sp.Integer(0)


class Equations(NamedTuple):
    """M(q) q'' + V(q, q') + G(q), the left-hand side of Eq. 5 without its damping."""

    M: sp.Matrix
    V: sp.Matrix
    G: sp.Matrix


def part_symbols(n: int) -> Part:
    """Return part n with a mass, an inertia and a volume of its own."""
    return Part(*sp.symbols(f"m_{n} l_g{n}x l_g{n}z I_{n} V_{n} l_b{n}x l_b{n}z", real=True))


def composite_parts(count: int) -> tuple[Part, ...]:
    """Return `count` parts, each with its own mass."""
    return tuple(part_symbols(n) for n in range(count))


def paper_parts(count: int) -> tuple[Part, ...]:
    """Return the paper's parts: `count` displaced volumes, and all mass in one centre with M, I (Eq. 3)."""
    M, l_gx, l_gz, inertia = sp.symbols("M l_gx l_gz I", real=True)
    volumes = [Part(volume=part.volume, l_bx=part.l_bx, l_bz=part.l_bz) for part in composite_parts(count)]
    return (volumes[0]._replace(mass=M, l_gx=l_gx, l_gz=l_gz, inertia=inertia), *volumes[1:])


def added_mass_symbols() -> sp.Matrix:
    """Return the planar added mass, symmetric (3, 3): surge, heave, pitch in body axes."""
    a11, a13, a15, a33, a35, a55 = sp.symbols("a11 a13 a15 a33 a35 a55", real=True)
    return sp.Matrix([[a11, a13, a15], [a13, a33, a35], [a15, a35, a55]])


def rotation(theta: Any) -> sp.Matrix:
    """Return R(theta) of Eq. 2, body to world."""
    return sp.Matrix([[sp.cos(theta), sp.sin(theta)], [-sp.sin(theta), sp.cos(theta)]])


def time_derivative(expression: Any) -> Any:
    """Return d/dt of an expression of q and q' by the chain rule, so that q'' enters it."""
    matrix = sp.Matrix([expression])
    return (matrix.jacobian(Q) * Q_DOT + matrix.jacobian(Q_DOT) * Q_DDOT)[0]


def place(l_x: Any, l_z: Any) -> sp.Matrix:
    """Return where a body point lies in the world (Eq. 1)."""
    return rotation(Q[2]) * sp.Matrix([l_x, l_z]) + sp.Matrix(Q[:2])


def kinetic_energy(parts: Sequence[Part], added_mass: sp.Matrix | None = None) -> Any:
    """Return T: Eq. 3 summed over the parts, and that of the added mass, nu^T A nu / 2 with nu in body axes."""
    T: Any = sp.Integer(0)
    for part in parts:
        x_G, z_G = place(part.l_gx, part.l_gz)
        speed_squared = time_derivative(x_G) ** 2 + time_derivative(z_G) ** 2
        T += part.mass * speed_squared / 2 + part.inertia * Q_DOT[2] ** 2 / 2
    if added_mass is not None:
        nu = body_jacobian() * Q_DOT
        T += (nu.T * added_mass * nu)[0] / 2
    return T


def potential_energy(parts: Sequence[Part]) -> Any:
    """Return U of Eq. 4: weight at each centre of mass, buoyancy at each centre of buoyancy, z down."""
    U: Any = sp.Integer(0)
    for part in parts:
        U += DENSITY * GRAVITY * part.volume * place(part.l_bx, part.l_bz)[1]
        U -= part.mass * GRAVITY * place(part.l_gx, part.l_gz)[1]
    return U


def body_jacobian() -> sp.Matrix:
    """Return J with [u, w, q] = J q'."""
    return sp.diag(rotation(Q[2]).T, 1)


def euler_lagrange(T: Any, U: Any) -> sp.Matrix:
    """Return d/dt (dL/dq') - dL/dq with L = T - U, (3, 1)."""
    L = sp.Matrix([T - U])
    momenta, forces = L.jacobian(Q_DOT), L.jacobian(Q)
    return sp.Matrix([time_derivative(momenta[i]) - forces[i] for i in range(3)])


def equations_of_motion(parts: Sequence[Part], added_mass: sp.Matrix | None = None) -> Equations:
    """Derive M, V, G of Eq. 5 from the energies of the parts and of the added mass, as they come: not simplified."""
    return equations_from(kinetic_energy(parts, added_mass), potential_energy(parts))


def equations_from(T: Any, U: Any) -> Equations:
    """Derive M, V, G of Eq. 5 from T(q, q') and U(q)."""
    left = euler_lagrange(T, U)
    M = left.jacobian(Q_DDOT)
    at_rest = dict.fromkeys([*Q_DOT, *Q_DDOT], 0)
    G = left.subs(at_rest)
    V = left.subs(dict.fromkeys(Q_DDOT, 0)) - G
    return Equations(M, V, G)


def simplified(equations: Equations) -> Equations:
    """Return the equations in their shortest form; takes seconds for several parts with added mass."""
    return Equations(*(matrix.applyfunc(sp.simplify) for matrix in equations))


def printed_equations(count: int) -> Equations:
    """Return M, V, G as the paper prints them below Eq. 5, each force with its own arm in tau_bx, for `count` parts."""
    parts, s, c = paper_parts(count), sp.sin(Q[2]), sp.cos(Q[2])
    M, l_gx, l_gz, inertia = parts[0][:4]
    F_g = M * GRAVITY
    F_b = [DENSITY * GRAVITY * part.volume for part in parts]
    tau_bz = -sum(F * part.l_bz for F, part in zip(F_b, parts, strict=True))
    tau_bx = -sum(F * part.l_bx for F, part in zip(F_b, parts, strict=True))
    M13, M23 = M * (l_gz * c - l_gx * s), -M * (l_gz * s + l_gx * c)
    return Equations(
        sp.Matrix([[M, 0, M13], [0, M, M23], [M13, M23, M * l_gz**2 + M * l_gx**2 + inertia]]),
        sp.Matrix([M23 * Q_DOT[2] ** 2, -M13 * Q_DOT[2] ** 2, 0]),
        sp.Matrix([0, -F_g + sum(F_b), (tau_bz + F_g * l_gz) * s + (tau_bx + F_g * l_gx) * c]),
    )


@dataclass(frozen=True)
class Evaluator:
    """M, V, G as one compiled function of q (3,), q' (3,) and the values of `arguments`, in that order."""

    arguments: tuple[Any, ...]
    function: Callable[..., Any]

    def __call__(self, q: Array, q_dot: Array, values: Sequence[float]) -> tuple[Array, Array, Array]:
        """Return M (3, 3), V (3,), G (3,) as numbers."""
        M, V, G = self.function(*q, *q_dot, *values)
        return np.asarray(M, dtype=np.float64), np.ravel(V).astype(np.float64), np.ravel(G).astype(np.float64)


def evaluator(equations: Equations, arguments: Sequence[Any]) -> Evaluator:
    """Compile equations with `sympy.lambdify`; `arguments` are the symbols that get values besides q and q'."""
    function = sp.lambdify([*Q, *Q_DOT, *arguments], list(equations), modules="numpy", cse=True)
    return Evaluator(tuple(arguments), function)


def acceleration(M: Array, V: Array, G: Array, generalized_force: Array) -> Array:
    """Solve Eq. 5 for q'' (3,); damping belongs to the generalized force."""
    return np.asarray(np.linalg.solve(M, generalized_force - V - G), dtype=np.float64)
