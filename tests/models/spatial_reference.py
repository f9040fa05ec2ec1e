"""Owns a second spatial simulator to hold the kernel against: momenta in world axes, rotation matrix, NumPy and SciPy.

Written from the equations (docs/spatial.md), not from the kernel: it reads the design itself and shares no code
with `assemble`. The states are x, R (body to world), P and H, the linear momentum and the angular momentum about the
moving body origin, both in world axes: of the body, p_R = m v + omega x m r_G and h_R = m r_G x v + I_O omega, and of
the water it sets in motion, (p_A, h_A) = M_A [v - R^T v_c, omega]. With V and V_r = V - v_c the velocity over ground
and through the water (Lamb, Hydrodynamics, 1932, art. 124; the same about a fixed point loses both cross products),

    dP/dt = F + (dM/dt nu),  dH/dt = T - V x P_R - V_r x P_A + (dM/dt nu).

The shear along the path needs no term here: it is the change of p_A. The terms in brackets undo what the momenta gain
when the mass properties change with the extensions, as the model leaves out the parts' own motion: M nu' is the force.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from models.design import Design
from tests.models.reference import ReferenceLaw, commanded

Array = NDArray[np.float64]
Profile = Callable[[float], float]
Extensions = dict[str, float]
ZERO = np.zeros(3)
DOWN = np.array([0.0, 0.0, 1.0])


def skew(a: Array) -> Array:
    """S(a) with S(a) b = a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def tensor(inertia: Any) -> Array:
    xx, yy, zz, xy, xz, yz = (getattr(inertia, name) for name in ("xx", "yy", "zz", "xy", "xz", "yz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def unit_axis(part: Any) -> Array:
    axis = np.array(part.axis)
    return np.asarray(axis / np.linalg.norm(axis))


def rotation_from_euler(roll: float, pitch: float, yaw: float) -> Array:
    """R (body to world) of yaw, then pitch, then roll about the turned axes."""
    return np.asarray(Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix())


class Current(NamedTuple):
    """Velocity of the water at a depth and time, and its partial derivatives; world axes."""

    velocity: Array
    by_depth: Array
    by_time: Array


def current_law(current: Any) -> Callable[[float, float], Current]:
    """v_c(z, t) of a description."""
    if current is None or current.kind == "uniform":
        steady = np.array([*(current.velocity if current else (0.0, 0.0)), 0.0])
        return lambda z, t: Current(steady, ZERO, ZERO)
    if current.kind == "sheared":
        top, shear = (np.array([*pair, 0.0]) for pair in (current.surface_velocity, current.shear))
        return lambda z, t: Current(top + shear * z, shear, ZERO)
    profiles = np.stack([current.north, current.east, np.zeros_like(current.north)], axis=-1)  # (time, depth, 3)
    curves = [PchipInterpolator(current.depths, profile) for profile in profiles]
    slopes = [curve.derivative() for curve in curves]
    first, last = current.depths[0], current.depths[-1]

    def tabulated(z: float, t: float) -> Current:
        held = min(max(z, first), last)
        k = int(np.searchsorted(current.times, t, side="right")) - 1
        inside = 0 <= k < len(curves) - 1
        k = max(k, 0)
        value, slope, change = curves[k](held), slopes[k](held), ZERO
        if inside:
            span = current.times[k + 1] - current.times[k]
            share = (t - current.times[k]) / span
            change = (curves[k + 1](held) - value) / span
            value, slope = value + share * (curves[k + 1](held) - value), slope + share * (slopes[k + 1](held) - slope)
        return Current(value, slope if first <= z <= last else ZERO, change)

    return tabulated


def water_laws(water: Any, gravity: float) -> tuple[Profile, Profile]:
    """Density and gauge pressure (0 above the surface) against depth of uniform water or of a density profile."""
    if water.kind == "uniform":
        rho = float(water.density)
        return lambda z: rho, lambda z: max(rho * gravity * z, 0.0)
    if water.kind != "density_profile":
        raise NotImplementedError("give density and pressure as functions of depth, and gravity, for this water")
    curve = PchipInterpolator(water.depths, water.densities)
    first, last = water.depths[0], water.depths[-1]

    def density(z: float) -> float:
        return float(curve(min(max(z, first), last)))

    def pressure(z: float) -> float:
        middle = float(curve.integrate(first, min(max(z, first), last)))
        above, below = max(min(z, first), 0.0), max(z - last, 0.0)
        return gravity * (water.densities[0] * above + middle + water.densities[-1] * below)

    return density, pressure


class Displaced(NamedTuple):
    """A part's volume without pressure, its first moment and centre in body axes, and what pressure and surface do."""

    volume: float
    moment: Array
    center: Array
    bulk_modulus: float | None
    height: float


def volume_and_moment(part: Any, e: float) -> tuple[float, Array]:
    """Displaced volume and its first moment (3): the core stays, the stack's centre moves by half its growth."""
    home = np.array(part.position)
    if part.kind in ("movable_mass", "rolling_mass"):
        return 0.0, ZERO
    if part.kind == "rigid":
        return part.volume, part.volume * home
    if part.kind == "bladder":
        volume = float(PchipInterpolator(part.extensions, part.volumes)(e))
        return volume, volume * home
    if part.kind == "piston":
        core, stack = part.volume, part.area * e
    else:
        r, R, pleats = part.inner_radius, part.outer_radius, part.pleats
        core = part.fixed_volume + pleats * part.pleat_volume + pleats * part.gap_volume
        frustum_height = e / pleats if part.as_printed else e / (2 * pleats)
        stack = 2 * pleats * (math.pi / 3.0) * frustum_height * (r**2 + r * R + R**2)
    return core + stack, (core + stack) * home + stack * (e - part.neutral) / 2.0 * unit_axis(part)


def displaced(part: Any, e: float) -> Displaced | None:
    volume, moment = volume_and_moment(part, e)
    neutral_volume = volume_and_moment(part, getattr(part, "neutral", 0.0))[0]
    if part.kind in ("movable_mass", "rolling_mass"):
        return None
    height = part.height if part.height is not None else (6.0 * neutral_volume / math.pi) ** (1.0 / 3.0)
    shift = moment / volume - part.position if volume > 0.0 else ZERO
    reach = abs(e - part.neutral) / 2.0 if part.kind in ("bellows", "piston") else 0.0
    far = float(np.linalg.norm(shift))
    # the centre of a cell that is nearly empty runs away; where its water is felt stays within half the travel
    center = np.array(part.position) + shift * (min(far, reach) / far if far > 0.0 else 0.0)
    return Displaced(volume, moment, center, part.bulk_modulus, height)


class Mass(NamedTuple):
    """Mass, first moment m r_G and inertia tensor about the body origin, or the rates of all three."""

    mass: float
    moment: Array
    inertia: Array

    @property
    def matrix(self) -> Array:
        """M_RB (6, 6) about the body origin."""
        S = skew(self.moment)
        return np.block([[self.mass * np.eye(3), -S], [S, self.inertia]])


def total(masses: list[Mass]) -> Mass:
    return Mass(*(sum(entries) for entries in zip(*masses, strict=True)))


def part_mass(part: Any, e: float, rate: float) -> tuple[Mass, Mass]:
    """One part's mass properties about the body origin, and their rates while its extension changes at `rate`."""
    center, own = np.array(part.center_of_mass or part.position), tensor(part.inertia)
    velocity, turning = ZERO, np.zeros((3, 3))
    if part.kind == "movable_mass":
        center, velocity = center + (e - part.neutral) * unit_axis(part), rate * unit_axis(part)
    elif part.kind == "rolling_mass":
        axis, pivot = unit_axis(part), np.array(part.pivot)
        turn = Rotation.from_rotvec((e - part.neutral) * axis).as_matrix()
        center, own, turning = pivot + turn @ (center - pivot), turn @ own @ turn.T, skew(rate * axis)
        velocity = turning @ (center - pivot)
    S, dS = skew(center), skew(velocity)
    now = Mass(part.mass, part.mass * center, own - part.mass * S @ S)
    return now, Mass(0.0, part.mass * velocity, turning @ own - own @ turning - part.mass * (dS @ S + S @ dS))


class State(NamedTuple):
    """Position in the world, R (body to world), velocity over ground and angular velocity in body axes."""

    position: Array
    R: Array
    v: Array
    omega: Array


class Flow(NamedTuple):
    """Motion through the water in body axes: velocity, angular velocity, speed."""

    v: Array
    omega: Array
    speed: float

    @property
    def alpha(self) -> float:
        return math.atan2(self.v[2], self.v[0])

    @property
    def sine(self) -> float:
        """sin(beta); 0 at rest."""
        return self.v[1] / self.speed if self.speed > 0.0 else 0.0


class SpatialReference:
    """The spatial glider of a design; extensions are given as a mapping by name (missing ones are neutral).

    `density` (kg/m3) and `pressure` (gauge, Pa) are functions of depth; `gravity` replaces the environment's.
    `angle_law(alpha, beta)` gives [X, Y, Z, K, M, N] / V^2 where the source is an angle table.
    """

    def __init__(
        self, design: Design, density: Profile | None = None, pressure: Profile | None = None, *,
        gravity: float | None = None, angle_law: Callable[[float, float], Array] | None = None,
    ) -> None:  # fmt: skip
        self.design, self.vehicle = design, design.vehicle
        environment = design.mission.environment
        stated = environment.gravity if environment.gravity is not None else 9.8
        self.gravity = stated if gravity is None else gravity
        if density is None or pressure is None:
            own = water_laws(environment.water, self.gravity)
            density, pressure = density or own[0], pressure or own[1]
        self.density, self.pressure = density, pressure
        self.current = current_law(environment.current)
        self.floats = environment.surface == "float"
        added = self.vehicle.added_mass
        self.M_A = np.zeros((6, 6))
        if added is not None and added.enabled:
            self.M_A = np.array(added.matrix) * density(0.0) / added.density
        damping = self.vehicle.damping
        names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
        self.D = np.diag([getattr(damping, name) for name in names])
        if damping.matrix is not None:
            self.D = self.D + np.array(damping.matrix)
        source = self.vehicle.hydrodynamics
        self.law: Any = ReferenceLaw(source) if source.kind == "polar_table" else angle_law
        if source.kind == "angle_table" and angle_law is None:
            raise NotImplementedError("give the law of an angle table")

    def mass(self, extensions: Extensions, rates: Extensions | None = None) -> tuple[Mass, Mass]:
        """Mass properties about the body origin, and their rates."""
        declared = self.vehicle.mass_properties
        if declared.kind == "declared":
            r = np.array(declared.center_of_mass)
            inertia = tensor(declared.inertia) - declared.mass * skew(r) @ skew(r)
            return Mass(declared.mass, declared.mass * r, inertia), Mass(0.0, ZERO, np.zeros((3, 3)))
        now, change = [], []
        for part in self.vehicle.components:
            e = extensions.get(part.name, getattr(part, "neutral", 0.0))
            its_own, its_change = part_mass(part, e, (rates or {}).get(part.name, 0.0))
            now.append(its_own)
            change.append(its_change)
        return total(now), total(change)

    def volumes(self, extensions: Extensions) -> list[Displaced]:
        parts = self.vehicle.components
        all_parts = (displaced(p, extensions.get(p.name, getattr(p, "neutral", 0.0))) for p in parts)
        return [d for d in all_parts if d is not None]

    def share(self, part: Displaced, z: float) -> float:
        """Share of a volume that displaces water with its centre at depth z: compressed, and faded if it floats."""
        share = 1.0 if part.bulk_modulus is None else 1.0 - max(self.pressure(z), 0.0) / part.bulk_modulus
        if self.floats:
            h = part.height
            s = min(max((z + h / 2.0) / h, 0.0), 1.0) if h > 0.0 else float(z > 0.0)
            share *= s * s * (3.0 - 2.0 * s)
        return share

    def static_wrench(self, state: State, mass: Mass, volumes: list[Displaced], t: float) -> tuple[Array, Array]:
        """Weight, buoyancy and the push of a current that changes in time: force and moment in world axes."""
        F = mass.mass * self.gravity * DOWN
        T = cross(state.R @ mass.moment, self.gravity * DOWN)
        for part in volumes:
            z = float(state.position[2] + state.R[2] @ part.center)
            weight = self.density(z) * self.share(part, z)
            push = self.current(z, t).by_time - self.gravity * DOWN
            F = F + weight * part.volume * push
            T = T + cross(state.R @ part.moment, weight * push)
        return F, T

    def hydrodynamic_wrench(self, flow: Flow, density: float) -> tuple[Array, Array]:
        """Force and moment of the source about the body origin, in body axes."""
        source = self.vehicle.hydrodynamics
        scale = density / source.reference_density
        if source.kind == "polar_table":
            return self._polar_wrench(source, flow, scale)
        F, T = self._coefficients(source, flow) if source.kind == "coefficients" else self._angles(source, flow)
        T = scale * (T + cross(np.array(source.reference_point), F))
        F = scale * F
        if source.kind == "angle_table":
            X, N = rate_wrench(source.rates, flow)
            F, T = F + scale * X, T + scale * N
        return F, T + self._munk(flow) if source.includes_munk_moment else T

    def _munk(self, flow: Flow) -> Array:
        """v_r x (A11 v_r): undoes the Munk moment that the momenta make."""
        return cross(flow.v, self.M_A[:3, :3] @ flow.v)

    def _polar_wrench(self, source: Any, flow: Flow, scale: float) -> tuple[Array, Array]:
        u, _, w = flow.v
        L, D, moment = self.law(flow.alpha) * (u * u + w * w)
        c, s = math.cos(flow.alpha), math.sin(flow.alpha)
        F = np.array([-D * c + L * s, 0.0, -D * s - L * c])
        T = np.array([0.0, moment + source.reference_point[2] * F[0] - source.reference_point[0] * F[2], 0.0])
        munk = ZERO
        if source.includes_munk_moment:
            munk = np.array([0.0, 1.0, 0.0]) * self._munk(flow._replace(v=np.array([u, 0.0, w])))
        given = source.lateral
        if given is not None:
            b, q = flow.sine, flow.speed**2
            F[1] += q * (given.sway_sideslip * b + given.sway_crossflow * b * abs(b))
            T[0] += q * (given.roll_sideslip * b + given.roll_crossflow * b * abs(b))
            T[2] += q * (given.yaw_sideslip * b + given.yaw_crossflow * b * abs(b))
            X, N = rate_wrench(given.rates, flow)
            F, T = F + X, T + N
            if given.includes_munk_moment:
                munk = munk + np.array([1.0, 0.0, 1.0]) * self._munk(flow)
        return scale * F, scale * T + munk

    @staticmethod
    def _coefficients(k: Any, flow: Flow) -> tuple[Array, Array]:
        """The literature's coefficients, turned from the flow frame to the body's: Ry(-alpha) Rz(beta)."""
        a, b, (p, q, r), V2 = flow.alpha, math.asin(min(max(flow.sine, -1.0), 1.0)), flow.omega, flow.speed**2
        S = {"speed_squared": V2, "speed": flow.speed, "none": 1.0}[k.rate_scaling]
        D = (k.drag_zero + k.drag_attack * a * a + k.drag_sideslip * b * b) * V2
        L, SF = (k.lift_zero + k.lift_attack * a) * V2, k.side_sideslip * b * V2
        roll = k.roll_sideslip * b * V2 + k.roll_rate * p * S
        pitch = (k.pitch_zero + k.pitch_attack * a) * V2 + (k.pitch_rate * q + k.pitch_rate_square * q * abs(q)) * S
        yaw = k.yaw_sideslip * b * V2 + k.yaw_rate * r * S
        to_body = Rotation.from_euler("YZ", [-a, b]).as_matrix()
        return to_body @ np.array([-D, SF, -L]), to_body @ np.array([roll, pitch, yaw])

    def _angles(self, source: Any, flow: Flow) -> tuple[Array, Array]:
        wrench = np.asarray(self.law(flow.alpha, math.asin(min(max(flow.sine, -1.0), 1.0)))) * flow.speed**2
        return wrench[:3], wrench[3:]

    def rates(
        self, state: State, mass: Mass, change: Mass, volumes: list[Displaced], t: float
    ) -> tuple[Array, Array]:  # fmt: skip
        """dP/dt and dH/dt, world axes."""
        R, nu = state.R, np.concatenate([state.v, state.omega])
        v_c = self.current(float(state.position[2]), t).velocity
        v_r = state.v - R.T @ v_c
        nu_r = np.concatenate([v_r, state.omega])
        F, T = self.static_wrench(state, mass, volumes, t)
        flow = Flow(v_r, state.omega, float(np.linalg.norm(v_r)))
        hydro = np.concatenate(self.hydrodynamic_wrench(flow, self.density(float(state.position[2]))))
        body = hydro - self.D @ nu_r + change.matrix @ nu
        P_R, P_A = R @ (mass.matrix[:3] @ nu), R @ (self.M_A[:3] @ nu_r)
        swept = cross(R @ state.v, P_R) + cross(R @ v_r, P_A)
        return F + R @ body[:3], T + R @ body[3:] - swept

    def momenta(self, state: State, mass: Mass, t: float) -> tuple[Array, Array]:
        """P and H about the body origin, world axes."""
        v_c = self.current(float(state.position[2]), t).velocity
        nu = np.concatenate([state.v, state.omega])
        nu_r = np.concatenate([state.v - state.R.T @ v_c, state.omega])
        momentum = mass.matrix @ nu + self.M_A @ nu_r
        return state.R @ momentum[:3], state.R @ momentum[3:]

    def motion(self, position: Array, R: Array, P: Array, H: Array, mass: Mass, t: float) -> State:
        """The state that has the momenta P and H."""
        v_c = self.current(float(position[2]), t).velocity
        momentum = np.concatenate([R.T @ P, R.T @ H]) + self.M_A[:, :3] @ (R.T @ v_c)
        nu = np.linalg.solve(mass.matrix + self.M_A, momentum)
        return State(position, R, nu[:3], nu[3:])

    def acceleration(
        self, position: Array, R: Array, v: Array, omega: Array, extensions: Extensions, t: float
    ) -> tuple[Array, Array]:
        """v' and omega' in body axes: the rates of the momenta, seen from the turning body."""
        state = State(*(np.asarray(a, dtype=float) for a in (position, R, v, omega)))
        R, omega = state.R, state.omega
        mass, still = self.mass(extensions)
        dP, dH = self.rates(state, mass, still, self.volumes(extensions), t)
        P, H = self.momenta(state, mass, t)
        seen = np.concatenate([R.T @ dP - cross(omega, R.T @ P), R.T @ dH - cross(omega, R.T @ H)])
        current = self.current(float(state.position[2]), t)
        along = current.by_time + float(R[2] @ state.v) * current.by_depth
        carried = R.T @ along - cross(omega, R.T @ current.velocity)
        nu_dot = np.linalg.solve(mass.matrix + self.M_A, seen + self.M_A[:, :3] @ carried)
        return nu_dot[:3], nu_dot[3:]

    def energies(
        self, position: Array, R: Array, v: Array, omega: Array, extensions: Extensions, t: float
    ) -> tuple[float, float]:
        """T and U, J: the water's motion counts by the velocity through it, U = 0 with all centres at the surface."""
        mass, _ = self.mass(extensions)
        nu = np.concatenate([v, omega])
        nu_r = np.concatenate([v - R.T @ self.current(float(position[2]), t).velocity, omega])
        U = -self.gravity * (mass.mass * position[2] + R[2] @ mass.moment)
        for part in self.volumes(extensions):
            z = float(position[2] + R[2] @ part.center)

            def weight(depth: float, part: Displaced = part) -> float:
                return self.density(depth) * self.share(part, depth)

            levels = getattr(self.design.mission.environment.water, "depths", ())
            corners = (m for m in (-part.height / 2.0, part.height / 2.0, *levels) if min(0.0, z) < m < max(0.0, z))
            whole = sum(gauss(weight, a, b) for a, b in pairwise(sorted({0.0, z, *corners})))
            U += self.gravity * part.volume * math.copysign(whole, z)
            U += self.gravity * float(R[2] @ (part.moment - part.volume * part.center)) * weight(z)
        return float(nu @ mass.matrix @ nu + nu_r @ self.M_A @ nu_r) / 2.0, float(U)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def gauss(f: Profile, a: float, b: float) -> float:
    """Integral of f from a to b, exact for polynomials up to degree 23."""
    return (
        (b - a)
        / 2.0
        * float(sum(w * f((a + b) / 2.0 + (b - a) / 2.0 * x) for x, w in zip(NODES, WEIGHTS, strict=True)))
    )


def rate_wrench(k: Any, flow: Flow) -> tuple[Array, Array]:
    """Force and moment of the rate terms, body axes."""
    S = flow.speed if k.scaling == "speed" else flow.speed**2
    p, q, r = flow.omega
    F = np.array([0.0, k.sway_roll * p + k.sway_yaw * r, k.heave_pitch * q])
    T = np.array([k.roll_roll * p + k.roll_yaw * r, k.pitch_pitch * q, k.yaw_roll * p + k.yaw_yaw * r])
    return S * F, S * T


def initial_state(glider: SpatialReference) -> State:
    start = glider.design.mission.initial
    R = rotation_from_euler(start.roll, start.pitch, start.yaw)
    v_c = glider.current(start.position[2], 0.0).velocity
    return State(np.array(start.position), R, np.array(start.velocity) + R.T @ v_c, np.array(start.angular_velocity))


def orthonormal(R: Array) -> Array:
    """The rotation nearest to R."""
    left, _, right = np.linalg.svd(R)
    return np.asarray(left @ right)


def glide(
    glider: SpatialReference, state: State, a: float, b: float, *, tolerance: float, max_step: float
) -> State:  # fmt: skip
    """The state at b from that at a, where the commands run linearly and the current is smooth."""
    ends = commanded(glider.design, a, before=False), commanded(glider.design, b, before=True)
    rates = {name: (ends[1][name] - e) / (b - a) for name, e in ends[0].items()}
    start, change = glider.mass(ends[0], rates)
    held = (start, change, glider.volumes(ends[0])) if ends[0] == ends[1] else None

    def at(t: float) -> tuple[Mass, Mass, list[Displaced]]:
        if held is not None:
            return held
        extensions = {name: e + (t - a) * rates[name] for name, e in ends[0].items()}
        return *glider.mass(extensions, rates), glider.volumes(extensions)

    def slope(t: float, y: Array) -> Array:
        t = min(t, math.nextafter(b, a))  # the current's rate of change jumps at b: take its limit from the left
        mass, change, volumes = at(t)
        now = glider.motion(y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:], mass, t)
        turning = (now.R @ skew(now.omega)).ravel()
        return np.concatenate([now.R @ now.v, turning, *glider.rates(now, mass, change, volumes, t)])

    P, H = glider.momenta(state, start, a)
    y = np.concatenate([state.position, state.R.ravel(), P, H])
    y = solve_ivp(slope, (a, b), y, method="DOP853", rtol=tolerance, atol=tolerance, max_step=max_step).y[:, -1]
    return glider.motion(y[:3], orthonormal(y[3:12].reshape(3, 3)), y[12:15], y[15:], at(b)[0], b)


def simulate_spatial_reference(
    design: Design, tolerance: float = 1e-12, *, glider: SpatialReference | None = None, times: Iterable[float] = (),
    max_step: float = 0.01,
) -> tuple[list[float], list[State]]:  # fmt: skip
    """Integrate with DOP853, started anew at every schedule point, time of the current's table and one of `times`.

    The velocities are continuous where the mass properties jump. Corners in curvature of 'pchip' escape the error
    estimate of long steps, hence `max_step` (s).
    """
    glider = glider or SpatialReference(design)
    mission = design.mission
    corners = {p.time for told in mission.control.schedules for p in told.points}
    corners |= {*times, *getattr(mission.environment.current, "times", ())}
    marks = [0.0, *sorted(t for t in corners if 0.0 < t < mission.duration), mission.duration]
    states = [initial_state(glider)]
    for a, b in pairwise(marks):
        states.append(glide(glider, states[-1], a, b, tolerance=tolerance, max_step=max_step))
    return marks, states
