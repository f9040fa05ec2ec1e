"""Owns the compilation of the kernel: started once in the background, so that a page can be up and say so.

On a machine's first start a process of its own compiles: within this one the compiler would hold up every answer.
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
from pathlib import Path

import numba

from models.kernel import CACHE_FOLDER
from models.presets import load_preset
from models.simulate import simulate

log = logging.getLogger(__name__)

_lock = threading.Lock()
_ready = threading.Event()


def kernel_is_ready() -> bool:
    """Whether the kernel is compiled (or loaded from its cache) in this process."""
    return _ready.is_set()


def warm_kernel() -> None:
    """Compile the kernel or load it from its cache; returns once it is ready. Safe to call from any thread."""
    with _lock:
        if not _ready.is_set():
            if not CACHE_FOLDER.exists() and not numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
                _compile_elsewhere()
            compile_here()
            _ready.set()


def warm_kernel_in_background() -> threading.Thread:
    """Start `warm_kernel` in a thread of its own and return that."""
    thread = threading.Thread(target=warm_kernel, name="kernel-warm-up", daemon=True)
    thread.start()
    return thread


def _compile_elsewhere() -> None:
    """Fill the cache from another process; where that fails, this one compiles for itself."""
    root = str(Path(__file__).parents[1])
    path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", "from models.warm import compile_here; compile_here()"]
    done = subprocess.run(command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        log.warning("the kernel could not be compiled in a process of its own: %s", done.stderr.strip()[-500:])


def compile_here() -> None:
    """Compile the kernel in this process, or load it from its cache, and leave it there: both models."""
    for preset_id in ("canete-dual-bellows", "quad-bellows-glide"):
        simulate(load_preset(preset_id))
