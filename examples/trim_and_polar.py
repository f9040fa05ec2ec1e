"""Find steady motions of the quad-bellows glider, and its best glides: `python examples/trim_and_polar.py`."""

from __future__ import annotations

import math

from models.glide_polar import glide_polar
from models.presets import load_preset
from models.targeted_trim import trim_for
from models.trim import find_trims

design = load_preset("quad-bellows-glide")
cells = [part.name for _, part in design.vehicle.actuated]
heavy_nose = dict(zip(cells, (0.015, 0.015, 0.028, 0.028), strict=True))  # m

found = find_trims(design, extensions=heavy_nose, depth=30.0)
print(found.searched)
for trim in found.solutions:
    print(f"  {trim}")

turn = trim_for(design, {"glide_angle": math.radians(-25.0), "speed": 0.3, "turn_radius": 25.0}, cells, depth=30.0)
print(f"a spiral of 25 m: {turn}")
too_fast = trim_for(design, {"glide_angle": math.radians(-25.0), "speed": 2.0}, cells, depth=30.0)
print(f"2 m/s: {too_fast}")

polar = glide_polar(design, points=30, depth=30.0, cycle_depth=100.0)
for name in ("best_range", "slowest_sink", "tightest_turn"):
    print(f"{name}: {getattr(polar, name)}")
best = polar.best_energy
assert best is not None
print(f"least energy: {best.per_km:.0f} J/km ({polar.energy}): {best.trim}")
