"""Owns the layout of the spatial state, and the records that only the spatial model reads.

| symbol in code | words | unit | frame |
|---|---|---|---|
| x, y, z | position of the body origin | m | world |
| q0 ... q3 | unit quaternion, body to world, scalar first (Hamilton) | 1 | |
| u, v, w; p, q, r | velocity of the body origin; angular velocity | m/s, rad/s | body |
| work_actuators, work_water, work_bed | work done on the glider since the start | J | |
| e | extension of each actuated part | m or rad | along or about its axis |
| spent | energy that each part has taken from the battery | J | |
| k_x, k_y, k_z | the unit vector down, which is the third row of R (body to world) | 1 | body |
| S_x, S_y, S_z | first moment of mass about the origin | kg m | body |
| B, B_x, B_y, B_z | mass of displaced water and its first moment | kg, kg m | body |
| head | integral of rho g over depth as a part feels it: gauge pressure once it is immersed | Pa | |
"""

from __future__ import annotations

import numpy as np

X, Y, Z, Q0, Q1, Q2, Q3, U, V, W, P, Q, R, WORK_ACTUATORS, WORK_WATER, WORK_BED = range(16)
EXTENSIONS = 16
"""Index of the first extension; after the extensions come as many energies spent."""

POLAR, ANGLES, COEFFICIENTS = range(3)
"""Hydrodynamic sources."""

_SPACE_REALS = (
    "gravity", "surface_level", "rearm_level", "bed_depth", "bed_stiffness", "bed_damping",
    "mass", "mass_x", "mass_y", "mass_z",
    "ixx", "iyy", "izz", "ixy", "ixz", "iyz",
    "water_top", "per_spacing",
    "per_reference_density", "reference_x", "reference_y", "reference_z",
    "munk_plane", "munk_lateral", "munk_whole",
    "rate_none", "rate_speed", "rate_speed2",
)  # fmt: skip
_SPACE_INTEGERS = ("spatial", "depth", "work", "extensions", "surface_ends", "bed_ends", "source", "levels")
SPACE = np.dtype((np.record, [(n, np.float64) for n in _SPACE_REALS] + [(n, np.int64) for n in _SPACE_INTEGERS]))
"""Scalars of the run. Masses and moments are those of all parts that do not move; `spatial`, `depth`, `work` and
`extensions` tell the integrator, for either model, which equations hold and where the state keeps what."""

_MEMBER_REALS = (
    "axis_x", "axis_y", "axis_z",
    "moving_mass", "base_x", "base_y", "base_z",
    "perp_x", "perp_y", "perp_z", "cross_x", "cross_y", "cross_z",
    "x", "y", "z", "per_bulk", "half_height", "per_efficiency", "recovery", "moves", "rolls",
)  # fmt: skip
MEMBER = np.dtype((np.record, [(n, np.float64) for n in _MEMBER_REALS]))
"""What the spatial model knows of an actuated part beyond `PART`: its mass moves along the axis from `base`, or, where
it `rolls`, on the circle base + cos(travel) perp + sin(travel) cross; at (x, y, z) stays a cell's fixed volume."""

SOLID_COLUMNS = ("volume", "x", "y", "z", "per_bulk", "half_height")
"""Columns of `solids`: the parts that displace water and do not move."""
COEFFICIENT_NAMES = (
    "drag_zero", "drag_attack", "drag_sideslip", "side_sideslip", "lift_zero", "lift_attack",
    "roll_sideslip", "roll_rate", "pitch_zero", "pitch_attack", "pitch_rate", "pitch_rate_square",
    "yaw_sideslip", "yaw_rate",
)  # fmt: skip
"""Entries of `coefficients` for the coefficient form; the planar model reads entry 11, which LATERAL_NAMES leaves 0."""
LATERAL_NAMES = (
    "sway_sideslip", "sway_crossflow", "roll_sideslip", "roll_crossflow", "yaw_sideslip", "yaw_crossflow",
)  # fmt: skip
"""Entries of `coefficients` beside a table over the angle of attack."""
