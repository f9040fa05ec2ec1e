"""Owns the wire types of the design of controllers. SI units and radians."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from models.controller_options import ControllerOptions
from models.controllers import Cascade, StateFeedback
from models.fields import text
from server.schemas import DesignDocument, Wire
from server.schemas_analyses import Matrix, Row
from server.schemas_linear import ModesItem, PointItem


class ControllerDesignOptions(ControllerOptions):
    """Which controller, and how it is designed."""

    kind: Literal["state_feedback", "cascade"] = text(
        "State feedback by the other options; or first gains of guidance, loops and allocation about the trim, for "
        "which only trim, sample_time and delay may be given.",
        default="state_feedback",
    )

    @property
    def unused(self) -> tuple[str, ...]:
        """Names of the options that are given, other than by their default, and have no use for this kind."""
        if self.kind != "cascade":
            return ()
        used = ("kind", "trim", "sample_time", "delay")
        fields = type(self).model_fields
        return tuple(name for name in fields if name not in used and getattr(self, name) != fields[name].default)


class ControllerDesignRequest(Wire):
    """A design that wants a controller; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: ControllerDesignOptions = ControllerDesignOptions()


class CellMarginsItem(Wire):
    """Margins of the loop broken at one cell, the others closed."""

    cell: str = Field(description="Name of the cell.")
    gain_low: float = Field(description="Smallest factor on its gains.")
    gain_high: float | None = Field(description="Largest factor; null where any will do.")
    phase: float | None = Field(description="Phase that it may lag, rad.")
    frequency: float | None = Field(description="Frequency of that, rad/s.")
    delay: float | None = Field(description="Delay that it may have besides, s.")
    disk: float = Field(description="Disk margin.")
    words: str = Field(description="This in words.")


class MarginsItem(Wire):
    """Margins of the sampled loop with its delay."""

    cells: list[CellMarginsItem] = Field(description="Cell by cell.")
    gain_low: float = Field(description="Smallest factor on all gains.")
    gain_high: float | None = Field(description="Largest factor; null where any will do.")
    delay: float | None = Field(description="Delay of all commands besides, s; null where many samples do no harm.")
    disk: float = Field(description="Disk margin against all cells at once, a lower bound.")
    disk_gain: list[float | None] = Field(description="Factors on every gain at once, by the disk margin.")
    disk_phase: float = Field(description="Lag of every cell at once, rad, by the disk margin.")
    return_difference: float = Field(description="Smallest singular value of I + L.")
    worst_frequency: float = Field(description="Where that is, rad/s.")
    words: str = Field(description="This in words.")


class FiguresItem(Wire):
    """Figures of a step response."""

    rise_time: float | None = Field(description="From 10 to 90 %, s.")
    overshoot: float = Field(description="As a share of the step.")
    settling_time: float | None = Field(description="Until it stays within 2 %, s.")
    error: float = Field(description="Left at the end, as a share of the step.")
    command: dict[str, float] = Field(description="Largest departure of each command, m or rad.")
    rate: dict[str, float] = Field(description="Largest rate of each extension asked for, m/s or rad/s.")
    words: str = Field(description="This in words.")


class StepItem(Wire):
    """The response to a step or a departure: by the linear model, and flown on the non-linear one."""

    state: str = Field(description="The stepped state.")
    start: float = Field(description="From, rad or m/s.")
    goal: float = Field(description="To, rad or m/s.")
    times: Row = Field(description="Samples of the controller, s.")
    linear: Row = Field(description="The state by the linear model.")
    flown: Row | None = Field(description="The state in flight; shorter where the flight ended.")
    cells: list[str] = Field(description="Cells, in the order of the commands' columns.")
    commands: Matrix = Field(description="Commands by the linear model, samples by cells.")
    predicted: FiguresItem = Field(description="Figures by the linear model.")
    flight: FiguresItem | None = Field(description="Figures of the flight.")
    difference: float | None = Field(description="Largest difference of both, as a share of the step.")
    status: str | None = Field(description="How the flight ended.")
    warnings: list[str] = Field(description="What asks for more than the cells can do, or differs in flight.")


class FeedbackItem(Wire):
    """A state feedback about one trim."""

    controller: StateFeedback = Field(description="The document for mission.control.controller.")
    trim: PointItem = Field(description="The trim.")
    cells: list[str] = Field(description="Cells, in the order of the gains' rows.")
    states: list[str] = Field(description="States fed back, in the order of the gains' columns.")
    gains: Matrix = Field(description="Cells by states and integrals, m (or rad) by the state's unit.")
    stable: bool = Field(description="Whether every small departure dies out.")
    open_loop: ModesItem = Field(description="Modes without it.")
    closed_loop: ModesItem = Field(description="Modes with it, as if continuous.")
    margins: MarginsItem | None = Field(description="Margins; null where the loop is not stable.")
    response: StepItem | None = Field(description="The step asked for; null if none.")
    recovery: StepItem | None = Field(description="The way back from the departures asked for; null if none.")
    warnings: list[str] = Field(description="What speaks against it.")


class TableItem(Wire):
    """A table of gains over a target of the trim."""

    target: str = Field(description="The target.")
    values: Row = Field(description="Its values.")
    controller: StateFeedback = Field(description="The document for mission.control.controller.")
    designs: list[FeedbackItem] = Field(description="The design at each value.")
    warnings: list[str] = Field(description="What speaks against it.")


class AxisItem(Wire):
    """The second-order model of one axis: inertia times acceleration + damping times rate + stiffness times angle."""

    angle: str = Field(description="The angle: theta or phi.")
    inertia: float = Field(description="Inertia with added mass, kg m2.")
    damping: float = Field(description="Damping, N m s/rad.")
    stiffness: float = Field(description="Stiffness, N m/rad.")


class SuggestionItem(Wire):
    """First gains of guidance, loops and allocation."""

    cascade: Cascade = Field(description="The document for mission.control.controller.")
    growth: float = Field(description="Growth of the slowest mode of the sampled linear loop, 1/s.")
    damping: float = Field(description="Damping ratio of its least damped mode.")
    settling_time: float | None = Field(description="Four time constants of the slowest, s; null where it does not.")
    axes: list[AxisItem] = Field(description="The axes on which the gains were found.")
    notes: list[str] = Field(description="What was found, in words.")


class DesignedController(Wire):
    """One of the three, by what was asked."""

    feedback: FeedbackItem | None = Field(description="State feedback about one trim.")
    table: TableItem | None = Field(description="A table of gains, where one was asked for.")
    cascade: SuggestionItem | None = Field(description="Guidance and loops, where the kind is cascade.")


CONTROL_REQUESTS: tuple[type[BaseModel], ...] = (ControllerDesignRequest,)
"""Types that OpenAPI must hold though no route declares them to FastAPI."""
