"""Owns the law in the angle of attack: data on 0 to 90 deg made into piecewise polynomials over the whole circle.

Lift and moment are odd in alpha, drag even (a hull symmetric about its horizontal plane). Past 90 deg nothing was
measured: |alpha| is reflected to 180 deg - |alpha|; drag and moment keep their value, lift changes sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import PolarTable
from models.hydrodynamics_coefficients import CoefficientForm
from models.memory import remembered
from models.problems import DesignError, Problem

QUANTITIES = ("lift", "drag", "moment")
DEGREES = {"lift": 5, "drag": 4, "moment": 7}
"""Degrees of the paper's polynomials (Canete et al., section II.B)."""
POINTER = "/vehicle/hydrodynamics"

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FitError:
    """How far a law lies from the data it was made from, per squared speed, and relative to the data's range."""

    quantity: str
    rms: float
    largest: float
    largest_at_deg: float
    range: float

    @property
    def relative(self) -> float:
        """Largest error as a share of the range of the data."""
        return self.largest / self.range if self.range > 0.0 else 0.0


@dataclass(frozen=True)
class HydrodynamicLaw:
    """Lift, drag and moment per squared speed as piecewise polynomials.

    `breaks` (pieces + 1,) from -pi to pi, rad; `coefficients` (pieces, 3, n) in powers of (alpha - break).
    """

    breaks: Array
    coefficients: Array
    errors: tuple[FitError, ...]

    def __call__(self, alpha: Any) -> Array:
        """Return lift, drag, moment per squared speed, shape (3, ...), at angles of attack in [-pi, pi] rad."""
        alpha = np.asarray(alpha, dtype=float)
        piece = np.clip(np.searchsorted(self.breaks, alpha, side="right") - 1, 0, len(self.breaks) - 2)
        s = alpha - self.breaks[piece]
        value = np.zeros((3, *alpha.shape))
        for power in range(self.coefficients.shape[2] - 1, -1, -1):
            value = value * s + np.moveaxis(self.coefficients[piece, :, power], -1, 0)
        return value


def coefficients_by_speed(table: PolarTable) -> dict[float, tuple[Array, Array]]:
    """Return for each speed its angles (n,) in rad and forces per squared speed (3, n)."""
    speed, alpha_deg = np.array(table.row_speed), np.array(table.row_alpha_deg)
    forces = np.array([table.row_lift, table.row_drag, table.row_moment])
    return {v: (np.deg2rad(alpha_deg[speed == v]), forces[:, speed == v] / v**2) for v in table.speeds}


def select_data(table: PolarTable) -> tuple[Array, Array]:
    """Return angles (n,) in rad and coefficients (3, n): those of the chosen speed, or the mean over all speeds."""
    data = coefficients_by_speed(table)
    if table.speed is not None:
        return data[table.speed]
    grids = [angles for angles, _ in data.values()]
    for v, angles in zip(data, grids, strict=True):
        if len(angles) != len(grids[0]) or not np.array_equal(angles, grids[0]):
            raise DesignError(
                [
                    Problem(
                        f"{POINTER}/row_alpha_deg",
                        f"the angles at {v} m/s differ from those at {next(iter(data))} m/s: they cannot be averaged",
                        hint="choose one speed, or give every speed the same angles",
                    )
                ]
            )
    return grids[0], np.mean([values for _, values in data.values()], axis=0)


def mirror(quantity: str, angles: Array, values: Array) -> tuple[Array, Array]:
    """Extend data on [0, pi/2] to [-pi, pi] by the symmetries that the module states."""
    beyond = -1.0 if quantity == "lift" else 1.0
    half_angles = np.concatenate([angles, np.pi - angles[-2::-1]])
    half_values = np.concatenate([values, beyond * values[-2::-1]])
    below = 1.0 if quantity == "drag" else -1.0
    return (
        np.concatenate([-half_angles[:0:-1], half_angles]),
        np.concatenate([below * half_values[:0:-1], half_values]),
    )


def _fit_pchip(angles: Array, data: Array) -> tuple[Array, Array]:
    """Pass periodic shape-preserving cubics through the mirrored data."""
    columns = []
    breaks = angles
    for quantity, values in zip(QUANTITIES, data, strict=True):
        exact = values.copy()
        if quantity != "drag":
            exact[0] = 0.0
        if quantity == "lift":
            exact[-1] = 0.0
        breaks, around = mirror(quantity, angles, exact)
        period = np.concatenate([breaks[:-1] - 2 * np.pi, breaks, breaks[1:] + 2 * np.pi])
        cubic = PchipInterpolator(period, np.concatenate([around[:-1], around, around[1:]]))
        first = len(breaks) - 1
        columns.append(cubic.c[::-1, first : first + len(breaks) - 1].T)
    return breaks, np.stack(columns, axis=1)


