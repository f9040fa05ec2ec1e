"""Owns the controller's place in a run: when it samples, what it sees, and when its commands reach the actuators."""

from __future__ import annotations

import math

from models.kernel import params
from models.kernel.actuators import SAME_TIME
from models.kernel.allocate import PART, SPAN
from models.kernel.control_layout import (
    APPLIED,
    CASCADE,
    DEPTH,
    EAST,
    FROM_X,
    FROM_Y,
    HEAVE,
    LEG,
    MOST_PENDING,
    NONE,
    NORTH,
    PHASE,
    PITCH,
    PITCH_RATE,
    ROLL,
    ROLL_RATE,
    SAMPLED,
    SET_POINT,
    SURGE,
    SWAY,
    WAYPOINTS,
    YAW,
    YAW_RATE,
)
from models.kernel.events import CLIMB, DIVE, LEG_ENDED, add_event
from models.kernel.guidance import choose_heading, choose_phase
from models.kernel.jit import compiled, internal
from models.kernel.loops import ask_of_cells, bank_for_heading, feed_back, share_among_cells, wind_up
from models.kernel.noise import normal
from models.kernel.search import last_not_above
from models.kernel.spatial import attitude, water_velocity
from models.kernel.spatial_layout import P, Q, R, U, V, W, X, Y, Z

IN_PLANE = (DEPTH, PITCH, SURGE, HEAVE, PITCH_RATE, NORTH)
"""What a planar glider can measure."""


@compiled
def see(t, y, p, seen):
    """Write what an ideal instrument measures into `seen`."""
    if p.space[0].spatial == 0:
        for j in range(seen.shape[0]):
            seen[j] = 0.0
        seen[DEPTH], seen[PITCH], seen[NORTH] = y[params.Z], y[params.THETA], y[params.X]
        seen[SURGE], seen[HEAVE], seen[PITCH_RATE] = y[params.U], y[params.W], y[params.Q]
        return
    rot = attitude(y)
    (cx, cy, cz), _shear, _change = water_velocity(t, y, last_not_above(t, p.current_times), p, rot)
    seen[DEPTH], seen[NORTH], seen[EAST] = y[Z], y[X], y[Y]
    seen[ROLL], seen[PITCH] = math.atan2(rot[7], rot[8]), math.asin(min(max(-rot[6], -1.0), 1.0))
    seen[YAW] = math.atan2(rot[3], rot[0])
    seen[SURGE], seen[SWAY], seen[HEAVE] = y[U] - cx, y[V] - cy, y[W] - cz
    seen[ROLL_RATE], seen[PITCH_RATE], seen[YAW_RATE] = y[P], y[Q], y[R]


@internal
def blur(sample, c, spatial, seen):
    """Add the noise of the instruments; a planar glider has none across its plane."""
    spread = (
        c.noise_depth, c.noise_attitude, c.noise_attitude, c.noise_attitude, c.noise_velocity, c.noise_velocity,
        c.noise_velocity, c.noise_rate, c.noise_rate, c.noise_rate, c.noise_place, c.noise_place,
    )  # fmt: skip
    for j in range(len(spread)):
        if spread[j] > 0.0 and (spatial or j in IN_PLANE):
            seen[j] += spread[j] * normal(c.seed, sample, j)


@internal
def fly_cascade(t, p, work, record, out):
    """Guidance, loops, allocation: from what is seen to commands."""
    c, memory, seen = p.control[0], work.memory, work.seen
    if choose_phase(seen, c, memory):
        note(t, CLIMB if memory[PHASE] != 0.0 else DIVE, record)
    holds_heading, leg_ended = choose_heading(seen, c, p.waypoints, memory)
    if leg_ended:
        note(t, LEG_ENDED, record)
    if holds_heading:
        bank_for_heading(seen, c, memory)
    pitch_error, roll_error = ask_of_cells(seen, c, memory)
    share_among_cells(c, p.cells, memory, work.share, out)
    wind_up(c, memory, pitch_error, roll_error)


@internal
def note(t, kind, record):
    """Record an event of the controller; the last row is kept for the end of the run."""
    if record.counts[1] < record.events.shape[0] - 1:
        add_event(t, kind, -1, record)


@internal
def set_off(p, work):
    """Prepare the memory at the first sample: the phase to begin with, and where the first leg begins."""
    c, memory = p.control[0], work.memory
    if c.lateral != WAYPOINTS:
        memory[LEG] = math.nan
    memory[SET_POINT] = math.nan
    memory[PHASE] = 1.0 if c.starts_climbing != 0 else 0.0
    memory[FROM_X], memory[FROM_Y] = work.seen[NORTH], work.seen[EAST]


@compiled
def take_sample(t, y, p, work, record):
    """Measure, decide, and queue the commands behind those that still wait."""
    c = p.control[0]
    sample = work.clock[SAMPLED]
    see(t, y, p, work.seen)
    if sample == 0.0:
        set_off(p, work)
    blur(int(sample), c, p.space[0].spatial != 0, work.seen)
    queued = work.pending[int(sample) % MOST_PENDING]
    if c.kind == CASCADE:
        fly_cascade(t, p, work, record, queued)
    else:
        first = p.space[0].extensions
        feed_back(t, work.seen, y, c, p.cells, p.gains, p.setpoints, p.chosen, first, work.memory, work.share, queued)
    work.clock[SAMPLED] = sample + 1.0


@internal
def apply_commands(p, work):
    """Hand the oldest commands that wait to the actuators; changes within the deadband are left."""
    queued = work.pending[int(work.clock[APPLIED]) % MOST_PENDING]
    for i in range(p.cells.shape[0]):
        part = int(p.cells[i, PART])
        change = abs(queued[part] - work.told[part])
        if not change <= p.control[0].deadband * p.cells[i, SPAN]:
            work.told[part] = queued[part]
    work.clock[APPLIED] += 1.0


@internal
def run_controller(t, y, p, work, record):
    """Take the samples and hand over the commands that are due at time t; return when something is due next."""
    c = p.control[0]
    if c.kind == NONE:
        return math.inf
    now = t + SAME_TIME * max(1.0, abs(t))
    while work.clock[SAMPLED] * c.sample_time <= now:
        take_sample(work.clock[SAMPLED] * c.sample_time, y, p, work, record)
    while work.clock[APPLIED] < work.clock[SAMPLED] and work.clock[APPLIED] * c.sample_time + c.delay <= now:
        apply_commands(p, work)
    due = work.clock[SAMPLED] * c.sample_time
    if work.clock[APPLIED] < work.clock[SAMPLED]:
        due = min(due, work.clock[APPLIED] * c.sample_time + c.delay)
    return due
