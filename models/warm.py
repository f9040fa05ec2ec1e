"""Owns the compilation of the kernel: started once in the background, so that a page can be up and say so."""

from __future__ import annotations

import threading

from models.presets import load_preset, preset_ids
from models.simulate import simulate

_lock = threading.Lock()
_ready = threading.Event()


def kernel_is_ready() -> bool:
    """Whether the kernel is compiled (or loaded from its cache) in this process."""
    return _ready.is_set()


def warm_kernel() -> None:
    """Compile the kernel or load it from its cache; returns once it is ready. Safe to call from any thread."""
    with _lock:
        if not _ready.is_set():
            simulate(load_preset(preset_ids()[0]))
            _ready.set()


def warm_kernel_in_background() -> threading.Thread:
    """Start `warm_kernel` in a thread of its own and return that."""
    thread = threading.Thread(target=warm_kernel, name="kernel-warm-up", daemon=True)
    thread.start()
    return thread
