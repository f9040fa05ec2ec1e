"""The planar equations in plain Python and NumPy, as a user's own script has them: Eq. 5 in world coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from models.design import Design
from models.hydrodynamic_law import build_law
from models.mass_properties import initial_extensions, mass_balance

Array = NDArray[np.float64]


def planar_equations(design: Design, extensions: dict[str, float]) -> Callable[[float, Array], Array]:
    """Return the right-hand side for q = [x, z, theta] and its rates at fixed extensions, without added mass."""
    balance = mass_balance(design.vehicle, extensions)
    M, I = balance.mass, balance.inertia[1, 1]  # noqa: E741
    lx, _, lz = balance.center_of_mass
    bx, _, bz = balance.center_of_buoyancy
    environment = design.mission.environment
    Fg = M * environment.gravity
    Fb = environment.water.density * environment.gravity * balance.volume
    C33 = design.vehicle.damping.pitch
    law = build_law(design.vehicle.hydrodynamics)

    def right_hand_side(t: float, y: Array) -> Array:
        theta, xd, zd, td = y[2], y[3], y[4], y[5]
        s, c = math.sin(theta), math.cos(theta)
        alpha = math.remainder(math.atan2(zd, xd) + theta, 2 * math.pi) if xd or zd else 0.0
        L, D, tau = law(alpha) * (xd * xd + zd * zd)
        sa, ca = math.sin(alpha), math.cos(alpha)
        Fx, Fz = -D * ca + L * sa, -D * sa - L * ca
        M13, M23 = M * (lz * c - lx * s), -M * (lz * s + lx * c)
        mass = np.array([[M, 0, M13], [0, M, M23], [M13, M23, M * (lx * lx + lz * lz) + I]])
        V = np.array([M23 * td * td, -M13 * td * td, 0.0])
        G = np.array([0.0, Fb - Fg, (-Fb * bz + Fg * lz) * s + (-Fb * bx + Fg * lx) * c])
        Q = np.array([c * Fx + s * Fz, -s * Fx + c * Fz, tau])
        return np.concatenate([y[3:], np.linalg.solve(mass, Q - V - np.array([0.0, 0.0, C33 * td]) - G)])

    return right_hand_side


def solve_reference(design: Design, times: Array, *, method: str, tolerance: float) -> Array:
    """Integrate a design whose cells only step, restarting at each step; return states (6, times)."""
    initial = design.mission.initial
    y = np.array([initial.position[0], initial.position[2], initial.pitch, 0.0, 0.0, 0.0])
    extensions = initial_extensions(design)
    switches = sorted({p.time for s in design.mission.control.schedules for p in s.points} | {0.0})
    ends = [*switches[1:], design.mission.duration]
    columns = []
    for begin, end in zip(switches, ends, strict=True):
        for schedule in design.mission.control.schedules:
            extensions |= {cell: p.extension for cell in (schedule.cell,) for p in schedule.points if p.time == begin}
        inside = times[(times >= begin) & ((times < end) | (end == design.mission.duration))]
        solution = solve_ivp(
            planar_equations(design, extensions), (begin, end), y,
            method=method, rtol=tolerance, atol=tolerance, t_eval=np.unique([*inside, end]),
        )  # fmt: skip
        columns.append(solution.y[:, : len(inside)])
        y = solution.y[:, -1]
    return np.concatenate(columns, axis=1)
