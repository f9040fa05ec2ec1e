"""Owns the components of a vehicle: what each weighs and displaces, where it sits, and how its actuator moves.

Body axes (x to the nose, y to starboard, z down through the keel), SI units. The volume laws are those of Canete et
al., Eqs. 9 and 10, corrected (docs/physics.md, section 3).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from models.fields import Description, Name, Switch, Vector3, quantity, require_direction, text, vector
from models.shapes import Shape

SMALLEST_STROKE = 1e-9
"""Finest difference of extensions that means anything, m."""
SMALLEST_LAG = 1e-4
"""Shortest lag that is told from none, s."""

Extension = Annotated[float, Field(strict=True, ge=-100.0, le=100.0)]
Volume = Annotated[float, Field(strict=True, ge=0.0, le=1e4)]
Angle = Annotated[float, Field(strict=True, ge=-100.0, le=100.0)]


class Inertia(Description):
    """Inertia tensor about a centre of mass, in body axes."""

    xx: float = quantity("Moment of inertia about x.", unit="kg m2", symbol="I_xx", ge=0.0, le=1e9, default=0.0)
    yy: float = quantity("Moment of inertia about y (pitch).", unit="kg m2", symbol="I_yy", ge=0.0, le=1e9, default=0.0)
    zz: float = quantity("Moment of inertia about z.", unit="kg m2", symbol="I_zz", ge=0.0, le=1e9, default=0.0)
    xy: float = quantity("Entry xy of the tensor.", unit="kg m2", symbol="I_xy", ge=-1e9, le=1e9, default=0.0)
    xz: float = quantity("Entry xz of the tensor.", unit="kg m2", symbol="I_xz", ge=-1e9, le=1e9, default=0.0)
    yz: float = quantity("Entry yz of the tensor.", unit="kg m2", symbol="I_yz", ge=-1e9, le=1e9, default=0.0)


class _Component(Description):
    name: Name = text("Name, unique within the vehicle.")
    mass: float = quantity("Mass.", unit="kg", symbol="m", ge=0.0, le=1e6)
    position: Vector3 = vector(
        "Centre of buoyancy (of a cell: at neutral extension) and, unless stated apart, centre of mass; body axes.",
        unit="m", symbol="r_b",
    )  # fmt: skip
    center_of_mass: Vector3 | None = vector(
        "Centre of mass in body axes, where it differs from the position.", unit="m", symbol="r_g", default=None
    )
    inertia: Inertia = text("Inertia about the component's own centre of mass.", default=Inertia())
    shapes: tuple[Shape, ...] = text("Simple shapes to draw it with.", default=(), max_length=16)
    color: str | None = text("Colour in every view, as #rrggbb.", default=None, pattern=r"^#[0-9a-fA-F]{6}$")
    notes: str = text("Where the numbers come from.", default="", max_length=4000)


class _Displacing(_Component):
    bulk_modulus: float | None = quantity(
        "Stiffness against pressure: V(p) = V (1 - p / K), p the gauge pressure. None means that it keeps its volume.",
        unit="Pa", symbol="K", ge=1e5, le=1e15, default=None,
    )  # fmt: skip
    height: float | None = quantity(
        "Vertical extent over which its buoyancy fades at the surface; that of a sphere of its volume if not given.",
        unit="m", symbol="h", gt=0.0, le=100.0, default=None,
    )  # fmt: skip


class Rigid(_Displacing):
    """A part that does not change: fuselage, wing, payload, ballast."""

    kind: Literal["rigid"] = text("Which component this is: a rigid part.")
    volume: float = quantity("Displaced volume.", unit="m3", symbol="V", ge=0.0, le=1e4, default=0.0)


class _Actuated(_Component):
    axis: Vector3 = vector("Direction of extension, in body axes.", unit="1", symbol="a", default=(1.0, 0.0, 0.0))
    rate_limit: float | None = quantity(
        "Fastest change of the extension; none means that it follows at once.",
        unit="m/s", symbol="e_rate", gt=0.0, le=1e3, default=None,
    )  # fmt: skip
    lag: float = quantity(
        "Time constant with which the extension follows its command.",
        unit="s", symbol="T", ge=0.0, le=1e5, default=0.0,
    )  # fmt: skip
    efficiency: float = quantity(
        "Share of the energy taken from the battery that becomes work of the actuator.",
        unit="1", symbol="eta", ge=1e-3, le=1.0, default=1.0,
    )  # fmt: skip
    recovery: float = quantity(
        "Share of the work that the water or weight does on the actuator which returns to the battery.",
        unit="1", symbol="eta_r", ge=0.0, le=1.0, default=0.0,
    )  # fmt: skip

    @model_validator(mode="after")
    def _axis_has_direction(self) -> Self:
        require_direction(self.axis)
        if 0.0 < self.lag < SMALLEST_LAG:
            raise ValueError(f"lag {self.lag:g} s is below {SMALLEST_LAG:g} s: give 0 for none")
        return self

    @property
    def stroke(self) -> tuple[float, float]:
        """Smallest and largest extension (the stops), m."""
        raise NotImplementedError

    @property
    def neutral(self) -> float:
        """Extension at which the component sits at its stated position, m."""
        raise NotImplementedError


def _require_stops(what: str, stops: tuple[float, float], neutral: float, unit: str) -> None:
    """Raise `ValueError` where stops leave no stroke, or the neutral place lies outside them."""
    low, high = stops
    if not high - low >= SMALLEST_STROKE:
        raise ValueError(
            f"{what}_range [{low}, {high}] {unit} is empty: the first stop must lie below the second, "
            f"by {SMALLEST_STROKE:g} {unit} at least"
        )
    if not low <= neutral <= high:
        raise ValueError(f"neutral_{what} {neutral} {unit} lies outside the stops [{low}, {high}] {unit}")


class _Stroked(_Actuated):
    extension_range: tuple[Extension, Extension] = vector(
        "Smallest and largest extension: the stops.", unit="m", symbol="e_min, e_max"
    )
    neutral_extension: Extension = quantity(
        "Extension at which the component is neutral and sits at its stated position.", unit="m", symbol="e_0"
    )

    @model_validator(mode="after")
    def _neutral_within_stops(self) -> Self:
        _require_stops("extension", self.extension_range, self.neutral_extension, "m")
        return self

    @property
    def stroke(self) -> tuple[float, float]:
        """The stated range of extensions, m."""
        return self.extension_range

    @property
    def neutral(self) -> float:
        """The stated neutral extension, m."""
        return self.neutral_extension


class Bellows(_Stroked, _Displacing):
    """A pleated cell: V(e) = V_fixed + m_p V_pleat + m_p V_gap + 2 m_p V_d, V_d = (pi/3) l_d (r^2 + r R + R^2).

    The frustum height is l_d = e / (2 m_p), so that the stack grows by the extension. `as_printed` keeps the paper's
    l_d = e / m_p (Canete et al., Eq. 10), which doubles the change of volume.
    """

    kind: Literal["bellows"] = text("Which component this is: a bellows cell.")
    pleats: int = quantity("Number of pleats.", unit="1", symbol="m_p", ge=1, le=1000)
    inner_radius: float = quantity("Radius in the valleys of the pleats.", unit="m", symbol="r", gt=0.0, le=50.0)
    outer_radius: float = quantity("Radius at the crests of the pleats.", unit="m", symbol="R", gt=0.0, le=50.0)
    fixed_volume: float = quantity("Volume of the rigid ends.", unit="m3", symbol="V_fixed", ge=0.0, le=1e4)
    pleat_volume: float = quantity(
        "Volume of one pleat's rigid rim.", unit="m3", symbol="V_pleat", ge=0.0, le=1e2, default=0.0
    )
    gap_volume: float = quantity(
        "Volume of one gap between pleats.", unit="m3", symbol="V_gap", ge=0.0, le=1e2, default=0.0
    )
    as_printed: Switch = text("Use the frustum height as the paper prints it (Eq. 10).", default=False)

    @model_validator(mode="after")
    def _radii_and_stroke(self) -> Self:
        if self.inner_radius > self.outer_radius:
            raise ValueError(
                f"inner_radius {self.inner_radius} m exceeds outer_radius {self.outer_radius} m: exchange them"
            )
        if self.extension_range[0] < 0.0:
            raise ValueError(f"extension_range starts at {self.extension_range[0]} m: a bellows cannot extend below 0")
        return self

    @property
    def core_volume(self) -> float:
        """Volume that does not change with the extension, m3."""
        return self.fixed_volume + self.pleats * (self.pleat_volume + self.gap_volume)

    @property
    def section(self) -> float:
        """dV/de: the mean section of the frustums (twice that as printed), m2."""
        r, R = self.inner_radius, self.outer_radius
        mean = math.pi / 3.0 * (r * r + r * R + R * R)
        return 2.0 * mean if self.as_printed else mean


class Piston(_Actuated, _Displacing):
    """A cell whose volume is linear in its extension: V(e) = V_0 + A e, neutral at e = 0.

    It needs only name, mass, volume, volume range and position; the stops follow from the range and the area.
    """

    kind: Literal["piston"] = text("Which component this is: a piston cell.")
    volume: Volume = quantity("Displaced volume at neutral (zero) extension.", unit="m3", symbol="V_0")
    volume_range: tuple[Volume, Volume] = vector(
        "Smallest and largest displaced volume.", unit="m3", symbol="V_min, V_max"
    )
    area: float = quantity("Area of the piston.", unit="m2", symbol="A", ge=1e-9, le=1e3, default=1e-3)

    @model_validator(mode="after")
    def _volume_within_range(self) -> Self:
        low, high = self.volume_range
        if not low < high:
            raise ValueError(f"volume_range [{low}, {high}] m3 is empty: the first must lie below the second")
        if not low <= self.volume <= high:
            raise ValueError(f"volume {self.volume} m3 lies outside volume_range [{low}, {high}] m3")
        if not (high - low) / self.area >= SMALLEST_STROKE:
            raise ValueError(
                f"volume_range [{low}, {high}] m3 over area {self.area} m2 is a stroke below {SMALLEST_STROKE:g} m: "
                "widen the range or narrow the piston"
            )
        return self

    @property
    def stroke(self) -> tuple[float, float]:
        """Smallest and largest extension that the volume range allows, m."""
        low, high = self.volume_range
        return (low - self.volume) / self.area, (high - self.volume) / self.area

    @property
    def neutral(self) -> float:
        """Zero: a piston's extension counts from neutral, m."""
        return 0.0


