"""Owns the water as tables that the kernel reads: density, pressure and current as cubics against the depth z.

Density by TEOS-10: IOC, SCOR and IAPSO (2010), The international thermodynamic equation of seawater - 2010, through
the Gibbs SeaWater toolbox (McDougall and Barker, 2011; the 75-term polynomial of Roquet et al., 2015).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import overload

import gsw
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from models.environment import (
    DEFAULT_GRAVITY,
    SMALLEST_LEVEL,
    Current,
    DensityProfile,
    Environment,
    ShearedCurrent,
    TabulatedCurrent,
    Teos10Water,
    UniformCurrent,
    UniformWater,
    Water,
)
from models.memory import remembered
from models.problems import DesignError, Problem

Array = NDArray[np.float64]

PIECES = (512, 1024, 2048, 4096, 8192, 16384)
TABULATION_ERROR = 1e-3
"""Error of the tabulated density that more pieces are tried for, kg/m3: a third of what a CTD resolves."""
SMALLEST_INVERSION = 1e-6
"""Least drop of density that counts as unstable, kg/m3: above rounding, below any instrument."""
SUBDIVISIONS = 8
"""Steps in which a layer is searched for an inversion: fresh water is densest near 4 degC, also between two levels."""


@dataclass(frozen=True, slots=True, eq=False)
class WaterTable:
    """Density and gauge pressure against depth, in pieces of one spacing.

    `rows` (n + 2, 6) holds z_ref (m), c0..c3 (kg/m3, kg/m4, ...) and P_ref (Pa). With h = z - z_ref, density is
    c0 + c1 h + c2 h^2 + c3 h^3 and pressure P_ref + g (c0 h + c1 h^2/2 + c2 h^3/3 + c3 h^4/4). Row 0 holds above `top`
    (m), also above the surface, the last row below the deepest level, both at constant density; the row at z is
    clip(floor((z - top)/spacing) + 1, 0, n + 1).
    """

    top: float
    spacing: float
    rows: Array


@dataclass(frozen=True, slots=True, eq=False)
class CurrentTable:
    """Velocity of the water against depth at each time, m/s; linear between the times (s), held outside them.

    `rows` (k * levels, 9) holds, for each of k times, `levels` rows of z_ref (m), then the cubics x0..x3 of the
    velocity north and y0..y3 of that east in h = z - z_ref. In force at z is the last row with z_ref <= z, the first
    above.
    """

    times: Array
    rows: Array
    levels: int


@dataclass(frozen=True, slots=True)
class UnstableLayer:
    """A layer between two levels (m) where denser water lies above: by `drop`, kg/m3, at one pressure."""

    top: float
    bottom: float
    drop: float


@remembered(most=100)
def gravity_of(environment: Environment) -> float:
    """Return gravity, m/s2: as stated, else of the water's latitude (Moritz, 2000, as in TEOS-10), else 9.8."""
    if environment.gravity is not None:
        return environment.gravity
    if isinstance(environment.water, Teos10Water):
        return float(gsw.grav(environment.water.latitude, 0.0))
    return DEFAULT_GRAVITY


def water_table(water: Water, gravity: float, *, mixed: float = 0.0) -> WaterTable:
    """Tabulate density and pressure; pressure is 0 at z = 0 and continuous. The rows are the caller's own.

    Down to the depth `mixed` (m) the water is taken as mixed, of the density found there: what pierces the surface then
    floats in one density, and its buoyancy derives from a potential. The pieces end at the deepest level; there are
    512, doubled to 16384 at most until the error between the nodes and at the levels is below 1e-3 kg/m3.

    Raises
    ------
    DesignError
        Where TEOS-10 knows no composition of the sea at the longitude and latitude.

    """
    table = _table(water, max(mixed, 0.0))
    rows = table.rows.copy()
    rows[:, 5] *= gravity
    return WaterTable(top=table.top, spacing=table.spacing, rows=rows)


@remembered(most=100)
def require_known(water: Water) -> None:
    """Raise `DesignError` where TEOS-10 knows no composition of the sea at the longitude and latitude."""
    _table(water, 0.0)


