"""Owns bare runs for timing: one kernel call and nothing else, and the C yardsticks, compiled and loaded."""

from __future__ import annotations

import ctypes
import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.design import Design
from models.kernel.integrate import PROGRESS, finish, integrate
from models.kernel.params import Record, make_record, make_work

Array = NDArray[np.float64]


def compile_c(name: str, folder: Path, *flags: str) -> ctypes.CDLL:
    """Compile the yardstick of this name with `-O3 -march=native` and further flags, and load it."""
    source = Path(__file__).with_name(f"{name}.c")
    library = folder / f"{name}{''.join(flags)}.so"
    command = ["gcc", "-O3", "-march=native", *flags, "-shared", "-fPIC", "-o", str(library), str(source), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def with_solver(design: Design, **changes: object) -> Design:
    """Return the design with another solver."""
    solver = design.mission.solver.model_copy(update=changes)
    return design.model_copy(update={"mission": design.mission.model_copy(update={"solver": solver})})


def with_duration(design: Design, duration: float) -> Design:
    """Return the design with a mission of another length."""
    return design.model_copy(update={"mission": design.mission.model_copy(update={"duration": duration})})


def recorded_run(assembly: Assembly) -> Callable[[], Record]:
    """Return a function that makes the bare kernel call; it returns the record, which the next call overwrites."""
    mission, solver = assembly.design.mission, assembly.design.mission.solver
    capacity, n = math.ceil(mission.duration / solver.output_interval) + 2, len(assembly.initial_state)
    record, work = make_record(capacity, n, 100, np.zeros(2)), make_work(n, len(assembly.cells))

    def run() -> Record:
        record.counts[:] = 0
        work.armed[:] = 1
        work.told[:] = math.nan
        work.memory[:] = 0.0
        work.clock[:] = 0.0
        y = assembly.initial_state.copy()
        integrate(
            solver.method == "adaptive", 0.0, mission.duration, solver.step, solver.output_interval, 10_000_000,
            y, assembly.params, work, record,
        )  # fmt: skip
        finish(record.control[PROGRESS], y, work, record)
        return record

    return run


def kernel_run(assembly: Assembly) -> Callable[[], Array]:
    """Return a function that makes the bare kernel call and returns the states (samples, n)."""
    run = recorded_run(assembly)

    def states() -> Array:
        record = run()
        return record.states[: record.counts[0]]

    return states
