"""Owns the loop that flies many designs side by side, each with its own time, step, segments and samples.

A step advances all lanes by vector instructions, and so is the polynomial made by which they are sampled. Where
something else falls into a lane's step (an event, a stop, a corner of its schedule, the end) that lane is seen to as a
single run is (integrate.py), by the same functions. What a lane computes depends on its design alone: never on its
place, nor on who flies beside it.
"""

from __future__ import annotations

import math

from models.kernel.actuators import SAME_TIME
from models.kernel.choice import any_of, select
from models.kernel.events import event_due, note_stops, stop_is_new
from models.kernel.integrate import (
    ACCEPTED,
    CANCEL,
    CANCELLED,
    COMPLETED,
    DIVERGED,
    EVALUATIONS,
    FIRST_STEP,
    PROGRESS,
    REJECTED,
    RUNNING,
    SAMPLES,
    SMALLEST_STEP,
    STEP_TOO_SMALL,
    TOO_MANY_STEPS,
    WORST,
    all_finite,
    conclude_step,
    copy_state,
    culprit,
    enter_segment,
    finish,
    reaches,
    show_controls,
)
from models.kernel.jit import compiled, internal
from models.kernel.lane_arrays import woven
from models.kernel.lane_params import (
    BEGAN,
    BLAMED,
    ERROR,
    FROM,
    LAST_ERROR,
    MOST_TAKEN,
    NEEDS,
    NEXT_SAMPLE,
    REACHED,
    SAMPLED,
    SEGMENT_END,
    SIZE,
    STEP,
    TAKEN,
    TIME,
    lanes_of,
    params_of,
    record_of,
    weave,
    work_of,
    work_of_lanes,
)
from models.kernel.lane_types import WIDTH
from models.kernel.model import settle
from models.kernel.step import interpolate, make_dense, next_factor, pair_step, rk4_step

DURATION, FIXED_STEP, INTERVAL = range(3)


@internal
def unweave(rows, lane, out):
    """Copy a lane's numbers from a woven array into an array of its own."""
    for j in range(out.shape[0]):
        out[j] = rows[j, lane]


@internal
def reweave(values, lane, rows):
    """Copy an array into a lane."""
    for j in range(values.shape[0]):
        rows[j, lane] = values[j]


@internal
def begin_lane_segment(lane, hold, cases, p, work, record):
    """Begin a lane's segment as a single run does, and put what came of it into the lane."""
    y, clock = hold.state[lane], hold.clock
    t, duration = clock[TIME, lane], cases.numbers[hold.case[lane], DURATION]
    clock[SEGMENT_END, lane] = min(enter_segment(t, y, p, work, record), duration)
    clock[BEGAN, lane], clock[TAKEN, lane] = t, 0.0
    reweave(y, lane, hold.y)
    reweave(work.k[0], lane, hold.k)
    for i in range(work.drive.shape[0]):
        for j in range(5):
            hold.drive[5 * i + j, lane] = work.drive[i, j]
    note_lane(lane, hold, cases, work, record)


@internal
def note_lane(lane, hold, cases, work, record):
    """Note in a lane when it has to be seen to next."""
    parts, clock, case = work.at_stop.shape[0], hold.clock, hold.case[lane]
    for i in range(parts):
        hold.flags[i, lane] = work.at_stop[i]
    for i in range(2):
        hold.flags[parts + i, lane] = work.armed[i]
    clock[NEXT_SAMPLE, lane] = next_sample(case, cases, record)


@internal
def next_sample(case, cases, record):
    """Return when the next sample of a design is due, infinity after the last."""
    row = record.counts[SAMPLES]
    return row * cases.numbers[case, INTERVAL] if row < record.times.shape[0] else math.inf


