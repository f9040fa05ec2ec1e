"""Owns the comparison of a design's force data with the law in use: the JSON that the page's dialog draws.

Forces are per squared speed, N s2/m2 and N m s2/m2, at the density at which they were taken; angles in degrees.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.hydrodynamic_law import QUANTITIES, FitError, build_law, coefficients_by_speed, select_data
from models.hydrodynamics import PolarTable

ANGLES_DEG = np.linspace(-180.0, 180.0, 361)
LAWS = {
    "pchip": "shape-preserving cubics through the data",
    "polynomial": "polynomials of degree 5, 4 and 7 in the angle of attack",
}
UNITS = {"lift": "N s²/m²", "drag": "N s²/m²", "moment": "N m s²/m²"}


def polar_document(table: PolarTable) -> dict[str, Any]:
    """Return the data of every speed, the data chosen, the law made from them, its errors, and where they come from.

    Raises
    ------
    DesignError
        Where `build_law` does.

    """
    law = build_law(table)
    angles, chosen = select_data(table)
    return {
        "units": UNITS,
        "law": {"name": table.law, "what": LAWS[table.law], "alpha_deg": ANGLES_DEG.tolist()}
        | _by_quantity(law(np.deg2rad(ANGLES_DEG))),
        "data": [
            {"speed": speed, "alpha_deg": np.rad2deg(alpha).tolist()} | _by_quantity(values)
            for speed, (alpha, values) in coefficients_by_speed(table).items()
        ],
        "chosen": {"what": _chosen(table), "alpha_deg": np.rad2deg(angles).tolist()} | _by_quantity(chosen),
        "errors": [_error(error) for error in law.errors],
        "reference_density": table.reference_density,
        "reference_point": table.reference_point,
        "provenance": table.provenance.model_dump(),
    }


def _by_quantity(values: NDArray[np.float64]) -> dict[str, list[float]]:
    return {name: row.tolist() for name, row in zip(QUANTITIES, values, strict=True)}


def _chosen(table: PolarTable) -> str:
    if table.speed is None and len(table.speeds) > 1:
        return f"mean of {len(table.speeds)} speeds"
    return f"{table.speed or table.speeds[0]:g} m/s"


def _error(error: FitError) -> dict[str, str | float]:
    return {
        "quantity": error.quantity,
        "rms": error.rms,
        "largest": error.largest,
        "largest_at_deg": error.largest_at_deg,
        "range": error.range,
        "relative": error.relative,
    }
