"""Owns many gliders at once, each told its commands from outside: one call advances all of them by a sample time."""

from __future__ import annotations

import math

from models.kernel.control import see
from models.kernel.events import note_stops
from models.kernel.integrate import SAMPLES, integrate
from models.kernel.jit import compiled

MOST_STEPS = 1_000_000
"""Of RK4 within one sample time."""


@compiled
def advance_many(times, span, step, states, told, codes, seen, p, work, record):
    """Advance every row of `states` (m, n) in place by `span` (s) with RK4 steps of `step` (s); fill `codes` (m,).

    `times` (m,) s is advanced too; `told` (m, parts) are the commands held meanwhile, NaN for a part that follows its
    schedule. `seen` (m, MEASURED) gets what ideal instruments measure afterwards. `work` and `record` are scratch; the
    record needs no room.
    """
    for i in range(states.shape[0]):
        y = states[i]
        for j in range(work.told.shape[0]):
            work.told[j] = told[i, j]
        for j in range(record.counts.shape[0]):
            record.counts[j] = 0
        record.counts[SAMPLES] = record.times.shape[0]
        note_stops(y, p, work)
        until = times[i] + span
        codes[i] = integrate(False, times[i], until, step, math.inf, MOST_STEPS, y, p, work, record)
        times[i] = until
        see(until, y, p, seen[i])
