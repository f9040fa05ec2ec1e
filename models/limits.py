"""Owns the limits on what a design may ask of the program; they are settings, and every message names them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """Largest design and mission that is accepted.

    `samples` bounds the result in time, `numbers` in memory (samples times columns); `steps` bounds the integrator:
    about a second of computing for a planar glide with two cells.
    """

    components: int = 256
    schedule_points: int = 10_000
    table_rows: int = 10_000
    duration: float = 7 * 86_400.0
    samples: int = 500_000
    numbers: int = 20_000_000
    steps: int = 5_000_000


DEFAULT_LIMITS = Limits()
