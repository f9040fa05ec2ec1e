"""Owns the comparison of a design's force data with the law in use: the JSON that the page's dialog draws.

Forces are per squared speed, N s2/m2 and N m s2/m2, at the density at which they were taken, without sideslip; angles
in degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.hydrodynamic_grid import build_grid_law
from models.hydrodynamic_law import QUANTITIES, FitError, build_law, coefficient_law, coefficients_by_speed, select_data
from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm

Array = NDArray[np.float64]

ANGLES_DEG = np.linspace(-180.0, 180.0, 361)
LAWS = {
    "pchip": "shape-preserving cubics through the data",
    "polynomial": "polynomials of degree 5, 4 and 7 in the angle of attack",
    "grid": "bicubic pieces through the table, drawn at zero sideslip",
    "coefficients": "the formulas of the coefficients, drawn at zero sideslip",
}
IN_TABLE = {"side force": "sway", "roll moment": "roll", "yaw moment": "yaw"}
IN_COEFFICIENTS = {
    "side force": ("side_sideslip",),
    "roll moment": ("roll_sideslip", "roll_rate"),
    "yaw moment": ("yaw_sideslip", "yaw_rate"),
}
UNITS = {"lift": "N s²/m²", "drag": "N s²/m²", "moment": "N m s²/m²"}


def source_in_short(source: Hydrodynamics) -> str:
    """Return in a few words how a source's forces are made."""
    match source:
        case PolarTable():
            return f"{'PCHIP' if source.law == 'pchip' else 'polynomials'} · {_chosen(source)}"
        case AngleTable():
            return f"{len(source.alpha_deg)} × {len(source.beta_deg)} angles"
        case CoefficientForm():
            return f"coefficients to ±{source.alpha_limit_deg:g}°"


def source_range(source: Hydrodynamics) -> dict[str, Any]:
    """Return title and range of a source: angles in deg and speeds in m/s it was measured or is meant for, or None."""
    told: dict[str, Any] = {"title": source.provenance.title, "short": source_in_short(source), "speed": None}
    match source:
        case PolarTable():
            return told | {
                "attack_deg": [-90.0, 90.0], "sideslip_deg": None, "speed": [source.speeds[0], source.speeds[-1]],
            }  # fmt: skip
        case AngleTable():
            slip, mirrored = source.beta_deg, source.mirrored
            return told | {
                "attack_deg": [source.alpha_deg[0], source.alpha_deg[-1]],
                "sideslip_deg": [-slip[-1] if mirrored else slip[0], slip[-1]],
            }
        case CoefficientForm():
            attack, sideslip = source.alpha_limit_deg, source.beta_limit_deg
            return told | {"attack_deg": [-attack, attack], "sideslip_deg": [-sideslip, sideslip]}


def polar_document(source: Hydrodynamics) -> dict[str, Any]:
    """Return the data, the law made from them over the angle of attack, its errors, and where they come from.

    Raises
    ------
    DesignError
        Where `build_law` does.

    """
    match source:
        case PolarTable():
            shown = _polar_table(source)
        case AngleTable():
            shown = _angle_table(source)
        case CoefficientForm():
            shown = _coefficients(source)
    return {
        "kind": source.kind,
        "units": UNITS,
        "data": [],
        "chosen": None,
        "errors": [],
        "reference_density": source.reference_density,
        "reference_point": source.reference_point,
        "munk": "with" if source.includes_munk_moment else "without",
        "provenance": source.provenance.model_dump(),
    } | shown


