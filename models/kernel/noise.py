"""Owns random numbers: normal, each a function of seed, sample and channel alone, so that runs repeat anywhere."""

from __future__ import annotations

import math

import numba
import numpy as np

from models.kernel.jit import compiled, internal

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST_MIX = np.uint64(0xBF58476D1CE4E5B9)
SECOND_MIX = np.uint64(0x94D049BB133111EB)


@internal
def scrambled(x):
    """Return the mix of 64 bits that ends SplitMix64 (Steele, Lea, Flood, 2014)."""
    x = (x ^ (x >> np.uint64(30))) * FIRST_MIX
    x = (x ^ (x >> np.uint64(27))) * SECOND_MIX
    return x ^ (x >> np.uint64(31))


@compiled
def normal(seed, sample, channel):
    """Return a normal number of mean 0 and deviation 1 (Box, Muller, 1958)."""
    key = scrambled(np.uint64(seed) * GOLDEN + np.uint64(sample))
    first = scrambled(key + GOLDEN * np.uint64(2 * channel + 1))
    second = scrambled(key + GOLDEN * np.uint64(2 * channel + 2))
    u = (np.float64(first >> np.uint64(11)) + 0.5) * (1.0 / 9007199254740992.0)
    v = np.float64(second >> np.uint64(11)) * (1.0 / 9007199254740992.0)
    return math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * v)


if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]  # as plain Python the products, which are meant to wrap around, would warn
    scrambled, normal = np.errstate(over="ignore")(scrambled), np.errstate(over="ignore")(normal)
