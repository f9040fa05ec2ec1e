"""Owns how a moment of a run is told: in seconds of a short run, as minutes or hours on a clock of a longer one.

The studio's time axis, readouts and marks follow the same rule (static/format.js). Durations are told in seconds.
"""

from __future__ import annotations

SHORT, MIDDLING = 180.0, 3.0 * 3600.0
"""Up to how long a run is told in seconds, and in minutes, s."""


def moment_in_words(t: float, end: float, *, unit: bool = True) -> str:
    """Return a moment t (s) of a run that ends at `end` (s): 16.2 s, 9:36 min, 1:02:03 h."""
    if end <= SHORT:
        return f"{t:.4g} s" if unit else f"{t:.4g}"
    whole, sign = int(abs(t) + 1e-9), "-" if t <= -1.0 else ""
    if end <= MIDDLING:
        return f"{sign}{whole // 60}:{whole % 60:02d}{' min' if unit else ''}"
    return f"{sign}{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d}{' h' if unit else ''}"


def stretch_in_words(start: float, stop: float, end: float) -> str:
    """Return a stretch of time of such a run: 16.2 to 32.6 s, 9:36 to 10:00 min."""
    return f"{moment_in_words(start, end, unit=False)} to {moment_in_words(stop, end)}"
