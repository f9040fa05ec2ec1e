"""Owns the water around the glider: density, gravity, surface and bed. World z points down; the surface is z = 0."""

from __future__ import annotations

from typing import Literal

from models.fields import Description, quantity, text


class UniformWater(Description):
    """Still water of one density."""

    kind: Literal["uniform"] = text("Which water this is: of one density.", default="uniform")
    density: float = quantity("Density.", unit="kg/m3", symbol="rho", ge=1e-3, le=2e4, default=1000.0)


class Environment(Description):
    """Where the mission takes place."""

    water: UniformWater = text("The water.", default=UniformWater())
    gravity: float = quantity("Acceleration of gravity.", unit="m/s2", symbol="g", ge=0.0, le=100.0, default=9.8)
    bed_depth: float | None = quantity(
        "Depth of the bed; contact of the body origin ends the run. None: no bed.",
        unit="m", symbol="z_bed", gt=0.0, le=2e4, default=None,
    )  # fmt: skip