@internal
def board(pair, lane, case, max_steps, hold, cases):
    """Let a lane fly a design from its beginning."""
    weave(case, lane, hold, cases)
    hold.case[lane] = case
    p, work, record = params_of(case, cases), work_of(lane, hold.work), record_of(case, cases)
    y, clock = hold.state[lane], hold.clock
    copy_state(cases.states[case], y)
    refresh(work)
    note_stops(y, p, work)
    clock[TIME, lane], clock[LAST_ERROR, lane], clock[MOST_TAKEN, lane] = 0.0, 1.0, max_steps
    clock[STEP, lane] = min(FIRST_STEP, cases.numbers[case, DURATION]) if pair else cases.numbers[case, FIXED_STEP]
    begin_lane_segment(lane, hold, cases, p, work, record)


@internal
def refresh(work):
    """Make scratch arrays as they are before a run (params.py)."""
    for i in range(work.told.shape[0]):
        work.told[i] = math.nan
    for i in range(work.armed.shape[0]):
        work.armed[i] = 1
    for i in range(work.memory.shape[0]):
        work.memory[i] = 0.0
    for i in range(work.clock.shape[0]):
        work.clock[i] = 0.0


@internal
def idle(lane, case, hold, cases):
    """Let a lane stand at the begin of a design that it holds: it steps along without moving."""
    clock = hold.clock
    hold.case[lane] = -1
    clock[TIME, lane] = clock[BEGAN, lane] = clock[TAKEN, lane] = clock[STEP, lane] = 0.0
    clock[SEGMENT_END, lane] = clock[NEXT_SAMPLE, lane] = clock[MOST_TAKEN, lane] = math.inf
    reweave(cases.states[case], lane, hold.y)
    for j in range(hold.y.shape[0]):
        hold.k[j, lane] = 0.0


@internal
def leave(lane, t, code, hold, cases, work, record):
    """End a lane's run at time t: count its steps, record its last state, and let the lane idle."""
    case = hold.case[lane]
    finish(t, hold.state[lane], work, record)
    cases.codes[case] = code
    cases.control[PROGRESS] += t
    idle(lane, case, hold, cases)


@internal
def account(pair, lane, taken, hold, record):
    """Count the accepted steps of a lane's segment."""
    record.counts[ACCEPTED] += taken
    record.counts[EVALUATIONS] += (6 if pair else 4) * taken
    hold.clock[MOST_TAKEN, lane] -= taken


@internal
def take_out(pair, lane, hold):
    """Copy what a lane's step began and ended with to where a single run has it."""
    work, n = work_of(lane, hold.work), hold.y.shape[0]
    unweave(hold.y, lane, hold.state[lane])
    unweave(hold.y1, lane, work.y1)
    for m in range(7 if pair else 5):
        for j in range(n):
            work.k[m, j] = hold.k[m * n + j, lane]
    parts = work.at_stop.shape[0]
    for i in range(2):
        work.armed[i] = int(hold.flags[parts + i, lane])


@internal
def see_to(pair, lane, hold, cases):
    """Do for a lane that was taken out what a single run does after a step; the lanes have gone on already."""
    case, clock = hold.case[lane], hold.clock
    p, work, record = params_of(case, cases), work_of(lane, hold.work), record_of(case, cases)
    y, taken = hold.state[lane], int(clock[TAKEN, lane])
    if not all_finite(work.y1):
        record.counts[WORST] = culprit(work, p)
        record.counts[EVALUATIONS] += 6 if pair else 4
        account(pair, lane, taken - 1, hold, record)
        leave(lane, clock[FROM, lane], DIVERGED, hold, cases, work, record)
        return
    status, t = conclude_step(
        pair, clock[FROM, lane], clock[SIZE, lane], clock[REACHED, lane], cases.numbers[case, INTERVAL], y, p, work,
        record,
    )  # fmt: skip
    if status == RUNNING:
        unweave(hold.y, lane, y)
        if cases.control[CANCEL] != 0.0:
            status = CANCELLED
        elif t >= cases.numbers[case, DURATION]:
            status = COMPLETED
        elif taken >= clock[MOST_TAKEN, lane]:
            status = TOO_MANY_STEPS
    if status != RUNNING:
        account(pair, lane, taken, hold, record)
        leave(lane, t, status, hold, cases, work, record)
    elif t >= clock[SEGMENT_END, lane]:
        account(pair, lane, taken, hold, record)
        begin_lane_segment(lane, hold, cases, p, work, record)
    else:
        note_lane(lane, hold, cases, work, record)


