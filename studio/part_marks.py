"""Owns which parts of a session are locked and which are hidden, and whether those that mirror each other go together.

None of it is in the document, nor changes the physics.

A locked part cannot be changed by anybody until it is unlocked: neither its fields, nor its schedule, nor its extension
at start. Parts are known by name, and marks follow a part that gets another one.
"""

from __future__ import annotations

import threading
from typing import Any

from models.components import Component
from models.design import Design
from models.problems import DesignError, Problem, pointer_to
from models.schedule import Schedule

Document = dict[str, Any]
FLAGS = ("locked", "hidden")


class PartMarks:
    """The marks of one session. Safe to use from several threads.

    `linked` tells whether a part that is edited or dragged by hand takes its mirror image along.
    """

    def __init__(
        self, locked: frozenset[str] = frozenset(), hidden: frozenset[str] = frozenset(), *, linked: bool = True
    ) -> None:
        self._lock = threading.Lock()
        self._marked = {"locked": locked, "hidden": hidden}
        self.linked = linked

    @property
    def locked(self) -> frozenset[str]:
        """Names of the parts that cannot be changed."""
        return self._marked["locked"]

    @property
    def hidden(self) -> frozenset[str]:
        """Names of the parts that are not drawn."""
        return self._marked["hidden"]

    def mark(self, name: str, **flags: bool) -> None:
        """Lock or unlock, hide or show a part: `locked` and `hidden` as given."""
        with self._lock:
            for flag, on in flags.items():
                names = self._marked[flag]
                self._marked[flag] = names | {name} if on else names - {name}

    def document(self) -> Document:
        """Return the marks as the session's file keeps them."""
        marked = {flag: sorted(names) for flag, names in self._marked.items()}
        return marked | {"linked": self.linked}

    def follow(self, before: Design, after: Design) -> None:
        """Give renamed parts their marks under the new name, and forget those of parts that are gone."""
        if not (self.locked or self.hidden):
            return
        names = _new_names(before, after)
        with self._lock:
            for flag, marked in self._marked.items():
                self._marked[flag] = frozenset(names[name] for name in marked if name in names)

    def clear(self) -> None:
        """Forget all marks: another document has come."""
        with self._lock:
            self._marked = {flag: frozenset() for flag in FLAGS}
            self.linked = True

    def require_free(self, before: Design, after: Design) -> None:
        """Raise `DesignError` where a change reaches a locked part."""
        for name in sorted(self.locked):
            pointer = _changed_field(before, after, name)
            if pointer is not None:
                raise DesignError([is_locked(pointer, name)])


def is_locked(pointer: str, name: str) -> Problem:
    """Return why a locked part cannot be changed, and how it can."""
    return Problem(
        pointer, f"'{name}' is locked", hint="unlock it first: by its lock in the list of parts, or by L there"
    )


def read_marks(document: Any) -> PartMarks:
    """Return the marks of a session's file; none where it was written before there were any."""
    given = document if isinstance(document, dict) else {}
    locked, hidden = (frozenset(str(name) for name in given.get(flag) or ()) for flag in FLAGS)
    return PartMarks(locked, hidden, linked=given.get("linked") is not False)


def _new_names(before: Design, after: Design) -> dict[str, str]:
    """Return under which name each part of the document before is in the one after."""
    old, new = ([c.name for c in design.vehicle.components] for design in (before, after))
    names = {name: name for name in old if name in new}
    if len(old) == len(new):
        # in place: a change that renames does not also move
        names |= {a: b for a, b in zip(old, new, strict=True) if a not in new and b not in old}
    return names


def _part(design: Design, name: str) -> tuple[int, Component] | None:
    return next(((i, c) for i, c in enumerate(design.vehicle.components) if c.name == name), None)


def _schedule(design: Design, name: str) -> Schedule | None:
    return next((s for s in design.mission.control.schedules if s.cell == name), None)


def _changed_field(before: Design, after: Design, name: str) -> str | None:
    """Return where a change reaches a part, or None where it does not."""
    old, new = _part(before, name), _part(after, name)
    if old is None:
        return None
    index, part = old
    if new is None or type(new[1]) is not type(part):
        return pointer_to("vehicle", "components", index)
    arranged = [c.name for c in before.vehicle.components] != [c.name for c in after.vehicle.components]
    for field in type(part).model_fields:
        if field == "color" and arranged:
            continue  # stated so that it stays the same
        if getattr(part, field) != getattr(new[1], field):
            return pointer_to("vehicle", "components", index, field)
    if before.mission.initial.extensions.get(name) != after.mission.initial.extensions.get(name):
        return pointer_to("mission", "initial", "extensions", name)
    if _schedule(before, name) != _schedule(after, name):
        found = [i for i, s in enumerate(before.mission.control.schedules) if s.cell == name]
        return pointer_to("mission", "control", "schedules", *found)
    return None
