"""Owns the one way functions are compiled: cached on disk, fused multiply-add allowed, nothing that hides a NaN.

`fastmath=True` would delete isfinite and reorder the range reduction of `sincos`; only contraction is allowed.
"""

from __future__ import annotations

import numba

compiled = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
inlined = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
