"""Owns the one way functions are compiled: cached on disk, fused multiply-add allowed, nothing that hides a NaN.

`fastmath=True` would delete isfinite and reorder the range reduction of `sincos`; only contraction is allowed.
"""

from __future__ import annotations

from typing import Any

import numba

# Without reference counts on arrays (`_nrt=False`): their atomic operations took half of a step, and nothing is
# allocated here.
_options: dict[str, Any] = {
    "cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract"}, "_nrt": False,
}  # fmt: skip
compiled = numba.njit(**_options)
inlined = numba.njit(forceinline=True, **_options)
# Without the wrappers through which Python would call it: unpacking the records costs more to compile than most of what
# stands inside.
_unseen: dict[str, Any] = _options | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
internal = numba.njit(forceinline=True, **_unseen)
