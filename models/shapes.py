"""Owns the simple shapes that components carry for drawing; they never enter the physics. Body axes, metres."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from models.fields import Description, Vector3, quantity, require_direction, text, vector


class _Placed(Description):
    offset: Vector3 = vector(
        "Centre of the shape relative to the component's position, in body axes.",
        unit="m", symbol="r_s", default=(0.0, 0.0, 0.0),
    )  # fmt: skip


class HullShape(_Placed):
    """A hull of revolution about the body x axis: elliptic nose, cylinder, elliptic tail."""

    kind: Literal["hull"] = text("Which shape this is: a hull of revolution.")
    length: float = quantity("Length over all.", unit="m", symbol="L", gt=0.0, le=100.0)
    radius: float = quantity("Radius of the cylindrical part.", unit="m", symbol="r", gt=0.0, le=50.0)
    nose_length: float = quantity("Length of the elliptic nose.", unit="m", symbol="L_n", ge=0.0, le=100.0)
    tail_length: float = quantity("Length of the elliptic tail.", unit="m", symbol="L_t", ge=0.0, le=100.0)


class CylinderShape(_Placed):
    """A circular cylinder along an axis."""

    kind: Literal["cylinder"] = text("Which shape this is: a circular cylinder.")
    length: float = quantity("Length along the axis.", unit="m", symbol="L", gt=0.0, le=100.0)
    radius: float = quantity("Radius.", unit="m", symbol="r", gt=0.0, le=50.0)
    axis: Vector3 = vector("Direction of the axis in body axes.", unit="1", symbol="a", default=(1.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _axis_has_direction(self) -> Self:
        require_direction(self.axis)
        return self


class _Flat(_Placed):
    chord: float = quantity("Chord at the root.", unit="m", symbol="c", gt=0.0, le=50.0)
    tip_chord: float | None = quantity(
        "Chord at the tip; the root's if not given.", unit="m", symbol="c_t", gt=0.0, le=50.0, default=None
    )
    sweep: float = quantity(
        "How far the tip's leading edge lies behind the root's.", unit="m", symbol="s", ge=-50.0, le=50.0, default=0.0
    )
    thickness: float = quantity("Thickness.", unit="m", symbol="t", gt=0.0, le=10.0, default=0.004)


class WingShape(_Flat):
    """A flat wing, port and starboard, with straight edges."""

    kind: Literal["wing"] = text("Which shape this is: a wing.")
    span: float = quantity("Span from tip to tip.", unit="m", symbol="b", gt=0.0, le=100.0)


class FinShape(_Flat):
    """One flat panel with straight edges, outward from its root; `offset` is the middle of the root chord."""

    kind: Literal["fin"] = text("Which shape this is: a fin.")
    span: float = quantity("Span from root to tip.", unit="m", symbol="b", gt=0.0, le=100.0)
    direction: Vector3 = vector(
        "Direction from root to tip, across the body x axis.", unit="1", symbol="d", default=(0.0, 0.0, -1.0)
    )

    @model_validator(mode="after")
    def _points_across(self) -> Self:
        if math.hypot(*self.direction[1:]) < 1e-9:
            raise ValueError("direction of a fin must lead away from the body x axis: give a vector such as [0, 0, -1]")
        return self


class BellowsShape(_Placed):
    """A pleated body along the cell's axis, drawn at its neutral length and stretched as the cell extends."""

    kind: Literal["bellows"] = text("Which shape this is: a pleated body.")
    length: float = quantity("Length at neutral extension.", unit="m", symbol="L", gt=0.0, le=100.0)
    inner_radius: float = quantity("Radius in the valleys of the pleats.", unit="m", symbol="r", gt=0.0, le=50.0)
    outer_radius: float = quantity("Radius at the crests of the pleats.", unit="m", symbol="R", gt=0.0, le=50.0)
    pleats: int = quantity("Number of pleats drawn.", unit="1", symbol="m_p", ge=1, le=200)


Shape = Annotated[HullShape | CylinderShape | WingShape | FinShape | BellowsShape, Field(discriminator="kind")]
