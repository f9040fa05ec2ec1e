"""Owns the wire types: what requests and answers look like beside the design document itself."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema

from models.design import Design
from models.variables import ALL_CELL_VARIABLES, ALL_VARIABLES
from server.editing import MAX_OPERATIONS

DESIGN_REF = {"$ref": "#/components/schemas/Design"}
# a reference beside a description must be wrapped
DesignDocument = Annotated[Any, WithJsonSchema({"allOf": [DESIGN_REF]})]
"""A design document that is read by `documents.read_request`, with its own messages."""
MOST_POINTS = 100_000
COLUMN_NAMES = (*ALL_VARIABLES, *ALL_CELL_VARIABLES)
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


class Wire(BaseModel):
    """Base of all wire types."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class ErrorItem(Wire):
    """One thing that is wrong."""

    pointer: str = Field(description="JSON Pointer to it in the request's body; empty for the whole.")
    message: str = Field(description="What is wrong, with the value.")
    limit: float | int | str | None = Field(description="The bound that was broken, if there is one.")
    hint: str | None = Field(description="The way out, if one is known.")


class ProblemDocument(Wire):
    """Every error, in the shape of RFC 9457."""

    type: str = Field(description="Always about:blank: the status says the kind.")
    title: str = Field(description="What went wrong, in a few words.")
    status: int = Field(description="The HTTP status.")
    detail: str | None = Field(default=None, description="What went wrong, in a sentence.")
    errors: list[ErrorItem] = Field(description="What is wrong, place by place; at most 100.")


class ApiIndex(Wire):
    """Where one begins."""

    version: str = Field(description="Version of the program.")
    links: dict[str, str] = Field(description="Addresses by what is there: openapi, docs, presets, designs, jobs...")


class Health(Wire):
    """Whether the program is up, and whether it can simulate at once."""

    status: Literal["ok"] = Field(description="The server answers.")
    kernel: Literal["compiling", "ready"] = Field(description="A simulation asked for while compiling waits for it.")
    version: str = Field(description="Version of the program.")


class Ready(Wire):
    """That every part that is needed can be reached."""

    status: Literal["ready"] = Field(description="Every check passed.")
    checks: dict[str, Literal["ok"]] = Field(description="The checks, by name.")


class PresetItem(Wire):
    """One preset in the list."""

    id: str = Field(description="Identifier, for /presets/{id}.")
    name: str = Field(description="Name of the design.")
    summary: str = Field(description="The beginning of its notes.")


class PresetList(Wire):
    """All presets."""

    items: list[PresetItem] = Field(description="In the order in which they are shown.")


class NoOptions(Wire):
    """There are no options."""


class ValidateRequest(Wire):
    """A design to check; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: NoOptions = NoOptions()


class Validity(Wire):
    """A design that can be simulated."""

    valid: Literal[True] = Field(description="It can be simulated; else the answer is 422.")
    identity: str = Field(description="SHA-256 of the canonical JSON: equal for equal designs.")
    warnings: list[ErrorItem] = Field(description="What does not stop a run, yet may surprise.")


class PatchOperation(BaseModel):
    """One operation of a JSON Patch (RFC 6902)."""

    model_config = ConfigDict(frozen=True, populate_by_name=True)

    op: Literal["add", "remove", "replace", "move", "copy", "test"] = Field(description="What to do.")
    path: str = Field(description="JSON Pointer into the design.")
    value: Any = Field(default=None, description="For add, replace and test.")
    from_: str | None = Field(default=None, alias="from", description="For move and copy.")


PATCH_SCHEMA = {
    "type": "array", "maxItems": MAX_OPERATIONS, "items": {"$ref": "#/components/schemas/PatchOperation"},
}  # fmt: skip
Patch = Annotated[Any, WithJsonSchema(PATCH_SCHEMA)]
"""A JSON Patch; `editing.apply_patch` reads it, with its own messages."""


class EditRequest(Wire):
    """A design and what to change in it."""

    design: DesignDocument = Field(description="The design document.")
    patch: Patch = Field(description="JSON Patch (RFC 6902) on the design.")


class SessionPatch(Wire):
    """A JSON Patch on the design of an open session; also the list itself."""

    patch: Patch = Field(description="JSON Patch (RFC 6902) on the design.")


class TrimRequest(Wire):
    """A design whose ballast is to be trimmed; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    component: str | None = Field(
        default=None, description="Rigid component whose volume may change; by default the one with the largest volume."
    )


class ComponentMass(Wire):
    """How one component weighs and floats."""

    name: str = Field(description="Name of the component.")
    kind: str = Field(description="Kind of the component.")
    mass: float = Field(description="Mass, kg.")
    center_of_mass: Vector = Field(description="Centre of mass in body axes, m.")
    volume: float = Field(description="Displaced volume at this extension, m3.")
    center_of_buoyancy: Vector = Field(description="Centre of buoyancy in body axes, m.")
    extension: float | None = Field(description="Extension, m; null where nothing moves.")


class MassProperties(Wire):
    """How the vehicle weighs and floats. Body axes: x to the nose, y to starboard, z down."""

    mass: float = Field(description="Mass, kg.")
    center_of_mass: Vector = Field(description="Centre of mass, m.")
    inertia: Annotated[list[Vector], Field(min_length=3, max_length=3)] = Field(
        description="Inertia about the centre of mass, 3x3, kg m2."
    )
    volume: float = Field(description="Displaced volume, m3.")
    center_of_buoyancy: Vector = Field(description="Centre of buoyancy, m.")
    net_buoyancy: float = Field(description="Buoyancy minus weight, N; positive rises.")
    components: list[ComponentMass] = Field(description="Each component, in the design's order.")


