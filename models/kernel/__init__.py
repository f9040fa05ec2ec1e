"""The compiled kernel: floats and arrays only; it never raises. Importing it names the folder of its machine code.

Numba's cache does not notice an edit in a file that a cached function calls, so the folder carries a hash of all the
kernel's sources: a change of any of them compiles anew.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numba

_SOURCES = sorted(Path(__file__).parent.glob("*.py"))


def _hash_of_sources() -> str:
    digest = hashlib.sha256()
    for source in _SOURCES:
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


KERNEL_HASH = _hash_of_sources()
"""Identifies the kernel's sources; recorded in every result."""

_root = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
CACHE_FOLDER = Path(os.environ.get("GLIDER_STUDIO_KERNEL_CACHE") or Path(_root) / "glider-studio")
CACHE_FOLDER = CACHE_FOLDER / f"kernel-{KERNEL_HASH}-numba-{numba.__version__}"
numba.config.CACHE_DIR = str(CACHE_FOLDER)  # type: ignore[attr-defined]
# The state has about ten numbers: loops over it lose more to vector loads of freshly stored scalars than they gain.
numba.config.LOOP_VECTORIZE = 0  # type: ignore[attr-defined]
