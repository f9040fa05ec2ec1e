"""Owns the table over angle of attack and sideslip: body-axis forces and moments per squared speed on a whole grid."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from models.fields import Switch, text, vector
from models.hydrodynamics import SMALLEST_SPACING_DEG, Force, RateTerms, Source

MAX_ANGLES = 721
Attack = Annotated[float, Field(strict=True, ge=-180.0, le=180.0)]
Sideslip = Annotated[float, Field(strict=True, ge=-90.0, le=90.0)]
Grid = tuple[tuple[Force, ...], ...]
QUANTITIES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def _grid(what: str, unit: str, symbol: str) -> Grid:
    description = f"{what} per squared speed, body axes: a row for each angle of attack, a column for each sideslip."
    return vector(description, unit=unit, symbol=symbol, min_length=2, max_length=MAX_ANGLES)  # type: ignore[no-any-return]


class AngleTable(Source):
    """Forces and moments in body axes over angle of attack and sideslip; cubics between.

    Where the sideslips begin at 0 the vehicle counts as symmetric from port to starboard, and negative ones are
    mirrored: surge, heave and pitch even, sway, roll and yaw odd. Angles of attack from -180 to 180 deg close a circle.
    Beyond the edges drag, side force, lift and moments of the edge are held.
    """

    kind: Literal["angle_table"] = text("Which source this is: a table over angle of attack and sideslip.")
    includes_munk_moment: Switch = text(
        "Whether the moments were measured on the body in a stream, and so already hold the Munk moment.", default=True
    )
    alpha_deg: tuple[Attack, ...] = vector(
        "Angles of attack, rising.", unit="deg", symbol="alpha", min_length=2, max_length=MAX_ANGLES
    )
    beta_deg: tuple[Sideslip, ...] = vector(
        "Sideslips, rising; from 0 for a symmetric vehicle.",
        unit="deg", symbol="beta", min_length=2, max_length=MAX_ANGLES,
    )  # fmt: skip
    surge: Grid = _grid("Force forward", "N s2/m2", "X")
    sway: Grid = _grid("Force to starboard", "N s2/m2", "Y")
    heave: Grid = _grid("Force down", "N s2/m2", "Z")
    roll: Grid = _grid("Moment about x, starboard down,", "N m s2/m2", "K")
    pitch: Grid = _grid("Moment about y, nose up,", "N m s2/m2", "M")
    yaw: Grid = _grid("Moment about z, nose to starboard,", "N m s2/m2", "N")
    rates: RateTerms = text("Forces and moments by the rates of turning.", default=RateTerms())

    @property
    def mirrored(self) -> bool:
        """Whether negative sideslips follow from the positive ones."""
        return self.beta_deg[0] == 0.0

    @model_validator(mode="after")
    def _whole_grid(self) -> Self:
        for name, angles in (("alpha_deg", self.alpha_deg), ("beta_deg", self.beta_deg)):
            for a, b in pairwise(angles):
                if b - a < SMALLEST_SPACING_DEG:
                    raise ValueError(f"{name} must rise by at least {SMALLEST_SPACING_DEG} deg: {a} is followed by {b}")
        for name in QUANTITIES:
            grid: Grid = getattr(self, name)
            if len(grid) != len(self.alpha_deg):
                raise ValueError(f"{name} has {len(grid)} rows, alpha_deg has {len(self.alpha_deg)} angles")
            for angle, row in zip(self.alpha_deg, grid, strict=True):
                if len(row) != len(self.beta_deg):
                    raise ValueError(
                        f"{name} at alpha = {angle} deg has {len(row)} entries, beta_deg has {len(self.beta_deg)}"
                    )
        self._check_seams()
        return self

    def _check_seams(self) -> None:
        for name in QUANTITIES:
            grid: Grid = getattr(self, name)
            size = max(abs(value) for row in grid for value in row)
            if self.alpha_deg[0] == -180.0 and self.alpha_deg[-1] == 180.0:
                for beta, a, b in zip(self.beta_deg, grid[0], grid[-1], strict=True):
                    if abs(a - b) > 1e-6 * size:
                        raise ValueError(
                            f"{name} at beta = {beta} deg is {a} at -180 deg and {b} at 180 deg: one direction"
                        )
            if self.mirrored and name in ("sway", "roll", "yaw"):
                for alpha, row in zip(self.alpha_deg, grid, strict=True):
                    if abs(row[0]) > 1e-6 * size:
                        raise ValueError(
                            f"{name} at alpha = {alpha} deg, beta = 0 is {row[0]}, not 0: a vehicle that is not "
                            "symmetric needs negative sideslips too"
                        )
