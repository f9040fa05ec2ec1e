"""Owns the loop over segments and steps: breakpoints, events, sampling, progress and cancelling. It never raises."""

from __future__ import annotations

import math

from models.kernel.actuators import SAME_TIME, begin_segment
from models.kernel.control import run_controller
from models.kernel.control_layout import LAST_ERROR, NEXT_STEP, SHOWN
from models.kernel.events import (
    SURFACE,
    add_event,
    ends_run,
    event_due,
    find_event,
    note_stops,
    scan_stops,
    stop_is_new,
)
from models.kernel.jit import compiled, internal
from models.kernel.model import bill_jump, derivative, energies, settle
from models.kernel.step import interpolate, make_dense, next_factor, pair_step, rk4_step

COMPLETED, AT_SURFACE, AT_BED, DIVERGED, STEP_TOO_SMALL, TOO_MANY_STEPS, CANCELLED, RUNNING = range(8)
CANCEL, PROGRESS = 0, 1
SAMPLES, EVENTS, ACCEPTED, REJECTED, EVALUATIONS, WORST = range(6)
SMALLEST_STEP = 1e-11
"""Shortest step, relative to the time reached and to 1 s."""
FIRST_STEP = 1e-3
"""First trial of the adaptive pair, s; the controller finds its own within a few steps."""
LARGEST = 1e6
"""A pitch (rad, planar) or depth (m, spatial) beyond this has diverged: `sincos` would make numbers up."""


@internal
def copy_state(source, target):
    """Copy one state."""
    for j in range(source.shape[0]):
        target[j] = source[j]


@internal
def enter_segment(t, y, p, work, record):
    """Begin a segment, charging the actuators for any jump; return when the segment ends."""
    due = run_controller(t, y, p, work, record)
    copy_state(y, work.held)
    end = min(begin_segment(t, y, p, work.drive, work.told), due)
    first = p.space[0].extensions
    jumped = False
    for j in range(first, first + p.parts.shape[0]):
        jumped |= work.held[j] != y[j]
    if jumped:
        kinetic, potential = energies(t, work.held, p)
        kinetic_after, potential_after = energies(t, y, p)
        y[p.space[0].work] += kinetic_after + potential_after - kinetic - potential
        bill_jump(work.held, y, p)
    scan_stops(t, 0.0, y, y, p, work, record)
    derivative(t, y, p, work.drive, work.k[0])
    record.counts[EVALUATIONS] += 1
    return end


@internal
def culprit(work, p):
    """Return the velocity that changed fastest as the step began: what a run that diverges went wrong in."""
    first, count = (7, 6) if p.space[0].spatial != 0 else (3, 3)
    worst = first
    for j in range(first, first + count):
        change = abs(work.k[0, j])
        if not math.isfinite(change):
            return j
        if change > abs(work.k[0, worst]):
            worst = j
    return worst


@internal
def all_finite(y):
    """Whether every state is finite, and none such that `sincos` cannot take it."""
    total = 0.0
    for j in range(y.shape[0]):
        total += y[j] * 0.0
    return (total == 0.0) & (abs(y[2]) < LARGEST)


@internal
def show_controls(row, work, record):
    """Keep what the controller asks for now, and the commands that it holds."""
    if record.controls.shape[0] == 0:
        return
    for j in range(SHOWN):
        record.controls[row, j] = work.memory[j]
    for i in range(work.told.shape[0]):
        record.controls[row, SHOWN + i] = work.told[i]


@internal
def sample_step(pair, t, h, until, interval, y, work, record):
    """Record the samples that fall into the step from t to `until`, its end excluded.

    One that misses a breakpoint or the end of the run by rounding belongs to what comes after.
    """
    until -= SAME_TIME * max(1.0, until)
    row = record.counts[SAMPLES]
    if row < record.times.shape[0] and row * interval < until:
        make_dense(pair, h, y, work)
        while row < record.times.shape[0] and row * interval < until:
            record.times[row] = row * interval
            interpolate((row * interval - t) / h, y, work.dense, record.states[row])
            show_controls(row, work, record)
            row += 1
        record.counts[SAMPLES] = row


@internal
def reaches(t, h, end):
    """Whether a step of h from t ends a segment; one that misses its end by rounding alone does."""
    return t + h >= end - SAME_TIME * max(1.0, end)


