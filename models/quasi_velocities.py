"""Owns the symbolic derivation of the spatial equations from T and U; for developers, tests and docs, never in a run.

Lagrange's equations in the quasi-velocities nu = [u v w p q r] of the body (Kirchhoff; Meirovitch, 1970, Methods of
Analytical Dynamics, 4.8), extensions held:

    d/dt dT/dv + omega x dT/dv = force        d/dt dT/domega + omega x dT/domega + v x dT/dv = moment

With T = nu^T M nu / 2 this is M nu' + V(nu) + G(phi, theta) = forces of the water. SI units, z down.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import sympy as sp

from models.derivation import DENSITY, GRAVITY, Equations

NU = sp.Matrix(sp.symbols("u v w p q r", real=True))
NU_DOT = sp.Matrix(sp.symbols("u_dot v_dot w_dot p_dot q_dot r_dot", real=True))
V, OMEGA = NU[:3, 0], NU[3:, 0]
DEPTH, ROLL, PITCH = sp.symbols("z phi theta", real=True)


class SpatialPart(NamedTuple):
    """One part: mass, centre of mass (3, 1), inertia about it (3, 3), volume, its centre (3, 1)."""

    mass: Any = sp.Integer(0)
    l_g: Any = sp.zeros(3, 1)
    inertia: Any = sp.zeros(3, 3)
    volume: Any = sp.Integer(0)
    l_b: Any = sp.zeros(3, 1)


def down() -> sp.Matrix:
    """Return k, the unit vector down in body axes: the third row of R (body to world)."""
    s, c = sp.sin(PITCH), sp.cos(PITCH)
    return sp.Matrix([-s, c * sp.sin(ROLL), c * sp.cos(ROLL)])


def kinetic_energy(parts: Sequence[SpatialPart]) -> Any:
    """Return T: each part by the velocity of its centre of mass, v + omega x l_g, and its spin."""
    T: Any = sp.Integer(0)
    for part in parts:
        speed = V + OMEGA.cross(part.l_g)
        T += part.mass * speed.dot(speed) / 2 + (OMEGA.T * part.inertia * OMEGA)[0] / 2
    return T


def energy_of_matrix(M: sp.Matrix) -> Any:
    """Return nu^T M nu / 2."""
    return (NU.T * M * NU)[0] / 2


def potential_energy(parts: Sequence[SpatialPart]) -> Any:
    """Return U(z, phi, theta): weight at the depth of each centre of mass, buoyancy at that of each volume."""
    k, U = down(), sp.Integer(0)
    for part in parts:
        U += DENSITY * GRAVITY * part.volume * (DEPTH + k.dot(part.l_b))
        U -= part.mass * GRAVITY * (DEPTH + k.dot(part.l_g))
    return U


def inertia(T: Any) -> sp.Matrix:
    """Return M = d2T / dnu2, (6, 6)."""
    return sp.hessian(T, list(NU))


def coriolis(T: Any) -> sp.Matrix:
    """Return V = [omega x P, omega x Pi + v x P] with the momenta P = dT/dv, Pi = dT/domega, (6, 1)."""
    momenta = sp.Matrix([T.diff(x) for x in NU])
    P, Pi = momenta[:3, 0], momenta[3:, 0]
    return sp.Matrix([OMEGA.cross(P), OMEGA.cross(Pi) + V.cross(P)])


def gravity(U: Any) -> sp.Matrix:
    """Return G (6, 1) by virtual displacement: dU/dt = G . nu, for z, phi and theta change as nu says.

    z' = k . v, phi' = p + (q sin phi + r cos phi) tan theta, theta' = q cos phi - r sin phi.
    """
    p, q, r = OMEGA
    s, c = sp.sin(ROLL), sp.cos(ROLL)
    roll_rate = p + (q * s + r * c) * sp.sin(PITCH) / sp.cos(PITCH)
    rate = U.diff(DEPTH) * down().dot(V) + U.diff(ROLL) * roll_rate + U.diff(PITCH) * (q * c - r * s)
    return sp.Matrix([sp.trigsimp(sp.expand(rate.diff(x))) for x in NU])


def equations_of_motion(T: Any, U: Any) -> Equations:
    """Derive M, V, G of M nu' + V + G = forces of the water."""
    return Equations(inertia(T), coriolis(T), gravity(U))
