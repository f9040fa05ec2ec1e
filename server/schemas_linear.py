"""Owns the wire types of the analyses of small motions: linear models, modes, stability. SI units and radians."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from server.schemas import DesignDocument, ErrorItem, Wire
from server.schemas_analyses import Extensions, Matrix, Row, TrimItem, TrimOptions

Series = list[float | None]
MOST_POINTS = 10_000


class LocusOptions(Wire):
    """A parameter over which eigenvalues are followed."""

    pointer: str = Field(
        max_length=500, description="JSON Pointer to a number of the design, or /extensions/ and a component's name."
    )
    values: Annotated[list[float], Field(min_length=1, max_length=500)] = Field(description="Values in order.")


class ResponseOptions(Wire):
    """One frequency response."""

    input: str = Field(description="Name of an input, such as 'command of ' and a component's name.")
    output: str = Field(description="Name of an output.")


class LinearizeOptions(TrimOptions):
    """Where to linearise: at the first trim that the other options find, or at an instant of the mission."""

    time: float | None = Field(
        default=None, ge=0.0, description="Linearise at this instant of the mission's run, s; a trim if not given."
    )
    responses: list[ResponseOptions] = Field(default=[], max_length=100, description="Frequency responses wanted.")
    frequencies: Annotated[list[float], Field(min_length=1, max_length=MOST_POINTS)] | None = Field(
        default=None, description="Frequencies, rad/s; chosen from the modes if not given."
    )
    locus: LocusOptions | None = Field(
        default=None,
        description="Eigenvalues over a parameter, trimmed anew at each value: for the targets, or at the extensions.",
    )


class LinearizeRequest(Wire):
    """A design to linearise; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: LinearizeOptions = LinearizeOptions()


class SignalItem(Wire):
    """A state, input or output."""

    name: str = Field(description="Name.")
    unit: str = Field(description="Unit.")
    meaning: str = Field(description="What it is.")
    value: float = Field(description="Value at the operating point.")


class PointItem(Wire):
    """An operating point."""

    depth: float = Field(description="Depth, m.")
    roll: float = Field(description="Roll, rad.")
    pitch: float = Field(description="Pitch, rad.")
    yaw: float = Field(description="Heading, rad.")
    velocity: Row = Field(description="u, v, w through the water, m/s.")
    angular_velocity: Row = Field(description="p, q, r, rad/s.")
    extensions: Extensions = Field(description="Extension by component name, m or rad.")
    commands: Extensions = Field(description="Commands where they differ.")
    time: float = Field(description="Time, s.")


class ModelItem(Wire):
    """x' = drift + A x + B c, y = C x + D c, of departures from the operating point."""

    model: Literal["planar", "spatial"] = Field(description="Which equations.")
    point: PointItem = Field(description="The operating point.")
    states: list[SignalItem] = Field(description="States.")
    inputs: list[SignalItem] = Field(description="Inputs: commanded extensions.")
    outputs: list[SignalItem] = Field(description="Outputs.")
    A: Matrix = Field(description="States by states.")
    B: Matrix = Field(description="States by inputs.")
    C: Matrix = Field(description="Outputs by states.")
    D: Matrix = Field(description="Outputs by inputs.")
    drift: Row = Field(description="Rate of each state at the point itself.")
    is_equilibrium: bool = Field(description="Whether nothing but depth and heading changes there.")
    residual: float = Field(description="Largest rate but those of depth and heading, SI units a second.")
    notes: list[str] = Field(description="What the model leaves out, in words.")


class ComplexRow(Wire):
    """Complex numbers."""

    real: Row = Field(description="Real parts.")
    imag: Row = Field(description="Imaginary parts.")


class ModeItem(Wire):
    """One mode; a conjugate pair counts once."""

    name: str = Field(description="Name, from the states that take part.")
    real: float = Field(description="Growth, 1/s.")
    imag: float = Field(description="Angular frequency, rad/s.")
    period: float | None = Field(description="Period, s; null where it does not oscillate.")
    damping_ratio: float | None = Field(description="Damping as a share of the critical one.")
    time_constant: float | None = Field(description="Time to fall to 1/e or to grow to e, s.")
    time_to_half: float | None = Field(description="Time to half, s; null where it does not decay.")
    time_to_double: float | None = Field(description="Time to double, s; null where it does not grow.")
    shares: Row = Field(description="Participation of each state; adds up to 1.")
    eigenvector: ComplexRow = Field(description="Right eigenvector, its largest entry 1.")


class ModesItem(Wire):
    """All modes."""

    states: list[str] = Field(description="Names of the states, in the order of shares and eigenvectors.")
    modes: list[ModeItem] = Field(description="Modes, those that grow or decay slowest first.")
    leading: str | None = Field(description="The mode that grows fastest or decays slowest, depth and heading aside.")
    growth: float | None = Field(description="Its growth, 1/s.")
    stable: bool = Field(description="Whether all but depth and heading decay.")


