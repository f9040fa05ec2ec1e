"""Owns the records of closed-loop control: what a controller is told once, and what it remembers from sample to sample.

A controller samples the glider every `sample_time`, works out commands, and hands them to the actuators after `delay`;
until the next they are held. Angles in rad, forces and moments in N and N m.
"""

from __future__ import annotations

import numpy as np

NONE, CASCADE, FEEDBACK = range(3)
"""Kinds of controller: none, guidance with loops and allocation, state feedback from a table of gains."""
HOLD_HEAVE, DEPTH_BAND = range(2)
"""Vertical guidance."""
NO_LATERAL, HOLD_ROLL, HOLD_HEADING, WAYPOINTS, STATION = range(5)
"""Lateral guidance."""

DEPTH, ROLL, PITCH, YAW, SURGE, SWAY, HEAVE, ROLL_RATE, PITCH_RATE, YAW_RATE, NORTH, EAST = range(12)
MEASURED = 12
"""What is measured: depth (m), attitude (rad), velocity through the water, angular velocity (body axes), place (m)."""

_CONTROL_REALS = (
    "sample_time", "delay", "deadband", "unwind",
    "noise_depth", "noise_attitude", "noise_velocity", "noise_rate", "noise_place",
    "top", "bottom", "dive_heave", "climb_heave",
    "dive_pitch", "climb_pitch", "dive_moment", "climb_moment",
    "pitch_p", "pitch_i", "pitch_d", "pitch_limit",
    "roll_p", "roll_i", "roll_d", "roll_limit",
    "heading_p", "heading_i", "heading_d", "bank_limit", "climb_bank_sign",
    "lateral_target", "arrival", "lookahead", "path_integral",
    "center_x", "center_y", "station_radius", "station_bank",
    "heave_scale", "pitch_scale", "roll_scale",
)  # fmt: skip
_CONTROL_INTEGERS = ("kind", "seed", "vertical", "holds_pitch", "lateral", "repeats", "starts_climbing", "integrals")
CONTROL = np.dtype((np.record, [(n, np.float64) for n in _CONTROL_REALS] + [(n, np.int64) for n in _CONTROL_INTEGERS]))
"""Scalars of the controller. `*_scale` is by what a wish is multiplied for the allocation; `unwind` (1/s) how fast an
integral gives back what the cells cannot do."""

(
    PHASE, PITCH_TARGET, ROLL_TARGET, HEADING_TARGET,
    HEAVE_WANTED, PITCH_WANTED, ROLL_WANTED, HEAVE_MISSING, PITCH_MISSING, ROLL_MISSING, LEG, SET_POINT,
) = range(12)  # fmt: skip
SHOWN = 12
"""First entries of the memory, which a result shows: phase (0 dive, 1 climb), targets, what was asked of the cells and
what they could not do, the leg of the way, and the set point of state feedback."""
PITCH_INTEGRAL, ROLL_INTEGRAL, HEADING_INTEGRAL = 12, 14, 16
"""Integrals, one for dives and one for climbs; the state feedback's begin at the first."""
PATH_INTEGRAL, AWAY, FROM_X, FROM_Y = 18, 19, 20, 21
PITCH_CUT, ROLL_CUT = 22, 23
"""What the limits of the loops cut off."""
MEMORY = 32

SAMPLED, APPLIED, NEXT_STEP, LAST_ERROR = range(4)
CLOCK = 4
"""Samples taken, samples handed to the actuators, and the integrator's next step and last error, kept between calls."""
MOST_PENDING = 64
"""Samples that may wait for their delay."""
