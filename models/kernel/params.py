"""Owns the kernel's records: `Params`, everything constant in a run, and the layout of the planar state.

The spatial state has a layout of its own (spatial_layout.py).

| symbol in code | words | unit | frame |
|---|---|---|---|
| x, z, theta | position of the body origin, pitch | m, rad | world |
| u, w, q | surge, heave, pitch rate | m/s, rad/s | body |
| work_actuators, work_water | work done on the glider since the start | J | |
| e | extension of each actuated part | m | along its axis |
| mass_x, mass_z | first moments of mass about the origin | kg m | body |
| volume_x, volume_z | first moments of displaced volume | m4 | body |
| a11 ... a55 | planar added mass (surge 1, heave 3, pitch 5) | kg, kg m, kg m2 | body |
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.kernel.control_layout import CLOCK, MEASURED, MEMORY, MOST_PENDING

X, Z, THETA, U, W, Q, WORK_ACTUATORS, WORK_WATER = range(8)
EXTENSIONS = 8
"""Index of the first extension in the state."""

_BODY_FIELDS = (
    "gravity", "density", "bed_depth",
    "mass", "mass_x", "mass_z", "inertia_yy",
    "volume", "volume_x", "volume_z",
    "a11", "a13", "a15", "a33", "a35", "a55", "munk_in_table",
    "d11", "d33", "d55",
    "force_scale", "reference_x", "reference_z", "lookup_scale",
)  # fmt: skip
BODY = np.dtype((np.record, [(name, np.float64) for name in _BODY_FIELDS]))
"""Scalars of the run. Masses, moments and volumes are those of all parts that do not move.

One dtype object serves all assemblies: the compiler's dispatcher compares objects first, and fields one by one else."""

_PART_REALS = (
    "axis_x", "axis_z", "neutral", "stop_low", "stop_high", "rate", "inverse_lag",
    "moving_mass", "moving_x", "moving_z",
    "x", "z", "core_volume", "grows",
)  # fmt: skip
_PART_INTEGERS = ("law_start", "law_count", "command_start", "command_count")
PART = np.dtype((np.record, [(n, np.float64) for n in _PART_REALS] + [(n, np.int64) for n in _PART_INTEGERS]))
"""One actuated part: its axis, stops, actuator, the mass that slides, and the cell that grows about (x, z)."""


class Params(NamedTuple):
    """Everything constant in a run; C-ordered, writable arrays of one exact type, so that one signature is compiled."""

    body: NDArray[np.void]  # (1,) of BODY
    parts: NDArray[np.void]  # (actuated parts,) of PART
    volume_law: NDArray[np.float64]  # (pieces, 5): extension where it begins, c0..c3 of V in powers of (e - begin)
    commands: NDArray[np.float64]  # (rows, 3): time, value, slope of the commanded extension from then on
    table: NDArray[np.float64]  # (pieces + 1, 1 + 3 n): alpha where it begins, then n coefficients of L, D, M
    lookup: NDArray[np.int64]  # (buckets,): piece at the lower edge of each equal bucket of alpha over [-pi, pi]
    error_scale: NDArray[np.float64]  # (state,): what an error of `tolerance` means in each state
    space: NDArray[np.void]  # (1,) of SPACE (spatial_layout.py)
    members: NDArray[np.void]  # (actuated parts,) of MEMBER; none for the planar model, as all that follows
    inertias: NDArray[np.float64]  # (actuated parts, 5, 6): xx yy zz xy xz yz of 1, cos, sin, cos 2, sin 2 of the angle
    solids: NDArray[np.float64]  # (parts that displace and do not move, 6): SOLID_COLUMNS
    added: NDArray[np.float64]  # (6, 6) added mass
    damping: NDArray[np.float64]  # (6, 6) linear damping
    rates: NDArray[np.float64]  # (6, 3): force by p, q, r
    coefficients: NDArray[np.float64]  # (14,): COEFFICIENT_NAMES, or LATERAL_NAMES and zeros
    grid_alpha: NDArray[np.float64]  # (a,) breaks of the table over both angles, rad
    grid_beta: NDArray[np.float64]  # (b,)
    grid: NDArray[np.float64]  # ((a - 1) (b - 1), 96): of each cell c_ij of sum c_ij ds^i dt^j, 4 x 4 for X, ... N
    water: NDArray[np.float64]  # (levels + 2, 6): z, c0..c3 of the density in powers of depth below z, pressure at z
    current: NDArray[np.float64]  # (times * levels, 9): z, c0..c3 of the velocity north, c0..c3 east
    current_times: NDArray[np.float64]  # (times,) s
    control: NDArray[np.void]  # (1,) of CONTROL (control_layout.py)
    cells: NDArray[np.float64]  # (cells under control, 10): rows of allocate.py
    waypoints: NDArray[np.float64]  # (waypoints, 2): north, east
    gains: NDArray[np.float64]  # (points, columns): rows of `feed_back` (loops.py)
    setpoints: NDArray[np.float64]  # (set points, 2): time, value
    chosen: NDArray[np.int64]  # (states fed back,): what is measured (control_layout.py), or MEASURED + part