class Bladder(_Actuated, _Displacing):
    """A cell whose volume is a measured, monotone table over the extension of its pump (PCHIP between the points)."""

    kind: Literal["bladder"] = text("Which component this is: a bladder cell.")
    extensions: tuple[Extension, ...] = vector(
        "Extensions of the pump at which the volume is known; rising. The first and last are the stops.",
        unit="m", symbol="e_k", min_length=2, max_length=1000,
    )  # fmt: skip
    volumes: tuple[Volume, ...] = vector(
        "Displaced volumes at those extensions; rising.", unit="m3", symbol="V_k", min_length=2, max_length=1000
    )
    neutral_extension: Extension = quantity("Extension at which the cell is neutral.", unit="m", symbol="e_0")

    @model_validator(mode="after")
    def _table_rises(self) -> Self:
        if len(self.extensions) != len(self.volumes):
            raise ValueError(f"extensions has {len(self.extensions)} entries, volumes has {len(self.volumes)}")
        for label, column in (("extensions", self.extensions), ("volumes", self.volumes)):
            for k, (a, b) in enumerate(pairwise(column)):
                if not a < b:
                    raise ValueError(f"{label} must rise: entry {k + 1} is {b}, not above entry {k}, {a}")
                if label == "extensions" and b - a < SMALLEST_STROKE:
                    raise ValueError(f"extensions must rise by {SMALLEST_STROKE:g} m at least: entry {k + 1} is {b}")
        low, high = self.stroke
        if not low <= self.neutral_extension <= high:
            raise ValueError(f"neutral_extension {self.neutral_extension} m lies outside the table [{low}, {high}] m")
        return self

    @property
    def stroke(self) -> tuple[float, float]:
        """First and last extension of the table, m."""
        return self.extensions[0], self.extensions[-1]

    @property
    def neutral(self) -> float:
        """The stated neutral extension, m."""
        return self.neutral_extension