@internal
def conclude_step(pair, t, size, reached, interval, y, p, work, record):
    """Record events and samples of a step from y at t to `work.y1`; return the status, and the time reached.

    Where an event ends the run, y becomes the state there.
    """
    if event_due(y, work.y1, p, work):
        kind, share = find_event(pair, size, y, p, work)
        if ends_run(kind, p):
            sample_step(pair, t, size, t + share * size, interval, y, work, record)
            interpolate(share, y, work.dense, work.held)
            copy_state(work.held, y)
            add_event(t + share * size, kind, -1, record)
            return AT_SURFACE if kind == SURFACE else AT_BED, t + share * size
        if record.counts[EVENTS] < record.events.shape[0] - 1:  # the last row is kept for the end of the run
            add_event(t + share * size, kind, -1, record)
    sample_step(pair, t, size, reached, interval, y, work, record)
    if stop_is_new(work.y1, p, work):
        make_dense(pair, size, y, work)
        scan_stops(t, size, y, work.y1, p, work, record)
    return RUNNING, reached


@compiled
def finish(t, y, work, record):
    """Record the last state."""
    row = record.counts[SAMPLES]
    record.times[row] = t
    copy_state(y, record.states[row])
    show_controls(row, work, record)
    record.counts[SAMPLES] = row + 1
    record.control[PROGRESS] = t


@compiled
def integrate(pair, begin, duration, step, interval, max_steps, y, p, work, record):
    """Integrate from time `begin` to `duration` (s), sampling at multiples of `interval` (s); return a status code.

    `pair` chooses the adaptive 5(4) pair, else RK4 takes steps of `step` (s), shortened only to end at a breakpoint.
    `y` (n,) is the state and is advanced in place; `work` and `record` are described in params.py. A call that begins
    where another ended goes on with its step; whoever calls adds the last sample (`finish`).
    """
    counts = record.counts
    last = 6 if pair else 4
    t, h, previous = begin, step, 1.0
    if pair:
        h = min(FIRST_STEP, duration)
        if begin > 0.0 and work.clock[NEXT_STEP] > 0.0:
            h, previous = work.clock[NEXT_STEP], work.clock[LAST_ERROR]
    status = RUNNING
    if begin == 0.0:
        note_stops(y, p, work)
    while status == RUNNING:
        segment_end = min(enter_segment(t, y, p, work, record), duration)
        segment_begin, taken = t, 0
        while t < segment_end and status == RUNNING:
            ends_segment = reaches(t, h, segment_end)
            size = segment_end - t if ends_segment else h
            if pair:
                error, counts[WORST] = pair_step(t, size, y, p, work)
                counts[EVALUATIONS] += 6
                if not error <= 1.0:
                    counts[REJECTED] += 1
                    h = size * min(next_factor(error, previous), 0.9)
                    if h < SMALLEST_STEP * max(1.0, t):
                        status = STEP_TOO_SMALL
                        if not math.isfinite(error):
                            status = DIVERGED
                            counts[WORST] = culprit(work, p)
                    elif counts[ACCEPTED] + counts[REJECTED] >= max_steps:
                        status = TOO_MANY_STEPS
                    continue
                factor = next_factor(error, previous)
                previous = max(error, 1e-4)
                if not ends_segment or factor < 1.0:
                    h = size * factor
            else:
                rk4_step(t, size, y, p, work)
                counts[EVALUATIONS] += 4
            if not all_finite(work.y1):
                counts[WORST] = culprit(work, p)
                status = DIVERGED
                continue
            taken += 1
            counts[ACCEPTED] += 1
            reached = segment_end if ends_segment else (t + size if pair else segment_begin + taken * step)
            status, t = conclude_step(pair, t, size, reached, interval, y, p, work, record)
            if status != RUNNING:
                continue
            copy_state(work.y1, y)
            settle(y, p)
            copy_state(work.k[last], work.k[0])
            record.control[PROGRESS] = t
            if record.control[CANCEL] != 0.0:
                status = CANCELLED
            elif counts[ACCEPTED] + counts[REJECTED] >= max_steps and t < duration:
                status = TOO_MANY_STEPS
        if status == RUNNING and t >= duration:
            status = COMPLETED
    work.clock[NEXT_STEP], work.clock[LAST_ERROR] = h, previous
    record.control[PROGRESS] = t
    return status
