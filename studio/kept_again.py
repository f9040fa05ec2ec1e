"""Owns computing kept runs anew after a session came back from its file, in a thread of its own."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from models.assemble import assemble
from models.design import loads_design
from models.limits import Limits
from models.problems import DesignError
from models.simulate import Control, run_assembly
from studio.kept_runs import KeptRun, KeptRuns

log = logging.getLogger(__name__)

SLIP = "The program failed on it; whoever runs this studio finds the reason in its log."
STAYS = "What it is computed from is kept, and tried again when the session is opened next."


class KeptAgain:
    """Computes the awaited runs of `kept` one after another; `on_done` is called after each, in that thread."""

    def __init__(self, kept: KeptRuns, *, limits: Limits, on_done: Callable[[], None]) -> None:
        self._kept, self._limits, self._on_done = kept, limits, on_done
        self._control = Control()
        self._thread: threading.Thread | None = None
        self._beginning = threading.Lock()

    def start(self) -> None:
        """Begin, where there is anything to compute and nobody has begun or closed; the kernel must be ready."""
        with self._beginning:
            if self._thread is not None or self._control.cancelled:
                return
            if any(kept.state == "computing" for kept in self._kept):
                self._thread = threading.Thread(target=self._work, name="kept-again", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Stop; a run that is being computed is cancelled, and stays in the file."""
        with self._beginning:  # either the thread runs and is told, or it never begins
            self._control.cancel()
            thread = self._thread
        if thread is not None:
            thread.join(timeout=5.0)

    def _work(self) -> None:
        for kept in self._kept:
            if kept.state != "computing" or self._kept.get(kept.id) is None:
                continue  # it is there, or was forgotten meanwhile
            self._compute(kept)
            if self._control.cancelled:
                return
            self._on_done()

    def _compute(self, kept: KeptRun) -> None:
        try:
            assembly = assemble(loads_design(kept.keepsake.content), self._limits)
            run = run_assembly(assembly, limits=self._limits, control=self._control)
        except DesignError as error:
            self._kept.failed(kept.id, f"It cannot be computed any more: {error.problems[0]}. {STAYS}")
        except Exception:  # whatever it is, the page must not wait for ever
            log.exception("a kept run cannot be computed anew")
            self._kept.failed(kept.id, f"{SLIP} {STAYS}")
        else:
            if not self._control.cancelled:
                self._kept.computed(kept.id, run)