@overload
def density_at(water: Water, depth: float, *, mixed: float = 0.0) -> float: ...
@overload
def density_at(water: Water, depth: Array, *, mixed: float = 0.0) -> Array: ...
def density_at(water: Water, depth: float | Array, *, mixed: float = 0.0) -> float | Array:
    """Return the density (kg/m3) at a depth or an array of depths (m), exactly as the kernel's table has it."""
    table = _table(water, max(mixed, 0.0))
    z = np.asarray(depth, dtype=np.float64)
    index = np.clip(np.floor((z - table.top) / table.spacing) + 1, 0, len(table.rows) - 1).astype(np.intp)
    z_ref, c0, c1, c2, c3, _ = np.moveaxis(table.rows[index], -1, 0)
    h = z - z_ref
    density: Array = c0 + h * (c1 + h * (c2 + h * c3))
    return density if isinstance(depth, np.ndarray) else float(density)


@remembered(most=100)
def surface_density(water: Water) -> float:
    """Return the density at z = 0, kg/m3."""
    return density_at(water, 0.0)


def profile_range(water: Water) -> tuple[float, float] | None:
    """Return the depths of the first and last level, m; None for water of one density."""
    return None if isinstance(water, UniformWater) else (water.depths[0], water.depths[-1])


@lru_cache(maxsize=32)
def _table(water: Water, top: float) -> WaterTable:
    """Tabulate at gravity 1; read only."""
    profile = _profile(water)
    if isinstance(water, UniformWater):
        top, levels = 0.0, np.zeros(1)
    else:
        levels = np.array(water.depths)
    end = levels[-1]
    if end - top < SMALLEST_LEVEL:
        pieces, spacing, end = np.empty((0, 5)), 1.0, top
    else:
        pieces, spacing = _pieces(profile, levels[levels > top], top)
    density_top, density_end = profile(np.array([top, end]))
    c = pieces[:, 1:] / [1.0, 2.0, 3.0, 4.0]
    weights = spacing * (c[:, 0] + spacing * (c[:, 1] + spacing * (c[:, 2] + spacing * c[:, 3])))
    rows = np.zeros((len(pieces) + 2, 6))
    rows[0, :2] = top, density_top
    rows[1:-1, :5] = pieces
    rows[-1, :2] = end, density_end
    rows[:, 5] = density_top * top + np.concatenate([[0.0, 0.0], np.cumsum(weights)])
    rows.flags.writeable = False
    return WaterTable(top=top, spacing=spacing, rows=rows)


def _pieces(profile: Callable[[Array], Array], levels: Array, top: float) -> tuple[Array, float]:
    """Return the cubics between nodes (n, 5): z_ref and c0..c3; and the spacing of the nodes, m."""
    for count in PIECES:
        nodes = np.linspace(top, levels[-1], count + 1)
        cubic = PchipInterpolator(nodes, profile(nodes))
        between = np.concatenate([(nodes[:-1] + nodes[1:]) / 2, levels])
        if np.max(np.abs(cubic(between) - profile(between))) <= TABULATION_ERROR:
            break
    return np.column_stack([nodes[:-1], cubic.c[::-1].T]), float(levels[-1] - top) / count


def _profile(water: Water) -> Callable[[Array], Array]:
    """Return the density (kg/m3) as a function of depth (m), held below the last level."""
    match water:
        case UniformWater():
            return lambda z: np.full(z.shape, water.density)
        case DensityProfile():
            return _held(water.depths, water.densities)
        case Teos10Water():
            state = _state(water)

            def density(z: Array) -> Array:
                salinity, temperature, pressure = state(z)
                rho: Array = gsw.rho(salinity, temperature, pressure)
                return rho

            return density


def _held(depths: tuple[float, ...], values: tuple[float, ...]) -> Callable[[Array], Array]:
    """Interpolate by shape-preserving cubics (Fritsch and Butland, 1984), held beyond the first and last level."""
    cubic = PchipInterpolator(depths, values)
    return lambda z: cubic(np.clip(z, depths[0], depths[-1]))


