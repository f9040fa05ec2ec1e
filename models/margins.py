"""Owns static margins along a run: hydrostatic, of weight and buoyancy, and hydrodynamic, of the flow about the hull.

Hydrostatic margin: by how much the centre of buoyancy lies above that of mass along gravity, m. Hydrodynamic margin:
(x of the centre of mass - x of the neutral point) / length, the neutral point being where a change of force acts: from
dM/dZ over the angle of attack in pitch, from dN/dY over the sideslip in yaw, both at fixed speed (Etkin and Reid, 1996,
2.3). In a flow from behind (u < 0), where a point of action ahead of the centre of mass rights, their sign is turned:
positive margins right the glider whichever way it moves. Body axes, SI units.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.kernel import outputs as planar_outputs
from models.kernel import params, spatial_layout, spatial_outputs
from models.mass_properties import mass_balance
from models.run import Run
from models.vehicle_length import vehicle_length
from models.water import gravity_of

Array = NDArray[np.float64]
SLOWEST = 1e-3
"""Below this speed (m/s) the flow rights nothing."""
TURN = 1e-4
"""Step in angle of attack and sideslip, rad."""
STEERED = ((0.0, 0.0), (TURN, 0.0), (-TURN, 0.0), (0.0, TURN), (0.0, -TURN))
"""Turns of the flow, in angle of attack and sideslip, from which slopes are taken: as it is, then up, down, aside."""
LEAST_SLOPE = 0.1
"""A neutral point needs a force that opposes the turn, by at least this share of the whole force per rad."""


class Hydrostatics(NamedTuple):
    """Along a run: `offset` (samples, 3) from the centre of buoyancy to that of mass, m, body axes.

    `margin` is its part along gravity, m; `pitch` and `roll` the righting moments per angle about body y and x over the
    weight, m.
    """

    offset: Array
    margin: Array
    pitch: Array
    roll: Array


class Hydrodynamics(NamedTuple):
    """Along a run: margins (samples,) as shares of `length` (m); not numbers where the flow says nothing."""

    pitch: Array
    yaw: Array
    length: float


def down_along(run: Run) -> tuple[Array, Array | float, Array]:
    """Return the unit vector down in body axes, by sample."""
    theta = run.values["theta"]
    if run.model == "planar":
        return -np.sin(theta), 0.0, np.cos(theta)
    phi, cp = run.values["phi"], np.cos(theta)
    return -np.sin(theta), cp * np.sin(phi), cp * np.cos(phi)


def offset_along(run: Run) -> tuple[Array, Array | float, Array]:
    """Return the way from the centre of buoyancy to that of mass in body axes, m, by sample."""
    v = run.values
    y = v["com_y"] - v["cob_y"] if run.model == "spatial" else 0.0
    return v["com_x"] - v["cob_x"], y, v["com_z"] - v["cob_z"]


def immersed(run: Run) -> NDArray[np.bool_]:
    """Return which samples are certainly under water as a whole; what floats is righted by other means.

    As deep as the farthest part is from the body origin, with the radius of a sphere of its volume.
    """
    if run.design.mission.environment.surface != "float":
        return np.ones(len(run.times), dtype=np.bool_)
    reach = max(
        math.hypot(*part.position) + (3.0 * getattr(part, "volume", 0.0) / (4.0 * math.pi)) ** (1.0 / 3.0)
        for part in run.design.vehicle.components
    )
    return np.asarray(run.values["z"] >= reach, dtype=np.bool_)


def hydrostatics(run: Run) -> Hydrostatics:
    """Return the hydrostatic margins of a run.

    With D = m r_G - B r_B the still moment is g D x k, k the unit vector down. Turning about body y by an angle it
    changes by -g (D_x k_x + D_z k_z) per rad, about body x by -g (D_y k_y + D_z k_z). Where parts may be out of the
    water the margins are not numbers.
    """
    v = run.values
    kx, ky, kz = down_along(run)
    x, y, z = offset_along(run)
    mass = mass_balance(run.design.vehicle).mass
    heavier = v["net_buoyancy"] / (gravity_of(run.design.mission.environment) * mass)
    # D / m = r_G - (1 + net / m g) r_B
    dx, dz = x - heavier * v["cob_x"], z - heavier * v["cob_z"]
    dy = y - heavier * v["cob_y"] if run.model == "spatial" else 0.0
    offset = np.stack(np.broadcast_arrays(x, y, z), axis=1)
    told = (x * kx + y * ky + z * kz, dx * kx + dz * kz, dy * ky + dz * kz)
    below = immersed(run)
    return Hydrostatics(offset, *(np.where(below, values, np.nan) for values in told))


def hydrodynamics(run: Run, assembly: Assembly) -> Hydrodynamics:
    """Return the hydrodynamic margins of a run, from forces at slightly turned flow and no rotation.

    They are all that a steady stream does: the source, the linear damping and, where the source does not hold it, the
    Munk moment v x (A11 v) of the added mass. Broadside and past a stall, where the force does not oppose the turn,
    there is no neutral point.
    """
    u, v, w = water_velocity(run)
    speed = np.sqrt(u * u + v * v + w * w)
    moving = np.flatnonzero(speed > SLOWEST)
    alpha, beta = np.arctan2(w, u)[moving], np.arctan2(v, np.hypot(u, w))[moving]
    length = vehicle_length(run.design.vehicle)
    forces = _planar_forces if run.model == "planar" else _spatial_forces
    turns = STEERED if run.model == "spatial" else STEERED[:3]
    by_alpha, by_beta = (np.repeat(turned, len(moving)) for turned in np.transpose(turns))
    many = len(turns)
    flow = _flow(np.tile(speed[moving], many), np.tile(alpha, many) + by_alpha, np.tile(beta, many) + by_beta)
    # one call for all: half of the time goes into preparing it
    straight, *turned = np.split(forces(run, assembly, np.tile(moving, many), flow), many)
    com, whole = run.values["com_x"][moving], np.linalg.norm(straight[:, :3], axis=1)
    pitch, yaw = (np.full(len(speed), np.nan) for _ in range(2))
    slope = (turned[0] - turned[1]) / (2.0 * TURN)
    opposing = -slope[:, 2] * np.cos(alpha)
    # of yaw too it is the sign of u that counts: sideslip is within 90 deg, its cosine never negative
    forward = np.copysign(1.0, u[moving])
    pitch[moving] = forward * (com - _point(-slope[:, 4], slope[:, 2], opposing > LEAST_SLOPE * whole)) / length
    if run.model == "spatial":
        slope = (turned[2] - turned[3]) / (2.0 * TURN)
        opposing = -slope[:, 1] * np.cos(beta)
        yaw[moving] = forward * (com - _point(slope[:, 5], slope[:, 1], opposing > LEAST_SLOPE * whole)) / length
    return Hydrodynamics(pitch, yaw, length)


def water_velocity(run: Run) -> tuple[Array, Array, Array]:
    """Return u, v, w through the water, m/s, by sample, from speed, angle of attack and sideslip."""
    v = run.values
    beta = v.get("beta", np.zeros(len(run.times)))
    return (
        v["speed"] * np.cos(v["alpha"]) * np.cos(beta),
        v["speed"] * np.sin(beta),
        v["speed"] * np.sin(v["alpha"]) * np.cos(beta),
    )


def _point(moment: Array, force: Array, told: NDArray[np.bool_]) -> Array:
    """Return where a change of force acts, m: moment over force; not a number where that is not `told`."""
    return np.where(told, moment / np.where(told, force, 1.0), np.nan)


def _flow(speed: Array, alpha: Array, beta: Array) -> tuple[Array, Array, Array]:
    cb = np.cos(beta)
    return speed * np.cos(alpha) * cb, speed * np.sin(beta), speed * np.sin(alpha) * cb


def _spatial_forces(run: Run, assembly: Assembly, samples: NDArray[np.intp], flow: tuple[Array, Array, Array]) -> Array:
    """Return X ... N (samples, 6) of a steady stream."""
    p, n = assembly.params, len(samples)
    still = p.current.copy()
    still[:, 1:] = 0.0
    states = np.zeros((n, len(assembly.initial_state)))
    states[:, spatial_layout.Z], states[:, spatial_layout.Q0] = run.values["z"][samples], 1.0
    states[:, spatial_layout.U : spatial_layout.W + 1] = np.stack(flow, axis=1)
    first, parts = spatial_layout.EXTENSIONS, len(assembly.cells)
    states[:, first : first + parts] = run.cell_values["extension"][samples]
    columns = np.zeros((n, len(spatial_outputs.COLUMNS)))
    scratch = [np.zeros((n, parts)) for _ in range(2)]
    if n:
        spatial_outputs.spatial_outputs(run.times[samples], states, p._replace(current=still), columns, *scratch)
    at = spatial_outputs.FIRST_FORCE
    total = columns[:, at : at + 6] + columns[:, at + 6 : at + 12]
    velocity = states[:, spatial_layout.U : spatial_layout.W + 1]
    total[:, 3:] -= np.cross(velocity, velocity @ p.added[:3, :3].T)
    return total


def _planar_forces(run: Run, assembly: Assembly, samples: NDArray[np.intp], flow: tuple[Array, Array, Array]) -> Array:
    """Return X ... N (samples, 6) of a steady stream in the plane."""
    p, n = assembly.params, len(samples)
    u, _v, w = flow
    states = np.zeros((n, len(assembly.initial_state)))
    states[:, params.Z], states[:, params.U], states[:, params.W] = run.values["z"][samples], u, w
    states[:, params.EXTENSIONS :] = run.cell_values["extension"][samples]
    columns = np.zeros((n, len(planar_outputs.COLUMNS)))
    scratch = [np.zeros((n, len(assembly.cells))) for _ in range(2)]
    if n:
        planar_outputs.outputs(run.times[samples], states, p, columns, *scratch)
    lift, drag, moment = (columns[:, planar_outputs.COLUMNS.index(name)] for name in ("lift", "drag", "moment"))
    speed = np.hypot(u, w)
    c, s = u / speed, w / speed
    b = p.body[0]
    total = np.zeros((n, 6))
    total[:, 0] = -drag * c + lift * s - b["d11"] * u
    total[:, 2] = -drag * s - lift * c - b["d33"] * w
    munk = w * (b["a11"] * u + b["a13"] * w) - u * (b["a13"] * u + b["a33"] * w)
    total[:, 4] = moment - (0.0 if b["munk_in_table"] else 1.0) * munk
    return total
