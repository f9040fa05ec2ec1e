"""Owns the description of hydrodynamic data: forces measured over the angle of attack and speed, and the law fitted.

Angles of attack are those of the measurement, 0 to 90 deg; `hydrodynamic_law` mirrors them to the whole circle.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from models.fields import Description, Switch, Vector3, quantity, text, vector
from models.memory import remembered

Degrees = Annotated[float, Field(strict=True, ge=0.0, le=90.0)]
Speed = Annotated[float, Field(strict=True, ge=1e-4, le=100.0)]
Force = Annotated[float, Field(strict=True, ge=-1e9, le=1e9)]
MAX_ROWS = 20_000
SMALLEST_SPACING_DEG = 0.01


class Provenance(Description):
    """Where data come from, and what they are not."""

    title: str = text("What the data are, in a few words.", min_length=1, max_length=200)
    source: str = text("Who made them, how and when.", min_length=1, max_length=4000)
    limits: str = text("What they are not: known limits, for every page that shows them.", default="", max_length=4000)


def coefficient(description: str, *, unit: str, symbol: str, ge: float = -1e9) -> Any:
    """Make the field of a coefficient that is 0 unless stated."""
    return quantity(description, unit=unit, symbol=symbol, ge=ge, le=1e9, default=0.0)


class RateTerms(Description):
    """Forces and moments in body axes by the rates of turning, times V or V^2."""

    scaling: Literal["speed", "speed_squared"] = text(
        "What the terms are multiplied by: V (strip theory), or V^2 (much of the glider literature); units change "
        "with it.",
        default="speed",
    )
    heave_pitch: float = coefficient("Force down by pitch rate.", unit="N s2/(m rad)", symbol="Z_q")
    pitch_pitch: float = coefficient("Pitch moment by pitch rate.", unit="N s2/rad", symbol="M_q")
    sway_roll: float = coefficient("Force to starboard by roll rate.", unit="N s2/(m rad)", symbol="Y_p")
    sway_yaw: float = coefficient("Force to starboard by yaw rate.", unit="N s2/(m rad)", symbol="Y_r")
    roll_roll: float = coefficient("Roll moment by roll rate.", unit="N s2/rad", symbol="K_p")
    roll_yaw: float = coefficient("Roll moment by yaw rate.", unit="N s2/rad", symbol="K_r")
    yaw_roll: float = coefficient("Yaw moment by roll rate.", unit="N s2/rad", symbol="N_p")
    yaw_yaw: float = coefficient("Yaw moment by yaw rate.", unit="N s2/rad", symbol="N_r")


class LateralCoefficients(Description):
    """What a table over the angle of attack lacks in three dimensions: side force, roll and yaw moments, rate terms.

    Y = V^2 (Y_b sin(beta) + Y_bb sin(beta) |sin(beta)|), K and N likewise, about the body origin, plus the rate terms.
    Written in the sine of the sideslip (v / V), they stay bounded and keep their sense when the glider moves backwards.
    """

    source: str = text("How the coefficients were found.", min_length=1, max_length=4000)
    includes_munk_moment: Switch = text(
        "Whether roll and yaw moments already hold the Munk moment; those of strip theory do not.", default=False
    )
    sway_sideslip: float = coefficient("Force to starboard by sideslip.", unit="N s2/(m2 rad)", symbol="Y_b")
    sway_crossflow: float = coefficient("Force to starboard by cross-flow drag.", unit="N s2/m2", symbol="Y_bb")
    roll_sideslip: float = coefficient("Roll moment by sideslip.", unit="N s2/(m rad)", symbol="K_b")
    roll_crossflow: float = coefficient("Roll moment by cross-flow drag.", unit="N s2/m", symbol="K_bb")
    yaw_sideslip: float = coefficient("Yaw moment by sideslip.", unit="N s2/(m rad)", symbol="N_b")
    yaw_crossflow: float = coefficient("Yaw moment by cross-flow drag.", unit="N s2/m", symbol="N_bb")
    rates: RateTerms = text("Forces and moments by the rates of turning.", default=RateTerms())


class Source(Description):
    """What every source of force says of itself."""

    provenance: Provenance = text("Where the data come from.")
    reference_density: float = quantity(
        "Density at which the forces were taken.", unit="kg/m3", symbol="rho_ref", ge=1e-3, le=2e4, default=1000.0
    )
    reference_point: Vector3 = vector(
        "Point about which the moments were taken, body axes.", unit="m", symbol="r_ref", default=(0.0, 0.0, 0.0)
    )


class PolarTable(Source):
    """Lift, drag and pitching moment over the angle of attack at one or several speeds, as a tank or CFD gives them."""

    kind: Literal["polar_table"] = text("Which source this is: a table over the angle of attack.")
    law: Literal["pchip", "polynomial"] = text(
        "Law between the data: shape-preserving cubics through them, or the paper's polynomials of degree 5, 4, 7.",
        default="pchip",
    )
    speed: Speed | None = quantity(
        "Use only the rows of this speed; none averages the coefficients of all speeds.",
        unit="m/s", symbol="V_data", default=None,
    )  # fmt: skip
    includes_munk_moment: Switch = text(
        "Whether the moment was measured on the body in a stream, and so already holds the Munk moment.", default=True
    )
    lateral: LateralCoefficients | None = text(
        "Side force, roll and yaw moments and rate terms for the spatial model; without them there are none.",
        default=None,
    )
    row_speed: tuple[Speed, ...] = vector("Speed of each row.", unit="m/s", symbol="V", max_length=MAX_ROWS)
    row_alpha_deg: tuple[Degrees, ...] = vector(
        "Angle of attack of each row.", unit="deg", symbol="alpha", max_length=MAX_ROWS
    )
    row_lift: tuple[Force, ...] = vector(
        "Force across the flow, up at positive angle of attack.", unit="N", symbol="F_L", max_length=MAX_ROWS
    )
    row_drag: tuple[Force, ...] = vector("Force along the flow.", unit="N", symbol="F_D", max_length=MAX_ROWS)
    row_moment: tuple[Force, ...] = vector(
        "Moment about the reference point, nose up positive.", unit="N m", symbol="tau", max_length=MAX_ROWS
    )

    @property
    def columns(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """The columns of the table by name."""
        return (
            ("row_speed", self.row_speed),
            ("row_alpha_deg", self.row_alpha_deg),
            ("row_lift", self.row_lift),
            ("row_drag", self.row_drag),
            ("row_moment", self.row_moment),
        )

    @property
    def speeds(self) -> tuple[float, ...]:
        """The speeds at which data exist, rising, m/s."""
        return tuple(sorted(set(self.row_speed)))

    @model_validator(mode="after")
    def _columns_match(self) -> Self:
        self._check_columns()
        return self

    @remembered(most=16)  # pydantic asks again for every description around it that is made anew
    def _check_columns(self) -> None:
        lengths = {name: len(column) for name, column in self.columns}
        if len(set(lengths.values())) != 1:
            raise ValueError(f"the columns differ in length: {lengths}")
        if not self.row_speed:
            raise ValueError("the table has no rows: give at least one speed, its angles from 0 to 90 deg")
        if self.speed is not None and self.speed not in self.row_speed:
            raise ValueError(f"no row has the chosen speed {self.speed} m/s; the data have {list(self.speeds)} m/s")
        grids: dict[float, list[float]] = {}
        for angle, speed in zip(self.row_alpha_deg, self.row_speed, strict=True):
            grids.setdefault(speed, []).append(angle)
        for speed, angles in grids.items():
            self._check_grid(speed, angles)

    @staticmethod
    def _check_grid(speed: float, angles: list[float]) -> None:
        for a, b in pairwise(angles):
            if b - a < SMALLEST_SPACING_DEG:
                raise ValueError(
                    f"angles at {speed} m/s must rise by at least {SMALLEST_SPACING_DEG} deg: {a} is followed by {b}"
                )
        if len(angles) < 4 or angles[0] != 0.0 or angles[-1] != 90.0:
            raise ValueError(
                f"the rows at {speed} m/s must run from 0 to 90 deg in at least 4 angles; they have {len(angles)}"
                + (f", from {angles[0]} to {angles[-1]} deg" if angles else "")
            )


MatrixRow = tuple[Force, Force, Force, Force, Force, Force]
Matrix6 = tuple[MatrixRow, MatrixRow, MatrixRow, MatrixRow, MatrixRow, MatrixRow]


class AddedMass(Description):
    """Added mass about the body origin in body axes: surge, sway, heave, roll, pitch, yaw."""

    enabled: Switch = text("Whether the added mass enters the equations.", default=True)
    matrix: Matrix6 = vector("Symmetric 6x6 matrix: kg, kg m and kg m2 by block.", unit="kg, kg m, kg m2", symbol="M_A")
    density: float = quantity(
        "Density at which the matrix holds; it scales with the water's.",
        unit="kg/m3", symbol="rho_ref", ge=1e-3, le=2e4, default=1000.0,
    )  # fmt: skip
    source: str = text("Where the matrix comes from.", default="", max_length=4000)


class Damping(Description):
    """Linear damping beside the hydrodynamic source, about the body origin in body axes."""

    surge: float = quantity("Force per surge velocity.", unit="N s/m", symbol="D_11", ge=0.0, le=1e6, default=0.0)
    sway: float = quantity("Force per sway velocity.", unit="N s/m", symbol="D_22", ge=0.0, le=1e6, default=0.0)
    heave: float = quantity("Force per heave velocity.", unit="N s/m", symbol="D_33", ge=0.0, le=1e6, default=0.0)
    roll: float = quantity("Moment per roll rate.", unit="N m s", symbol="D_44", ge=0.0, le=1e6, default=0.0)
    pitch: float = quantity(
        "Moment per pitch rate (the paper's C33).", unit="N m s", symbol="C_33", ge=0.0, le=1e6, default=0.0
    )
    yaw: float = quantity("Moment per yaw rate.", unit="N m s", symbol="D_66", ge=0.0, le=1e6, default=0.0)
    matrix: Matrix6 | None = vector(
        "Full 6x6 matrix that is added to the entries above (spatial model only).",
        unit="N s/m, N s, N m s", symbol="D", default=None,
    )  # fmt: skip
