"""Owns the wire types of the analyses of steady motion: trim, polar, allocation. SI units and radians."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from server.schemas import DesignDocument, Wire

Extensions = dict[str, float]
Row = list[float]
Matrix = list[Row]
AT_EXTENSIONS = "Extension by component name, m (rad of a part that rolls); those not named are at their initial one."
AT_DEPTH = "Depth at which the water is taken, m; by default that at which the mission starts, all parts immersed."


class TrimTargets(Wire):
    """What a motion should be; without a target of a turn it is straight."""

    glide_angle: float | None = Field(
        default=None, description="Angle of the path to the horizon, rad; climb positive."
    )
    speed: float | None = Field(default=None, description="Speed through the water, m/s.")
    sink_rate: float | None = Field(default=None, description="Vertical speed, m/s; down positive.")
    turn_rate: float | None = Field(default=None, description="Turn rate, rad/s; to the right positive.")
    turn_radius: float | None = Field(default=None, description="Radius of the turn, m; to the right positive.")
    pitch: float | None = Field(default=None, description="Pitch, rad; nose up positive.")
    roll: float | None = Field(default=None, description="Roll, rad; starboard down positive.")

    def given(self) -> dict[str, float]:
        """Return the targets that are given, by name."""
        return self.model_dump(exclude_none=True)


class SearchOptions(Wire):
    """How finely steady motions are searched for."""

    angle_step: float | None = Field(default=None, description="Step in angle of attack, rad; 2 deg if not given.")
    banks: Annotated[list[float], Field(max_length=100)] | None = Field(
        default=None, description="Banks from which turns are sought, to either side, rad; a few if not given."
    )


class TrimOptions(Wire):
    """Which steady motion is sought: all at given extensions, or one that meets targets by moving free cells."""

    extensions: Extensions = Field(default={}, description=AT_EXTENSIONS)
    depth: float | None = Field(default=None, description=AT_DEPTH)
    targets: TrimTargets = Field(default=TrimTargets(), description="What the motion should be; none searches for all.")
    free: list[str] | None = Field(
        default=None, description="Cells that may move to meet the targets; all that move if null or empty."
    )
    search: SearchOptions = Field(default=SearchOptions(), description="How finely all motions are searched for.")


class TrimAnalysisRequest(Wire):
    """A design to trim; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: TrimOptions = TrimOptions()


class TrimItem(Wire):
    """One steady motion: all that changes in it is position and heading."""

    kind: Literal["glide", "spiral"] = Field(description="Straight, or turning.")
    stable: bool = Field(description="Whether every small disturbance dies out, extensions and depth held.")
    growth: float = Field(description="Largest real part of the eigenvalues, 1/s.")
    extensions: Extensions = Field(description="Extension by component name, m or rad.")
    depth: float = Field(description="Depth at which the water is taken, m.")
    roll: float = Field(description="Roll, rad.")
    pitch: float = Field(description="Pitch, rad.")
    velocity: Annotated[Row, Field(min_length=3, max_length=3)] = Field(
        description="Velocity u, v, w of the body origin through the water, body axes, m/s."
    )
    turn_rate: float = Field(description="Turn rate about the vertical, to the right, rad/s.")
    turn_radius: float | None = Field(description="Radius of the path, to the right positive, m; null where straight.")
    speed: float = Field(description="Speed, m/s.")
    sink_rate: float = Field(description="Vertical speed, down positive, m/s.")
    glide_angle: float = Field(description="Angle of the path to the horizon, climb positive, rad.")
    glide_ratio: float | None = Field(description="Horizontal way per change of depth; null on a level path.")
    angle_of_attack: float = Field(description="Angle of attack, rad.")
    sideslip: float = Field(description="Sideslip, rad.")
    net_buoyancy: float = Field(description="Buoyancy minus weight, N.")
    residual: dict[str, float] = Field(description="What is left out of balance: X, Y, Z (N), K, M, N (N m).")


class RestItem(Wire):
    """How the glider hangs at rest where weight is buoyancy."""

    roll: float = Field(description="Roll, rad.")
    pitch: float = Field(description="Pitch, rad.")
    stiffness: float = Field(description="Righting moment, times the sine of the tilt, N m.")


class MissedItem(Wire):
    """A target that is not met."""

    target: str = Field(description="Name of the target.")
    wanted: float = Field(description="What was wanted.")
    reached: float = Field(description="What the nearest motion reaches.")


class BoundItem(Wire):
    """A free cell at a stop."""

    cell: str = Field(description="Name of the cell.")
    stop: Literal["lower", "upper"] = Field(description="Which stop.")
    extension: float = Field(description="Where that is, m or rad.")


class FailureItem(Wire):
    """Why no motion meets the targets, and what comes nearest."""

    message: str = Field(description="All of this in words.")
    residual: dict[str, float] = Field(description="Out of balance were the targets held: X, Y, Z (N), K, M, N (N m).")
    missed: list[MissedItem] = Field(description="What the nearest motion misses.")
    active: list[BoundItem] = Field(description="Free cells that are at a stop in it.")
    nearest: TrimItem | None = Field(description="The nearest steady motion within the stops; null if none was found.")


class TrimAnswer(Wire):
    """The steady motions found: stable ones first."""

    trims: list[TrimItem] = Field(description="All that the search found, or the one that meets the targets.")
    searched: str | None = Field(description="What was searched, in words; null where targets were given.")
    rest: RestItem | None = Field(description="Where weight is buoyancy nothing glides: how it hangs instead.")
    failure: FailureItem | None = Field(description="Why targets cannot be met; null where they are.")


