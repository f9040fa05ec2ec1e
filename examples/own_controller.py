"""Turn the quad-bellows glider to a heading by a controller written here: `python examples/own_controller.py`."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from models.allocation import allocate, effectiveness
from models.design import Design
from models.own_controller import Measurement, simulate_with
from models.presets import load_preset

HEADING, PITCH, HEAVE = math.radians(60.0), math.radians(-25.0), -3.0  # rad, rad, N


def without_schedules(design: Design, *, duration: float) -> Design:
    """Return a design whose cells are left to a controller."""
    control = design.mission.control.model_copy(update={"schedules": ()})
    mission = design.mission.model_copy(update={"control": control, "duration": duration})
    return design.model_copy(update={"mission": mission})


design = without_schedules(load_preset("quad-bellows-glide"), duration=240.0)
cells = effectiveness(design)


def hold_heading(seen: Measurement) -> Mapping[str, float]:
    """Bank into the turn, and share heave (N), pitch and roll moment (N m) among the cells."""
    error = math.remainder(HEADING - seen.yaw, 2.0 * math.pi)
    roll_rate, pitch_rate, yaw_rate = seen.angular_velocity
    bank = float(np.clip(0.6 * error - 3.0 * yaw_rate, -0.35, 0.35))
    pitch_moment = 2.0 * (PITCH - seen.pitch) - 4.0 * pitch_rate
    roll_moment = 1.0 * (bank - seen.roll) - 1.0 * roll_rate
    return allocate(cells, [HEAVE, pitch_moment, roll_moment]).extensions


run = simulate_with(design, hold_heading, sample_time=1.0, delay=0.2)
for time in (30.0, 60.0, 120.0, 240.0):
    heading, turning, roll = (
        math.degrees(np.interp(time, run.times, run.values[name])) for name in ("psi", "turn_rate", "phi")
    )
    print(f"at {time:3.0f} s: heading {heading:4.1f} deg, turning {turning:5.2f} deg/s, roll {roll:4.1f} deg")
