"""Owns the control laws: loops over pitch, bank and heading with allocation to the cells, and state feedback."""

from __future__ import annotations

import math

from models.kernel.allocate import BASE, HIGH, LOW, PART, SPAN, allocate
from models.kernel.control_layout import (
    HEADING_INTEGRAL,
    HEADING_TARGET,
    HEAVE_MISSING,
    HEAVE_WANTED,
    MEASURED,
    NO_LATERAL,
    PHASE,
    PITCH,
    PITCH_CUT,
    PITCH_INTEGRAL,
    PITCH_MISSING,
    PITCH_RATE,
    PITCH_TARGET,
    PITCH_WANTED,
    ROLL,
    ROLL_CUT,
    ROLL_INTEGRAL,
    ROLL_MISSING,
    ROLL_RATE,
    ROLL_TARGET,
    ROLL_WANTED,
    SET_POINT,
    SHOWN,
    YAW,
    YAW_RATE,
)
from models.kernel.guidance import wrapped
from models.kernel.jit import internal
from models.kernel.search import last_not_above


@internal
def clipped(value, limit):
    """Return a value within -limit to limit."""
    return min(max(value, -limit), limit)


@internal
def wound(integral, gain, error, missing, limit, c):
    """Return an integral after a sample: it follows the error, and gives back what was asked for and not done.

    That is anti-windup by back-calculation (Astrom, Hagglund, 2006, Advanced PID Control, 3.5). Without a gain there is
    nothing to wind up.
    """
    if gain == 0.0:
        return 0.0
    return clipped(integral + c.sample_time * (gain * error - c.unwind * missing), limit)


@internal
def bank_for_heading(seen, c, memory):
    """Set the bank that turns the glider to its heading; what the bank's limit cuts off unwinds the integral."""
    climbing = memory[PHASE] != 0.0
    at = HEADING_INTEGRAL + (1 if climbing else 0)
    error = wrapped(memory[HEADING_TARGET] - seen[YAW])
    asked = c.heading_p * error + memory[at] - c.heading_d * seen[YAW_RATE]
    given = clipped(asked, c.bank_limit)
    memory[at] = wound(memory[at], c.heading_i, error, asked - given, c.bank_limit, c)
    memory[ROLL_TARGET] = given * (c.climb_bank_sign if climbing else 1.0)


@internal
def ask_of_cells(seen, c, memory):
    """Set heave, pitch and roll moment that are wanted of the cells; return the errors of pitch and roll.

    What their limits cut off is kept for `wind_up`.
    """
    climbing = memory[PHASE] != 0.0
    phase = 1 if climbing else 0
    memory[HEAVE_WANTED] = c.climb_heave if climbing else c.dive_heave
    memory[PITCH_WANTED] = c.climb_moment if climbing else c.dive_moment
    memory[ROLL_WANTED] = 0.0
    pitch_error = roll_error = 0.0
    if c.holds_pitch != 0:
        pitch_error = memory[PITCH_TARGET] - seen[PITCH]
        asked = c.pitch_p * pitch_error + memory[PITCH_INTEGRAL + phase] - c.pitch_d * seen[PITCH_RATE]
        asked += memory[PITCH_WANTED]
        memory[PITCH_WANTED] = clipped(asked, c.pitch_limit)
        memory[PITCH_CUT] = asked - memory[PITCH_WANTED]
    if c.lateral != NO_LATERAL:
        roll_error = memory[ROLL_TARGET] - seen[ROLL]
        asked = c.roll_p * roll_error + memory[ROLL_INTEGRAL + phase] - c.roll_d * seen[ROLL_RATE]
        memory[ROLL_WANTED] = clipped(asked, c.roll_limit)
        memory[ROLL_CUT] = asked - memory[ROLL_WANTED]
    return pitch_error, roll_error


@internal
def share_among_cells(c, cells, memory, share, out):
    """Write the extensions that make what is wanted into `out`, by part, and note what they leave missing."""
    missing = allocate(
        cells, c.heave_scale * memory[HEAVE_WANTED], c.pitch_scale * memory[PITCH_WANTED],
        c.roll_scale * memory[ROLL_WANTED], share,
    )  # fmt: skip
    memory[HEAVE_MISSING] = missing[0] / c.heave_scale
    memory[PITCH_MISSING] = missing[1] / c.pitch_scale
    memory[ROLL_MISSING] = missing[2] / c.roll_scale
    for i in range(cells.shape[0]):
        row = cells[i]
        out[int(row[PART])] = row[BASE] + share[i] * row[SPAN]