def _state(water: Teos10Water) -> Callable[[Array], tuple[Array, Array, Array]]:
    """Return absolute salinity (g/kg), conservative temperature (degC) and pressure (dbar) as functions of depth (m).

    Below the last level all three are held, above the first one pressure is not.
    """
    in_situ = _held(water.depths, water.temperatures)
    measured = _held(water.depths, water.salinities) if water.salinities else np.zeros_like

    def state(z: Array) -> tuple[Array, Array, Array]:
        pressure = gsw.p_from_z(-np.minimum(z, water.depths[-1]), water.latitude)
        salinity = _absolute_salinity(water, measured(z), pressure)
        return salinity, gsw.CT_from_t(salinity, in_situ(z), pressure), pressure

    return state


def _absolute_salinity(water: Teos10Water, measured: Array, pressure: Array) -> Array:
    salinity: Array
    if water.salinities is None or water.salinity_kind == "absolute":
        return measured
    if water.longitude is None:
        salinity = gsw.SR_from_SP(measured)
        return salinity
    salinity = gsw.SA_from_SP(measured, pressure, water.longitude, water.latitude)
    if np.isnan(salinity).any():
        message = (
            f"TEOS-10 knows no composition of the sea at longitude {water.longitude:g}, latitude {water.latitude:g} deg"
        )
        hint = "leave longitude out: practical salinity then takes the reference composition"
        raise DesignError([Problem("/mission/environment/water/longitude", message, hint=hint)])
    return salinity


@lru_cache(maxsize=32)
def unstable_layers(water: Water) -> UnstableLayer | None:
    """Return the layer between two levels where density falls most with depth; None where the water is stable.

    In TEOS-10 water neighbours are compared at the pressure midway, as N^2 does, so that compression hides nothing.
    """
    if isinstance(water, UniformWater):
        return None
    depths = np.array(water.depths)
    share = np.arange(SUBDIVISIONS) / SUBDIVISIONS
    z = np.append((depths[:-1, None] + np.diff(depths)[:, None] * share).ravel(), depths[-1])
    if isinstance(water, Teos10Water):
        salinity, temperature, pressure = _state(water)(z)
        midway = (pressure[:-1] + pressure[1:]) / 2
        above = gsw.rho(salinity[:-1], temperature[:-1], midway)
        falls = above - gsw.rho(salinity[1:], temperature[1:], midway)
    else:
        falls = -np.diff(_profile(water)(z))
    drops = np.maximum(falls, 0.0).reshape(-1, SUBDIVISIONS).sum(axis=1)
    worst = int(np.argmax(drops))
    if drops[worst] < SMALLEST_INVERSION:
        return None
    return UnstableLayer(top=water.depths[worst], bottom=water.depths[worst + 1], drop=float(drops[worst]))


def current_table(current: Current | None) -> CurrentTable:
    """Tabulate a current; none is still water. The arrays are the caller's own."""
    table = _current(current)
    return CurrentTable(times=table.times.copy(), rows=table.rows.copy(), levels=table.levels)


@lru_cache(maxsize=32)
def _current(current: Current | None) -> CurrentTable:
    row = np.zeros((1, 9))
    match current:
        case UniformCurrent():
            row[0, [1, 5]] = current.velocity
        case ShearedCurrent():
            row[0, [1, 5]] = current.surface_velocity
            row[0, [2, 6]] = current.shear
        case TabulatedCurrent():
            return _tabulated(current)
    return CurrentTable(times=np.zeros(1), rows=row, levels=1)


def _tabulated(current: TabulatedCurrent) -> CurrentTable:
    depths = np.array(current.depths)
    rows = np.zeros((len(current.times), len(depths) + 1, 9))
    rows[:, :, 0] = np.concatenate([depths[:1], depths])
    for first, table in ((1, current.north), (5, current.east)):
        values = np.array(table)
        rows[:, 1:-1, first : first + 4] = PchipInterpolator(depths, values.T).c[::-1].transpose(2, 1, 0)
        rows[:, 0, first] = values[:, 0]
        rows[:, -1, first] = values[:, -1]
    return CurrentTable(times=np.array(current.times), rows=rows.reshape(-1, 9), levels=len(depths) + 1)
