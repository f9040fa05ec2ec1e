"""Owns the section of docs/control.md that says what the controller does not do."""

from __future__ import annotations


def section() -> str:
    """Return the section."""
    return """## Limits

- Place, depth and attitude are measured without bias; place is known under water. What a real glider does between
  fixes is not modelled.
- The allocation takes each cell's effect at neutral, level, at the surface's density: in a pitched dive moments are
  smaller by the cosine of pitch, which the loops make up for.
- It asks where the cells shall be, not how they get there: each runs at its own rate limit, so pitch and bank change
  last where heave changes most.
- Anti-windup knows the loops' limits and what the cells cannot do, not how fast they get there: a slow integral in
  pitch can creep from dive to dive while cells travel.
- The gains are tuned for the quad glider in its own water, by hand. Nothing here proves that they are robust; delays
  beyond a second or two and larger gains make pitch swing (`tests/models/test_guidance.py`).
- The wish for heave knows nothing of the water: where density changes with depth, so does speed.
- No surfacing for a fix or a call, no obstacle, no bottom avoidance: below the band it turns, above the bed it does not
  look.
"""
