"""Owns guidance: which phase a glide is in, and which pitch, bank and heading it should have there."""

from __future__ import annotations

import math

from models.kernel.control_layout import (
    AWAY,
    DEPTH,
    DEPTH_BAND,
    EAST,
    FROM_X,
    FROM_Y,
    HEADING_TARGET,
    HOLD_HEADING,
    HOLD_ROLL,
    LEG,
    NORTH,
    PATH_INTEGRAL,
    PHASE,
    PITCH_TARGET,
    ROLL_TARGET,
    STATION,
    WAYPOINTS,
)
from models.kernel.jit import internal

BACK_SHARE = 0.5
"""Share of its radius within which a glider on station stops heading back."""


@internal
def wrapped(angle):
    """Return an angle within -pi to pi."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@internal
def choose_phase(seen, c, memory):
    """Turn to the climb below the band and to the dive above it; return whether the phase changed."""
    before = memory[PHASE]
    if c.vertical == DEPTH_BAND:
        if seen[DEPTH] >= c.bottom:
            memory[PHASE] = 1.0
        elif seen[DEPTH] <= c.top:
            memory[PHASE] = 0.0
    climbing = memory[PHASE] != 0.0
    memory[PITCH_TARGET] = c.climb_pitch if climbing else c.dive_pitch
    return memory[PHASE] != before


@internal
def next_leg(seen, c, waypoints, memory):
    """Go to the next waypoint where this one is reached or passed; return whether that happened."""
    leg = int(memory[LEG])
    if leg >= waypoints.shape[0]:
        return False
    to_x, to_y = waypoints[leg, 0] - seen[NORTH], waypoints[leg, 1] - seen[EAST]
    along_x, along_y = waypoints[leg, 0] - memory[FROM_X], waypoints[leg, 1] - memory[FROM_Y]
    passed = to_x * along_x + to_y * along_y <= 0.0
    if not (passed or math.hypot(to_x, to_y) <= c.arrival):
        return False
    if leg + 1 < waypoints.shape[0] or c.repeats != 0:
        memory[FROM_X], memory[FROM_Y] = waypoints[leg, 0], waypoints[leg, 1]
        memory[LEG] = (leg + 1) % waypoints.shape[0]
        memory[PATH_INTEGRAL] = 0.0
    else:
        memory[LEG] = leg + 1  # beyond the last: on along its leg
    return True


@internal
def heading_along(seen, c, waypoints, memory):
    """Return the heading along the leg by integral line of sight (Borhaug, Pavlov, Pettersen, 2008).

    Without a lookahead it is straight for the waypoint, and past the last one the course of its leg.
    """
    done = int(memory[LEG]) >= waypoints.shape[0]
    leg = min(int(memory[LEG]), waypoints.shape[0] - 1)
    course = math.atan2(waypoints[leg, 1] - memory[FROM_Y], waypoints[leg, 0] - memory[FROM_X])
    if c.lookahead <= 0.0:
        if done:
            return course
        return math.atan2(waypoints[leg, 1] - seen[EAST], waypoints[leg, 0] - seen[NORTH])
    off_x, off_y = seen[NORTH] - memory[FROM_X], seen[EAST] - memory[FROM_Y]
    across = math.cos(course) * off_y - math.sin(course) * off_x
    aimed = across + c.path_integral * memory[PATH_INTEGRAL]
    memory[PATH_INTEGRAL] += c.sample_time * c.lookahead * across / (aimed * aimed + c.lookahead * c.lookahead)
    return wrapped(course - math.atan2(aimed, c.lookahead))


@internal
def on_station(seen, c, memory):
    """Return whether to spiral, and the heading back to the centre: outside its radius the glider heads back."""
    to_x, to_y = c.center_x - seen[NORTH], c.center_y - seen[EAST]
    away = math.hypot(to_x, to_y)
    if away > c.station_radius:
        memory[AWAY] = 1.0
    elif away < BACK_SHARE * c.station_radius:
        memory[AWAY] = 0.0
    return memory[AWAY] == 0.0, math.atan2(to_y, to_x)


@internal
def choose_heading(seen, c, waypoints, memory):
    """Set the targets of roll and heading; return whether heading is to be held, and whether a leg ended."""
    memory[ROLL_TARGET], memory[HEADING_TARGET] = math.nan, math.nan
    turn = c.climb_bank_sign if memory[PHASE] != 0.0 else 1.0
    ended = False
    if c.lateral == HOLD_ROLL:
        memory[ROLL_TARGET] = c.lateral_target * turn
    elif c.lateral == HOLD_HEADING:
        memory[HEADING_TARGET] = c.lateral_target
    elif c.lateral == WAYPOINTS:
        ended = next_leg(seen, c, waypoints, memory)
        memory[HEADING_TARGET] = heading_along(seen, c, waypoints, memory)
    elif c.lateral == STATION:
        spirals, back = on_station(seen, c, memory)
        if spirals:
            memory[ROLL_TARGET] = c.station_bank * turn
        else:
            memory[HEADING_TARGET] = back
    return not math.isnan(memory[HEADING_TARGET]), ended
