"""Owns what the fields of the left panel show: the schema they are made from, the document, and what follows from it.

Long columns of numbers (force data, profiles) stay behind: a page that edits a field has no use for them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from pydantic_core import to_json

from models.components import Bellows, Bladder, Cell, Piston
from models.design import Design
from models.hydrodynamic_law import build_law
from models.hydrodynamics import PolarTable
from models.hydrodynamics_angles import AngleTable
from models.mass_properties import MassBalance, initial_extensions, mass_balance
from models.volumes import volume
from models.water import density_at, gravity_of, profile_range
from studio.scene import vehicle_length

LONGEST = 40
"""Entries of a list that a page can edit; of a longer one only their number is told."""
UNTITLED = ("title", "discriminator")
"""Members of the schema that no field needs."""


@cache
def schema_json() -> bytes:
    """Return the JSON Schema of a design, without what the page does not read."""
    return to_json(_slim(Design.model_json_schema()))


def _slim(node: Any, *, named: bool = False) -> Any:
    """Leave titles out of a schema; `named` says that the keys are names of fields."""
    if isinstance(node, dict):
        return {
            key: _slim(value, named=key in ("properties", "$defs"))
            for key, value in node.items() if named or key not in UNTITLED
        }  # fmt: skip
    return [_slim(item) for item in node] if isinstance(node, list) else node


def fields_of(design: Design) -> dict[str, Any]:
    """Return the document without its long lists, and the numbers and sentences that follow from it."""
    return {"design": shortened(design.model_dump(mode="json")), "facts": _facts(design)}


def shortened(node: Any) -> Any:
    """Return a document in which {"entries": n} stands for each list of more than `LONGEST` entries."""
    if isinstance(node, dict):
        return {name: shortened(value) for name, value in node.items()}
    if isinstance(node, list):
        return {"entries": len(node)} if len(node) > LONGEST else [shortened(item) for item in node]
    return node


def _facts(design: Design) -> dict[str, Any]:
    start = initial_extensions(design)
    return {
        "length": vehicle_length(design),
        "gravity": gravity_of(design.mission.environment),
        "start": start,
        "stroke": {part.name: part.stroke for _, part in design.vehicle.actuated},
        "volumes": {part.name: _volumes(part, start) for part in design.vehicle.components if _displaces(part)},
        "mass": _mass(mass_balance(design.vehicle, start)),
        "water": water_in_words(design),
        "forces": forces_in_words(design),
        "speeds": list(source.speeds) if isinstance(source := design.vehicle.hydrodynamics, PolarTable) else [],
    }


def _displaces(part: object) -> bool:
    return isinstance(part, Bellows | Piston | Bladder)


def _volumes(part: Any, start: Mapping[str, float]) -> dict[str, float]:
    cell: Cell = part
    return {"neutral": volume(cell, cell.neutral), "start": volume(cell, start[cell.name])}


def _mass(balance: MassBalance) -> dict[str, Any]:
    return {
        "mass": balance.mass,
        "center_of_mass": balance.center_of_mass.tolist(),
        "inertia": balance.inertia.diagonal().tolist(),
    }


def water_in_words(design: Design) -> str:
    """Return what water that changes with depth is, in a sentence; nothing of uniform water."""
    water = design.mission.environment.water
    depths = profile_range(water)
    if depths is None:
        return ""
    what = "TEOS-10 from temperature and salinity" if water.kind == "teos10" else "Density profile"
    low, high = (density_at(water, depth) for depth in depths)
    levels, source = len(getattr(water, "depths", ())), getattr(water, "source", "")
    span = f"{levels} levels from {depths[0]:g} to {depths[1]:g} m"
    return f"{what}: {span}, {low:.2f} to {high:.2f} kg/m³. {source}".strip()


def forces_in_words(design: Design) -> list[str]:
    """Return what the force data are, and how well their law fits or how far they reach, a sentence each."""
    source = design.vehicle.hydrodynamics
    said = [source.provenance.title]
    match source:
        case PolarTable():
            errors = build_law(source).errors
            fits = "; ".join(f"{e.quantity} {100 * e.relative:.1f} % at {e.largest_at_deg:.0f}°" for e in errors)
            said.append(f"Largest misfit of the data's range: {fits}.")
        case AngleTable():
            a, b = source.alpha_deg, source.beta_deg
            mirrored = " (and mirrored)" if source.mirrored else ""
            said.append(
                f"Table over {len(a)} angles of attack, {a[0]:g} to {a[-1]:g}°, and {len(b)} sideslips, {b[0]:g} to "
                f"{b[-1]:g}°{mirrored}. Beyond, the forces of its edge are held."
            )
    return said
