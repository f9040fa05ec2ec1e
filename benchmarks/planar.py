"""Speed and accuracy of planar glides, side by side with C and SciPy: `python -m benchmarks.planar`.

Everything runs single-threaded in one process; the C yardstick is compiled here with `gcc -O3 -march=native`.
"""

from __future__ import annotations

import ctypes
import tempfile
import tracemalloc
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.bare import compile_c, kernel_run, with_solver
from benchmarks.reference import solve_reference
from benchmarks.timing import interleaved_medians, print_ratio
from models.assemble import Assembly, assemble
from models.design import Design
from models.kernel.params import EXTENSIONS
from models.presets import load_preset
from models.simulate import run_assembly

Array = NDArray[np.float64]
STEP = 1e-3
POSITION_GOAL = 1e-6


class CParams(ctypes.Structure):
    """The `Params` of planar_rk4.c: pointers into the kernel's own records."""

    _fields_ = (
        ("body", ctypes.c_void_p), ("parts", ctypes.c_void_p), ("n_parts", ctypes.c_int64),
        ("volume_law", ctypes.c_void_p), ("commands", ctypes.c_void_p), ("table", ctypes.c_void_p),
        ("table_rows", ctypes.c_int64), ("columns", ctypes.c_int64),
        ("lookup", ctypes.c_void_p), ("n_lookup", ctypes.c_int64),
    )  # fmt: skip


def c_run(library: ctypes.CDLL, assembly: Assembly) -> Callable[[], Array]:
    """Return a function that integrates the preset in C, segment by segment of its step schedule."""
    p, mission = assembly.params, assembly.design.mission
    records = CParams(
        p.body.ctypes.data, p.parts.ctypes.data, len(p.parts), p.volume_law.ctypes.data, p.commands.ctypes.data,
        p.table.ctypes.data, *p.table.shape, p.lookup.ctypes.data, len(p.lookup),
    )  # fmt: skip
    every = round(mission.solver.output_interval / STEP)
    times = [*sorted({point.time for s in mission.control.schedules for point in s.points}), mission.duration]
    steps = [round((b - a) / STEP) for a, b in pairwise(times)]
    commands = [{s.cell: s.points[k].extension for s in mission.control.schedules} for k in range(len(steps))]
    states = np.zeros((sum(steps) // every + 1, len(assembly.initial_state)))
    rates = np.zeros(len(p.parts))
    rk4 = library.rk4
    rk4.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_double, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p]
    rk4.restype = ctypes.c_int64

    def run() -> Array:
        y = assembly.initial_state.copy()
        saved = 0
        for count, command in zip(steps, commands, strict=True):
            for i, name in enumerate(assembly.cells):
                y[EXTENSIONS + i] = command.get(name, y[EXTENSIONS + i])
            out = states[saved:].ctypes.data
            saved += rk4(y.ctypes.data, ctypes.byref(records), rates.ctypes.data, STEP, count, every, out)
        states[saved] = y
        return states

    return run


def position_error(states: Array, reference: Array) -> float:
    """Return the largest distance between two paths at the output times, m."""
    return float(np.hypot(*(states[:, :2].T - reference[:2])).max())


def tolerance_for_goal(design: Design, reference: Array) -> tuple[float, float]:
    """Return the loosest tolerance of a fine ladder whose path meets the goal at every output time, and its error."""
    for exponent in np.arange(-4.0, -11.0, -0.25):
        tolerance = float(10.0**exponent)
        states = kernel_run(assemble(with_solver(design, method="adaptive", tolerance=tolerance)))()
        if (error := position_error(states, reference)) <= POSITION_GOAL:
            return tolerance, error
    raise SystemExit("no tolerance meets the goal: the kernel and the reference disagree")


def report_memory(design: Design) -> None:
    """Print what a long run allocates beside its own output; it starts deep, so that it runs to its end."""
    initial = design.mission.initial.model_copy(update={"position": (0.0, 0.0, 1000.0)})
    mission = design.mission.model_copy(update={"duration": 2000.0, "initial": initial})
    long = design.model_copy(update={"mission": mission})
    assembly = assemble(long)
    run_assembly(assembly)
    tracemalloc.start()
    run = run_assembly(assembly)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    samples, output = run.data.sizes["time"], run.data.nbytes
    print(f"memory of a run of {samples} samples: peak {peak / 1e6:.2f} MB, output {output / 1e6:.2f} MB")


def main() -> None:
    """Run everything and print the ratios."""
    design = load_preset("canete-dual-bellows")
    fixed = assemble(with_solver(design, method="rk4", step=STEP))
    interval = design.mission.solver.output_interval
    times = np.arange(round(design.mission.duration / interval) + 1) * interval
    reference = solve_reference(design, times, method="DOP853", tolerance=1e-12)
    tolerance, error = tolerance_for_goal(design, reference)
    adaptive = kernel_run(assemble(with_solver(design, method="adaptive", tolerance=tolerance)))
    with tempfile.TemporaryDirectory() as folder:
        in_c = c_run(compile_c("planar_rk4", Path(folder)), fixed)
        kernel = kernel_run(fixed)
        cases = {"kernel rk4": kernel, "c rk4": in_c, "kernel adaptive": adaptive}
        median = interleaved_medians(cases, rounds=41)
        difference = np.abs(kernel() - in_c())[:, [0, 1, 2, 3, 4, 5, 7]].max()
    print(f"{design.name}, {design.mission.duration:g} s, {len(times)} samples")
    for name, seconds in median.items():
        print(f"  {name:<18} {1e3 * seconds:9.3f} ms")
    print(f"  largest difference of any state, kernel and C: {difference:.1e}")
    print(f"  adaptive at tolerance {tolerance:.1e}: largest position error {error:.1e} m against DOP853 at 1e-12")
    print(f"  rk4 at {STEP} s: largest position error {position_error(kernel(), reference):.1e} m")
    print_ratio("RK4 at 1 ms: kernel time over C time", median["kernel rk4"] / median["c rk4"], target="at most 1.25x")
    speedup = median["kernel rk4"] / median["kernel adaptive"]
    print_ratio("adaptive pair at 1e-6 m: faster than RK4 at 1 ms by", speedup, target="at least 8x")
    scipy_tolerance = 1e-6
    while position_error(solve_reference(design, times, method="RK45", tolerance=scipy_tolerance).T, reference) > 1e-6:
        scipy_tolerance /= 2.0
    cases = {
        "scipy": lambda: solve_reference(design, times, method="RK45", tolerance=scipy_tolerance),
        "kernel": adaptive,
    }
    median = interleaved_medians(cases, rounds=3)
    print(f"  solve_ivp RK45 at {scipy_tolerance:.1e}, same accuracy: {1e3 * median['scipy']:.1f} ms")
    print_ratio("adaptive pair: faster than solve_ivp by", median["scipy"] / median["kernel"], target="at least 100x")
    report_memory(design)


if __name__ == "__main__":
    main()
