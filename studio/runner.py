"""Owns the thread that simulates a session's newest design: an older simulation that still runs is cancelled."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from models.assemble import Assembly
from models.limits import Limits
from models.run import Run, Status
from models.simulate import Control, run_assembly
from models.warm import kernel_is_ready

log = logging.getLogger(__name__)

GRACE = 0.25
"""How long a simulation may go on once a newer design waits, s: while someone drags, quick ones all get drawn."""
KERNEL_POLL = 0.1
SETTLE_WITHIN = 0.2
"""While newer designs keep coming, `on_settled` is still called this often, s."""
QUICK = 0.03
"""A run expected to take less, s, is told together with its document: one redraw in place of two."""


ONE_AT_A_TIME = threading.Lock()
"""Held while a run is told, which is all Python: sessions that did so at once would all take as long as all of them."""


class Runner:
    """Simulates in a thread of its own. Of the designs submitted while it is busy only the newest is simulated.

    `on_change` is called there at each `touch` and before each simulation that is not known to be quick, `on_run` after
    each one that ended, and `on_settled` after that for what may wait: left out while a newer design does, but never
    for longer than `SETTLE_WITHIN`.
    """

    def __init__(
        self, *, limits: Limits, on_change: Callable[[], None], on_run: Callable[[Assembly, Run], None],
        on_settled: Callable[[Assembly, Run], None],
    ) -> None:  # fmt: skip
        self._limits, self._on_change, self._on_run, self._on_settled = limits, on_change, on_run, on_settled
        self._settled_at = 0.0
        self._wake = threading.Condition()
        self._pending: Assembly | None = None
        self._touched = self._closed = False
        self._control: Control | None = None
        self._began = 0.0
        self._last: tuple[Assembly, float] | None = None
        self._thread = threading.Thread(target=self._work, name="session-runner", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether a design waits or is being simulated."""
        with self._wake:
            return self._pending is not None or self._control is not None

    def submit(self, assembly: Assembly) -> None:
        """Simulate this next, in place of any that waits."""
        with self._wake:
            self._pending = assembly
            control = self._control
            left = self._began + GRACE - time.monotonic()
            self._wake.notify()
        if control is not None:
            if left <= 0.0:
                control.cancel()
            else:
                timer = threading.Timer(left, control.cancel)
                timer.daemon = True
                timer.start()

    def touch(self) -> None:
        """Call `on_change` without a simulation."""
        with self._wake:
            self._touched = True
            self._wake.notify()

    def close(self) -> None:
        """Stop the thread; a running simulation is cancelled."""
        with self._wake:
            self._closed = True
            self._wake.notify()
            if self._control is not None:
                self._control.cancel()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5.0)

    def _work(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._pending is not None or self._touched or self._closed)
                if self._closed:
                    return
                touched, self._touched = self._touched, False
                quick = not touched and self._pending is not None and self._is_quick(self._pending)
            try:
                if not quick:
                    self._on_change()
                self._simulate_newest()
            except Exception:  # a view's mistake must not end the session's only worker
                log.exception("a session's worker failed")

    def _is_quick(self, assembly: Assembly) -> bool:
        """Whether a design's run will be quick, as that of the last design with this duration and solver was."""
        if self._last is None:
            return False
        last, elapsed = self._last
        mission, before = assembly.design.mission, last.design.mission
        return elapsed < QUICK and mission.duration == before.duration and mission.solver == before.solver

    def _take(self) -> Assembly | None:
        """Return the newest design once the kernel is ready; None where there is none, or views must hear first."""
        with self._wake:
            while self._pending is not None and not kernel_is_ready():
                self._wake.wait(KERNEL_POLL)
                if self._closed or self._touched:
                    return None
            assembly, self._pending = self._pending, None
            if assembly is not None:
                self._control, self._began = Control(), time.monotonic()
            return assembly

    def _simulate_newest(self) -> None:
        assembly = self._take()
        if assembly is None:
            return
        try:
            run = run_assembly(assembly, limits=self._limits, control=self._control)
        finally:
            with self._wake:
                self._control = None
        self._last = assembly, time.monotonic() - self._began
        if run.status is Status.cancelled:
            self._on_change()
        else:
            with ONE_AT_A_TIME:
                self._on_run(assembly, run)
                if self._pending is None or time.monotonic() - self._settled_at > SETTLE_WITHIN:
                    self._on_settled(assembly, run)
                    self._settled_at = time.monotonic()
