"""Owns one run: a design goes through the door and the kernel, and comes back as a result on named axes."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.design import Design
from models.kernel import KERNEL_HASH
from models.kernel.integrate import CANCEL, PROGRESS, integrate
from models.kernel.outputs import COLUMNS, outputs
from models.kernel.params import EXTENSIONS, make_record, make_work
from models.limits import DEFAULT_LIMITS, Limits
from models.run import Event, Run, Status

STATUS_BY_CODE = (
    Status.completed, Status.surface, Status.bed, Status.diverged,
    Status.step_too_small, Status.too_many_steps, Status.cancelled,
)  # fmt: skip
EVENT_KINDS = {1: "surface", 2: "bed", 3: "end_of_stroke"}
MAX_EVENTS = 1000
STATES = ("x", "z", "theta", "u", "w", "q", "actuator_work", "water_work")


class Control:
    """A handle on a run in another thread: its progress, and a way to stop it."""

    def __init__(self) -> None:
        self.flags = np.zeros(2)

    def cancel(self) -> None:
        """Ask the run to stop after its present step; what it has computed is kept."""
        self.flags[CANCEL] = 1.0

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
    design, p = assembly.design, assembly.params
    mission, solver = design.mission, design.mission.solver
    n = len(assembly.initial_state)
    capacity = math.ceil(mission.duration / solver.output_interval) + 2
    record = make_record(capacity, n, MAX_EVENTS, control.flags if control is not None else np.zeros(2))
    began = time.perf_counter()
    code = integrate(
        solver.method == "adaptive", mission.duration, solver.step, solver.output_interval, limits.steps,
        assembly.initial_state.copy(), p, make_work(n, len(assembly.cells)), record,
    )  # fmt: skip
    counts = record.counts
    samples = int(counts[0])
    times, states = record.times[:samples], record.states[:samples]
    columns = np.zeros((samples, len(COLUMNS)))
    commands, volumes = (np.zeros((samples, len(assembly.cells))) for _ in range(2))
    outputs(times, states, p, columns, commands, volumes)
    statistics: dict[str, int | float] = {
        "steps": int(counts[2]),
        "rejected_steps": int(counts[3]),
        "evaluations": int(counts[4]),
        "elapsed": time.perf_counter() - began,
    }
    values = dict(zip(STATES, states[:, :EXTENSIONS].T, strict=True)) | dict(zip(COLUMNS, columns.T, strict=True))
    cells = {"command": commands, "extension": states[:, EXTENSIONS:], "volume": volumes}
    return Run(
        design=design, times=times, values=values, cells=assembly.cells, cell_values=cells,
        status=STATUS_BY_CODE[code], events=_events(record.events[: counts[1]], assembly.cells),
        statistics=statistics, kernel=KERNEL_HASH,
    )  # fmt: skip


def _events(rows: NDArray[np.float64], cells: tuple[str, ...]) -> tuple[Event, ...]:
    return tuple(
        Event(float(t), EVENT_KINDS[int(kind)], cells[int(part)] if part >= 0 else None) for t, kind, part in rows
    )
