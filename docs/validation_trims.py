"""Owns the trims of check 7 of docs/validation.md: the Seawing's spiral as a root, held against the simulated one."""

from __future__ import annotations

from functools import cache

from docs import validation_seawing as seawing
from models.trim import Trim, find_trims

DEMANDED = 1e-6
"""Largest difference of roll and pitch (rad), velocities (m/s) and turn rate (rad/s)."""


@cache
def spiral_trims() -> tuple[Trim, ...]:
    """Return the stable trims of the spiral's design."""
    return find_trims(seawing.spiral_design()).stable


def differences(trim: Trim) -> dict[str, float]:
    """Return how far a trim is from the end of the simulated spiral, by state: rad, m/s, rad/s."""
    final = seawing.spiral().final
    found = {"phi": trim.roll, "theta": trim.pitch, "turn_rate": trim.turn_rate}
    found |= dict(zip("uvw", trim.velocity.tolist(), strict=True))
    return {name: abs(value - final[name]) for name, value in found.items()}


@cache
def largest_difference() -> float:
    """Return the largest difference of the trim nearest to the simulated spiral."""
    return min(max(differences(trim).values()) for trim in spiral_trims())
