"""Owns how the range of a hydrodynamic source is said in a few words: always in sight beside the source's name."""

from __future__ import annotations

from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm


def range_in_short(source: Hydrodynamics) -> str:
    """Return the angles of attack, sideslips and speeds for which a source has data, or was meant."""
    match source:
        case PolarTable():
            low, high = source.speeds[0], source.speeds[-1]
            speeds = f"{low:g} m/s" if low == high else f"{low:g}–{high:g} m/s"
            # a table over one angle from 0 to 90 deg is mirrored to negative ones
            return f"α ±{max(source.row_alpha_deg):g}°, {speeds}"
        case AngleTable():
            alpha, beta = (
                _span(source.alpha_deg[0], source.alpha_deg[-1]),
                _span(source.beta_deg[0], source.beta_deg[-1]),
            )
            return f"α {alpha}, β {f'±{source.beta_deg[-1]:g}°' if source.mirrored else beta}"
        case CoefficientForm():
            return f"α ±{source.alpha_limit_deg:g}°, β ±{source.beta_limit_deg:g}°"


def _span(low: float, high: float) -> str:
    return f"±{high:g}°" if low == -high else f"{low:g} to {high:g}°".replace("-", "−")
