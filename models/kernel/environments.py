"""Owns many gliders at once, each told its commands from outside: one call advances all of them by a sample time."""

from __future__ import annotations

import math

from models.kernel.allocate import BASE, PART, SPAN, allocate
from models.kernel.control import see
from models.kernel.events import note_stops
from models.kernel.integrate import COMPLETED, SAMPLES, integrate
from models.kernel.jit import compiled


@compiled
def advance_many(pair, times, span, step, max_steps, states, told, codes, seen, p, work, record):
    """Advance every row of `states` (m, n) in place by `span` (s) with RK4 steps of `step` (s), or by the pair.

    `max_steps` bounds the steps of each row, `codes` (m,) get how each ended. `times` (m,) s is advanced too; `told`
    (m, parts) are the commands held meanwhile, NaN for a part that follows its schedule. `seen` (m, MEASURED) gets what
    ideal instruments measure afterwards. A row whose code is not that of a completed run when the call begins has
    ended, and is left as it is. `work` and `record` are scratch; the record needs no room.
    """
    for i in range(states.shape[0]):
        if codes[i] != COMPLETED:
            continue
        y = states[i]
        for j in range(work.told.shape[0]):
            work.told[j] = told[i, j]
        for j in range(record.counts.shape[0]):
            record.counts[j] = 0
        record.counts[SAMPLES] = record.times.shape[0]
        work.armed[0] = work.armed[1] = 1  # the row before may have met the surface or the bed
        note_stops(y, p, work)
        until = times[i] + span
        codes[i] = integrate(pair, times[i], until, step, math.inf, max_steps, y, p, work, record)
        times[i] = until
        see(until, y, p, seen[i])


@compiled
def allocate_many(wishes, cells, share, told):
    """Write the extensions that make each scaled wish (m, 3) into `told` (m, parts), as far as the stops allow.

    `cells` are rows of allocate.py; `share` (at least as many) is scratch. Parts not among them are left.
    """
    for i in range(wishes.shape[0]):
        allocate(cells, wishes[i, 0], wishes[i, 1], wishes[i, 2], share)
        for k in range(cells.shape[0]):
            told[i, int(cells[k, PART])] = cells[k, BASE] + share[k] * cells[k, SPAN]