@internal
def choose_step(lane, hold, cases):
    """Choose a lane's next step by the error of the last, as a single run does; return 1 where that ends the run."""
    case, clock = hold.case[lane], hold.clock
    error, previous, size = clock[ERROR, lane], clock[LAST_ERROR, lane], clock[SIZE, lane]
    factor = next_factor(error, previous)
    if error <= 1.0:
        clock[LAST_ERROR, lane] = max(error, 1e-4)
        if clock[REACHED, lane] != clock[SEGMENT_END, lane] or factor < 1.0:
            clock[STEP, lane] = size * factor
        return 0
    h, t = size * min(factor, 0.9), clock[FROM, lane]
    clock[STEP, lane] = h
    clock[MOST_TAKEN, lane] -= 1.0
    counts = cases.record.counts[case]
    counts[WORST] = int(clock[BLAMED, lane])
    counts[REJECTED] += 1
    counts[EVALUATIONS] += 6
    status = RUNNING
    if h < SMALLEST_STEP * max(1.0, t):
        status = STEP_TOO_SMALL if math.isfinite(error) else DIVERGED
    elif clock[TAKEN, lane] >= clock[MOST_TAKEN, lane]:
        status = TOO_MANY_STEPS
    if status == RUNNING:
        return 0
    work, record = work_of(lane, hold.work), record_of(case, cases)
    unweave(hold.y, lane, hold.state[lane])
    unweave(hold.k, lane, work.k[0])
    if status == DIVERGED:
        counts[WORST] = culprit(work, params_of(case, cases))
    account(True, lane, int(clock[TAKEN, lane]), hold, record)
    leave(lane, t, status, hold, cases, work, record)
    return 1


@internal
def step_all(pair, p, work, y, clock):
    """Take one step in every lane; return whether any is to be seen to, and any to be sampled: `clock` says which."""
    t, end, h = clock[TIME], clock[SEGMENT_END], clock[STEP]
    ends = reaches(t, h, end)
    size = select(ends, end - t, h)
    clock[FROM], clock[SIZE] = t, size
    surface, bed = work.armed[0], work.armed[1]
    if pair:
        clock[ERROR], clock[BLAMED] = pair_step(t, size, y, p, work)
        reached = t + size
    else:
        rk4_step(t, size, y, p, work)
        clock[ERROR] = 0.0
        reached = clock[BEGAN] + (clock[TAKEN] + 1.0) * h
    good = clock[ERROR] <= 1.0
    reached = select(ends, end, reached)
    taken = clock[TAKEN] + 1.0
    needs = ends | (taken >= clock[MOST_TAKEN]) | event_due(y, work.y1, p, work) | stop_is_new(work.y1, p, work)
    needs |= select(all_finite(work.y1), 0.0, 1.0) > 0.0
    needs &= good & (h > 0.0)
    due = (clock[NEXT_SAMPLE] < reached - SAME_TIME * max(1.0, reached)) & good & (h > 0.0)
    clock[REACHED], clock[TAKEN] = reached, select(good, taken, clock[TAKEN])
    work.armed[0], work.armed[1] = select(good, work.armed[0], surface), select(good, work.armed[1], bed)
    clock[NEEDS] = select(needs, 1.0, 0.0)
    clock[SAMPLED] = select(needs, 0.0, select(due, 1.0, 0.0))
    return any_of(needs), any_of(clock[SAMPLED] > 0.0)


