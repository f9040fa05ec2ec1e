"""Owns the records that only the spatial model reads: made from a design, and empty for a planar run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.components import Actuated, MovableMass, Rigid, RollingMass
from models.design import DeclaredMass, Design
from models.environment import Current, Environment
from models.hydrodynamic_grid import build_grid_law
from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import LateralCoefficients, PolarTable, RateTerms
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.kernel import params, spatial_layout
from models.kernel.spatial_layout import COEFFICIENT_NAMES, LATERAL_NAMES, MEMBER, SPACE
from models.mass_properties import Masses, inertia_matrix, rotation_about
from models.memory import remembered
from models.records import named_bytes, records
from models.still_parts import still_masses
from models.volumes import axis_numbers, unit_axis, volume
from models.water import CurrentTable, WaterTable, current_table, gravity_of, water_table

Array = NDArray[np.float64]
BED_FREQUENCY = 5.0
"""How fast the glider would swing on the bed's spring, rad/s; it sinks in by its net weight over 25 (m + A33)."""
REARM = 4.0
"""The surface counts as left at this many times the depth at which the glider begins to emerge."""
SHORTEST_REARM = 0.2
"""The surface or bed counts as left at least this far from it, m."""
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Order in which the kernel keeps a symmetric 3x3 matrix."""
ANGLES = 2.0 * math.pi * np.arange(5) / 5.0
HARMONICS = np.column_stack([np.ones(5), np.cos(ANGLES), np.sin(ANGLES), np.cos(2 * ANGLES), np.sin(2 * ANGLES)])
"""Angles (rad) from which an inertia that turns is known as a trigonometric sum, and its terms at each of them."""
STILL = ("mass_x", "mass_y", "mass_z", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""First moments of mass and inertia of what does not move, as `still_masses` has them."""


WITHOUT: dict[str, Array | NDArray[np.void]] = {
    "members": np.zeros(0, dtype=MEMBER), "inertias": np.zeros((0, 5, 6)),
    "solids": np.zeros((0, len(spatial_layout.SOLID_COLUMNS))),
}  # fmt: skip
"""Of each component what the planar model does not read."""
NOTHING = dict.fromkeys(MEMBER.names or (), 0.0)


def spatial_records(
    design: Design, parts: list[Actuated], weighs: Masses, *, added: Array, damping: Array
) -> dict[str, Any]:
    """Return the fields of `Params` beyond those of the planar model.

    `weighs` is what the vehicle does at any extensions, `added` and `damping` its added mass and linear damping (6, 6).
    """
    emerging = emerging_depth(design)
    environment, source = design.mission.environment, design.vehicle.hydrodynamics
    water, current = _water(environment, emerging), _current(environment.current)
    return {
        "space": _space(design, weighs, emerging=emerging, heave_added=added.item(2, 2)),
        **_part_arrays(design, parts),
        "added": added,
        "damping": damping,
        **_source_arrays(source),
        "water": water.rows,
        "current": current.rows,
        "current_times": current.times,
    }  # fmt: skip


@remembered(most=2_000)
def fading_height(component: Any) -> float:
    """Return the vertical extent over which a component's buoyancy fades, m; 0 of a mass inside, which has none.

    It is the component's own, or that of a sphere. The sphere has the component's volume at neutral extension, or,
    where it displaces nothing then, at its larger stop.
    """
    if isinstance(component, MovableMass | RollingMass):
        return 0.0
    if component.height is not None:
        return float(component.height)
    displaced = volume(component, 0.0 if isinstance(component, Rigid) else component.neutral)
    if displaced <= 0.0 and not isinstance(component, Rigid):
        displaced = max(volume(component, stop) for stop in component.stroke)
    return float((6.0 * displaced / math.pi) ** (1.0 / 3.0))


def emerging_depth(design: Design) -> float:
    """Return the depth of a part's centre above which some part of a floating glider begins to emerge, m."""
    if design.mission.environment.surface == "end":
        return 0.0
    return max(0.5 * fading_height(component) for component in design.vehicle.components)


@remembered(most=16)
def _water(environment: Environment, emerging: float) -> WaterTable:
    """Return density and pressure as the kernel reads them; designs in one environment share them."""
    return water_table(environment.water, gravity_of(environment), mixed=emerging)


