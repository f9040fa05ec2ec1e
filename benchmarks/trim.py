"""Speed of trims and glide polars on assembled designs, side by side: `python -m benchmarks.trim`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from benchmarks.timing import interleaved_times, spread
from models.assemble import assemble
from models.glide_polar import glide_polar, polar_curve
from models.presets import load_preset
from models.targeted_trim import trim_for
from models.trim import find_trims

DIVE = math.radians(-30.0)
GOALS = {"trim": 5.0, "polar": 100.0}
"""Milliseconds to stay below."""


def cases() -> dict[str, Callable[[], object]]:
    """Return what is timed, by words."""
    canete, quad, seawing = (
        assemble(load_preset(name)) for name in ("canete-dual-bellows", "quad-bellows-glide", "seawing-spiral")
    )
    two = canete.cells
    low = {"Front bellows": 0.0144, "Rear bellows": 0.0158}
    deep = {cell: 0.0112 if cell.startswith("Front") else 0.0275 for cell in quad.cells}
    turn = {"glide_angle": DIVE, "speed": 0.25, "turn_radius": 25.0}
    return {
        "trim, two cells in a plane": lambda: find_trims(canete, extensions=low),
        "trim, four cells in space": lambda: find_trims(quad, extensions=deep),
        "trim, the Seawing's spiral": lambda: find_trims(seawing),
        "trim for path and speed, two cells": lambda: trim_for(canete, {"glide_angle": DIVE, "speed": 0.07}, two),
        "trim for path and speed, four cells": lambda: trim_for(quad, {"glide_angle": DIVE, "speed": 0.3}, quad.cells),
        "trim for a turn, four cells": lambda: trim_for(quad, turn, quad.cells),
        "trim for a radius, the Seawing": lambda: trim_for(seawing, {"turn_radius": 150.0}, seawing.cells),
        "polar of 50 points, two cells": lambda: polar_curve(canete, -0.2),
        "polar of 50 points, four cells": lambda: polar_curve(quad, -3.8),
        "whole envelope, four cells": lambda: glide_polar(quad),
    }


def main() -> None:
    """Time everything in turns and print medians."""
    for name, values in interleaved_times(cases(), rounds=21).items():
        goal = GOALS.get(name.split()[0].strip(","))
        aim = f"   to reach: below {goal:g} ms" if goal else ""
        print(f"{name:<40} {1e3 * np.median(values):8.2f} ms ({spread(1e3 * values)}){aim}")


if __name__ == "__main__":
    main()
