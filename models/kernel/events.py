"""Owns events: the body origin reaches the surface or the bed, which may end a run, or a part reaches a stop.

A controller adds its own: it begins a dive or a climb, or a leg of its way ends (control.py).
"""

from __future__ import annotations

from models.kernel.choice import select
from models.kernel.jit import compiled, internal
from models.kernel.step import interpolate_one, make_dense

NOTHING, SURFACE, BED, STOP, DIVE, CLIMB, LEG_ENDED = range(7)
EVENT = 1
"""Where `Record.counts` counts events."""
SURFACE_SLACK = 1e-9
"""The surface event fires this far above z = 0 (m), so that rounding in a glider floating at rest does not fire it."""
STOP_SHARE = 1e-6
"""A part has reached a stop within this share of its stroke: a lagging part only ever tends to its command."""


@internal
def distance_to(kind, z, p):
    """Return how far the event is away, m; negative once it has happened."""
    s = p.space[0]
    return z - s.surface_level + SURFACE_SLACK if kind == SURFACE else s.bed_depth - z


@internal
def event_due(y, y1, p, work):
    """Whether the body origin meets the surface or the bed between two states; after a meeting it must first leave."""
    s = p.space[0]
    z = y1[s.depth]
    work.armed[0] = select(z >= s.rearm_level, 1, work.armed[0])
    work.armed[1] = select(z <= s.bed_depth - s.rearm_level, 1, work.armed[1])
    return met(SURFACE, y, y1, p, work) | met(BED, y, y1, p, work)


@internal
def met(kind, y, y1, p, work):
    """Whether the body origin meets the surface, or the bed, between two states."""
    z = p.space[0].depth
    armed = work.armed[0 if kind == SURFACE else 1] == 1
    return armed & (distance_to(kind, y1[z], p) < 0.0) & (distance_to(kind, y[z], p) >= 0.0)


@internal
def ends_run(kind, p):
    """Whether an event ends the run."""
    return (p.space[0].surface_ends if kind == SURFACE else p.space[0].bed_ends) != 0


@compiled
def find_event(pair, h, y, p, work):
    """Return the kind of the event within the step from y to `work.y1`, and at which fraction of it that happens."""
    z = p.space[0].depth
    kind = SURFACE if met(SURFACE, y, work.y1, p, work) else BED
    work.armed[0 if kind == SURFACE else 1] = 0
    make_dense(pair, h, y, work)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if distance_to(kind, interpolate_one(middle, y, work.dense, z), p) < 0.0:
            high = middle
        else:
            low = middle
    return kind, high


@internal
def stop_side(e, part):
    """Return -1 or 1 where the extension is at the lower or upper stop, else 0."""
    slack = STOP_SHARE * (part.stop_high - part.stop_low)
    return select(e <= part.stop_low + slack, -1, select(e >= part.stop_high - slack, 1, 0))


@internal
def note_stops(y, p, work):
    """Note where the parts are, without an event."""
    first = p.space[0].extensions
    for i in range(p.parts.shape[0]):
        work.at_stop[i] = stop_side(y[first + i], p.parts[i])


@internal
def stop_is_new(y, p, work):
    """Whether some part's place at its stops differs from the noted one."""
    changed = False
    first = p.space[0].extensions
    for i in range(p.parts.shape[0]):
        changed |= stop_side(y[first + i], p.parts[i]) != work.at_stop[i]
    return changed


@compiled
def scan_stops(t, h, y, y1, p, work, record):
    """Record which parts reached a stop between t (state y) and t + h (state y1); one at rest there is recorded once.

    With h = 0 the states are the same instant; else `work.dense` must hold the step's polynomial.
    """
    first = p.space[0].extensions
    for i in range(p.parts.shape[0]):
        side = stop_side(y1[first + i], p.parts[i])
        if side != 0 and side != work.at_stop[i]:
            low, high = 0.0, 1.0
            for _ in range(50 if h > 0.0 else 0):
                middle = 0.5 * (low + high)
                if stop_side(interpolate_one(middle, y, work.dense, first + i), p.parts[i]) == side:
                    high = middle
                else:
                    low = middle
            if record.counts[EVENT] < record.events.shape[0] - 1:  # the last row is kept for the end of the run
                add_event(t + high * h, STOP, i, record)
        work.at_stop[i] = side


@internal
def add_event(t, kind, part, record):
    """Append one event."""
    row = record.counts[EVENT]
    record.events[row, 0] = t
    record.events[row, 1] = kind
    record.events[row, 2] = part
    record.counts[EVENT] = row + 1
