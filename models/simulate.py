"""Owns one run: a design goes through the door and the kernel, and comes back as a result on named axes."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.design import Design
from models.kernel import KERNEL_HASH, params
from models.kernel import outputs as planar
from models.kernel import spatial_outputs as spatial
from models.kernel.control_layout import SHOWN
from models.kernel.integrate import CANCEL, PROGRESS, finish, integrate
from models.kernel.params import Record, Work
from models.limits import DEFAULT_LIMITS, Limits
from models.run import Event, Run, Status
from models.variables import CONTROL_VARIABLES

Array = NDArray[np.float64]
STATUS_BY_CODE = (
    Status.completed, Status.surface, Status.bed, Status.diverged,
    Status.step_too_small, Status.too_many_steps, Status.cancelled,
)  # fmt: skip
EVENT_KINDS = {1: "surface", 2: "bed", 3: "end_of_stroke", 4: "dive", 5: "climb", 6: "waypoint"}
MAX_EVENTS = 1000
STATES = {
    "planar": ("x", "z", "theta", "u", "w", "q", "actuator_work", "water_work"),
    "spatial": (
        "x", "y", "z", "q0", "q1", "q2", "q3", "u", "v", "w", "p", "q", "r",
        "actuator_work", "water_work", "bed_work",
    ),
}  # fmt: skip
"""Names of the states before the extensions."""
FAILED = (Status.diverged, Status.step_too_small)


class Control:
    """A handle on a run in another thread: its progress, and a way to stop it."""

    def __init__(self) -> None:
        self.flags = np.zeros(2)

    def cancel(self) -> None:
        """Ask the run to stop after its present step; what it has computed is kept."""
        self.flags[CANCEL] = 1.0

    @property
    def cancelled(self) -> bool:
        """Whether it was asked to stop."""
        return bool(self.flags[CANCEL])

    @property
    def time_reached(self) -> float:
        """Simulated time reached, s."""
        return float(self.flags[PROGRESS])


def simulate(design: Design, *, limits: Limits = DEFAULT_LIMITS, control: Control | None = None) -> Run:
    """Simulate a design's mission.

    Raises
    ------
    DesignError
        Where the design cannot be simulated. What goes wrong during the run is told by `Run.status`.

    """
    return run_assembly(assemble(design, limits), limits=limits, control=control)


def run_assembly(assembly: Assembly, *, limits: Limits = DEFAULT_LIMITS, control: Control | None = None) -> Run:
    """Integrate an assembled design and compute its outputs."""
    mission, solver = assembly.design.mission, assembly.design.mission.solver
    y, p, work = assembly.initial_state.copy(), assembly.params, make_work(assembly)
    record = make_record(assembly, control)
    began = time.perf_counter()
    code = integrate(
        solver.method == "adaptive", 0.0, mission.duration, solver.step, solver.output_interval, limits.steps,
        y, p, work, record,
    )  # fmt: skip
    finish(record.control[PROGRESS], y, work, record)
    return make_run(assembly, record, int(code), time.perf_counter() - began)


def make_work(assembly: Assembly) -> Work:
    """Return fresh scratch arrays for a run of a design."""
    return params.make_work(len(assembly.initial_state), len(assembly.cells))


def make_record(assembly: Assembly, control: Control | None = None, *, keeps_commands: bool = False) -> Record:
    """Return an empty record with room for a design's mission.

    It keeps what a controller of the design shows, and, with that or with `keeps_commands`, the commands that are held.
    """
    mission = assembly.design.mission
    capacity = math.ceil(mission.duration / mission.solver.output_interval) + 2
    shown = SHOWN + len(assembly.cells) if keeps_commands or mission.control.controller is not None else 0
    flags = control.flags if control is not None else np.zeros(2)
    return params.make_record(capacity, len(assembly.initial_state), MAX_EVENTS, flags, shown=shown)


def make_run(assembly: Assembly, record: Record, code: int, elapsed: float) -> Run:
    """Compute the outputs of what the kernel recorded; `code` is its status, `elapsed` (s) what it took."""
    counts = record.counts
    samples = int(counts[0])
    values, cells = _second_pass(assembly, record.times[:samples], record.states[:samples])
    if len(record.controls):
        told = record.controls[:samples, SHOWN:]
        cells["command"] = np.where(np.isnan(told), cells["command"], told)
    if assembly.design.mission.control.controller is not None:
        values |= dict(zip(CONTROL_VARIABLES, record.controls[:samples, :SHOWN].T, strict=True))
    statistics: dict[str, int | float] = {
        "steps": int(counts[2]), "rejected_steps": int(counts[3]), "evaluations": int(counts[4]), "elapsed": elapsed,
    }  # fmt: skip
    status = STATUS_BY_CODE[code]
    return Run(
        design=assembly.design, times=record.times[:samples], values=values, cells=assembly.cells, cell_values=cells,
        status=status, events=_events(record.events[: counts[1]], assembly.cells), statistics=statistics,
        kernel=KERNEL_HASH, trouble=_state_name(assembly, int(counts[5])) if status in FAILED else None,
    )  # fmt: skip


def _second_pass(assembly: Assembly, times: Array, states: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return every variable over time, and every one over time and cell, from the saved states."""
    solver, parts = assembly.design.mission.solver, len(assembly.cells)
    names, second = STATES[solver.model], spatial if solver.model == "spatial" else planar
    columns = np.empty((len(times), len(second.COLUMNS)))
    commands, volumes = (np.empty((len(times), parts)) for _ in range(2))
    if solver.model == "spatial":
        spatial.spatial_outputs(times, states, assembly.params, columns, commands, volumes)
    else:
        planar.outputs(times, states, assembly.params, columns, commands, volumes)
    first = len(names)
    values = dict(zip(names, states[:, :first].T, strict=True)) | dict(zip(second.COLUMNS, columns.T, strict=True))
    cells = {"command": commands, "extension": states[:, first : first + parts], "volume": volumes}
    if solver.model == "spatial":
        cells["energy"] = states[:, first + parts :]
        values["battery_energy"] = cells["energy"].sum(axis=1) + assembly.design.vehicle.hotel_power * times
    return values, cells


def _state_name(assembly: Assembly, index: int) -> str:
    names = STATES[assembly.design.mission.solver.model]
    if index < len(names):
        return names[index]
    what = ("the extension", "the energy")[(index - len(names)) // len(assembly.cells)]
    return f"{what} of '{assembly.cells[(index - len(names)) % len(assembly.cells)]}'"


def _events(rows: Array, cells: tuple[str, ...]) -> tuple[Event, ...]:
    return tuple(
        Event(float(t), EVENT_KINDS[int(kind)], cells[int(part)] if part >= 0 else None) for t, kind, part in rows
    )