_current: Callable[[Current | None], CurrentTable] = remembered(most=16)(current_table)


def _part_arrays(design: Design, parts: list[Actuated]) -> dict[str, Array | NDArray[np.void]]:
    """Return what the spatial model alone knows of each component."""
    if design.mission.solver.model != "spatial":
        return WITHOUT
    declared = isinstance(design.vehicle.mass_properties, DeclaredMass)
    floats = design.mission.environment.surface != "end"
    still = [c for c in design.vehicle.components if isinstance(c, Rigid) and c.volume > 0.0]
    return {
        "members": records(MEMBER, (_member(part, declared, floats) for part in parts)),
        "inertias": np.concatenate([WITHOUT["inertias"], *(_harmonics(part, declared) for part in parts)]),
        "solids": np.concatenate([WITHOUT["solids"], *(_solid(component, floats) for component in still)]),
    }


def _space(design: Design, weighs: Masses, *, emerging: float, heave_added: float) -> NDArray[np.void]:
    spatial = design.mission.solver.model == "spatial"
    layout: Any = spatial_layout if spatial else params
    heave = weighs.mass + heave_added
    values = {
        "bed_stiffness": heave * BED_FREQUENCY**2,
        "bed_damping": 2.0 * heave * BED_FREQUENCY,
        "spatial": spatial, "depth": layout.Z, "work": layout.WORK_ACTUATORS, "extensions": layout.EXTENSIONS,
        **_surroundings(design.mission.environment, emerging),
        **_source_numbers(design.vehicle.hydrodynamics),
        "mass": weighs.mass, **dict(zip(STILL, still_masses(design.vehicle, weighs), strict=True)),
    }  # fmt: skip
    return records(SPACE, [named_bytes(SPACE, values)])


@remembered(most=16)
def _surroundings(environment: Environment, emerging: float) -> dict[str, float]:
    water = _water(environment, emerging)
    return {
        "gravity": gravity_of(environment),
        "surface_level": emerging,
        "rearm_level": max(REARM * emerging, emerging + SHORTEST_REARM),
        "bed_depth": math.inf if environment.bed_depth is None else environment.bed_depth,
        "water_top": water.top, "per_spacing": 1.0 / water.spacing,
        "surface_ends": environment.surface == "end", "bed_ends": environment.bed_contact == "end",
        "levels": _current(environment.current).levels,
    }  # fmt: skip


@remembered(most=16)
def _source_numbers(source: Hydrodynamics) -> dict[str, float]:
    x, y, z = source.reference_point
    return {
        "per_reference_density": 1.0 / source.reference_density,
        "reference_x": x, "reference_y": y, "reference_z": z, **_source_switches(source),
    }  # fmt: skip


def _source_switches(source: Hydrodynamics) -> dict[str, float]:
    kind = {"polar_table": spatial_layout.POLAR, "angle_table": spatial_layout.ANGLES}
    scaling = source.rate_scaling if isinstance(source, CoefficientForm) else _rate_terms(source).scaling
    lateral = source.lateral if isinstance(source, PolarTable) else None
    plane = isinstance(source, PolarTable)
    return {
        "source": kind.get(source.kind, spatial_layout.COEFFICIENTS),
        "munk_plane": float(plane and source.includes_munk_moment),
        "munk_whole": float(not plane and source.includes_munk_moment),
        "munk_lateral": float(lateral is not None and lateral.includes_munk_moment),
        "rate_none": float(scaling == "none"),
        "rate_speed": float(scaling == "speed"),
        "rate_speed2": float(scaling == "speed_squared"),
    }


def _rate_terms(source: PolarTable | AngleTable) -> RateTerms:
    if isinstance(source, AngleTable):
        return source.rates
    return source.lateral.rates if source.lateral is not None else RateTerms()