class ModeControlItem(Wire):
    """How the inputs move one mode."""

    name: str = Field(description="Name of the mode.")
    real: float = Field(description="Growth, 1/s.")
    imag: float = Field(description="Angular frequency, rad/s.")
    distance: float = Field(description="Smallest singular value of the scaled [l I - A, B], 1/s.")
    cosines: Row = Field(description="How well each input alone moves it, 0 to 1.")
    movable: bool = Field(description="Whether any input moves it.")


class ControllabilityItem(Wire):
    """What the inputs can move."""

    inputs: list[str] = Field(description="Names of the inputs.")
    states: int = Field(description="Number of states.")
    rank: int = Field(description="How many of them the inputs reach.")
    modes: list[ModeControlItem] = Field(description="Mode by mode.")
    unmoved: list[str] = Field(description="Modes that no input moves.")
    words: str = Field(description="This in words.")


class ResponseItem(Wire):
    """A frequency response."""

    input: str = Field(description="Name of the input.")
    output: str = Field(description="Name of the output.")
    unit: str = Field(description="Unit of the magnitude.")
    dc_gain: float | None = Field(description="Gain at rest; null where the output runs away.")
    frequencies: Row = Field(description="Angular frequencies, rad/s.")
    magnitude: Row = Field(description="Magnitude.")
    magnitude_db: Series = Field(description="Magnitude, dB.")
    phase: Row = Field(description="Phase without jumps, rad.")


class CrossingItem(Wire):
    """Where a branch changes its stability."""

    branch: int = Field(description="Index of the branch.")
    name: str = Field(description="Name of its mode.")
    value: float = Field(description="Value of the parameter, by interpolation.")
    frequency: float = Field(description="Angular frequency there, rad/s.")
    becomes_stable: bool = Field(description="Stable beyond it, or before it.")


class LocusFailure(Wire):
    """A value without a steady motion."""

    value: float = Field(description="Value of the parameter.")
    message: str = Field(description="Why.")


class LocusItem(Wire):
    """Eigenvalues over a parameter."""

    pointer: str = Field(description="The parameter.")
    values: Row = Field(description="Its values.")
    eigenvalues: list[list[Row] | None] = Field(
        description="By value and branch [real, imaginary], 1/s; null without a motion."
    )
    names: list[str] = Field(description="Names of the modes where the branches begin.")
    points: list[PointItem | None] = Field(description="Steady motion at each value.")
    failures: list[LocusFailure] = Field(description="Values without one.")
    crossings: list[CrossingItem] = Field(description="Where stability changes.")


class LinearizeAnswer(Wire):
    """The linear model, its modes, and what was asked of it."""

    trim: TrimItem | None = Field(description="The trim about which it is; null at an instant of the mission.")
    model: ModelItem = Field(description="The matrices.")
    modes: ModesItem = Field(description="Its modes.")
    controllability: ControllabilityItem = Field(description="Which modes the cells can move.")
    responses: list[ResponseItem] = Field(description="The frequency responses asked for.")
    locus: LocusItem | None = Field(description="The root locus, if asked for.")


class StabilityOptions(Wire):
    """How finely stability is followed."""

    samples: int = Field(default=200, ge=2, le=2000, description="Instants at which small motions are looked at.")
    max_points: int = Field(default=1000, ge=2, le=100_000, description="Most samples of the margins in the answer.")


class StabilityRequest(Wire):
    """A design whose mission's stability is wanted; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: StabilityOptions = StabilityOptions()


class ExtremeItem(Wire):
    """The worst value of a margin over the run."""

    name: str = Field(description="Which margin.")
    unit: str = Field(description="Its unit.")
    value: float = Field(description="Its worst value.")
    time: float = Field(description="When, s.")


class StabilityAnswer(Wire):
    """Margins and growth of small motions along the mission."""

    status: str = Field(description="How the run ended.")
    message: str = Field(description="This in words: where it was cut off, the margins end there too.")
    times: Row = Field(description="Times of the margins, s.")
    offset: Matrix = Field(description="From the centre of buoyancy to that of mass, body axes, m.")
    hydrostatic_margin: Series = Field(description="Centre of buoyancy above that of mass, along gravity, m.")
    pitch_stiffness: Series = Field(description="Hydrostatic stiffness in pitch over the weight, m.")
    roll_stiffness: Series = Field(description="Hydrostatic stiffness in roll over the weight, m.")
    pitch_margin: Series = Field(description="(x of CoM - x of neutral point) / length, in pitch.")
    yaw_margin: Series = Field(description="The same in yaw.")
    growth_times: Row = Field(description="Times of the growth, s.")
    growth: Series = Field(description="Largest growth of small motions, frozen in time, 1/s.")
    length: float = Field(description="Length of the vehicle, m.")
    extremes: list[ExtremeItem] = Field(description="The worst value of each, and when.")
    warnings: list[ErrorItem] = Field(description="What stability is lost, when and for how long.")


LINEAR_REQUESTS: tuple[type[BaseModel], ...] = (LinearizeRequest, StabilityRequest)
"""Types that OpenAPI must hold though no route declares them to FastAPI."""
