"""Owns the search of an ordered table."""

from __future__ import annotations

from models.kernel.choice import any_of, select
from models.kernel.jit import internal


@internal
def last_not_above(value, ordered):
    """Return the index of the last entry that is not above a value, by bisection; 0 where the first is."""
    low, high = 0, ordered.shape[0]
    while any_of(high - low > 1):
        middle = (low + high) >> 1
        above = ordered[middle] > value
        low, high = select(above, low, middle), select(above, middle, high)
    return low