class MovableMass(_Stroked):
    """A mass inside the hull that slides along an axis; its position is that at neutral extension."""

    kind: Literal["movable_mass"] = text("Which component this is: a mass that slides.")


class RollingMass(_Actuated):
    """A mass inside the hull that turns about an axis through a pivot; its position is that at the neutral angle.

    Its extension is the angle about the axis (right-handed), and its inertia turns with it.
    """

    kind: Literal["rolling_mass"] = text("Which component this is: a mass that rolls about an axis.")
    pivot: Vector3 = vector(
        "A point on the axis about which it turns, body axes.", unit="m", symbol="r_p", default=(0.0, 0.0, 0.0)
    )
    angle_range: tuple[Angle, Angle] = vector(
        "Smallest and largest angle: the stops.", unit="rad", symbol="e_min, e_max"
    )
    neutral_angle: Angle = quantity(
        "Angle at which it sits at its stated position.", unit="rad", symbol="e_0", default=0.0
    )
    rate_limit: float | None = quantity(
        "Fastest change of the angle; none means that it follows at once.",
        unit="rad/s", symbol="e_rate", gt=0.0, le=1e3, default=None,
    )  # fmt: skip

    @model_validator(mode="after")
    def _neutral_within_stops(self) -> Self:
        _require_stops("angle", self.angle_range, self.neutral_angle, "rad")
        return self

    @property
    def stroke(self) -> tuple[float, float]:
        """The stated range of angles, rad."""
        return self.angle_range

    @property
    def neutral(self) -> float:
        """The stated neutral angle, rad."""
        return self.neutral_angle


Cell = Bellows | Piston | Bladder
Mover = MovableMass | RollingMass
Actuated = Cell | Mover
Component = Annotated[Rigid | Bellows | Piston | Bladder | MovableMass | RollingMass, Field(discriminator="kind")]


def extension_unit(component: Actuated) -> str:
    """Return the unit of a component's extension: m, or rad where it rolls."""
    return "rad" if isinstance(component, RollingMass) else "m"
