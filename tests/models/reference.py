"""Owns a second simulator to hold the kernel against: Eq. 5 in world coordinates, NumPy and SciPy, ideal actuators.

Written from the equations, not from the kernel: it reads the design itself and shares no code with `assemble`.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from models.design import Design
from models.water import gravity_of

Array = NDArray[np.float64]
SIGNS = {"row_lift": (-1.0, -1.0), "row_drag": (1.0, 1.0), "row_moment": (-1.0, 1.0)}
"""Sign of each column at -alpha, and at 180 deg - alpha."""
DEGREES = {"row_lift": 5, "row_drag": 4, "row_moment": 7}


class ReferenceLaw:
    """Lift, drag and moment per squared speed from a table of the design."""

    def __init__(self, table: Any) -> None:
        speeds = np.array(table.row_speed)
        chosen = [table.speed] if table.speed is not None else sorted(set(table.row_speed))
        self.angles = np.radians(np.array(table.row_alpha_deg)[speeds == chosen[0]])
        self.data = {
            name: np.mean([np.array(getattr(table, name))[speeds == v] / v**2 for v in chosen], axis=0)
            for name in SIGNS
        }
        self.data["row_lift"][0] = self.data["row_moment"][0] = 0.0
        self.curve = self._polynomials() if table.law == "polynomial" else self._pchip()

    def _pchip(self) -> Any:
        self.data["row_lift"][-1] = 0.0
        a = self.angles
        quarter = np.column_stack([self.data[name] for name in SIGNS])
        below, beyond = (np.array([signs[i] for signs in SIGNS.values()]) for i in (0, 1))
        half = np.vstack([quarter, beyond * quarter[-2::-1]])
        half_angles = np.concatenate([a, math.pi - a[-2::-1]])
        circle = np.vstack([below * half[:0:-1], half])
        circle_angles = np.concatenate([-half_angles[:0:-1], half_angles])
        turns = [circle_angles[:-1] - 2 * math.pi, circle_angles, circle_angles[1:] + 2 * math.pi]
        return PchipInterpolator(np.concatenate(turns), np.vstack([circle[:-1], circle, circle[1:]]))

    def _polynomials(self) -> Any:
        columns = []
        for name, degree in DEGREES.items():
            powers = np.arange(0 if name == "row_drag" else 1, degree + 1)
            fit = np.linalg.lstsq(self.angles[:, None] ** powers, self.data[name], rcond=None)[0]
            columns.append((powers, fit))

        def curve(alpha: float) -> Array:
            size, values = abs(alpha), []
            folded = min(size, math.pi - size)
            for (powers, fit), (below, beyond) in zip(columns, SIGNS.values(), strict=True):
                sign = (below if alpha < 0.0 else 1.0) * (beyond if size > math.pi / 2 else 1.0)
                values.append(sign * float(folded**powers @ fit))
            return np.array(values)

        return curve

    def __call__(self, alpha: float) -> Array:
        return np.asarray(self.curve(alpha), dtype=float)


class Balance(NamedTuple):
    """Mass, centre of mass [x, z], pitch inertia about it, displaced volume and its first moment [x, z]."""

    mass: float
    center: Array
    inertia: float
    volume: float
    moment: Array


class ReferenceGlider:
    """The planar glider of a design; extensions are given as a mapping by name."""

    def __init__(self, design: Design) -> None:
        self.design, self.vehicle = design, design.vehicle
        self.law = ReferenceLaw(design.vehicle.hydrodynamics)
        environment = design.mission.environment
        self.density, self.gravity = environment.water.density, gravity_of(environment)
        added = design.vehicle.added_mass
        full = np.array(added.matrix) * self.density / added.density if added and added.enabled else np.zeros((6, 6))
        self.A = full[np.ix_([0, 2, 4], [0, 2, 4])]

    def volume_and_moment(self, part: Any, e: float) -> tuple[float, Array]:
        """Displaced volume and its first moment [x, z]: the core stays, the stack's centre moves by half its growth."""
        home = np.array(part.position)[[0, 2]]
        if part.kind == "rigid":
            return part.volume, part.volume * home
        if part.kind == "movable_mass":
            return 0.0, 0.0 * home
        if part.kind == "bladder":
            V = float(PchipInterpolator(part.extensions, part.volumes)(e))
            return V, V * home
        if part.kind == "piston":
            core, stack = part.volume, part.area * e
        else:
            r, R = part.inner_radius, part.outer_radius
            core = part.fixed_volume + part.pleats * (part.pleat_volume + part.gap_volume)
            height = e / part.pleats * (1.0 if part.as_printed else 0.5)
            stack = 2 * part.pleats * math.pi / 3.0 * height * (r * r + r * R + R * R)
        axis = np.array(part.axis)[[0, 2]] / np.linalg.norm(part.axis)
        return core + stack, (core + stack) * home + stack * axis * 0.5 * (e - part.neutral)

    def mass_and_center(self, extensions: dict[str, float]) -> tuple[float, Array, float]:
        """Mass, centre of mass [x, z] and pitch inertia about it."""
        declared = self.vehicle.mass_properties
        if declared.kind == "declared":
            return declared.mass, np.array(declared.center_of_mass)[[0, 2]], declared.inertia.yy
        masses, centers, own = [], [], []
        for part in self.vehicle.components:
            center = np.array(part.center_of_mass or part.position)[[0, 2]]
            if part.kind == "movable_mass":
                axis = np.array(part.axis)[[0, 2]] / np.linalg.norm(part.axis)
                center = center + (extensions[part.name] - part.neutral) * axis
            masses.append(part.mass)
            centers.append(center)
            own.append(part.inertia.yy)
        m, r = np.array(masses), np.array(centers)
        center = m @ r / m.sum()
        return float(m.sum()), center, float(sum(own) + m @ ((r - center) ** 2).sum(axis=1))

    def generalized_force(self, q: Array, v: Array) -> Array:
        """Q of Eqs. 6 to 8, 11, 12, with the damping of the design, moments moved to the body origin."""
        s, c = math.sin(q[2]), math.cos(q[2])
        R = np.array([[c, s], [-s, c]])
        u, w = R.T @ v[:2]
        alpha = (math.atan2(v[1], v[0]) + q[2] + math.pi) % (2 * math.pi) - math.pi
        table, speed2 = self.vehicle.hydrodynamics, v[0] ** 2 + v[1] ** 2
        L, D, moment = self.law(alpha) * speed2 * self.density / table.reference_density
        F = np.array([-D * math.cos(alpha) + L * math.sin(alpha), -D * math.sin(alpha) - L * math.cos(alpha)])
        x_r, _, z_r = table.reference_point
        moment += z_r * F[0] - x_r * F[1]
        damping = self.vehicle.damping
        if table.includes_munk_moment:
            A = self.A
            moment -= (A[1, 1] - A[0, 0]) * u * w + A[0, 1] * (u * u - w * w)
        moment -= damping.pitch * v[2]
        return np.array([*(R @ (F - np.array([damping.surge * u, damping.heave * w]))), moment])

    def balance(self, extensions: dict[str, float]) -> Balance:
        """Mass properties and displaced volume with its first moment, at given extensions."""
        total, moment = 0.0, np.zeros(2)
        for part in self.vehicle.components:
            volume, first = self.volume_and_moment(part, extensions.get(part.name, 0.0))
            total, moment = total + volume, moment + first
        return Balance(*self.mass_and_center(extensions), total, moment)

    def matrices(self, q: Array, v: Array, balance: Balance) -> tuple[Array, Array, Array]:
        """M, V, G of Eq. 5 with the added mass."""
        s, c, rate = math.sin(q[2]), math.cos(q[2]), v[2]
        m, (lx, lz), inertia, volume, (moment_x, moment_z) = balance
        M13, M23 = m * (lz * c - lx * s), -m * (lz * s + lx * c)
        M = np.array([[m, 0.0, M13], [0.0, m, M23], [M13, M23, m * (lx * lx + lz * lz) + inertia]])
        V = np.array([M23 * rate**2, -M13 * rate**2, 0.0])
        G = self.gravity * np.array([0.0, -m, m * (lz * s + lx * c)])
        G += self.density * self.gravity * np.array([0.0, volume, -(moment_z * s + moment_x * c)])
        J = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        dJ = np.array([[-s, -c, 0.0], [c, -s, 0.0], [0.0, 0.0, 0.0]])
        dM = dJ.T @ self.A @ J + J.T @ self.A @ dJ
        V += rate * dM @ v - np.array([0.0, 0.0, 0.5 * v @ dM @ v])
        return M + J.T @ self.A @ J, V, G

    def acceleration(self, q: Array, v: Array, balance: Balance) -> Array:
        M, V, G = self.matrices(q, v, balance)
        return np.linalg.solve(M, self.generalized_force(q, v) - V - G)


