"""Owns what lanes are made of: many designs' records in one set of arrays, and how a lane takes one of them.

Designs that share lanes have the same numbers of parts, pieces and states and the same switches (`models/batch.py`).
What each of them reads at its own pace stays as it is (tables); the rest is woven, so that one load serves all lanes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.kernel import lane_items  # noqa: F401  # teaches the compiler how lanes are read and written
from models.kernel.control_layout import CLOCK, MEASURED, MEMORY, MOST_PENDING
from models.kernel.jit import internal
from models.kernel.lane_arrays import (
    rows_of,
    tables,
    woven,
    woven_body,
    woven_members,
    woven_parts,
    woven_space,
)
from models.kernel.lane_types import WIDTH
from models.kernel.params import Params, Record, Work

FIELDS = Params._fields
WOVEN = (
    "body", "parts", "volume_law", "error_scale", "space", "members", "inertias", "solids", "added", "damping", "rates",
    "coefficients",
)  # fmt: skip
"""Fields of `Params` that are woven, in their order among the words of a design."""
TABLES = ("table", "lookup", "grid_alpha", "grid_beta", "grid", "water", "current", "current_times")
"""Fields that each lane reads at rows of its own."""
PLACES = tuple(FIELDS.index(name) for name in TABLES)


class Cases(NamedTuple):
    """Many designs, and room for what their runs leave behind."""

    params: Params  # fields of all designs one after another, equal ones shared
    spans: NDArray[np.int64]  # (designs, fields, 2) first row and end of each field
    words: NDArray[np.float64]  # (designs, words) what is woven
    starts: NDArray[np.int64]  # (WOVEN,) where each field begins among the words
    states: NDArray[np.float64]  # (designs, n) initial states
    numbers: NDArray[np.float64]  # (designs, 3) duration, step, interval between samples, s
    record: Record  # one after another, but events, counts and control, which have an axis of designs before their own
    rooms: NDArray[np.int64]  # (designs, 2, 2) first sample and end in times and states; and in controls
    codes: NDArray[np.int64]  # (designs,) how each run ended
    control: NDArray[np.float64]  # (2,) set [0] to stop early; [1] is the time flown by the runs that ended, s


class LaneParams(NamedTuple):
    """`Params` of all lanes, for the physics alone."""

    body: object
    parts: object
    volume_law: object
    error_scale: object
    space: object
    members: object
    inertias: object
    solids: object
    added: object
    damping: object
    rates: object
    coefficients: object
    table: object
    lookup: object
    grid_alpha: object
    grid_beta: object
    grid: object
    water: object
    current: object
    current_times: object


class LaneWork(NamedTuple):
    """`Work` of all lanes, as far as steps need it."""

    k: object
    y1: object
    dense: object
    held: object
    drive: object
    at_stop: object
    armed: object


class Hold(NamedTuple):
    """The memory of the lanes."""

    words: NDArray[np.float64]  # (words, WIDTH)
    spans: NDArray[np.int32]  # (TABLES, 2, WIDTH)
    y: NDArray[np.float64]  # (n, WIDTH)
    k: NDArray[np.float64]  # (7 n, WIDTH)
    y1: NDArray[np.float64]  # (n, WIDTH)
    dense: NDArray[np.float64]  # (4 n, WIDTH)
    held: NDArray[np.float64]  # (n, WIDTH)
    drive: NDArray[np.float64]  # (5 (parts + 1), WIDTH)
    flags: NDArray[np.float64]  # (parts + 2, WIDTH) at_stop, then armed
    clock: NDArray[np.float64]  # (CLOCKS, WIDTH)
    case: NDArray[np.int64]  # (WIDTH,) the design that a lane flies; -1 for none
    work: Work  # of each lane, with an axis of lanes before its own
    state: NDArray[np.float64]  # (WIDTH, n) a lane's state, for what is done lane by lane


(
    TIME, BEGAN, TAKEN, STEP, SEGMENT_END, NEXT_SAMPLE, MOST_TAKEN, LAST_ERROR,
    FROM, SIZE, REACHED, ERROR, BLAMED, NEEDS, SAMPLED,
) = range(15)  # fmt: skip
CLOCKS = 15
"""Rows of `Hold.clock`. Of a lane: the time; when its segment began, the steps accepted since then, and how long the
next is to be; when the segment ends; when the next sample is due; after how many accepted steps of this segment the
limit of all steps is reached; the last error. Of the step just taken: its begin, length and end, its error and the
state that is to blame for that, 1 where something falls into it, and 1 where nothing but samples does."""


def make_hold(words: int, states: int, parts: int) -> Hold:
    """Return the memory of lanes for designs of this many woven words, states and parts."""
    lanes = (WIDTH,)
    work = Work(
        k=np.zeros((WIDTH, 7, states)), y1=np.zeros((WIDTH, states)), dense=np.zeros((WIDTH, 4, states)),
        held=np.zeros((WIDTH, states)), drive=np.zeros((WIDTH, parts + 1, 5)),
        at_stop=np.zeros((WIDTH, parts), dtype=np.int64), armed=np.zeros((WIDTH, 2), dtype=np.int64),
        told=np.zeros((WIDTH, parts)), seen=np.zeros((WIDTH, MEASURED)), memory=np.zeros((WIDTH, MEMORY)),
        share=np.zeros((WIDTH, parts)), pending=np.zeros((WIDTH, MOST_PENDING, parts)), clock=np.zeros((WIDTH, CLOCK)),
    )  # fmt: skip
    return Hold(
        words=np.zeros((words, *lanes)), spans=np.zeros((len(TABLES), 2, *lanes), dtype=np.int32),
        y=np.zeros((states, *lanes)), k=np.zeros((7 * states, *lanes)), y1=np.zeros((states, *lanes)),
        dense=np.zeros((4 * states, *lanes)), held=np.zeros((states, *lanes)),
        drive=np.zeros((5 * (parts + 1), *lanes)), flags=np.zeros((parts + 2, *lanes)),
        clock=np.zeros((CLOCKS, *lanes)), case=np.full(lanes, -1), work=work, state=np.zeros((WIDTH, states)),
    )  # fmt: skip


@internal
def params_of(case, cases):
    """Return the `Params` of one design."""
    p, s = cases.params, cases.spans[case]
    return Params(
        rows_of(p.body, s[0, 0], s[0, 1]),
        rows_of(p.parts, s[1, 0], s[1, 1]),
        rows_of(p.volume_law, s[2, 0], s[2, 1]),
        rows_of(p.commands, s[3, 0], s[3, 1]),
        rows_of(p.table, s[4, 0], s[4, 1]),
        rows_of(p.lookup, s[5, 0], s[5, 1]),
        rows_of(p.error_scale, s[6, 0], s[6, 1]),
        rows_of(p.space, s[7, 0], s[7, 1]),
        rows_of(p.members, s[8, 0], s[8, 1]),
        rows_of(p.inertias, s[9, 0], s[9, 1]),
        rows_of(p.solids, s[10, 0], s[10, 1]),
        rows_of(p.added, s[11, 0], s[11, 1]),
        rows_of(p.damping, s[12, 0], s[12, 1]),
        rows_of(p.rates, s[13, 0], s[13, 1]),
        rows_of(p.coefficients, s[14, 0], s[14, 1]),
        rows_of(p.grid_alpha, s[15, 0], s[15, 1]),
        rows_of(p.grid_beta, s[16, 0], s[16, 1]),
        rows_of(p.grid, s[17, 0], s[17, 1]),
        rows_of(p.water, s[18, 0], s[18, 1]),
        rows_of(p.current, s[19, 0], s[19, 1]),
        rows_of(p.current_times, s[20, 0], s[20, 1]),
        rows_of(p.control, s[21, 0], s[21, 1]),
        rows_of(p.cells, s[22, 0], s[22, 1]),
        rows_of(p.waypoints, s[23, 0], s[23, 1]),
        rows_of(p.gains, s[24, 0], s[24, 1]),
        rows_of(p.setpoints, s[25, 0], s[25, 1]),
        rows_of(p.chosen, s[26, 0], s[26, 1]),
    )


@internal
def record_of(case, cases):
    """Return the `Record` of one design."""
    r, rooms = cases.record, cases.rooms[case]
    return Record(
        rows_of(r.times, rooms[0, 0], rooms[0, 1]),
        rows_of(r.states, rooms[0, 0], rooms[0, 1]),
        r.events[case],
        r.counts[case],
        r.control[case],
        rows_of(r.controls, rooms[1, 0], rooms[1, 1]),
    )


@internal
def work_of(lane, work):
    """Return the `Work` of one lane."""
    return Work(
        work.k[lane], work.y1[lane], work.dense[lane], work.held[lane], work.drive[lane], work.at_stop[lane],
        work.armed[lane], work.told[lane], work.seen[lane], work.memory[lane], work.share[lane], work.pending[lane],
        work.clock[lane],
    )  # fmt: skip


@internal
def lanes_of(hold, cases):
    """Return the constants of all lanes as the physics reads them."""
    p, at, words, spans = cases.params, cases.starts, hold.words, hold.spans
    first = cases.spans[0]
    parts, laws, n = first[1, 1] - first[1, 0], first[2, 1] - first[2, 0], hold.y.shape[0]
    members, solids = first[8, 1] - first[8, 0], first[10, 1] - first[10, 0]
    return LaneParams(
        woven_body(words, at[0], 1), woven_parts(words, at[1], parts), woven(words, at[2], (laws, 5)),
        woven(words, at[3], (n,)), woven_space(words, at[4], 1), woven_members(words, at[5], members),
        woven(words, at[6], (members, 5, 6)), woven(words, at[7], (solids, 6)), woven(words, at[8], (6, 6)),
        woven(words, at[9], (6, 6)), woven(words, at[10], (6, 3)), woven(words, at[11], (14,)),
        tables(p.table, spans[0]), tables(p.lookup, spans[1]), tables(p.grid_alpha, spans[2]),
        tables(p.grid_beta, spans[3]), tables(p.grid, spans[4]), tables(p.water, spans[5]), tables(p.current, spans[6]),
        tables(p.current_times, spans[7]),
    )  # fmt: skip


@internal
def work_of_lanes(hold):
    """Return what the steps of all lanes write into."""
    n, parts = hold.y.shape[0], hold.flags.shape[0] - 2
    return LaneWork(
        woven(hold.k, 0, (7, n)), woven(hold.y1, 0, (n,)), woven(hold.dense, 0, (4, n)), woven(hold.held, 0, (n,)),
        woven(hold.drive, 0, (parts + 1, 5)), woven(hold.flags, 0, (parts,)), woven(hold.flags, parts, (2,)),
    )  # fmt: skip


@internal
def weave(case, lane, hold, cases):
    """Put a design's constants into a lane."""
    for j in range(hold.words.shape[0]):
        hold.words[j, lane] = cases.words[case, j]
    for j in range(len(PLACES)):
        span = cases.spans[case, PLACES[j]]
        hold.spans[j, 0, lane] = span[0]
        hold.spans[j, 1, lane] = span[1] - span[0]