@internal
def wind_up(c, memory, pitch_error, roll_error):
    """Advance the integrals: by the errors, and back by what limits and stops cut off."""
    phase = 1 if memory[PHASE] != 0.0 else 0
    if c.holds_pitch != 0:
        i = PITCH_INTEGRAL + phase
        missing = memory[PITCH_CUT] + memory[PITCH_MISSING]
        memory[i] = wound(memory[i], c.pitch_i, pitch_error, missing, c.pitch_limit, c)
    if c.lateral != NO_LATERAL:
        i = ROLL_INTEGRAL + phase
        missing = memory[ROLL_CUT] + memory[ROLL_MISSING]
        memory[i] = wound(memory[i], c.roll_i, roll_error, missing, c.roll_limit, c)


@internal
def blended(gains, low, share, j):
    """Return column j of the table of gains between two of its rows."""
    if share == 0.0:
        return gains[low, j]
    return gains[low, j] + share * (gains[low + 1, j] - gains[low, j])


@internal
def set_point(t, setpoints):
    """Return the value asked for at a time: linear between the set points, held beyond them."""
    j = last_not_above(t, setpoints[:, 0])
    if j + 1 >= setpoints.shape[0] or t <= setpoints[0, 0]:
        return setpoints[j, 1]
    share = (t - setpoints[j, 0]) / (setpoints[j + 1, 0] - setpoints[j, 0])
    return setpoints[j, 1] + share * (setpoints[j + 1, 1] - setpoints[j, 1])


@internal
def departure(seen, y, k, chosen, first, low, share, gains, cells):
    """Return how far chosen state k is from its trim: one of those measured, or the extension of a cell."""
    code = chosen[k]
    at_trim = blended(gains, low, share, 1 + cells + k)
    if code >= MEASURED:
        return y[first + code - MEASURED] - at_trim
    return wrapped(seen[code] - at_trim) if code == YAW else seen[code] - at_trim


@internal
def feed_back(t, seen, y, c, cells, gains, setpoints, chosen, first, memory, over, out):
    """Write e = e0 - K (x - x0) - K_I (integral of the first errors) into `out`, by part.

    A row of `gains` is [value of the set point, e0 (cells), x0 (states), K (cells by states and integrals)]. An
    integral stands still while it would push a cell farther beyond its stop; `over` (cells,) is scratch.
    """
    n, m, k_i = cells.shape[0], chosen.shape[0], c.integrals
    value = set_point(t, setpoints)
    for j in range(SHOWN):
        memory[j] = math.nan
    memory[SET_POINT] = value
    low = last_not_above(value, gains[:, 0])
    share = 0.0
    if low + 1 < gains.shape[0]:
        share = clipped((value - gains[low, 0]) / (gains[low + 1, 0] - gains[low, 0]), 1.0)
        share = max(share, 0.0)
    for i in range(n):
        at = 1 + n + m + i * (m + k_i)
        command = blended(gains, low, share, 1 + i)
        for k in range(m):
            command -= blended(gains, low, share, at + k) * departure(seen, y, k, chosen, first, low, share, gains, n)
        for k in range(k_i):
            command -= blended(gains, low, share, at + m + k) * memory[PITCH_INTEGRAL + k]
        lowest = cells[i, BASE] + cells[i, SPAN] * cells[i, LOW]
        highest = cells[i, BASE] + cells[i, SPAN] * cells[i, HIGH]
        over[i] = 1.0 if command >= highest else (-1.0 if command <= lowest else 0.0)
        out[int(cells[i, PART])] = min(max(command, lowest), highest)
    for k in range(k_i):
        step = c.sample_time * departure(seen, y, k, chosen, first, low, share, gains, n)
        worse = False
        for i in range(n):
            worse |= over[i] * blended(gains, low, share, 1 + n + m + i * (m + k_i) + m + k) * step < 0.0
        if not worse:
            memory[PITCH_INTEGRAL + k] += step
