"""Hold a heading across a current, and see what it takes: `python examples/hold_heading.py`."""

from __future__ import annotations

import math

import numpy as np

from models.energy import energy_bill
from models.presets import load_preset
from models.simulate import simulate

run = simulate(load_preset("quad-bellows-heading"))
values = run.values
second_dive = next(event.time for event in run.events if event.kind == "dive")
late = run.times >= second_dive
error = np.degrees(values["heading_target"] - values["psi"])[late]
north, east = (float(np.ptp(values[name][late])) for name in "xy")
missing = max(float(np.abs(values[f"{axis}_missing"][late]).max()) for axis in ("pitch_moment", "roll_moment"))
bill = energy_bill(run)
assert bill is not None and bill.whole.per_km is not None
heading, track = math.degrees(values["heading_target"][-1]), math.degrees(math.atan2(east, north))
print(f"heading {heading:.1f} deg, track over ground {track:.1f} deg")
print(f"heading error {np.sqrt(np.mean(error**2)):.2f} deg (rms), {np.abs(error).max():.2f} deg at most")
print(f"moments missing: at most {missing:.3f} N m")
print(f"battery {1e-3 * bill.whole.total:.1f} kJ, {1e-3 * bill.whole.per_km:.1f} kJ/km")
for spent in bill.dives:
    print(f"  {spent.begin:5.0f} s to {spent.end:5.0f} s: {spent.depth:5.1f} m deep, {1e-3 * spent.total:.2f} kJ")
