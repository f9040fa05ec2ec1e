"""Owns the changes of a design that touch several places at once, as JSON Patches: adding, renaming, removing parts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import TypeAdapter

from models.components import Bellows, Bladder, Component, Piston, Rigid
from models.design import DeclaredMass, Design
from models.problems import DesignError, Problem, pointer_to
from models.volumes import volume
from models.water import surface_density
from studio.bodies import drawn_extent
from studio.control_changes import removed_from_control, renamed_in_control
from studio.part_kinds import NAMES, new_part

Operation = dict[str, Any]
Patch = list[Operation]

_components: TypeAdapter[Component] = TypeAdapter(Component)
COMPONENT = re.compile(r"/vehicle/components/(0|[1-9][0-9]{0,5})(/name)?")


def free_name(design: Design, wanted: str) -> str:
    """Return the wanted name, or the first of 'wanted 2', 'wanted 3', … that no component has."""
    taken = {c.name for c in design.vehicle.components}
    if wanted not in taken:
        return wanted
    number = 2
    while f"{wanted} {number}" in taken:
        number += 1
    return f"{wanted} {number}"


def free_place(design: Design) -> float:
    """Return the x of the widest gap between the drawn cells along the vehicle, m, in whole millimetres."""
    parts = design.vehicle.components
    reach = [(c.position[0] + e[0], c.position[0] + e[1]) for c in parts for e in [drawn_extent(c)]]
    low, high = min(r[0] for r in reach), max(r[1] for r in reach)
    cells = sorted(r for c, r in zip(parts, reach, strict=True) if not isinstance(c, Rigid))
    gaps, end = [], low
    for a, b in cells:
        gaps.append((a - end, (a + end) / 2.0))
        end = max(end, b)
    gaps.append((high - end, (high + end) / 2.0))
    return round(max(gaps)[1], 3)


def added(design: Design, kind: str) -> Patch:
    """Return the patch that adds a small part of a kind in the widest gap; a cell floats neutral by itself."""
    component = new_part(design, kind, free_place(design))
    component["name"] = free_name(design, NAMES[kind])
    if kind == "rolling_mass":  # a finger's breadth below its axis, so that turning it moves weight sideways
        x, y, z = component["position"]
        component |= {"pivot": [x, y, z], "position": [x, y, z + 0.01]}
    part = _components.validate_python(component)
    if isinstance(part, Bellows | Piston | Bladder):
        density = surface_density(design.mission.environment.water)
        component["mass"] = float(f"{density * volume(part, part.neutral):.4g}")
    return [
        {"op": "add", "path": "/vehicle/components/-", "value": component},
        *declared_more(design, component["mass"]),
    ]


def declared_more(design: Design, mass: float) -> Patch:
    """Return the patch that adds to the declared mass, where mass is declared: a part that counts must weigh too."""
    declared = design.vehicle.mass_properties
    if not isinstance(declared, DeclaredMass):
        return []
    return [{"op": "replace", "path": "/vehicle/mass_properties/mass", "value": declared.mass + mass}]


def duplicated(design: Design, index: int) -> Patch:
    """Return the patch that adds a copy of a component beside it, without its colour and schedule."""
    original = component_at(design, index)
    low, high = drawn_extent(original)
    x, y, z = original.position
    shift = round(max(high - low, 0.01) * 1.1, 3)
    document = original.model_dump(mode="json")
    document |= {"name": free_name(design, original.name), "position": [x + shift, y, z], "color": None}
    for name in ("center_of_mass", "pivot"):
        if document.get(name) is not None:
            gx, gy, gz = document[name]
            document[name] = [gx + shift, gy, gz]
    if isinstance(original, Rigid):
        document["color"] = original.color
    return [{"op": "add", "path": "/vehicle/components/-", "value": document}, *declared_more(design, original.mass)]


def component_at(design: Design, index: int) -> Component:
    """Return a component by index; raises `DesignError` where there is none."""
    if not 0 <= index < len(design.vehicle.components):
        raise DesignError([Problem(pointer_to("vehicle", "components", index), "there is no such component")])
    return design.vehicle.components[index]


def same_component(before: Design, after: Design, index: int) -> int:
    """Return where the component at an index is after a change: by its name, or where it has gone, its old place."""
    name = before.vehicle.components[index].name
    names = [c.name for c in after.vehicle.components]
    return names.index(name) if name in names else min(index, len(names) - 1)


def index_of(design: Design, name: str) -> int:
    """Return the index of a component by name; raises `DesignError` where there is none."""
    for i, component in enumerate(design.vehicle.components):
        if component.name == name:
            return i
    raise DesignError([Problem("/vehicle/components", f"no component is named '{name}'")])


def renamed(design: Design, index: int, name: Any) -> Patch:
    """Return the patch that renames a component, in schedules, in a controller and in the initial extensions too."""
    old = component_at(design, index).name
    patch: Patch = [{"op": "replace", "path": pointer_to("vehicle", "components", index, "name"), "value": name}]
    if not isinstance(name, str) or name == old:
        return patch
    for i, schedule in enumerate(design.mission.control.schedules):
        if schedule.cell == old:
            path = pointer_to("mission", "control", "schedules", i, "cell")
            patch.append({"op": "replace", "path": path, "value": name})
    patch += renamed_in_control(design, old, name)
    if old in design.mission.initial.extensions:
        folder = ("mission", "initial", "extensions")
        patch.append({"op": "move", "from": pointer_to(*folder, old), "path": pointer_to(*folder, name)})
    return patch


def removed(design: Design, index: int) -> Patch:
    """Return the patch that removes a component, its schedules and its initial extension.

    A controller does without it; one that fed its gains back is removed.
    """
    name = component_at(design, index).name
    if len(design.vehicle.components) == 1:
        hint = "add another component first"
        raise DesignError([Problem("/vehicle/components", "the last component cannot be removed", limit=1, hint=hint)])
    patch: Patch = [{"op": "remove", "path": pointer_to("vehicle", "components", index)}]
    schedules = design.mission.control.schedules
    for i in reversed([i for i, schedule in enumerate(schedules) if schedule.cell == name]):
        patch.append({"op": "remove", "path": pointer_to("mission", "control", "schedules", i)})
    patch += removed_from_control(design, name)
    if name in design.mission.initial.extensions:
        patch.append({"op": "remove", "path": pointer_to("mission", "initial", "extensions", name)})
    return patch


def completed(design: Design, patch: Sequence[Mapping[str, Any]]) -> Sequence[Mapping[str, Any]]:
    """Return a patch that renames or removes one component together with what follows from it; others as they are."""
    if not _is_patch(patch) or len(patch) != 1:
        return patch
    operation = patch[0]
    match = COMPONENT.fullmatch(str(operation.get("path")))
    if match is None or int(match[1]) >= len(design.vehicle.components):
        return patch
    index, of_name = int(match[1]), match[2] is not None
    if operation.get("op") == "replace" and of_name:
        return renamed(design, index, operation.get("value"))
    if operation.get("op") == "remove" and not of_name:
        return removed(design, index)
    return patch


def merge_key(patch: Sequence[Mapping[str, Any]]) -> str | None:
    """Return what makes two edits steps of one drag: the fields they replace; None where they change the structure."""
    if not _is_patch(patch) or not patch or any(operation.get("op") != "replace" for operation in patch):
        return None
    return json.dumps([str(operation.get("path")) for operation in patch])


def _is_patch(patch: object) -> bool:
    """Whether it has the outer shape of a patch; what is wrong with any other is told where patches are applied."""
    return isinstance(patch, list | tuple) and all(isinstance(operation, Mapping) for operation in patch)
