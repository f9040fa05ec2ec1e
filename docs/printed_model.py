"""Owns the paper's equations in world axes, Eqs. 1 to 8, 11 and 12, with each form it prints as a switch.

Canete et al., Eq. 5, integrated by SciPy's DOP853 from switch to switch: it shares the force law and the components'
volumes with the library, but neither its body-axis equations nor its integrators. Declared mass, no added mass, cells
without rate limit or lag. SI units, z down.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from models.design import DeclaredMass, Design
from models.hydrodynamic_law import HydrodynamicLaw, build_law
from models.mass_properties import component_center_of_buoyancy, initial_extensions
from models.volumes import volume

Array = NDArray[np.float64]
RUNAWAY = 2.0
"""Speed at which a glide is given up, m/s: more than twenty times what the buoyancy can drive."""


class Forms(NamedTuple):
    """Which forms are taken as the paper prints them."""

    rotation: bool = False
    """Eqs. 6 and 7: the first matrix is [[c, -s], [s, c]] instead of R(theta)."""
    arctangent: bool = False
    """Eq. 11: arctan(z_dot / x_dot) instead of atan2."""
    fixed_centers: bool = False
    """Cells keep their centre of buoyancy as they extend."""


AS_DERIVED = Forms()


class Glide(NamedTuple):
    """A path: time (n,), x, z, theta, x_dot, z_dot, theta_dot (6, n), and how it ended."""

    time: Array
    state: Array
    ending: str


@dataclass(frozen=True)
class Buoyancy:
    """Forces (n,) and arms (n, 2) of all components while the extensions are held."""

    force: Array
    arm: Array


def rotation(theta: float) -> Array:
    """Return R(theta) of Eq. 2, body to world."""
    s, c = np.sin(theta), np.cos(theta)
    return np.array([[c, s], [-s, c]])


def angle_of_attack(q: Array, *, arctangent: bool) -> float:
    """Return alpha of Eq. 11, wrapped to [-pi, pi]; q is the whole state (6,)."""
    theta, x_dot, z_dot = q[2:5]
    with np.errstate(divide="ignore", invalid="ignore"):
        flow = np.nan_to_num(np.arctan(z_dot / x_dot)) if arctangent else np.arctan2(z_dot, x_dot)
    return float(np.remainder(flow + theta + np.pi, 2.0 * np.pi) - np.pi)


def generalized_force(q: Array, law: HydrodynamicLaw, forms: Forms) -> Array:
    """Return Q of Eq. 7, (3,), from lift, drag and moment at the squared speed of Eq. 12."""
    alpha = angle_of_attack(q, arctangent=forms.arctangent)
    lift, drag, moment = law(alpha) * (q[3] ** 2 + q[4] ** 2)
    s, c = np.sin(alpha), np.cos(alpha)
    body = np.array([[c, -s], [s, c]]) @ np.array([-drag, -lift])
    first = rotation(q[2]).T if forms.rotation else rotation(q[2])
    return np.array([*(first @ body), moment])


class PrintedModel:
    """Eq. 5 of a design, with M, V, C, G as they stand below it (tau_bx with each force's own arm)."""

    def __init__(self, design: Design, forms: Forms = AS_DERIVED) -> None:
        declared = design.vehicle.mass_properties
        if not isinstance(declared, DeclaredMass):
            raise TypeError(f"the paper declares its mass properties; this design has {declared.kind!r} ones")
        self.design, self.forms = design, forms
        self.law = build_law(design.vehicle.hydrodynamics)
        self.M, self.I = declared.mass, declared.inertia.yy
        self.l_gx, _, self.l_gz = declared.center_of_mass
        self.C33 = design.vehicle.damping.pitch
        self.g = design.mission.environment.gravity
        self.rho = design.mission.environment.water.density

    def buoyancy(self, extensions: dict[str, float]) -> Buoyancy:
        """Return F_b and l_b of every component at the given extensions."""
        parts = [(c, extensions.get(c.name, 0.0)) for c in self.design.vehicle.components]
        centers = [
            np.array(c.position) if self.forms.fixed_centers else component_center_of_buoyancy(c, e) for c, e in parts
        ]
        force = np.array([self.rho * self.g * volume(c, e) for c, e in parts])
        return Buoyancy(force, np.array(centers)[:, ::2])

    def slope(self, q: Array, held: Buoyancy) -> Array:
        """Return d/dt of [x, z, theta, x_dot, z_dot, theta_dot]."""
        M, l_gx, l_gz = self.M, self.l_gx, self.l_gz
        s, c, rate = np.sin(q[2]), np.cos(q[2]), q[5]
        M13, M23 = M * (l_gz * c - l_gx * s), -M * (l_gz * s + l_gx * c)
        inertia = np.array([[M, 0.0, M13], [0.0, M, M23], [M13, M23, M * (l_gx**2 + l_gz**2) + self.I]])
        coriolis = np.array([M23 * rate**2, -M13 * rate**2, 0.0])
        tau_bx, tau_bz = -held.force @ held.arm
        F_g = M * self.g
        gravity = np.array(
            [0.0, held.force.sum() - F_g, (tau_bz + F_g * l_gz) * s + (tau_bx + F_g * l_gx) * c]
        )  # fmt: skip
        damping = np.array([0.0, 0.0, self.C33 * rate])
        Q = generalized_force(q, self.law, self.forms)
        return np.concatenate([q[3:], np.linalg.solve(inertia, Q - coriolis - damping - gravity)])

    def glide(self) -> Glide:
        """Integrate the mission's steps; ends early at the surface or above `RUNAWAY`."""
        mission = self.design.mission
        switches = {p.time for s in mission.control.schedules for p in s.points if p.time < mission.duration}
        marks = sorted({0.0, mission.duration} | switches)
        start = mission.initial
        q = np.array([start.position[0], start.position[2], start.pitch, 0.0, 0.0, 0.0])
        times, states, ending = [], [], "completed"
        for a, b in pairwise(marks):
            held = self.buoyancy(self._extensions(a))
            solution = solve_ivp(
                lambda _t, y, held=held: self.slope(y, held), (a, b), q, method="DOP853", rtol=1e-12, atol=1e-13,
                dense_output=True, events=[_surface, _runaway],
            )  # fmt: skip
            t = np.append(np.arange(a, solution.t[-1], 0.05), solution.t[-1])
            times.append(t)
            states.append(solution.sol(t))
            q = solution.y[:, -1]
            if solution.status == 1:
                ending = "surface" if len(solution.t_events[0]) else "runaway"
                break
        return Glide(np.concatenate(times), np.concatenate(states, axis=1), ending)

    def _extensions(self, t: float) -> dict[str, float]:
        extensions = initial_extensions(self.design)
        for schedule in self.design.mission.control.schedules:
            for point in schedule.points:
                if point.time <= t:
                    extensions[schedule.cell] = point.extension
        return extensions


def _surface(_t: float, q: Array, *_: Any) -> float:
    return float(q[1])


def _runaway(_t: float, q: Array, *_: Any) -> float:
    return float(np.hypot(q[3], q[4]) - RUNAWAY)


for _event in (_surface, _runaway):
    _event.terminal = True  # type: ignore[attr-defined]
