"""Owns a worker's life (one thread, no keyboard interrupts, no longer than its parent's), and what it runs on."""

from __future__ import annotations

import os
import signal
import threading
import time

WATCH_EVERY = 0.5
"""How often a worker looks whether its parent lives, s."""
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def processor() -> str:
    """Return the kind of processor that the kernel is compiled for here, such as znver3."""
    from llvmlite.binding import get_host_cpu_name

    name: str = get_host_cpu_name()
    return name


def begin_worker(parent: int) -> None:
    """Set a pool's process up; it ends itself once `parent` has gone, which a spawned process else outlives."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), name="parent-watch", daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(WATCH_EVERY)
    os._exit(1)
