"""Owns what an edit of one part does to its mirror image: what the same edit would, seen in a mirror."""

from __future__ import annotations

from collections.abc import Collection

from models.components import Component
from models.design import Design
from models.mass_properties import initial_extensions
from models.problems import pointer_to
from studio.changes import Operation, Patch
from studio.part_symmetry import UNSEEN, mirrored, partners


def followed(before: Design, after: Design, *, staying: Collection[str]) -> Patch:
    """Return the patch that brings mirror images along with parts that an edit changed, but for those named `staying`.

    Where parts were added, removed, renamed or moved in the list it is empty.
    """
    old, new = before.vehicle.components, after.vehicle.components
    if [part.name for part in old] != [part.name for part in new]:
        return []
    pairs = [(i, j) for i, j in enumerate(partners(old)) if j is not None and new[j].name not in staying]
    patch: Patch = [_image(new[i], new[j], j) for i, j in pairs if new[j] == old[j] and _differs(old[i], new[i])]
    start, now = initial_extensions(before), initial_extensions(after)
    for i, j in pairs:
        name, other = new[i].name, new[j].name
        # a pair that banks starts unlike, and stays so
        if name in now and start[name] == start[other] == now[other] != now[name]:
            path = pointer_to("mission", "initial", "extensions", other)
            patch.append({"op": "add", "path": path, "value": now[name]})
    return patch


def _differs(old: Component, new: Component) -> bool:
    fields = [field for field in type(new).model_fields if field not in UNSEEN]
    return any(getattr(old, field) != getattr(new, field) for field in fields)


def _image(part: Component, partner: Component, index: int) -> Operation:
    own = {field: getattr(partner, field) for field in UNSEEN}
    return {"op": "replace", "path": pointer_to("vehicle", "components", index), "value": mirrored(part) | own}
