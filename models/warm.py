"""Owns the compilation of the kernel: started once in the background, so that a page can be up and say so.

On a machine's first start processes of their own compile: within this one the compiler would hold up every answer. What
simulates comes first, then what analyses (trim, linear models). What flies batches (lanes) is compiled by whoever runs
them (`warm_batch`).
"""

from __future__ import annotations

import hashlib
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

PRESETS = ("canete-dual-bellows", "quad-bellows-glide")
"""One of each model."""
_PLACE = hashlib.sha256(str(Path(__file__).parent).encode()).hexdigest()[:8]
"""Machine code is kept apart for each folder that the program lies in."""
SIMULATION_DONE = CACHE_FOLDER / f"simulation-{_PLACE}"
"""Stands in the cache once what simulates is compiled."""
ANALYSES_DONE = CACHE_FOLDER / f"analyses-{_PLACE}"
"""Stands in the cache once the analyses are compiled too."""
LANES_DONE = CACHE_FOLDER / f"lanes-{_PLACE}"
"""Stands in the cache once the lanes are compiled too."""
_lock, _analyses_lock, _lanes_lock = threading.Lock(), threading.Lock(), threading.Lock()
_ready, _analyses_ready, _lanes_ready = threading.Event(), threading.Event(), threading.Event()


def kernel_is_ready() -> bool:
    """Whether what simulates is compiled (or loaded from its cache) in this process."""
    return _ready.is_set()


def analyses_are_ready() -> bool:
    """Whether what analyses is compiled (or loaded from its cache) in this process."""
    return _analyses_ready.is_set()


def batch_is_compiled() -> bool:
    """Whether what flies batches is in the cache, or compiled by nobody, so that using it holds nobody up for long."""
    return _lanes_ready.is_set() or LANES_DONE.exists() or not _compiles()


def warm_kernel() -> None:
    """Compile what simulates or load it from its cache; returns once it is ready. Safe to call from any thread."""
    with _lock:
        if not _ready.is_set():
            if not SIMULATION_DONE.exists() and _compiles():
                _elsewhere("compile_here")
            compile_here()
            _ready.set()


def warm_analyses() -> None:
    """Compile or load what analyses, after what simulates; returns once it is ready. Safe to call from any thread."""
    if _analyses_ready.is_set():
        return
    warm_kernel()
    with _analyses_lock:
        if not _analyses_ready.is_set():
            if not ANALYSES_DONE.exists() and _compiles():
                _elsewhere("compile_analyses_here")
            if _compiles():
                compile_analyses_here()  # from its cache: else the first trim would hold everybody up for a second
            _analyses_ready.set()


def warm_batch() -> None:
    """Compile what flies batches, after what simulates; returns once it is in the cache. Safe to call from any thread.

    Before worker processes start, so that none of them compiles it for itself.
    """
    if _lanes_ready.is_set():
        return
    warm_kernel()
    with _lanes_lock:
        if not _lanes_ready.is_set():
            if not LANES_DONE.exists() and _compiles():
                _elsewhere("compile_lanes_here")
            _lanes_ready.set()


def warm_kernel_in_background() -> threading.Thread:
    """Start `warm_analyses`, and so `warm_kernel`, in a thread of its own and return that."""
    thread = threading.Thread(target=warm_analyses, name="kernel-warm-up", daemon=True)
    thread.start()
    return thread


def _compiles() -> bool:
    return not numba.config.DISABLE_JIT  # type: ignore[attr-defined]


def _elsewhere(function: str) -> None:
    """Fill the cache from another process; where that fails, this one compiles for itself."""
    root = str(Path(__file__).parents[1])
    path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", f"from models.warm import {function}; {function}()"]
    done = subprocess.run(command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        log.warning("the kernel could not be compiled in a process of its own: %s", done.stderr.strip()[-500:])


def compile_here() -> None:
    """Compile what simulates in this process, or load it from its cache, and leave it there: both models."""
    for preset_id in PRESETS:
        simulate(load_preset(preset_id))
    if _compiles():
        SIMULATION_DONE.touch()


def compile_analyses_here() -> None:
    """Compile what analyses in this process, or load it from its cache, and leave it there."""
    from models.allocation import allocate, effectiveness
    from models.linearize import linearize
    from models.operating_point import point_of
    from models.targeted_trim import TrimFailure, trim_for
    from models.trim import find_trims

    for preset_id in PRESETS:
        design = load_preset(preset_id)
        cells = effectiveness(design)
        allocate(cells, (0.0, 0.0, 0.0))
        find_trims(design)
        found = trim_for(design, {"glide_angle": -0.5}, cells.cells)
        if not isinstance(found, TrimFailure):
            linearize(design, point_of(found))
    if _compiles():
        ANALYSES_DONE.touch()


def compile_lanes_here() -> None:
    """Compile what flies batches in this process, or load it from its cache, and leave it there: both models."""
    from models.assemble import assemble
    from models.batch import run_batch

    for _run in run_batch([assemble(load_preset(preset_id)) for preset_id in PRESETS]):
        pass
    if _compiles():
        LANES_DONE.touch()
