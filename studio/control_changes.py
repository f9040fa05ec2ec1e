"""Owns what renaming and removing a component changes in a controller, as JSON Patches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from models.controllers import Cascade, StateFeedback, names_under_control
from models.design import Design
from models.problems import pointer_to

Patch = list[dict[str, Any]]
CONTROLLER = ("mission", "control", "controller")


def _named_in_control(design: Design) -> list[tuple[tuple[str, ...], Sequence[str]]]:
    """Return the lists of a controller that name components, each with its place."""
    match design.mission.control.controller:
        case Cascade(allocation=rule):
            return [((*CONTROLLER, "allocation", "cells"), rule.cells or ())]
        case StateFeedback(cells=cells, states=states):
            return [((*CONTROLLER, "cells"), cells), ((*CONTROLLER, "states"), states)]
    return []


def renamed_in_control(design: Design, old: str, name: str) -> Patch:
    """Return the patch that gives a component its new name wherever the controller names it."""
    patch: Patch = [
        {"op": "replace", "path": pointer_to(*place, k), "value": name}
        for place, names in _named_in_control(design) for k, known in enumerate(names) if known == old
    ]  # fmt: skip
    controller = design.mission.control.controller
    if isinstance(controller, Cascade) and old in controller.allocation.effort:
        folder = (*CONTROLLER, "allocation", "effort")
        patch.append({"op": "move", "from": pointer_to(*folder, old), "path": pointer_to(*folder, name)})
    return patch


def removed_from_control(design: Design, name: str) -> Patch:
    """Return the patch that takes a component out of a controller; the controller goes where it was all it had."""
    controller = design.mission.control.controller
    named = [names for _, names in _named_in_control(design)]
    moving = [part.name for _, part in design.vehicle.actuated]
    if controller is None or not any(name in names for names in (*named, names_under_control(controller, moving))):
        return []
    if isinstance(controller, StateFeedback) or names_under_control(controller, moving) == (name,):
        return [{"op": "remove", "path": pointer_to(*CONTROLLER)}]
    patch: Patch = [
        {"op": "remove", "path": pointer_to(*CONTROLLER, "allocation", "cells", k)}
        for k, known in enumerate(controller.allocation.cells or ()) if known == name
    ]  # fmt: skip
    if name in controller.allocation.effort:
        patch.append({"op": "remove", "path": pointer_to(*CONTROLLER, "allocation", "effort", name)})
    return patch