def _polar_table(table: PolarTable) -> dict[str, Any]:
    law = build_law(table)
    angles, chosen = select_data(table)
    lateral = "none: nothing holds the glider against sideslip" if table.lateral is None else table.lateral.source
    return {
        "law": _law(table.law, law(np.deg2rad(ANGLES_DEG))),
        "data": [
            {"speed": speed, "alpha_deg": np.rad2deg(alpha).tolist()} | _by_quantity(values)
            for speed, (alpha, values) in coefficients_by_speed(table).items()
        ],
        "chosen": {"what": _chosen(table), "alpha_deg": np.rad2deg(angles).tolist()} | _by_quantity(chosen),
        "errors": [_error(error) for error in law.errors],
        "range_deg": [0.0, 90.0],
        "folds": True,
        "beyond": "Nothing was measured outside 0 to 90°: lift and moment are odd in the angle, drag even; past 90° "
        "all three are reflected.",
        "sideways": lateral,
    }


def _angle_table(table: AngleTable) -> dict[str, Any]:
    law, radians = build_grid_law(table), np.deg2rad(ANGLES_DEG)
    low, high = table.alpha_deg[0], table.alpha_deg[-1]
    shown: dict[str, Any] = {
        "law": _law("grid", _flow_frame(radians, np.array([law(alpha, 0.0) for alpha in radians]).T)),
        "range_deg": [low, high],
        "folds": False,
        "beyond": f"The table runs from {low:g} to {high:g}° of attack and from {table.beta_deg[0]:g} to "
        f"{table.beta_deg[-1]:g}° of sideslip{', mirrored' if table.mirrored else ''}; the forces of its edges are "
        "held beyond.",
        "sideways": _sideways("table", {what: _in_table(table, name) for what, name in IN_TABLE.items()}),
    }
    if 0.0 in table.beta_deg:
        k = table.beta_deg.index(0.0)
        columns = np.array([[row[k] for row in getattr(table, name)] for name in ("surge", "heave", "pitch")])
        body = np.zeros((6, len(table.alpha_deg)))
        body[[0, 2, 4]] = columns
        shown["chosen"] = {"what": "the table at zero sideslip", "alpha_deg": list(table.alpha_deg)} | _by_quantity(
            _flow_frame(np.deg2rad(table.alpha_deg), body)
        )
    return shown


def _coefficients(source: CoefficientForm) -> dict[str, Any]:
    limit, slip = source.alpha_limit_deg, source.beta_limit_deg
    return {
        "law": _law("coefficients", coefficient_law(source)(np.deg2rad(ANGLES_DEG))),
        "range_deg": [-limit, limit],
        "folds": False,
        "beyond": f"Meant for angles of attack to ±{limit:g}° and sideslips to ±{slip:g}°; beyond, the formulas go on.",
        "sideways": _sideways(
            "coefficients",
            {what: any(getattr(source, name) for name in names) for what, names in IN_COEFFICIENTS.items()},
        ),
    }


def _in_table(table: AngleTable, name: str) -> bool:
    by_rates = (getattr(table.rates, f"{name}_{rate}") for rate in ("roll", "yaw"))
    return bool(np.any(getattr(table, name))) or any(by_rates)


def _sideways(where: str, given: Mapping[str, object]) -> str:
    """Return which lateral forces a source gives, told by its values; `given` says of each whether one is not zero."""
    there, missing = ([what for what in given if bool(given[what]) is wanted] for wanted in (True, False))
    if not there:
        return f"no side force, roll or yaw moment: they are all zero in the {where}; nothing holds against sideslip"
    told = f"the {where} give{'s' if where == 'table' else ''} {_listed(there, 'and')}"
    return f"{told}; no {_listed(missing, 'or')}" if missing else told


def _listed(words: list[str], link: str) -> str:
    return f" {link} ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _flow_frame(alpha: Array, body: Array) -> Array:
    """Return lift, drag and moment (3, n) of body-axis forces and moments (6, n) at zero sideslip."""
    X, Z, M = body[0], body[2], body[4]
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([s * X - c * Z, -(c * X + s * Z), M])


def _law(name: str, values: Array) -> dict[str, Any]:
    return {"name": name, "what": LAWS[name], "alpha_deg": ANGLES_DEG.tolist()} | _by_quantity(values)


def _by_quantity(values: Array) -> dict[str, list[float]]:
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
