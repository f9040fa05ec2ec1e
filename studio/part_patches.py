"""Owns the changes of the list of parts as JSON Patches: mirroring, reordering, and stating the mass properties."""

from __future__ import annotations

import re
from typing import Any, Literal

from models.components import Actuated, Component, Rigid
from models.design import Design
from models.mass_properties import initial_extensions, mass_balance
from models.problems import DesignError, Problem, pointer_to
from models.schedule import Schedule
from studio.changes import Patch, component_at, declared_more, free_name, renamed
from studio.palette import component_colors
from studio.part_symmetry import is_its_own_image, mirrored, partners

Sense = Literal["same", "opposite"]
SIDES = re.compile(r"\b(port|starboard|left|right)\b", re.IGNORECASE)
OTHER_SIDE = {"port": "starboard", "starboard": "port", "left": "right", "right": "left"}


def mirror(design: Design, index: int, schedule: Sense | None = None) -> Patch:
    """Return the patch that adds a component's mirror image after it; both are named by their side.

    `schedule` gives the image the same commands, which keeps the glider level, or opposite ones about neutral, which
    bank it; without, it follows none.
    """
    original = component_at(design, index)
    if is_its_own_image(original):
        message = f"'{original.name}' stands in the plane of symmetry (y = 0): its mirror image is itself"
        if design.mission.solver.model == "planar":  # where no part has a side
            hint = "choose the spatial model first, then give it a position y"
            raise DesignError([Problem("/mission/solver/model", message, limit="spatial", hint=hint)])
        pointer = pointer_to("vehicle", "components", index, "position", 1)
        raise DesignError([Problem(pointer, message, limit=0.0, hint="give it a position y first")])
    partner = partners(design.vehicle.components)[index]
    if partner is not None:
        pointer, there = pointer_to("vehicle", "components", index), design.vehicle.components[partner].name
        hint = f"remove '{there}' first to make it anew"
        raise DesignError([Problem(pointer, f"'{original.name}' is mirrored by '{there}' already", hint=hint)])
    own, other = _names(design, original)
    image = mirrored(original) | {"name": other}
    if not isinstance(original, Rigid):
        image["color"] = None
    patch = colors_kept(design)
    if own != original.name:
        patch += renamed(design, index, own)
    patch.append({"op": "add", "path": pointer_to("vehicle", "components", index + 1), "value": image})
    patch += declared_more(design, original.mass)
    if schedule is not None and not isinstance(original, Rigid):
        patch += _commands(design, original, other, opposite=schedule == "opposite")
    return patch


def _names(design: Design, original: Component) -> tuple[str, str]:
    """Return the names of a component and of its mirror image."""
    found = SIDES.search(original.name)
    if found is not None:
        word = OTHER_SIDE[found[0].lower()]
        word = word.capitalize() if found[0][0].isupper() else word
        return original.name, free_name(design, original.name[: found.start()] + word + original.name[found.end() :])
    side, across = ("starboard", "port") if original.position[1] >= 0.0 else ("port", "starboard")
    return free_name(design, f"{original.name} {side}"), free_name(design, f"{original.name} {across}")


def _commands(design: Design, original: Actuated, name: str, *, opposite: bool) -> Patch:
    """Return the patch that gives the mirror image a schedule and an extension at start."""
    low, high = original.stroke

    def turned(extension: float) -> float:
        return min(max(2.0 * original.neutral - extension, low), high) if opposite else extension

    patch: Patch = []
    found: Schedule | None = next((s for s in design.mission.control.schedules if s.cell == original.name), None)
    if found is not None:
        points = [p.model_dump() | {"extension": turned(p.extension)} for p in found.points]
        value = {"cell": name, "points": points}
        patch.append({"op": "add", "path": "/mission/control/schedules/-", "value": value})
    start = design.mission.initial.extensions.get(original.name)
    if start is not None:
        path = pointer_to("mission", "initial", "extensions", name)
        patch.append({"op": "add", "path": path, "value": turned(start)})
    return patch


def moved(design: Design, index: int, to: int) -> Patch:
    """Return the patch that puts a component at another place of the list; each keeps its colour."""
    component_at(design, index)
    component_at(design, to)
    if index == to:
        return []
    paths = [pointer_to("vehicle", "components", k) for k in (index, to)]
    return [*colors_kept(design), {"op": "move", "from": paths[0], "path": paths[1]}]


def colors_kept(design: Design) -> Patch:
    """Return the patch that states the colours of cells, which else go by their order."""
    parts = design.vehicle.components
    return [
        {"op": "replace", "path": pointer_to("vehicle", "components", i, "color"), "value": color}
        for i, (part, color) in enumerate(zip(parts, component_colors(parts), strict=True))
        if part.color is None and not isinstance(part, Rigid)
    ]


def mass_properties(design: Design, kind: str) -> Patch:
    """Return the patch that declares what the components now amount to, or composes the mass properties again."""
    value: dict[str, Any] = {"kind": kind}
    if kind == "declared":
        balance = mass_balance(design.vehicle, initial_extensions(design))
        names = (("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2))
        value |= {
            "mass": balance.mass,
            "center_of_mass": balance.center_of_mass.tolist(),
            "inertia": {name: float(balance.inertia[i, j]) for name, i, j in names},
        }
    return [{"op": "replace", "path": "/vehicle/mass_properties", "value": value}]
