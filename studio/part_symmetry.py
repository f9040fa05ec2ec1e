"""Owns symmetry from port to starboard: a component's mirror image, and which components are each other's.

Vectors mirror across the plane y = 0 by the sign of their y. An axis of turning is no such vector: its x and z change
sign instead, so that a mirrored mass rolls the other way by the same angle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from models.components import Component, RollingMass

TOLERANCE, SMALLEST = 1e-6, 1e-9
"""How far apart two numbers may be that count as mirrored: as a share of the larger, and in m, kg or rad."""
UNSEEN = ("name", "color", "notes")
"""Fields in which partners may differ."""
MIRRORED_VECTORS = ("position", "center_of_mass", "pivot", "offset", "direction", "axis")
CROSS_TERMS = ("xy", "yz")


def mirrored(component: Component) -> dict[str, Any]:
    """Return the document of a component's mirror image, under the same name."""
    document = _mirrored(component.model_dump(mode="json"))
    if isinstance(component, RollingMass):
        x, y, z = component.axis
        document["axis"] = [_plain(-x), y, _plain(-z)]
    return document


def _plain(value: float) -> float:
    return value + 0.0  # no negative zero


def _mirrored(document: dict[str, Any]) -> dict[str, Any]:
    changed = dict(document)
    for field, value in document.items():
        if field in MIRRORED_VECTORS and value is not None:
            changed[field] = [value[0], _plain(-value[1]), value[2]]
        elif field in CROSS_TERMS:
            changed[field] = _plain(-value)
        elif field == "inertia":
            changed[field] = _mirrored(value)
        elif field == "shapes":
            changed[field] = [_mirrored(shape) for shape in value]
    return changed


def is_its_own_image(component: Component) -> bool:
    """Whether mirroring leaves a component as it is: it stands in the plane of symmetry."""
    return _alike(mirrored(component), component.model_dump(mode="json"))


@lru_cache(maxsize=64)
def partners(components: tuple[Component, ...]) -> tuple[int | None, ...]:
    """Return for each component the index of the one that mirrors it, or None."""
    found: list[int | None] = [None] * len(components)
    for i, component in enumerate(components):
        if found[i] is not None:
            continue
        j = _image_among(component, components, [k for k in range(i + 1, len(components)) if found[k] is None])
        if j is not None:
            found[i], found[j] = j, i
    return tuple(found)


def _image_among(component: Component, components: Sequence[Component], places: Sequence[int]) -> int | None:
    x, y, z = component.position
    image = None
    for j in places:
        other = components[j]
        near = math.dist((x, -y, z), other.position) <= TOLERANCE * (1.0 + abs(x) + abs(y) + abs(z))
        if type(other) is not type(component) or not near:
            continue
        image = mirrored(component) if image is None else image
        if _alike(image, other.model_dump(mode="json")) and not is_its_own_image(component):
            return j
    return None


def _alike(a: Any, b: Any) -> bool:
    """Whether two documents are equal but for what is unseen and for the tolerance of numbers."""
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(name in UNSEEN or _alike(a[name], b[name]) for name in a)
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(_alike(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=TOLERANCE, abs_tol=SMALLEST)
    return bool(a == b)
