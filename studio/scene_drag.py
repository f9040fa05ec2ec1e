"""Owns moving a part in the scene with the pointer: along a body axis, in whole millimetres, its mirror image with it.

A part is taken by its mesh or by the arrows above it. By its mesh it goes along its axis as far as keeps it under the
pointer, which moves over a plane that faces the camera; the arrows tell a place, and no modifiers: they always snap.
"""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.problems import DesignError, pointer_to
from studio.attitude import Quaternion, rotate
from studio.part_marks import is_locked
from studio.part_symmetry import partners
from studio.session import Session

log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

STEP = 1e-3
"""What places snap to, m; with Alt they are free, to a hundredth of that."""
MODIFIERS: dict[str | None, tuple[int, bool]] = {
    # the body axis along which a part goes, and whether it goes freely
    None: (0, False), "alt": (0, True),
    "shift": (1, False), "alt+shift": (1, True),
    "cmd/ctrl": (2, False), "cmd/ctrl+alt": (2, True),
}  # fmt: skip
AXES = ("x", "y", "z")
MOVED = 1e-7
"""How far from where it was a place must be, m, to have left it: the client's arithmetic moves it by less."""
LEAST_SIGHT = 0.05
"""Squared share of an axis across the line of sight below which a drag along it would leap."""


@dataclass(frozen=True)
class Grip:
    """A part that is being moved: where it was, and which part mirrors it."""

    index: int
    name: str
    begin: Vector
    partner: int | None
    gesture: str


@dataclass(frozen=True)
class Drag:
    """A part held by its mesh: where in the scene it was grabbed, and along which axis it goes."""

    grip: Grip
    grabbed: Array
    axis: int
    free: bool


def along(way: Array, axis: Array, sight: Array) -> float:
    """Return how far along a unit axis (3,) a pointer went by a way (3,) in the plane across the line of sight (3,)."""
    across = axis - (axis @ sight) * sight
    return float(way @ across) / max(float(across @ across), LEAST_SIGHT)


def snapped(value: float, *, free: bool) -> float:
    """Return a place in whole steps, or where it is free in hundredths of them."""
    step = STEP / 100.0 if free else STEP
    return round(round(value / step) * step, 9)


class PartMoves:
    """Moves parts of a session: one step of undo for each time that one is taken and let go."""

    def __init__(self, session: Session, attitude: Callable[[], Quaternion]) -> None:
        self._session, self._attitude = session, attitude
        self._numbers = itertools.count(1)
        self._drag: Drag | None = None
        self._by_arrows: Grip | None = None
        self.label: tuple[int, str] | None = None

    def take(self, index: int) -> Grip | None:
        """Begin to move a part, and select it; None, and the session tells why, where it is locked."""
        part = self._session.design.vehicle.components[index]
        if part.name in self._session.marks.locked:
            pointer = pointer_to("vehicle", "components", index, "position")
            self._session.refuse(DesignError([is_locked(pointer, part.name)]))
            return None
        self._session.select(index)
        partner = partners(self._session.design.vehicle.components)[index]
        return Grip(index, part.name, part.position, partner, f"move {next(self._numbers)}")

    def put(self, grip: Grip, place: Vector) -> None:
        """Put a part somewhere else, and its mirror image on the other side, where pairs are linked and it is free."""
        design = self._session.design
        components = design.vehicle.components
        if grip.index >= len(components) or components[grip.index].name != grip.name:
            return  # the document has become another one meanwhile
        x, y, z = place
        if design.mission.solver.model == "planar":
            y = components[grip.index].position[1]
        patch = [_replace(grip.index, (x, y, z))]
        free = grip.partner is not None and components[grip.partner].name not in self._session.marks.locked
        if grip.partner is not None and free and self._session.linked:
            patch.append(_replace(grip.partner, (x, -y, z)))
        try:
            self._session.edit(patch, gesture=grip.gesture)
        except DesignError:
            log.debug("a dragged part was refused; the session tells why")

    def drag_by_arrows(self, phase: str, place: Vector) -> None:
        """Follow the arrows that drag the selected part; across the one that is pulled it stays where it was."""
        if phase == "start":
            self._by_arrows = self.take(self._session.selected)
        elif self._by_arrows is not None:
            self._pull(self._by_arrows, place)
        if phase == "end":
            self._by_arrows = self.label = None
            self._session.touch()

    def _pull(self, grip: Grip, place: Vector) -> None:
        ways = [to - begin for to, begin in zip(place, grip.begin, strict=True)]
        axis = max(range(3), key=lambda k: abs(ways[k]))
        x, y, z = (
            snapped(to, free=False) if abs(way) > MOVED else begin
            for to, way, begin in zip(place, ways, grip.begin, strict=True)
        )
        if abs(ways[axis]) > MOVED:
            self.label = grip.index, _words(axis, (x, y, z)[axis], free=False)
        self.put(grip, (x, y, z))

    def drag(self, index: int, event: Any) -> None:
        """Follow the pointer that drags a part by its mesh."""
        if event.phase == "start":
            self._begin(index, event)
        elif self._drag is not None and self._drag.grip.index == index:
            self._go_on(self._drag, event)
        if event.phase == "end":
            self._drag = self.label = None
            self._session.touch()

    def _begin(self, index: int, event: Any) -> None:
        grip = self.take(index) if index < len(self._session.design.vehicle.components) else None
        axis, free = MODIFIERS.get(event.modifier, (0, False))
        self._drag = None if grip is None else Drag(grip, np.array(event.start_position), axis, free)

    def _go_on(self, drag: Drag, event: Any) -> None:
        camera = event.client.camera
        sight = np.array(camera.look_at) - np.array(camera.position)
        sight = sight / max(float(np.linalg.norm(sight)), 1e-12)
        axis = rotate(np.eye(3)[drag.axis : drag.axis + 1], self._attitude())[0]
        way = along(np.array(event.end_position) - drag.grabbed, axis, sight)
        place = list(drag.grip.begin)
        if not math.isfinite(way) or (drag.axis == 1 and self._session.design.mission.solver.model == "planar"):
            return
        place[drag.axis] = snapped(place[drag.axis] + way, free=drag.free)
        self.label = drag.grip.index, _words(drag.axis, place[drag.axis], free=drag.free)
        self.put(drag.grip, (place[0], place[1], place[2]))


def _replace(index: int, place: Vector) -> dict[str, Any]:
    return {"op": "replace", "path": pointer_to("vehicle", "components", index, "position"), "value": list(place)}


def _words(axis: int, place: float, *, free: bool) -> str:
    return f"{AXES[axis]} {1e3 * place:.{2 if free else 0}f} mm".replace("-", "\N{MINUS SIGN}")