def _fit_polynomials(angles: Array, data: Array) -> tuple[Array, Array]:
    """Fit the paper's polynomials in |alpha| on [0, pi/2] and reflect them."""
    breaks = np.array([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi])
    order = max(DEGREES.values()) + 1
    coefficients = np.zeros((4, 3, order))
    for j, (quantity, values) in enumerate(zip(QUANTITIES, data, strict=True)):
        lowest = 0 if quantity == "drag" else 1
        powers = np.arange(lowest, DEGREES[quantity] + 1)
        if len(angles) < len(powers):
            raise DesignError(
                [
                    Problem(
                        f"{POINTER}/row_alpha_deg",
                        f"{len(angles)} angles are too few to fit {quantity} by degree {DEGREES[quantity]}",
                        limit=len(powers),
                        hint="use the law 'pchip' or give more angles",
                    )
                ]
            )
        solution = np.linalg.lstsq(angles[:, None] ** powers, values, rcond=None)[0]
        inner = Polynomial(np.concatenate([np.zeros(lowest), solution]))
        below = 1.0 if quantity == "drag" else -1.0
        beyond = -1.0 if quantity == "lift" else 1.0
        arguments = (Polynomial([0.0, 1.0]), Polynomial([np.pi / 2, -1.0]), Polynomial([0.0, 1.0]))
        pieces = (
            below * beyond * inner(arguments[0]),
            below * inner(arguments[1]),
            inner(arguments[2]),
            beyond * inner(arguments[1]),
        )
        for k, piece in enumerate(pieces):
            coefficients[k, j, : len(piece.coef)] = piece.coef
    return breaks, coefficients


@lru_cache(maxsize=64)
def build_law(table: PolarTable) -> HydrodynamicLaw:
    """Make the law of a table; laws of equal tables are made once, since every edit of a design asks again.

    Raises
    ------
    DesignError
        Where speeds cannot be averaged, angles are too few, or drag does not stay positive.

    """
    angles, data = select_data(table)
    fit = _fit_pchip if table.law == "pchip" else _fit_polynomials
    breaks, coefficients = fit(angles, data)
    coefficients = np.ascontiguousarray(coefficients)
    for shared in (breaks, coefficients):
        shared.setflags(write=False)
    law = HydrodynamicLaw(breaks, coefficients, _errors(breaks, coefficients, angles, data))
    _require_positive_drag(table, law)
    return law


def coefficient_law(source: CoefficientForm) -> HydrodynamicLaw:
    """Return lift, drag and moment of the coefficient form without sideslip: one polynomial from -180 to 180 deg.

    Two pieces, so that the one that glides use most begins at zero angle and loses no digits.
    """
    at_zero = np.array(
        [
            [source.lift_zero, source.lift_attack, 0.0],
            [source.drag_zero, 0.0, source.drag_attack],
            [source.pitch_zero, source.pitch_attack, 0.0],
        ]
    )
    coefficients = np.zeros((2, 3, 4))
    coefficients[1, :, :3] = at_zero
    for j, row in enumerate(at_zero):
        moved = Polynomial(row)(Polynomial([-np.pi, 1.0]))
        coefficients[0, j, : len(moved.coef)] = moved.coef
    return HydrodynamicLaw(np.array([-np.pi, 0.0, np.pi]), coefficients, ())


@remembered(most=100)
def law_of(source: Hydrodynamics) -> HydrodynamicLaw | None:
    """Return a source's law in the angle of attack; None for a table over both angles.

    Raises
    ------
    DesignError
        Where `build_law` does.

    """
    match source:
        case PolarTable():
            return build_law(source)
        case CoefficientForm():
            return coefficient_law(source)
        case _:
            return None


def _errors(breaks: Array, coefficients: Array, angles: Array, data: Array) -> tuple[FitError, ...]:
    difference = np.abs(HydrodynamicLaw(breaks, coefficients, ())(angles) - data)
    if len(breaks) == 5:  # at 90 deg lift has both signs: compare with the branch that was fitted
        difference[:, -1] = np.abs(
            HydrodynamicLaw(breaks, coefficients, ())(np.nextafter(angles[-1], 0.0)) - data[:, -1]
        )
    return tuple(
        FitError(
            quantity=quantity,
            rms=float(np.sqrt(np.mean(miss**2))),
            largest=float(miss.max()),
            largest_at_deg=float(np.rad2deg(angles[miss.argmax()])),
            range=float(np.ptp(values)),
        )
        for quantity, miss, values in zip(QUANTITIES, difference, data, strict=True)
    )


def _require_positive_drag(table: PolarTable, law: HydrodynamicLaw) -> None:
    angles = np.unique(np.concatenate([np.linspace(0.0, np.pi, 3601), law.breaks[law.breaks >= 0.0]]))
    drag = law(angles)[1]
    if drag.min() > 0.0:
        return
    worst = np.rad2deg(angles[drag.argmin()])
    raise DesignError(
        [
            Problem(
                f"{POINTER}/row_drag" if table.law == "pchip" else f"{POINTER}/law",
                f"drag falls to {drag.min():.4g} N s2/m2 per squared speed at {worst:.1f} deg by '{table.law}'",
                limit=0.0,
                hint="drag must stay positive: check the data" + (", or use 'pchip'" if table.law != "pchip" else ""),
            )
        ]
    )
