"""Owns the water around the glider: density, current, gravity, surface and bed. World z points down from z = 0."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from models.fields import Description, quantity, text, vector

DEFAULT_GRAVITY = 9.8
MAX_LEVELS = 5000
Depth = Annotated[float, Field(strict=True, ge=0.0, le=2e4)]
Density = Annotated[float, Field(strict=True, ge=1e-3, le=2e4)]
Temperature = Annotated[float, Field(strict=True, ge=-2.0, le=40.0)]
Salinity = Annotated[float, Field(strict=True, ge=0.0, le=42.0)]
Velocity = Annotated[float, Field(strict=True, ge=-50.0, le=50.0)]
Shear = Annotated[float, Field(strict=True, ge=-10.0, le=10.0)]
Time = Annotated[float, Field(strict=True, ge=0.0, le=1e9)]
Velocity2 = tuple[Velocity, Velocity]
SMALLEST_LEVEL = 1e-3
"""Least difference of depth between two levels of a profile, m."""


def _depths(least: int = 2) -> tuple[Depth, ...]:
    return vector(  # type: ignore[no-any-return]
        "Depths of the levels, rising.", unit="m", symbol="z", min_length=least, max_length=MAX_LEVELS
    )


def _require_rising(depths: tuple[float, ...]) -> None:
    for k, (a, b) in enumerate(pairwise(depths)):
        if not b - a >= SMALLEST_LEVEL:
            raise ValueError(
                f"depths must rise by {SMALLEST_LEVEL:g} m at least: level {k + 1} is at {b} m, after {a} m; "
                "sort the profile and drop repeated levels"
            )


def _require_length(name: str, column: tuple[object, ...], depths: tuple[float, ...]) -> None:
    if len(column) != len(depths):
        raise ValueError(f"{name} has {len(column)} levels, depths has {len(depths)}")


class UniformWater(Description):
    """Water of one density."""

    kind: Literal["uniform"] = text("Which water this is: of one density.", default="uniform")
    density: float = quantity("Density.", unit="kg/m3", symbol="rho", ge=1e-3, le=2e4, default=1000.0)


class DensityProfile(Description):
    """Water whose density is given against depth; shape-preserving cubics between the levels, held beyond them."""

    kind: Literal["density_profile"] = text("Which water this is: density against depth.")
    depths: tuple[Depth, ...] = _depths()
    densities: tuple[Density, ...] = vector(
        "In-situ density at the levels.", unit="kg/m3", symbol="rho", min_length=2, max_length=MAX_LEVELS
    )
    source: str = text("Where the profile comes from.", default="", max_length=4000)

    @model_validator(mode="after")
    def _levels(self) -> Self:
        _require_rising(self.depths)
        _require_length("densities", self.densities, self.depths)
        return self


class Teos10Water(Description):
    """Fresh or salt water by TEOS-10 from temperature and salinity against depth; held beyond the first and last level.

    Latitude sets pressure and, unless the environment states it, gravity.
    """

    kind: Literal["teos10"] = text("Which water this is: temperature and salinity against depth.")
    depths: tuple[Depth, ...] = _depths()
    temperatures: tuple[Temperature, ...] = vector(
        "In-situ temperature at the levels (ITS-90).", unit="degC", symbol="t", min_length=2, max_length=MAX_LEVELS
    )
    salinities: tuple[Salinity, ...] | None = vector(
        "Salinity at the levels; none is fresh water.",
        unit="g/kg", symbol="S", min_length=2, max_length=MAX_LEVELS, default=None,
    )  # fmt: skip
    salinity_kind: Literal["practical", "absolute"] = text(
        "Whether salinities are practical (PSS-78, as a CTD gives them) or absolute (g/kg).", default="practical"
    )
    latitude: float = quantity("Latitude, north positive.", unit="deg", symbol="phi", ge=-90.0, le=90.0)
    longitude: float | None = quantity(
        "Longitude, east positive: gives practical salinity the composition of that sea; none takes the reference one.",
        unit="deg", symbol="lambda", ge=-180.0, le=360.0, default=None,
    )  # fmt: skip
    source: str = text("Where the profile comes from.", default="", max_length=4000)

    @model_validator(mode="after")
    def _levels(self) -> Self:
        _require_rising(self.depths)
        _require_length("temperatures", self.temperatures, self.depths)
        if self.salinities is not None:
            _require_length("salinities", self.salinities, self.depths)
        return self


def _uniform_unless_told(water: Any) -> Any:
    """Water that does not say its kind is uniform, so that {"density": 998} is enough."""
    return {"kind": "uniform", **water} if isinstance(water, dict) and "kind" not in water else water


Water = Annotated[
    UniformWater | DensityProfile | Teos10Water, Field(discriminator="kind"), BeforeValidator(_uniform_unless_told)
]


class UniformCurrent(Description):
    """The same current everywhere."""

    kind: Literal["uniform"] = text("Which current this is: the same everywhere.")
    velocity: Velocity2 = vector("Velocity north (x) and east (y).", unit="m/s", symbol="v_c")


class ShearedCurrent(Description):
    """A current that changes linearly with depth, all the way down."""

    kind: Literal["sheared"] = text("Which current this is: linear in depth.")
    surface_velocity: Velocity2 = vector("Velocity north (x) and east (y) at the surface.", unit="m/s", symbol="v_c0")
    shear: tuple[Shear, Shear] = vector("Change of the velocity per depth.", unit="1/s", symbol="dv_c/dz")


class TabulatedCurrent(Description):
    """A current against depth, and against time where `times` are given; held beyond the first and last of each.

    Shape-preserving cubics in depth, linear in time.
    """

    kind: Literal["tabulated"] = text("Which current this is: a table.")
    depths: tuple[Depth, ...] = _depths()
    times: tuple[Time, ...] = vector(
        "Times of the profiles, rising; one for a steady current.",
        unit="s", symbol="t", min_length=1, max_length=MAX_LEVELS, default=(0.0,),
    )  # fmt: skip
    north: tuple[tuple[Velocity, ...], ...] = vector(
        "Velocity north (x): a profile over the depths for each time.", unit="m/s", symbol="v_cx", min_length=1
    )
    east: tuple[tuple[Velocity, ...], ...] = vector(
        "Velocity east (y): a profile over the depths for each time.", unit="m/s", symbol="v_cy", min_length=1
    )
    source: str = text("Where the table comes from.", default="", max_length=4000)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        _require_rising(self.depths)
        for a, b in pairwise(self.times):
            if not b - a >= SMALLEST_LEVEL:
                raise ValueError(f"times must rise by {SMALLEST_LEVEL:g} s at least: {a} s is followed by {b} s")
        for name, table in (("north", self.north), ("east", self.east)):
            if len(table) != len(self.times):
                raise ValueError(f"{name} has {len(table)} profiles, times has {len(self.times)}")
            for k, profile in enumerate(table):
                _require_length(f"{name}, profile {k},", profile, self.depths)
        return self


Current = Annotated[UniformCurrent | ShearedCurrent | TabulatedCurrent, Field(discriminator="kind")]


class Environment(Description):
    """Where the mission takes place."""

    water: Water = text("The water.", default=UniformWater())
    current: Current | None = text("How the water moves; none is still water.", default=None)
    gravity: float | None = quantity(
        "Acceleration of gravity; none takes that of the water's latitude, or 9.8 where it has none.",
        unit="m/s2", symbol="g", ge=0.0, le=100.0, default=None,
    )  # fmt: skip
    surface: Literal["end", "float"] = text(
        "What the surface does: it ends the run when the body origin reaches it, or the glider floats there, the "
        "buoyancy of each part fading as it emerges (spatial model only).",
        default="end",
    )
    bed_depth: float | None = quantity(
        "Depth of the bed, which the body origin may touch. None: no bed.",
        unit="m", symbol="z_bed", gt=0.0, le=2e4, default=None,
    )  # fmt: skip
    bed_contact: Literal["end", "slide"] = text(
        "What the bed does: contact ends the run, or the glider lands and slides on it without friction (spatial "
        "model only).",
        default="end",
    )
