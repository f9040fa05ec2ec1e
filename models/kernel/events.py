"""Owns events: the body origin reaches the surface or the bed (these end a run), or a part reaches a stop."""

from __future__ import annotations

from models.kernel.jit import compiled, inlined
from models.kernel.params import EXTENSIONS, Z
from models.kernel.step import interpolate_one, make_dense

NOTHING, SURFACE, BED, STOP = range(4)
SURFACE_SLACK = 1e-9
"""The surface event fires this far above z = 0 (m), so that rounding in a glider floating at rest does not fire it."""
STOP_SHARE = 1e-6
"""A part has reached a stop within this share of its stroke: a lagging part only ever tends to its command."""


@inlined
def distance_to(kind, z, p):
    """Return how far the event is away, m; negative once it has happened."""
    return z + SURFACE_SLACK if kind == SURFACE else p.body[0].bed_depth - z


@compiled
def find_event(pair, h, y, y1, k, p, dense):
    """Return the kind of the event within the step (0: none) and the fraction of the step where it happens."""
    kind = NOTHING
    if distance_to(SURFACE, y1[Z], p) < 0.0 and distance_to(SURFACE, y[Z], p) >= 0.0:
        kind = SURFACE
    elif distance_to(BED, y1[Z], p) < 0.0 and distance_to(BED, y[Z], p) >= 0.0:
        kind = BED
    if kind == NOTHING:
        return NOTHING, 1.0
    make_dense(pair, h, y, y1, k, dense)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if distance_to(kind, interpolate_one(middle, y, dense, Z), p) < 0.0:
            high = middle
        else:
            low = middle
    return kind, high


@inlined
def stop_side(e, part):
    """Return -1 or 1 where the extension is at the lower or upper stop, else 0."""
    slack = STOP_SHARE * (part.stop_high - part.stop_low)
    return -1 if e <= part.stop_low + slack else (1 if e >= part.stop_high - slack else 0)


@compiled
def scan_stops(t, h, y, y1, dense, p, at_stop, events, counts):
    """Note which parts reached a stop between t (state y) and t + h (state y1); one at rest there is noted once.

    With h = 0 the states are the same instant and `dense` is not read.
    """
    for i in range(p.parts.shape[0]):
        side = stop_side(y1[EXTENSIONS + i], p.parts[i])
        if side != 0 and side != at_stop[i]:
            low, high = 0.0, 1.0
            for _ in range(50 if h > 0.0 else 0):
                middle = 0.5 * (low + high)
                if stop_side(interpolate_one(middle, y, dense, EXTENSIONS + i), p.parts[i]) == side:
                    high = middle
                else:
                    low = middle
            if counts[1] < events.shape[0] - 1:
                events[counts[1], 0] = t + high * h
                events[counts[1], 1] = STOP
                events[counts[1], 2] = i
                counts[1] += 1
        at_stop[i] = side


@compiled
def stop_is_new(y1, p, at_stop):
    """Whether some part's place at its stops differs from the noted one."""
    for i in range(p.parts.shape[0]):
        if stop_side(y1[EXTENSIONS + i], p.parts[i]) != at_stop[i]:
            return True
    return False