class PolarOptions(Wire):
    """How a glide polar is made."""

    extensions: Extensions = Field(default={}, description=AT_EXTENSIONS)
    points: int = Field(default=50, ge=2, le=400, description="Points of each curve.")
    cells: list[str] | None = Field(default=None, description="Cells that move; all that move if not given.")
    depth: float | None = Field(default=None, description=AT_DEPTH)
    cycle_depth: float | None = Field(
        default=None, description="Depth of the dive cycle over which pumping is reckoned, m."
    )


class PolarRequest(Wire):
    """A design whose glide polar is wanted; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: PolarOptions = PolarOptions()


class PolarCurve(Wire):
    """Steady glides at one heave: the pitching moment of the cells is swept."""

    heave: float = Field(description="Change of net buoyancy that the cells make, N, up.")
    trims: list[TrimItem] = Field(description="The glides, by angle of attack.")
    moments: Row = Field(description="Pitching moment of the cells from neutral at each, N m, nose up.")
    left_out: dict[str, int] = Field(description="How many points of the sweep have no glide, by reason.")


class EnergyItem(Wire):
    """A glide and what a kilometre of way takes from the battery in it."""

    trim: TrimItem = Field(description="The glide.")
    hotel: float = Field(description="Of the hotel load, J/km.")
    pump: float = Field(description="Of pumping, J/km.")
    per_km: float = Field(description="Both, J/km.")


class PolarAnswer(Wire):
    """Speed against glide angle over the cells' strokes."""

    cells: list[str] = Field(description="The cells that move.")
    cycle_depth: float = Field(description="Depth of the dive cycle over which pumping is reckoned, m.")
    energy: str = Field(description="What the energy is reckoned from, in words.")
    curves: list[PolarCurve] = Field(description="One for each heave, dives first.")
    best_range: TrimItem | None = Field(description="The flattest path.")
    best_energy: EnergyItem | None = Field(description="The least energy for the way; null where none goes anywhere.")
    slowest_sink: TrimItem | None = Field(description="The slowest change of depth.")
    tightest_turn: TrimItem | None = Field(description="The smallest radius; null where nothing turns the glider.")


class Wish(Wire):
    """What is wanted of the cells, from neutral."""

    heave: float = Field(default=0.0, description="Net buoyancy, N, up.")
    pitch: float = Field(default=0.0, description="Pitch moment, N m, nose up.")
    roll: float = Field(default=0.0, description="Roll moment, N m, starboard down.")


class AxisWeights(Wire):
    """How much each axis counts where not all can be had."""

    heave: float = Field(default=1.0, gt=0.0, le=1e6, description="Of heave.")
    pitch: float = Field(default=1.0, gt=0.0, le=1e6, description="Of the pitch moment.")
    roll: float = Field(default=1.0, gt=0.0, le=1e6, description="Of the roll moment.")


class AllocationOptions(Wire):
    """Which cells, at which depth, and what is wanted of them."""

    cells: list[str] | None = Field(default=None, description="Cells; all that move if not given.")
    depth: float = Field(default=0.0, ge=0.0, le=12e3, description="Depth whose density counts, m.")
    wanted: Wish | None = Field(default=None, description="What the cells should make; none asks only what they can.")
    weights: AxisWeights = Field(default=AxisWeights(), description="How much each axis counts.")
    effort: dict[str, Annotated[float, Field(gt=0.0, le=1e6)]] = Field(
        default={}, description="How unwillingly a cell leaves neutral, by name; 1 where not named."
    )


class AllocationRequest(Wire):
    """A design whose cells are looked at; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: AllocationOptions = AllocationOptions()


class AllocationItem(Wire):
    """Extensions for what is wanted."""

    extensions: Extensions = Field(description="Extension by component name, m or rad.")
    reached: Wish = Field(description="What they make.")
    missing: Wish = Field(description="What is wanted and not made.")
    at_stop: list[str] = Field(description="Cells at a stop.")
    short: list[str] = Field(description="Axes that fall short.")
    message: str = Field(description="This in words.")


class AllocationAnswer(Wire):
    """What the cells do to heave, pitch and roll, alone and together."""

    cells: list[str] = Field(description="The cells, in the order of the columns.")
    units: list[str] = Field(description="Unit of each extension.")
    matrix: Matrix = Field(description="3 by cells: N, N m and N m by m (or rad) of extension from neutral.")
    rank: int = Field(description="How many axes the cells act on apart.")
    singular_values: Row = Field(description="Of the matrix scaled by strokes and by the authority of each axis.")
    directions: Matrix = Field(description="The combinations of axes that they belong to, by column.")
    alone: dict[str, Row] = Field(description="Least and most of each axis while the others are zero, N, N m, N m.")
    holds: list[str] = Field(description="Axes that can be held apart from the others.")
    words: str = Field(description="This in words.")
    allocation: AllocationItem | None = Field(description="The extensions for what is wanted; null if nothing is.")


ANALYSIS_REQUESTS: tuple[type[BaseModel], ...] = (
    TrimAnalysisRequest, PolarRequest, AllocationRequest,
)  # fmt: skip
"""Types that OpenAPI must hold though no route declares them to FastAPI."""
