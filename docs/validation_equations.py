"""Owns check 1 of docs/validation.md: the equations that the kernel solves, against two other derivations of them.

Planar: M, V, G of Eq. 5 from the energies, by symbolic differentiation. Spatial: the accelerations against the
independent simulator of the tests, which integrates momenta in world axes.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from models import derivation as dv
from models.assemble import Assembly, assemble
from models.design import Design, parse_design
from models.kernel.model import energies
from models.mass_properties import component_center_of_buoyancy, component_center_of_mass
from models.presets import load_preset, preset_ids
from models.volumes import volume
from models.water import gravity_of
from tests.models.support import BODY, document, slope_at, without_water
from tests.models.test_spatial_oracle import moving_design, reference_for

Array = NDArray[np.float64]
COUNTS = (1, 2, 3, 4, 5)
STATES = 40
"""Random states of each planar vehicle and of each spatial design."""
SEED = 20130305
DEMANDED = {"planar": 1e-11, "spatial": 1e-9}
"""Largest relative difference: rounding of terms that cancel."""
ADDED = dv.added_mass_symbols()
ENTRIES = [ADDED[0, 0], ADDED[0, 1], ADDED[0, 2], ADDED[1, 1], ADDED[1, 2], ADDED[2, 2]]
KINDS: tuple[dict[str, Any], ...] = (
    {"kind": "piston", "volume": 5e-5, "volume_range": [2e-5, 8e-5], "area": 1e-3},
    {"kind": "movable_mass", "extension_range": [-0.05, 0.05], "neutral_extension": 0.0},
    {"kind": "bellows", "extension_range": [0.0, 0.03], "neutral_extension": 0.01, "pleats": 5,
     "inner_radius": 0.012, "outer_radius": 0.018, "fixed_volume": 1e-5},
    {"kind": "bladder", "extensions": [0.0, 0.01, 0.03], "volumes": [1e-5, 3e-5, 9e-5], "neutral_extension": 0.02},
)  # fmt: skip


class PlanarDifferences(NamedTuple):
    """Largest relative differences of M, V and G over the random states of a vehicle of so many components."""

    count: int
    M: float
    V: float
    G: float


class SpatialDifferences(NamedTuple):
    """Relative difference of each state's accelerations of one design, (states,)."""

    name: str
    relative: Array


def random_vehicle(count: int, random: np.random.Generator) -> Assembly:
    """Assemble a body and up to four moving parts at random places, with random masses and added mass."""
    parts = [
        kind | {
            "name": f"Part {i}", "mass": float(random.uniform(0.02, 0.3)), "inertia": {"yy": 1e-3},
            "position": [float(random.uniform(-0.3, 0.3)), 0.0, float(random.uniform(-0.03, 0.03))],
            "axis": [float(random.normal()), 0.0, float(random.normal())],
        }
        for i, kind in enumerate(KINDS[: count - 1])
    ]  # fmt: skip
    body = BODY | {"mass": float(random.uniform(0.8, 2.0))}
    changed = document(*parts, body=body)
    changed["vehicle"]["components"] = [body, *parts]
    half = random.uniform(-1.0, 1.0, (6, 6)) * [[0.3], [0.7], [1.5], [0.1], [0.15], [0.1]]
    added = half @ half.T + 1e-3 * np.eye(6)
    changed["vehicle"]["added_mass"] = {"matrix": added.tolist()}
    changed["vehicle"]["hydrodynamics"]["includes_munk_moment"] = False
    return assemble(parse_design(changed))


def symbol_values(assembly: Assembly, y: Array) -> list[float]:
    """Return the numbers for the symbols, taken from the description and not from the kernel."""
    design = assembly.design
    extensions = dict(zip(assembly.cells, y[8:], strict=True))
    environment = design.mission.environment
    values = [gravity_of(environment), environment.water.density]
    for part in design.vehicle.components:
        e = float(extensions.get(part.name, 0.0))
        r_G, r_B = component_center_of_mass(part, e), component_center_of_buoyancy(part, e)
        values += [part.mass, r_G[0], r_G[2], part.inertia.yy, volume(part, e), r_B[0], r_B[2]]
    added = np.array(design.vehicle.added_mass.matrix)[np.ix_([0, 2, 4], [0, 2, 4])]
    return [*values, *added[np.triu_indices(3)]]


def body_matrix(assembly: Assembly, y: Array) -> Array:
    """Return the mass matrix in body axes (3, 3), read off the kernel's kinetic energy by polarisation."""
    matrix = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for sign in (1.0, -1.0):
                probe = y.copy()
                probe[3:6] = 0.0
                probe[3 + i] += 1.0
                probe[3 + j] += sign
                matrix[i, j] += 0.5 * sign * energies(0.0, probe, assembly.params)[0]
    return matrix


