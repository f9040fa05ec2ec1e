"""Owns the design document: one JSON file that holds a vehicle and its mission, so that a glide can be replayed."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import rfc8785
from pydantic import Field, ValidationError, model_validator

from models.components import Actuated, Component, Inertia, Rigid
from models.fields import Description, Vector3, quantity, text, vector
from models.hydrodynamic_sources import Hydrodynamics
from models.hydrodynamics import AddedMass, Damping
from models.memory import remembered
from models.mission import Mission
from models.plain_words import plainly
from models.problems import DesignError, Problem

FORMAT = "glider-design"
VERSION = 1


class CompositeMass(Description):
    """Mass, centre of mass and inertia follow from the components, again at every extension."""

    kind: Literal["composite"] = text("Mass properties are composed from the components.", default="composite")


class DeclaredMass(Description):
    """Mass, centre of mass and inertia are stated and frozen, as in the paper; volumes still follow the cells."""

    kind: Literal["declared"] = text("Mass properties are stated.")
    mass: float = quantity("Total mass.", unit="kg", symbol="m", gt=0.0, le=1e6)
    center_of_mass: Vector3 = vector("Centre of mass in body axes.", unit="m", symbol="r_G")
    inertia: Inertia = text("Inertia about the centre of mass.")


MassProperties = Annotated[CompositeMass | DeclaredMass, Field(discriminator="kind")]


class Vehicle(Description):
    """The glider: its components, and how water acts on it."""

    components: tuple[Component, ...] = text("All parts; at least one.", min_length=1)
    mass_properties: MassProperties = text(
        "Whether mass, centre of mass and inertia are composed from the components or stated.", default=CompositeMass()
    )
    hydrodynamics: Hydrodynamics = text("Forces and moments of the water on the whole vehicle.")
    added_mass: AddedMass | None = text("Added mass of the whole vehicle.", default=None)
    damping: Damping = text("Linear damping beside the hydrodynamic data.", default=Damping())
    hotel_power: float = quantity(
        "Power that electronics and payload draw all the time.",
        unit="W", symbol="P_hotel", ge=0.0, le=1e6, default=0.0,
    )  # fmt: skip

    @property
    @remembered(most=16)  # every check and record of a design begins with them
    def actuated(self) -> tuple[tuple[int, Actuated], ...]:
        """The components that move, each with its index among all components."""
        return tuple((i, c) for i, c in enumerate(self.components) if not isinstance(c, Rigid))

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        seen: dict[str, int] = {}
        for i, component in enumerate(self.components):
            if component.name in seen:
                raise ValueError(
                    f"components {seen[component.name]} and {i} are both named '{component.name}': rename one"
                )
            seen[component.name] = i
        return self


class Design(Description):
    """A design document, version 1."""

    format: Literal["glider-design"] = text("Says that this is a design document.")
    version: Literal[1] = text("Version of the document's format.")
    name: str = text("Name of the design.", min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")
    notes: str = text("What it is, where its numbers come from, and what it is not.", default="", max_length=20_000)
    vehicle: Vehicle = text("The glider.")
    mission: Mission = text("The glide.")

    def to_json(self) -> str:
        """Return the document as indented JSON, ready for a file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, ensure_ascii=False) + "\n"

    @property
    def identity(self) -> str:
        """SHA-256 of the canonical JSON (RFC 8785): two designs with one identity are the same design."""
        return hashlib.sha256(rfc8785.dumps(self.model_dump(mode="json"))).hexdigest()


def parse_design(document: Any) -> Design:
    """Turn a decoded JSON document into a `Design`.

    Raises
    ------
    DesignError
        With a JSON Pointer, the bound and a hint for every field that is wrong.

    """
    if not isinstance(document, dict):
        raise DesignError([Problem("", f"a design is a JSON object, not {type(document).__name__}")])
    _check_header(document)
    try:
        return Design.model_validate(document)
    except ValidationError as error:
        raise DesignError(plainly(error, document, _schema())) from None


@cache
def _schema() -> dict[str, Any]:
    return Design.model_json_schema()


def _check_header(document: dict[str, Any]) -> None:
    if document.get("format") != FORMAT:
        raise DesignError(
            [Problem("/format", f"this is not a glider design: format is {document.get('format')!r}", limit=FORMAT)]
        )
    version = document.get("version")
    if isinstance(version, bool):
        raise DesignError([Problem("/version", "the version is a number, not true or false", limit=VERSION)])
    if type(version) is int and version > VERSION:
        raise DesignError(
            [
                Problem(
                    "/version",
                    f"the document has version {version}; this program reads versions up to {VERSION}",
                    limit=VERSION,
                    hint="open it with a newer glider studio",
                )
            ]
        )


def _refuse_constant(token: str) -> float:
    raise DesignError([Problem("", f"{token} is not JSON: numbers must be finite")])


def loads_design(content: str | bytes) -> Design:
    """Parse the text of a design file; raises `DesignError` also where it is not JSON."""
    try:
        document = json.loads(content, parse_constant=_refuse_constant)
    except DesignError:
        raise
    except (ValueError, RecursionError) as error:  # not JSON, not UTF-8, or a number of thousands of digits
        raise DesignError([Problem("", f"the file is not JSON: {error}")]) from None
    return parse_design(document)


def load_design(path: Path) -> Design:
    """Read a design file; raises `DesignError`, or `OSError` where the file cannot be read."""
    return loads_design(path.read_bytes())
