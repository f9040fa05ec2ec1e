"""Owns one designer's work: the document, its last good run, the last problem, undo and redo. No Viser, no HTTP."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from typing import Any

from models.assemble import Assembly, assemble
from models.components import Component
from models.design import Design
from models.limits import DEFAULT_LIMITS, Limits
from models.mass_properties import trim_ballast
from models.problems import DesignError, Problem
from models.run import Run
from models.warm import kernel_is_ready
from server.editing import apply_patch
from studio import changes
from studio.consequences import LiveConsequences
from studio.kept_again import KeptAgain
from studio.kept_runs import NO_RUNS, KeptRun, KeptRuns, SavedRuns
from studio.listeners import Listeners
from studio.origin import Origin
from studio.pairs import followed
from studio.part_marks import PartMarks
from studio.runner import Runner
from studio.scene_display import FIRST_DISPLAY, Display

log = logging.getLogger(__name__)

HISTORY = 200
"""Steps that can be undone."""
MERGE_WITHIN = 1.0
"""Edits of the same field that follow each other this closely are one step of undo, s."""


class Change(Enum):
    """What subscribers are told: document, problem or selection changed; or a run ended, and maybe those too."""

    document = auto()
    run = auto()


class Session:
    """One designer's document and what follows from it.

    Every view changes it through these operations and hears of it through `subscribe`; subscribers are called in the
    session's own thread, one at a time. A change that cannot be parsed or assembled raises `DesignError`, is told by
    `problem`, and leaves document and run as they were.
    """

    def __init__(
        self, session_id: str, design: Design, *, limits: Limits = DEFAULT_LIMITS, revision: int = 1,
        origin: Origin | None = None, kept: SavedRuns = NO_RUNS, display: Display = FIRST_DISPLAY,
    ) -> None:  # fmt: skip
        self.id = session_id
        self._limits = limits
        self._lock = threading.RLock()
        self._assembly = assemble(design, limits)
        self._run: Run | None = None
        self._run_assembly: Assembly | None = None
        self._run_number = revision - 1  # no change has more than one run: after a restart no number means another one
        self._problem: tuple[Problem, ...] = ()
        self._revision = revision
        self._origin = origin
        self.kept = KeptRuns(kept)
        self._again = KeptAgain(self.kept, limits=limits, on_done=self.touch)
        self.marks = PartMarks()
        self._display = display
        self._identity: tuple[Design, str] | None = None
        self._selected = design.vehicle.actuated[0][0] if design.vehicle.actuated else 0
        self._undo: deque[Assembly] = deque(maxlen=HISTORY)
        self._redo: deque[Assembly] = deque(maxlen=HISTORY)
        self._last_merge: tuple[str | None, float] = (None, 0.0)
        self._listeners: Listeners[Callable[[Change], None]] = Listeners()
        self.consequences = LiveConsequences()
        self._runner = Runner(
            limits=limits, on_change=lambda: self._tell(Change.document), on_run=self._finish, on_settled=self._settle
        )
        self._runner.submit(self._assembly)

    @property
    def design(self) -> Design:
        """The document, always one that can be simulated."""
        return self._assembly.design

    @property
    def assembly(self) -> Assembly:
        """The document made ready for the kernel, with its warnings and its hydrodynamic law."""
        return self._assembly

    @property
    def limits(self) -> Limits:
        """What its designs may ask for."""
        return self._limits

    @property
    def run(self) -> Run | None:
        """The last run that ended; None until the first one has."""
        return self._run

    @property
    def run_number(self) -> int:
        """Number of the last run that ended: a curve of an older one is out of date, also after a restart."""
        return self._run_number

    @property
    def simulating(self) -> bool:
        """Whether the run does not belong to the document yet."""
        return self._run_assembly is not self._assembly

    @property
    def compiling(self) -> bool:
        """Whether runs wait for the kernel to be compiled."""
        return self._run is None and not kernel_is_ready()

    @property
    def problem(self) -> tuple[Problem, ...]:
        """What was wrong with the last change; empty after one that was accepted."""
        return self._problem

    @property
    def revision(self) -> int:
        """Number of the document's state; each accepted change has a higher one."""
        return self._revision

    @property
    def origin(self) -> Origin | None:
        """Where the document came from; None where it is kept in this session alone."""
        return self._origin

    @property
    def changed(self) -> bool:
        """Whether the document differs from the one at its origin."""
        design, known, origin = self.design, self._identity, self._origin
        if origin is None:
            return False
        if known is None or known[0] is not design:
            self._identity = known = design, design.identity
        return known[1] != origin.identity

    @property
    def can_undo(self) -> bool:
        """Whether there is a change to undo."""
        return bool(self._undo)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone change to make again."""
        return bool(self._redo)

    @property
    def selected(self) -> int:
        """Index of the component being edited."""
        return min(self._selected, len(self.design.vehicle.components) - 1)

    @property
    def selected_component(self) -> Component:
        """The component being edited."""
        components = self.design.vehicle.components
        return components[min(self._selected, len(components) - 1)]

    def edit(self, patch: Sequence[Mapping[str, Any]], *, gesture: str | None = None, paired: bool = False) -> Design:
        """Apply a JSON Patch (RFC 6902); renaming or removing one component also changes what names it.

        Edits of one gesture that follow each other are one step of undo, however long it lasts. A `paired` one takes
        mirror images along, as long as pairs are `linked`.
        """
        key, within = (changes.merge_key(patch), MERGE_WITHIN) if gesture is None else (gesture, math.inf)

        def make(design: Design) -> Design:
            edited = apply_patch(design, changes.completed(design, patch))
            along = followed(design, edited, staying=self.marks.locked) if paired and self.marks.linked else []
            return apply_patch(edited, along) if along else edited

        return self._change(make, merge=key, within=within)

    @property
    def linked(self) -> bool:
        """Whether a part that is edited or dragged by hand takes its mirror image along."""
        return self.marks.linked

    def link(self, linked: bool) -> None:
        """Have mirror images go along, or stay."""
        self.marks.linked = linked
        self._runner.touch()

    def set_field(self, pointer: str, value: Any) -> Design:
        """Set one field by JSON Pointer."""
        return self.edit([{"op": "replace", "path": pointer, "value": value}])

    def replace(self, design: Design) -> Design:
        """Put another document in this one's place; that, too, can be undone.

        It has no origin: saved, it is a design of its own, and overwrites none.
        """
        replaced = self._change(lambda _: design, guarded=False)
        self.marks.clear()
        self.come_from(None)
        return replaced

    def come_from(self, origin: Origin | None) -> None:
        """Remember where the document was opened from, or is kept now."""
        self._origin = origin
        self._runner.touch()

    def arrange(self, make: Callable[[Design], changes.Patch], *, select: int | None = None) -> Design:
        """Apply the patch that `make` makes of the present document, and select a component."""
        return self._change(lambda design: apply_patch(design, make(design)), select=select)

    def mark(self, index: int, **flags: bool) -> None:
        """Lock or unlock, hide or show a component: `locked` and `hidden` as given."""
        self.marks.mark(changes.component_at(self.design, index).name, **flags)
        self._runner.touch()

    def add_component(self, kind: str) -> Design:
        """Add a part of one of the kinds of `part_kinds.NAMES`, and select it."""
        return self._change(lambda design: apply_patch(design, changes.added(design, kind)), select=-1)

    def duplicate_component(self, index: int) -> Design:
        """Add a copy of a component, and select it."""
        return self._change(lambda design: apply_patch(design, changes.duplicated(design, index)), select=-1)

    def remove_component(self, name: str) -> Design:
        """Remove a component with its schedules and initial extension."""
        return self._change(lambda design: apply_patch(design, changes.removed(design, changes.index_of(design, name))))

    def trim_ballast(self) -> str:
        """Make the glider neutral with all cells neutral; returns what was changed, in words."""
        said: list[str] = []

        def trim(design: Design) -> Design:
            trimmed, change = trim_ballast(design)
            said.append(str(change))
            return trimmed

        self._change(trim)
        return said[0]

    def undo(self) -> bool:
        """Take back the last change; False where there is none."""
        return self._travel(self._undo, self._redo)

    def redo(self) -> bool:
        """Make the last undone change again; False where there is none."""
        return self._travel(self._redo, self._undo)

    def select(self, index: int) -> None:
        """Choose the component to edit."""
        with self._lock:
            changes.component_at(self.design, index)
            changed, self._selected = index != self._selected, index
        if changed:
            self._runner.touch()

    @property
    def display(self) -> Display:
        """What is shown in the scene beside the design and its run."""
        return self._display

    def touch(self) -> None:
        """Have everybody told, though neither document nor run changed."""
        self._runner.touch()

    @property
    def ghost(self) -> KeptRun | None:
        """The kept run whose ghost flies along in the scene."""
        return None if self._display.ghost is None else self.kept.get(self._display.ghost)

    def show(self, display: Display) -> None:
        """Show something else in the scene."""
        self._display = display
        self._runner.touch()

    def keep_run(self, name: str | None = None) -> KeptRun:
        """Keep the present run to compare with; there must be one."""
        assert self._run is not None
        kept = self.kept.keep(self._run, name)
        self._runner.touch()
        return kept

    def rename_run(self, run_id: str, name: str) -> bool:
        """Give a kept run another name; False where there is none."""
        renamed = self.kept.rename(run_id, name)
        self._runner.touch()
        return renamed

    def forget_run(self, run_id: str) -> bool:
        """Keep a run no longer; False where there is none."""
        forgotten = self.kept.forget(run_id)
        self._runner.touch()
        return forgotten

    def refuse(self, error: DesignError) -> None:
        """Tell a problem with a change that was refused before it reached the document."""
        self._problem = error.problems
        self._runner.touch()

    def subscribe(self, listener: Callable[[Change], None]) -> Callable[[], None]:
        """Have `listener` called after each change, in the session's own thread; returns how to stop that."""
        return self._listeners.add(listener)

    def close(self) -> None:
        """Stop simulating, tell once more, and stop telling."""
        self._again.close()
        self._runner.close()
        self._tell(Change.document)

    def _change(
        self, make: Callable[[Design], Design], *, merge: str | None = None, select: int | None = None,
        guarded: bool = True, within: float = MERGE_WITHIN,
    ) -> Design:  # fmt: skip
        try:
            with self._lock:
                design = make(self.design)
                if guarded:
                    self.marks.require_free(self.design, design)
                unchanged = design == self.design
                if not unchanged:
                    self._accept(assemble(design, self._limits), merge, within)
                self._problem = ()
                if select is not None:
                    self._selected = select % len(design.vehicle.components)
                assembly = self._assembly
        except DesignError as error:
            self.refuse(error)
            raise
        if unchanged:
            self._runner.touch()
        else:
            self._runner.submit(assembly)
        return assembly.design

    def _accept(self, assembly: Assembly, merge: str | None, within: float) -> None:
        now = time.monotonic()
        key, at = self._last_merge
        if merge is None or merge != key or now - at > within or not self._undo:
            self._undo.append(self._assembly)
        self._last_merge = merge, now
        self._redo.clear()
        self._put(assembly)

    def _put(self, assembly: Assembly) -> None:
        before, after = self.design, assembly.design
        self.marks.follow(before, after)
        self._selected = changes.same_component(before, after, self.selected)
        self._assembly = assembly
        self._problem = ()
        self._revision += 1

    def _travel(self, source: deque[Assembly], target: deque[Assembly]) -> bool:
        with self._lock:
            if not source:
                return False
            target.append(self._assembly)
            self._put(source.pop())
            self._last_merge = None, 0.0
            assembly = self._assembly
        self._runner.submit(assembly)
        return True

    def _finish(self, assembly: Assembly, run: Run) -> None:
        self._run, self._run_assembly = run, assembly
        self._run_number += 1
        self._tell(Change.run)

    def _settle(self, assembly: Assembly, run: Run) -> None:
        self.consequences.update(assembly, run, self._run_number)
        self._again.start()  # now that the kernel is ready, and what is worked on has come first

    def _tell(self, change: Change) -> None:
        for listener in self._listeners:
            try:
                listener(change)
            except Exception:  # one view's mistake must not leave the others behind
                log.exception("a view of session %s failed", self.id)