def world_acceleration(y: Array, dy: Array) -> Array:
    """Return q'' from the slopes of the body velocities: d/dt (R nu)."""
    s, c, q = math.sin(y[2]), math.cos(y[2]), y[5]
    R, dR = np.array([[c, s], [-s, c]]), q * np.array([[-s, c], [-c, -s]])
    return np.array([*(R @ dy[3:5] + dR @ y[3:5]), dy[5]])


def _share(got: Array, expected: Array) -> float:
    return float(np.abs(got - expected).max() / np.abs(expected).max())


def differences_at(assembly: Assembly, equations: dv.Evaluator, y: Array) -> tuple[float, float, float]:
    """Return the relative differences of M, V and G at one state.

    M from the kinetic energy; G from the acceleration at rest, V from that in motion without weight, both without the
    forces of the water.
    """
    s, c = math.sin(y[2]), math.cos(y[2])
    R = np.array([[c, s], [-s, c]])
    M, V, G = equations(y[:3], np.array([*(R @ y[3:5]), y[5]]), symbol_values(assembly, y))
    J = np.block([[R.T, np.zeros((2, 1))], [np.zeros((1, 2)), np.ones((1, 1))]])
    p = without_water(assembly.params)
    weightless = p._replace(body=p.body.copy())
    weightless.body["gravity"] = 0.0
    rest = y.copy()
    rest[3:6] = 0.0
    return (
        _share(J.T @ body_matrix(assembly, y) @ J, M),
        _share(-M @ world_acceleration(y, slope_at(weightless, y)), V),
        _share(-M @ world_acceleration(rest, slope_at(p, rest)), G),
    )


@cache
def planar_differences() -> tuple[PlanarDifferences, ...]:
    """Compare M, V, G for 1 to 5 components."""
    random, results = np.random.default_rng(SEED), []
    for count in COUNTS:
        assembly = random_vehicle(count, random)
        parts = dv.composite_parts(count)
        symbols = [s for part in parts for s in part if s.is_Symbol]
        derived = dv.equations_of_motion(parts, ADDED)
        equations = dv.evaluator(derived, [dv.GRAVITY, dv.DENSITY, *symbols, *ENTRIES])
        strokes = [part.stroke for _, part in assembly.design.vehicle.actuated]
        found = []
        for _ in range(STATES):
            motion = random.uniform([-50, 0, -math.pi, -2, -2, -3], [50, 50, math.pi, 2, 2, 3])
            y = np.array([*motion, 0.0, 0.0, *(random.uniform(*stroke) for stroke in strokes)])
            found.append(differences_at(assembly, equations, y))
        results.append(PlanarDifferences(count, *(float(v) for v in np.max(found, axis=0))))
    return tuple(results)


def spatial_designs() -> dict[str, Design]:
    """Return the designs of the spatial comparison by name: every preset, and a test glider with all off its plane."""
    designs = {
        "test glider": moving_design({}),
        "test glider, rate terms by V": moving_design({"rate_scaling": "speed", "includes_munk_moment": True}),
    }
    for preset_id in preset_ids():
        design = load_preset(preset_id)
        shown = design.model_dump(mode="json")
        shown["mission"]["solver"]["model"] = "spatial"
        # afloat, the water near the surface is mixed, and either simulator scales added mass by its own surface density
        shown["mission"]["environment"] |= {"gravity": gravity_of(design.mission.environment), "surface": "end"}
        designs[preset_id] = parse_design(shown)
    return designs


def random_state(assembly: Assembly, random: np.random.Generator) -> Array:
    """Return a state at any attitude and in any motion, 2 to 50 m deep, extensions anywhere within the stops."""
    attitude = random.normal(size=4)
    place, motion = random.uniform([-50, -50, 2], [50, 50, 50]), random.uniform(-1.0, 1.0, 6)
    strokes = [part.stroke for _, part in assembly.design.vehicle.actuated]
    extensions = [random.uniform(*stroke) for stroke in strokes]
    attitude /= np.linalg.norm(attitude)
    return np.array([*place, *attitude, *motion, 0.0, 0.0, 0.0, *extensions, *np.zeros(len(strokes))])


@cache
def spatial_differences() -> tuple[SpatialDifferences, ...]:
    """Compare the accelerations of every design at random states."""
    random, results = np.random.default_rng(SEED), []
    for name, design in spatial_designs().items():
        assembly, reference = assemble(design), reference_for(design)
        found = []
        for _ in range(STATES):
            y = random_state(assembly, random)
            rotation = Rotation.from_quat(y[3:7], scalar_first=True).as_matrix()
            extensions = dict(zip(assembly.cells, y[16 : 16 + len(assembly.cells)], strict=True))
            pair = reference.acceleration(y[:3], rotation, y[7:10], y[10:13], extensions, 0.0)
            got = slope_at(assembly.params, y)[7:13]
            found.append(max(_share(got[:3], pair[0]), _share(got[3:], pair[1])))
        results.append(SpatialDifferences(name, np.array(found)))
    return tuple(results)