def _rates(source: Hydrodynamics) -> Array:
    """Return force by p, q, r (6, 3); of the coefficient form only what the planar model needs of it."""
    rates = np.zeros((6, 3))
    if isinstance(source, CoefficientForm):
        rates[4, 1] = source.pitch_rate
        return rates
    terms = _rate_terms(source)
    rates[1, 0], rates[1, 2] = terms.sway_roll, terms.sway_yaw
    rates[2, 1] = terms.heave_pitch
    rates[3, 0], rates[3, 2] = terms.roll_roll, terms.roll_yaw
    rates[4, 1] = terms.pitch_pitch
    rates[5, 0], rates[5, 2] = terms.yaw_roll, terms.yaw_yaw
    return rates


@remembered(most=16)
def _source_arrays(source: Hydrodynamics) -> dict[str, Array]:
    """Return rates, the table over both angles, and coefficients, zeros where there are none; designs share them."""
    numbers = np.zeros(len(COEFFICIENT_NAMES))
    grid = {"grid_alpha": np.zeros(2), "grid_beta": np.zeros(2), "grid": np.zeros((1, 96))}
    described: CoefficientForm | LateralCoefficients | None = None
    names: tuple[str, ...] = LATERAL_NAMES
    if isinstance(source, CoefficientForm):
        described, names = source, COEFFICIENT_NAMES
    elif isinstance(source, PolarTable):
        described = source.lateral
    else:
        law = build_grid_law(source)
        grid = {"grid_alpha": law.alpha.copy(), "grid_beta": law.beta.copy(), "grid": law.pieces.reshape(-1, 96).copy()}
    if described is not None:
        numbers[: len(names)] = [getattr(described, name) for name in names]
    return {"rates": _rates(source), "coefficients": numbers, **grid}


@remembered(most=1_000)
def _solid(component: Rigid, floats: bool) -> Array:
    """Return the row of a component that displaces and does not move, (1, 6)."""
    compressed = 0.0 if component.bulk_modulus is None else 1.0 / component.bulk_modulus
    return np.array([[component.volume, *component.position, compressed, _half_height(component, floats)]])


def _half_height(component: Any, floats: bool) -> float:
    return 0.5 * fading_height(component) if floats else 0.0


@remembered(most=1_000)
def _member(part: Actuated, declared: bool, floats: bool) -> bytes:
    """Return the record of a part that moves; `declared` where masses are, `floats` where it may emerge."""
    values = {"per_efficiency": 1.0 / part.efficiency, "recovery": part.recovery}
    values |= _along("axis", axis_numbers(part))
    values["x"], values["y"], values["z"] = part.position
    if isinstance(part, MovableMass | RollingMass):
        values["moving_mass"], values["moves"] = (0.0, 0.0) if declared else (part.mass, 1.0)
        values |= _place_of_mass(part)
    else:
        values["per_bulk"] = 0.0 if part.bulk_modulus is None else 1.0 / part.bulk_modulus
        values["half_height"] = _half_height(part, floats)
    return named_bytes(MEMBER, NOTHING | values)


def _along(name: str, numbers: Iterable[float]) -> dict[str, float]:
    return {f"{name}_{letter}": number for letter, number in zip("xyz", numbers, strict=True)}


def _place_of_mass(part: MovableMass | RollingMass) -> dict[str, float]:
    base = np.array(part.center_of_mass or part.position)
    if isinstance(part, MovableMass):
        return _along("base", base.tolist())
    axis, arm = unit_axis(part), base - np.array(part.pivot)
    across = arm - axis * (axis @ arm)
    circle = _along("perp", across.tolist()) | _along("cross", np.cross(axis, arm).tolist())
    return {"rolls": 1.0} | circle | _along("base", (base - across).tolist())


@remembered(most=1_000)
def _harmonics(part: Actuated, declared: bool) -> Array:
    """Return a moving mass's own inertia as a trigonometric sum of its angle: (1, 5, 6) of 1, c, s, c2, s2."""
    harmonics = np.zeros((1, 5, 6))
    if declared:
        return harmonics
    own = inertia_matrix(part.inertia)
    if isinstance(part, MovableMass):
        harmonics[0, 0] = [own[i, j] for i, j in ENTRIES]
    elif isinstance(part, RollingMass):
        turned = [turn @ own @ turn.T for turn in (rotation_about(unit_axis(part), a) for a in ANGLES)]
        harmonics[0] = np.linalg.solve(HARMONICS, np.array([[m[i, j] for i, j in ENTRIES] for m in turned]))
    return harmonics
