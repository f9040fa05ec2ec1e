"""Owns the loop over segments and steps: breakpoints, events, sampling, progress and cancelling. It never raises."""

from __future__ import annotations

import math

import numpy as np

from models.kernel.actuators import DRIVE_COLUMNS, begin_segment
from models.kernel.events import BED, STOP, SURFACE, find_event, scan_stops, stop_is_new, stop_side
from models.kernel.jit import compiled, inlined
from models.kernel.params import EXTENSIONS, WORK_ACTUATORS
from models.kernel.planar import derivative, energies
from models.kernel.step import interpolate, make_dense, next_factor, pair_step, rk4_step

COMPLETED, AT_SURFACE, AT_BED, DIVERGED, STEP_TOO_SMALL, TOO_MANY_STEPS, CANCELLED = range(7)
CANCEL, PROGRESS = 0, 1
SMALLEST_STEP = 1e-11
FIRST_STEP = 1e-3


@inlined
def enter_segment(t, y, p, drive, scratch):
    """Begin a segment, charging the actuators for any jump; return when the segment ends."""
    kinetic, potential = energies(y, p)
    scratch[:] = y
    end = begin_segment(t, y, p, drive)
    for j in range(EXTENSIONS, y.shape[0]):
        if scratch[j] != y[j]:
            kinetic_after, potential_after = energies(y, p)
            y[WORK_ACTUATORS] += kinetic_after + potential_after - kinetic - potential
            break
    return end


@inlined
def all_finite(y):
    """Whether every state is finite."""
    total = 0.0
    for j in range(y.shape[0]):
        total += y[j] * 0.0
    return total == 0.0


@compiled
def integrate(pair, duration, step, interval, max_steps, y, p, times, states, events, counts, control):
    """Integrate from time 0, sampling every `interval`; return a status code.

    Parameters
    ----------
    pair : bool
        Adaptive 5(4) pair, else RK4 with `step` seconds.
    y : (n,) initial state, advanced in place to the final one.
    times, states : (samples,), (samples, n), filled.
    events : (rows, 3) filled with time, kind, part; of further stops only the count is kept.
    counts : (5,) integers, filled: samples, events, accepted steps, rejected steps, evaluations.
    control : (2,) floats: set [CANCEL] to stop early; [PROGRESS] is the time reached, s.

    """
    n = y.shape[0]
    k = np.zeros((7, n))
    y1 = np.empty(n)
    dense = np.empty((4, n))
    scratch = np.empty(n)
    drive = np.zeros((p.parts.shape[0], DRIVE_COLUMNS))
    at_stop = np.zeros(p.parts.shape[0], dtype=np.int64)
    for i in range(p.parts.shape[0]):
        at_stop[i] = stop_side(y[EXTENSIONS + i], p.parts[i])
    t = 0.0
    h = step if not pair else min(FIRST_STEP, duration)
    previous = 1.0
    last = 6 if pair else 4
    status = COMPLETED
    running = True
    while running:
        segment_end = min(enter_segment(t, y, p, drive, scratch), duration)
        scan_stops(t, 0.0, y, y, dense, p, at_stop, events, counts)
        derivative(t, y, p, drive, k[0])
        counts[4] += 1
        start, taken = t, 0
        while t < segment_end:
            remaining = segment_end - t
            ends_segment = h >= remaining * (1.0 - 1e-12)
            size = remaining if ends_segment else h
            if pair:
                error = pair_step(t, size, y, y1, k, p, drive)
                counts[4] += 6
                if not error <= 1.0:
                    counts[3] += 1
                    h = size * min(next_factor(error, previous), 0.9)
                    if h < SMALLEST_STEP * max(1.0, t):
                        status = STEP_TOO_SMALL if math.isfinite(error) else DIVERGED
                        running = False
                        break
                    if counts[2] + counts[3] >= max_steps:
                        status, running = TOO_MANY_STEPS, False
                        break
                    continue
                factor = next_factor(error, previous)
                previous = max(error, 1e-4)
                if not ends_segment or factor < 1.0:
                    h = size * factor
            else:
                rk4_step(t, size, y, y1, k, p, drive)
                counts[4] += 4
            if not all_finite(y1):
                status, running = DIVERGED, False
                break
            taken += 1
            counts[2] += 1
            t1 = segment_end if ends_segment else (t + size if pair else start + taken * step)
            kind, share = find_event(pair, size, y, y1, k, p, dense)
            t_stop = t1 if kind == 0 else t + share * size
            row = counts[0]
            if row < times.shape[0] and row * interval < t_stop:
                make_dense(pair, size, y, y1, k, dense)
                while row < times.shape[0] and row * interval < t_stop:
                    times[row] = row * interval
                    interpolate((times[row] - t) / size, y, dense, states[row])
                    row += 1
                counts[0] = row
            if kind != 0:
                make_dense(pair, size, y, y1, k, dense)
                interpolate(share, y, dense, scratch)
                y[:] = scratch
                t = t_stop
                events[counts[1], 0], events[counts[1], 1], events[counts[1], 2] = t, kind, -1.0
                counts[1] += 1
                status = AT_SURFACE if kind == SURFACE else AT_BED
                running = False
                break
            if stop_is_new(y1, p, at_stop):
                make_dense(pair, size, y, y1, k, dense)
                scan_stops(t, size, y, y1, dense, p, at_stop, events, counts)
            y[:] = y1
            k[0, :] = k[last, :]
            t = t1
            control[PROGRESS] = t
            if control[CANCEL] != 0.0:
                status, running = CANCELLED, False
                break
            if counts[2] + counts[3] >= max_steps and t < duration:
                status, running = TOO_MANY_STEPS, False
                break
        if t >= duration:
            running = False
    row = counts[0]
    times[row] = t
    states[row, :] = y
    counts[0] = row + 1
    control[PROGRESS] = t
    return status


__all__ = [
    "AT_BED", "AT_SURFACE", "BED", "CANCEL", "CANCELLED", "COMPLETED", "DIVERGED", "PROGRESS", "STEP_TOO_SMALL",
    "STOP", "SURFACE", "TOO_MANY_STEPS", "integrate",
]  # fmt: skip
