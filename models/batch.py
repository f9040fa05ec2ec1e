"""Owns many runs at once: designs that may share lanes fly side by side in the kernel, the others one by one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import partial
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.kernel import lane_arrays, lane_params
from models.kernel.control_layout import SHOWN
from models.kernel.lane_params import FIELDS, WOVEN, Cases, Hold
from models.kernel.lanes import fly_lanes
from models.kernel.params import Params, Record
from models.kernel.spatial_layout import SPACE
from models.limits import DEFAULT_LIMITS, Limits
from models.run import Run
from models.simulate import MAX_EVENTS, Control, make_run, run_assembly

Array = NDArray[np.float64]
TOGETHER = 512
"""Designs that are flown before the first of their runs is handed out."""
NUMBERS_TOGETHER = 20_000_000
"""Numbers of their samples that are in memory at once; a design that has more flies alone."""
LAWS, MOVES = lane_arrays.LAWS, lane_arrays.ALIKE
SWITCHES = tuple(name for name in SPACE.names or () if SPACE[name].kind == "i")
EVEN = ("commands", *WOVEN)
"""Fields that every design has for itself; equal ones of the others are kept once."""


def lanes_exist() -> bool:
    """Whether designs can be flown in lanes, which exist in compiled code alone."""
    return not numba.config.DISABLE_JIT  # type: ignore[attr-defined]


def run_batch(
    assemblies: Sequence[Assembly], *, limits: Limits = DEFAULT_LIMITS, control: Control | None = None
) -> Iterator[Run]:
    """Yield the run of each assembled design in order, as `run_assembly` would return it.

    No bit of a run depends on which others are flown with it. Lanes pay where eight or more designs are alike in sizes
    and switches (`_likeness`); fewer fly in part-empty lanes, which may take longer than alone. `control` stops them
    all, each where it is; of those that have not begun there is the first step. Its `time_reached` is the sum over the
    runs that have ended.
    """
    first = 0
    while first < len(assemblies):
        last = _end_of_window(assemblies, first)
        yield from _fly_window(assemblies[first:last], limits, control)
        first = last


def _end_of_window(assemblies: Sequence[Assembly], first: int) -> int:
    numbers = 0
    for k in range(first, min(first + TOGETHER, len(assemblies))):
        numbers += _capacity(assemblies[k]) * (len(assemblies[k].initial_state) + 1)
        if numbers > NUMBERS_TOGETHER:
            return max(k, first + 1)
    return min(first + TOGETHER, len(assemblies))


def _fly_window(window: Sequence[Assembly], limits: Limits, control: Control | None) -> Iterator[Run]:
    """Fly designs; each run is made as it is handed out, for its outputs take far more room than its states."""
    if not lanes_exist():
        yield from (run_assembly(assembly, limits=limits, control=control) for assembly in window)
        return
    groups: dict[Hashable, list[int]] = {}
    for k, assembly in enumerate(window):
        groups.setdefault(_likeness(assembly), []).append(k)
    flown: dict[int, Callable[[], Run]] = {}
    for members in groups.values():
        flown |= zip(members, _fly_group([window[k] for k in members], limits, control or Control()), strict=True)
    for k in range(len(window)):
        yield flown.pop(k)()


def _likeness(assembly: Assembly) -> Hashable:
    """Return what designs must have in common to share lanes: sizes and switches."""
    p, method = assembly.params, assembly.design.mission.solver.method
    sizes = tuple(len(getattr(p, name)) for name in WOVEN)
    switches = [
        tuple(records[name].tolist())
        for records, names in ((p.parts, LAWS), (p.space, SWITCHES), (p.members, MOVES))
        for name in names
    ]
    columns = tuple(array.shape[1:] for array in p)
    return method, sizes, tuple(switches), columns, len(assembly.initial_state), _shown(assembly)


def _shown(assembly: Assembly) -> int:
    return SHOWN + len(assembly.cells) if assembly.design.mission.control.controller is not None else 0


def _capacity(assembly: Assembly) -> int:
    mission = assembly.design.mission
    return math.ceil(mission.duration / mission.solver.output_interval) + 2


def _fly_group(group: list[Assembly], limits: Limits, control: Control) -> list[Callable[[], Run]]:
    """Fly designs that share lanes; return what makes the run of each."""
    cases = cases_of(group, control)
    hold = hold_for(cases)
    began = time.perf_counter()
    fly_lanes(group[0].design.mission.solver.method == "adaptive", limits.steps, cases, hold)
    elapsed = (time.perf_counter() - began) / len(group)

    def run_of(k: int) -> Run:
        return make_run(group[k], _record_of(k, cases), int(cases.codes[k]), elapsed)

    return [partial(run_of, k) for k in range(len(group))]


def hold_for(cases: Cases) -> Hold:
    """Return the memory of the lanes that fly them."""
    parts = int(cases.spans[0, FIELDS.index("parts"), 1])
    return lane_params.make_hold(cases.words.shape[1], cases.states.shape[1], parts)


def _record_of(k: int, cases: Cases) -> Record:
    """Return a design's record; its samples are copied, so that a run that is kept does not keep all others' alive."""
    record, ((first, last), (shown, end)) = cases.record, cases.rooms[k]
    last = first + record.counts[k, 0]
    return Record(
        record.times[first:last].copy(), record.states[first:last].copy(), record.events[k], record.counts[k],
        record.control[k], record.controls[shown:end].copy(),
    )  # fmt: skip


def cases_of(group: list[Assembly], control: Control) -> Cases:
    """Put the records of designs that share lanes one after another."""
    count, n = len(group), len(group[0].initial_state)
    spans = np.zeros((count, len(FIELDS), 2), dtype=np.int64)
    fields: dict[str, Any] = {
        name: _joined([getattr(a.params, name) for a in group], spans[:, k], name) for k, name in enumerate(FIELDS)
    }
    solvers = [a.design.mission.solver for a in group]
    rooms, record = _rooms([_capacity(a) for a in group], n, _shown(group[0]))
    woven = [fields[name].view(np.float64).reshape(count, -1) for name in WOVEN]
    sizes = [columns.shape[1] for columns in woven]
    return Cases(
        params=Params(**fields), spans=spans, words=np.concatenate(woven, axis=1),
        starts=np.concatenate([[0], np.cumsum(sizes[:-1])]).astype(np.int64),
        states=np.array([a.initial_state for a in group]),
        numbers=np.array([
            (a.design.mission.duration, s.step, s.output_interval) for a, s in zip(group, solvers, strict=True)
        ]),
        record=record, rooms=rooms, codes=np.zeros(count, dtype=np.int64), control=control.flags,
    )  # fmt: skip


def _joined(arrays: list[NDArray[np.generic]], spans: NDArray[np.int64], name: str) -> NDArray[np.generic]:
    """Return arrays one after another, and write the rows of each into `spans` (arrays, 2)."""
    if name in EVEN:
        lengths = np.array([len(a) for a in arrays])
        ends = lengths.cumsum()
        spans[:, 0], spans[:, 1] = ends - lengths, ends
        return _end_to_end(arrays)
    if all(array is arrays[0] for array in arrays):  # what follows from what designs have in common is one array
        spans[:] = 0, len(arrays[0])
        return arrays[0]
    spans_by_content: dict[Hashable, tuple[int, int]] = {}
    spans_by_array: dict[int, tuple[int, int]] = {}
    kept: list[NDArray[np.generic]] = []
    end = 0
    for array in arrays:
        if id(array) in spans_by_array:
            continue
        content = (array.shape, array.tobytes())
        if content not in spans_by_content:
            spans_by_content[content] = end, end + len(array)
            kept.append(array)
            end += len(array)
        spans_by_array[id(array)] = spans_by_content[content]
    spans[:] = [spans_by_array[id(array)] for array in arrays]
    return _end_to_end(kept)


def _end_to_end(arrays: list[NDArray[np.generic]]) -> NDArray[np.generic]:
    """Return arrays of one type one after another; records by their bytes, for NumPy compares them field by field."""
    if arrays[0].dtype.fields is None:
        return np.concatenate(arrays)
    joined: NDArray[np.generic] = np.frombuffer(bytearray().join(a.tobytes() for a in arrays), dtype=arrays[0].dtype)
    return joined


def _rooms(capacities: list[int], states: int, shown: int) -> tuple[NDArray[np.int64], Record]:
    """Return where each design's samples go, and the empty record of all."""
    ends = np.cumsum(capacities)
    rooms = np.zeros((len(capacities), 2, 2), dtype=np.int64)
    rooms[:, 0] = np.column_stack([ends - capacities, ends])
    if shown:
        rooms[:, 1] = rooms[:, 0]
    total = int(ends[-1])
    record = Record(
        np.zeros(total), np.zeros((total, states)), np.zeros((len(capacities), MAX_EVENTS, 3)),
        np.zeros((len(capacities), 6), dtype=np.int64), np.zeros((len(capacities), 2)),
        np.zeros((total if shown else 0, shown)),
    )  # fmt: skip
    return rooms, record