def commanded(design: Design, t: float, *, before: bool) -> dict[str, float]:
    """Extensions of ideal actuators at t; `before` takes the limit from the left at a step."""
    given = design.mission.initial.extensions
    extensions = {c.name: given.get(c.name, c.neutral) for _, c in design.vehicle.actuated}
    for told in design.mission.control.schedules:
        last_t, value = 0.0, extensions[told.cell]
        for point in told.points:
            reached = t > point.time or (t == point.time and not before)
            if not reached:
                if point.shape == "ramp" and t > last_t:
                    value += (point.extension - value) * (t - last_t) / (point.time - last_t)
                break
            last_t, value = point.time, point.extension
        extensions[told.cell] = value
    return extensions


def simulate_reference(design: Design, tolerance: float = 1e-13) -> tuple[list[float], list[Array]]:
    """Integrate with DOP853, started anew at every schedule point; the states [q, q'] at those times and the end."""
    glider, mission = ReferenceGlider(design), design.mission
    start, end = mission.initial, mission.duration
    times = {p.time for told in mission.control.schedules for p in told.points if 0.0 < p.time < end}
    marks = [0.0, *sorted(times), end]
    s, c = math.sin(start.pitch), math.cos(start.pitch)
    u, _, w = start.velocity
    velocity = [c * u + s * w, -s * u + c * w, start.angular_velocity[1]]
    y = np.array([start.position[0], start.position[2], start.pitch, *velocity])
    states = [y]
    for a, b in pairwise(marks):
        ends = commanded(design, a, before=False), commanded(design, b, before=True)

        held = glider.balance(ends[0]) if ends[0] == ends[1] else None

        def slope(t: float, y: Array, a: float = a, b: float = b, ends: Any = ends, held: Any = held) -> Array:
            share = (t - a) / (b - a)
            balance = held or glider.balance({n: e + share * (ends[1][n] - e) for n, e in ends[0].items()})
            return np.concatenate([y[3:], glider.acceleration(y[:3], y[3:], balance)])

        # the corners in curvature of 'pchip' escape the error estimate of long steps: 4e-7 at a tolerance of 1e-13
        y = solve_ivp(slope, (a, b), y, method="DOP853", rtol=tolerance, atol=tolerance, max_step=0.01).y[:, -1]
        states.append(y)
    return marks, states


def world_state(y: Array) -> Array:
    """[q, q'] of a kernel state, which keeps its velocity in body axes."""
    s, c = math.sin(y[2]), math.cos(y[2])
    return np.array([y[0], y[1], y[2], c * y[3] + s * y[4], -s * y[3] + c * y[4], y[5]])