@internal
def sample_all(pair, work, y, clock, hold, cases):
    """Record the samples of the step in every lane into which nothing else falls: one of each lane at a time."""
    make_dense(pair, clock[SIZE], y, work)
    more = True
    while more:
        interpolate((clock[NEXT_SAMPLE] - clock[FROM]) / clock[SIZE], y, work.dense, work.held)
        more = False
        for lane in range(WIDTH):
            if hold.clock[SAMPLED, lane] > 0.0:
                more |= sample_lane(lane, hold, cases)


@internal
def sample_lane(lane, hold, cases):
    """Record what was interpolated for a lane; return whether another sample falls into its step."""
    case, clock = hold.case[lane], hold.clock
    record, until = record_of(case, cases), clock[REACHED, lane]
    row = record.counts[SAMPLES]
    record.times[row] = clock[NEXT_SAMPLE, lane]
    unweave(hold.held, lane, record.states[row])
    show_controls(row, work_of(lane, hold.work), record)
    record.counts[SAMPLES] = row + 1
    clock[NEXT_SAMPLE, lane] = next_sample(case, cases, record)
    again = clock[NEXT_SAMPLE, lane] < until - SAME_TIME * max(1.0, until)
    clock[SAMPLED, lane] = 1.0 if again else 0.0
    return again


@internal
def accept(pair, p, work, y, clock):
    """Go on from the end of the step in every lane where that was good."""
    good = clock[ERROR] <= 1.0
    settle(work.y1, p)
    last = 6 if pair else 4
    for j in range(y.shape[0]):
        y[j] = select(good, work.y1[j], y[j])
        work.k[0, j] = select(good, work.k[last, j], work.k[0, j])
    clock[TIME] = select(good, clock[REACHED], clock[TIME])


@internal
def give_up(pair, hold, cases):
    """End every lane's run where it is; return how many that are."""
    ended = 0
    for lane in range(WIDTH):
        if hold.case[lane] >= 0:
            work, record = work_of(lane, hold.work), record_of(hold.case[lane], cases)
            unweave(hold.y, lane, hold.state[lane])
            account(pair, lane, int(hold.clock[TAKEN, lane]), hold, record)
            leave(lane, hold.clock[TIME, lane], CANCELLED, hold, cases, work, record)
            ended += 1
    return ended


@compiled
def fly_lanes(pair, max_steps, cases, hold):
    """Fly all designs of `cases` (lane_params.py), each as `integrate` would, and leave their codes and records.

    `pair` chooses the adaptive pair, else RK4; `max_steps` bounds the steps of each; `hold` is scratch.
    """
    count = cases.codes.shape[0]
    ended, coming = 0, 0
    for lane in range(WIDTH):
        weave(0, lane, hold, cases)
        idle(lane, 0, hold, cases)
    while ended < count:
        for lane in range(WIDTH):
            if hold.case[lane] < 0 and coming < count:
                board(pair, lane, coming, max_steps, hold, cases)
                coming += 1
        ended += advance(pair, hold, cases)


@internal
def advance(pair, hold, cases):
    """Step all lanes until a run ends; return how many did."""
    p, work = lanes_of(hold, cases), work_of_lanes(hold)
    y, clock = woven(hold.y, 0, (hold.y.shape[0],)), woven(hold.clock, 0, (hold.clock.shape[0],))
    ended = 0
    while ended == 0:
        seen_to, sampled = step_all(pair, p, work, y, clock)
        if sampled:
            sample_all(pair, work, y, clock, hold, cases)
        if seen_to:
            for lane in range(WIDTH):
                if hold.clock[NEEDS, lane] > 0.0:
                    take_out(pair, lane, hold)
        if pair:
            for lane in range(WIDTH):
                if hold.case[lane] >= 0:
                    ended += choose_step(lane, hold, cases)
        accept(pair, p, work, y, clock)
        if seen_to:
            for lane in range(WIDTH):
                if hold.clock[NEEDS, lane] > 0.0:
                    see_to(pair, lane, hold, cases)
                    ended += 1 if hold.case[lane] < 0 else 0
        if cases.control[CANCEL] != 0.0:
            ended += give_up(pair, hold, cases)
    return ended