class Work(NamedTuple):
    """Scratch arrays of one run, made outside the kernel: it allocates nothing, so no reference is ever counted."""

    k: NDArray[np.float64]  # (7, n) slopes of the stages
    y1: NDArray[np.float64]  # (n,) state after the step
    dense: NDArray[np.float64]  # (4, n) polynomial within the step
    held: NDArray[np.float64]  # (n,) a state kept for a moment
    drive: NDArray[np.float64]  # (parts + 1, 5) how each part moves in the present segment (actuators.py)
    at_stop: NDArray[np.int64]  # (parts,) -1, 0, 1: lower stop, between, upper stop
    armed: NDArray[np.int64]  # (2,) whether the surface and the bed may be met anew; at rest there, only once
    told: NDArray[np.float64]  # (parts,) the command held for a part; NaN where it follows its schedule
    seen: NDArray[np.float64]  # (MEASURED,) what the controller measures
    memory: NDArray[np.float64]  # (MEMORY,) what it remembers
    share: NDArray[np.float64]  # (parts,) of the allocation
    pending: NDArray[np.float64]  # (MOST_PENDING, parts) commands that wait for their delay
    clock: NDArray[np.float64]  # (CLOCK,) of the controller and the integrator


class Record(NamedTuple):
    """What a run leaves behind, and how it is watched."""

    times: NDArray[np.float64]  # (samples,) s
    states: NDArray[np.float64]  # (samples, n)
    events: NDArray[np.float64]  # (rows, 3) time, kind, part; further stops are not kept once it is full
    counts: NDArray[np.int64]  # (6,) samples, events, accepted steps, rejected steps, evaluations, worst state
    control: NDArray[np.float64]  # (2,) set [0] to stop early; [1] is the time reached, s
    controls: NDArray[np.float64]  # (samples or 0, SHOWN + parts) the controller's memory, and the commands it holds


def make_work(states: int, parts: int) -> Work:
    """Return fresh scratch arrays for a state of `states` numbers and `parts` actuated parts."""
    return Work(
        k=np.zeros((7, states)),
        y1=np.zeros(states),
        dense=np.zeros((4, states)),
        held=np.zeros(states),
        drive=np.zeros((parts + 1, 5)),
        at_stop=np.zeros(parts, dtype=np.int64),
        armed=np.ones(2, dtype=np.int64),
        told=np.full(parts, np.nan),
        seen=np.zeros(MEASURED),
        memory=np.zeros(MEMORY),
        share=np.zeros(parts),
        pending=np.zeros((MOST_PENDING, parts)),
        clock=np.zeros(CLOCK),
    )


def make_record(samples: int, states: int, events: int, control: NDArray[np.float64], *, shown: int = 0) -> Record:
    """Return an empty record with room for `samples` samples and `events` events; `shown` numbers of a controller."""
    return Record(
        np.zeros(samples), np.zeros((samples, states)), np.zeros((events, 3)), np.zeros(6, dtype=np.int64), control,
        np.zeros((samples if shown else 0, shown)),
    )  # fmt: skip
