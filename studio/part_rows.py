"""Owns what the State says of each component's row in the list of parts, beside its name, kind and colour."""

from __future__ import annotations

from typing import Any

from models.design import Design
from studio.part_marks import PartMarks
from studio.part_symmetry import partners


def part_rows(design: Design, marks: PartMarks) -> list[dict[str, Any]]:
    """Return of each component its partner across the plane of symmetry, its marks, and its first shape's kind."""
    components = design.vehicle.components
    return [
        {
            "partner": partner, "locked": part.name in marks.locked, "hidden": part.name in marks.hidden,
            "shape": part.shapes[0].kind if part.shapes else None,
        }
        for part, partner in zip(components, partners(components), strict=True)
    ]  # fmt: skip