class Edited(Wire):
    """The design as edited, and what it weighs."""

    design: Design = Field(description="The design after the patch.")
    mass_properties: MassProperties = Field(description="At the initial extensions.")
    warnings: list[ErrorItem] = Field(description="What does not stop a run, yet may surprise.")


class Change(Wire):
    """What was changed to trim the ballast."""

    component: str = Field(description="Name of the component.")
    pointer: str = Field(description="JSON Pointer to the changed field in the design.")
    before: float = Field(description="Volume before, m3.")
    after: float = Field(description="Volume after, m3.")
    message: str = Field(description="The change in words.")


class Trimmed(Wire):
    """The design with its ballast trimmed: neutral with every cell at its neutral extension."""

    design: Design = Field(description="The design after the change.")
    change: Change = Field(description="What was changed.")
    mass_properties: MassProperties = Field(description="At the initial extensions.")


class PreviewOptions(Wire):
    """What a preview answers."""

    max_points: int | None = Field(
        default=None, ge=2, le=MOST_POINTS,
        description="Most samples in the answer; extremes are kept. JSON: 2000 if not given; files: all.",
    )  # fmt: skip
    columns: Annotated[list[str], Field(max_length=100)] | None = Field(
        default=None, description=f"Columns of a JSON answer beside t; all if not given. Of: {', '.join(COLUMN_NAMES)}."
    )


class PreviewRequest(Wire):
    """A design to simulate; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: PreviewOptions = PreviewOptions()


class EventItem(Wire):
    """Something that happened at an instant."""

    time: float = Field(description="When, s.")
    kind: str = Field(description="surface, bed or end_of_stroke.")
    cell: str | None = Field(description="The cell it happened to, if any.")
    label: str = Field(description="The event in words.")


class CellColumns(Wire):
    """What one cell did; entries match the times in columns.t."""

    name: str = Field(description="Name of the component.")
    unit: str = Field(description="Unit of command and extension: m, or rad where it rolls.")
    command: list[float | None] | None = Field(default=None, description="Commanded extension.")
    extension: list[float | None] | None = Field(default=None, description="Extension.")
    volume: list[float | None] | None = Field(default=None, description="Displaced volume, m3.")
    energy: list[float | None] | None = Field(
        default=None, description="Energy taken from the battery, J (spatial model)."
    )


class EnergyBalance(Wire):
    """How well the works explain the energies."""

    residual: float | None = Field(description="Largest energy that the balance does not explain, J.")
    exchanged: float | None = Field(description="Largest energy or work in the balance, J.")
    relative_residual: float | None = Field(description="Their ratio.")


class SpentItem(Wire):
    """What the battery gave over a stretch of a run."""

    begin: float = Field(description="From, s.")
    end: float = Field(description="To, s.")
    depth: float = Field(description="Greatest depth, m.")
    distance: float = Field(description="Horizontal way over ground, m.")
    total: float = Field(description="All energy, J.")
    hotel: float = Field(description="Hotel load, J.")
    parts: dict[str, float] = Field(description="Energy of each actuator by name, J.")
    per_km: float | None = Field(description="Energy per kilometre of horizontal way, J/km; null over less than 1 m.")


class Bill(Wire):
    """The energy bill of a run and of each of its dives."""

    whole: SpentItem = Field(description="The whole run.")
    dives: list[SpentItem] = Field(description="Each dive, from where it is shallow to where it is shallow again.")


class Preview(Wire):
    """One simulated glide. A number that is not finite is null."""

    status: str = Field(description="How the run ended: completed, surface, bed, diverged, cancelled, ...")
    message: str = Field(description="The status in words, and what to try.")
    events: list[EventItem] = Field(description="What happened, in order of time.")
    units: dict[str, str] = Field(description="Unit of each column.")
    columns: dict[str, list[float | None]] = Field(description="t and the columns, all of one length.")
    cells: list[CellColumns] = Field(description="Each component that moves.")
    final: dict[str, float | None] = Field(description="The last sample of every variable.")
    energy: EnergyBalance = Field(description="The balance of energy.")
    bill: Bill | None = Field(description="What the battery gave; null for the planar model, which keeps no account.")
    statistics: dict[str, float] = Field(description="Steps, evaluations, and seconds of computing.")
    warnings: list[ErrorItem] = Field(description="What does not stop a run, yet may surprise.")


class MassOptions(Wire):
    """At which extensions to weigh."""

    extensions: dict[str, float] = Field(
        default={}, description="Extension by component name, m; those not named are at their initial extension."
    )


class MassRequest(Wire):
    """A design to weigh; also the document itself."""

    design: DesignDocument = Field(description="The design document.")
    options: MassOptions = MassOptions()


REQUESTS: tuple[type[BaseModel], ...] = (
    ValidateRequest, EditRequest, TrimRequest, PreviewRequest, MassRequest, SessionPatch, PatchOperation,
    ProblemDocument,
)  # fmt: skip
"""Types that OpenAPI must hold though no route declares them to FastAPI."""
