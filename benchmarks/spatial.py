"""Speed, accuracy and energy of flights in six degrees of freedom, side by side with C: `python -m benchmarks.spatial`.

Everything runs single-threaded in one process; the C yardstick is compiled here with `gcc -O3 -march=native`.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.bare import compile_c, kernel_run, recorded_run, with_duration, with_solver
from benchmarks.timing import interleaved_times, print_ratio, spread
from models.assemble import Assembly, assemble
from models.design import Design, parse_design
from models.kernel.integrate import ACCEPTED
from models.mission import Solver
from models.presets import load_preset, preset_ids
from models.presets.quad_glider import quad_glider
from models.simulate import simulate

Array = NDArray[np.float64]
STEP = 0.02
"""Step of RK4 beside C, s."""
POSITION_GOAL = 1e-4
HOUR = 3600.0
WATERS: dict[str, dict[str, Any]] = {
    "still, stratified water": {},
    "a sheared current": {"current": {"kind": "sheared", "surface_velocity": [0.05, -0.03], "shear": [-4e-4, 3e-4]}},
}


class CParams(ctypes.Structure):
    """The `Params` of spatial.c: pointers into the kernel's own records."""

    _fields_ = tuple(
        (name, ctypes.c_int64 if name.startswith("n_") or name == "table_rows" else ctypes.c_void_p)
        for name in (
            "body", "parts", "n_parts", "volume_law", "commands", "table", "table_rows", "lookup", "n_lookup",
            "space", "members", "solids", "n_solids", "added", "damping", "rates", "lateral",
            "water", "n_water", "current", "current_times", "n_current_times",
        )
    )  # fmt: skip


def four_cells(water: dict[str, Any]) -> Design:
    """Return the quad glider's spiral in water given by its density, run by RK4."""
    document = quad_glider("spiral")
    profile = {"kind": "density_profile", "depths": [0.0, 8.0, 20.0, 120.0], "densities": [998.2, 998.4, 999.8, 1000.4]}
    document["mission"]["environment"] = {"water": profile, "surface": "end", "gravity": 9.8, **water}
    document["mission"]["duration"] = 240.0
    return with_solver(parse_design(document), method="rk4", step=STEP, output_interval=1.0)


def c_run(library: ctypes.CDLL, assembly: Assembly) -> Callable[[], Array]:
    """Return a function that integrates the design in C, segment by segment of its schedule."""
    p, mission = assembly.params, assembly.design.mission
    sizes = {
        "n_parts": p.parts, "table_rows": p.table, "n_lookup": p.lookup, "n_solids": p.solids, "n_water": p.water,
        "n_current_times": p.current_times,
    }  # fmt: skip
    arrays = p._asdict() | {"lateral": p.coefficients}
    records = CParams(*(len(sizes[n]) if n in sizes else arrays[n].ctypes.data for n, _ in CParams._fields_))
    every = round(mission.solver.output_interval / STEP)
    corners = {point.time for s in mission.control.schedules for point in s.points}
    times = [*sorted({0.0} | {t for t in corners if t < mission.duration}), mission.duration]
    segments = [(start, round((end - start) / STEP)) for start, end in pairwise(times)]
    states = np.zeros((sum(steps for _, steps in segments) // every + 1, len(assembly.initial_state)))
    rk4 = library.rk4
    rk4.argtypes = [ctypes.c_void_p] * 2 + [ctypes.c_double] * 2 + [ctypes.c_int64] * 2 + [ctypes.c_void_p]
    rk4.restype = ctypes.c_int64

    def run() -> Array:
        y = assembly.initial_state.copy()
        saved = 0
        for start, steps in segments:
            saved += rk4(y.ctypes.data, ctypes.byref(records), start, STEP, steps, every, states[saved:].ctypes.data)
        states[saved] = y
        return states

    return run


def report_beside_c() -> None:
    """Print kernel and C side by side, in still water and in a current.

    gcc's own vectors slow this code down, so that C stands beside it without them too.
    """
    with tempfile.TemporaryDirectory() as folder:
        libraries = {"c": compile_c("spatial", Path(folder))}
        libraries["c, no vectors"] = compile_c("spatial", Path(folder), "-fno-tree-vectorize")
        for name, water in WATERS.items():
            assembly = assemble(four_cells(water))
            kernel = kernel_run(assembly)
            in_c = {case: c_run(library, assembly) for case, library in libraries.items()}
            times = interleaved_times({"kernel": kernel} | in_c, rounds=41)
            a, b = kernel(), in_c["c"]()
            difference = (np.abs(a - b) / np.maximum(np.abs(b).max(axis=0), 1.0)).max()
            count = 4 * round(assembly.design.mission.duration / STEP)
            print(f"four cells in {name}: RK4 at {STEP:g} s, {count} derivatives")
            for case, values in times.items():
                print(f"  {case:<14} {1e9 * np.median(values) / count:6.1f} ns each ({spread(1e9 * values / count)})")
            print(f"  largest difference of any state, as a share of its size or of 1: {difference:.1e}")
            for case, target in (("c", "at most 1.3x"), ("c, no vectors", "no target")):
                ratios = times["kernel"] / times[case]
                print(f"  ratio round by round: {spread(ratios)}")
                ratio = float(np.median(times["kernel"]) / np.median(times[case]))
                print_ratio(f"spatial derivative: kernel time over {case}", ratio, target=target)


def position_error(states: Array, reference: Array) -> float:
    """Return the largest distance between two paths at the output times, m."""
    return float(np.linalg.norm(states[:, :3] - reference[:, :3], axis=1).max())


def tolerance_for_goal(design: Design, reference: Array) -> tuple[float, float]:
    """Return the loosest tolerance of a fine ladder whose path meets the goal at every output time, and its error."""
    for exponent in np.arange(-4.0, -11.0, -0.25):
        tolerance = float(10.0**exponent)
        states = kernel_run(assemble(with_solver(design, tolerance=tolerance)))()
        if len(states) == len(reference) and (error := position_error(states, reference)) <= POSITION_GOAL:
            return tolerance, error
    raise SystemExit("no tolerance meets the goal")


def report_yo_yo(whole: Design) -> None:
    """Print the speed of one hour of the yo-yo at the goal's accuracy."""
    hour = with_duration(whole, HOUR)
    finest, finer = (kernel_run(assemble(with_solver(hour, tolerance=t)))() for t in (1e-13, 1e-12))
    tolerance, error = tolerance_for_goal(hour, finest)
    at_goal = with_solver(hour, tolerance=tolerance)
    kernel = recorded_run(assemble(at_goal))
    times = interleaved_times({"kernel": kernel, "whole run": lambda: simulate(at_goal)}, rounds=41)
    seconds = float(np.median(times["kernel"]))
    print(f"{whole.name}: one hour of it")
    print(f"  tolerances of 1e-13 and 1e-12 differ by {position_error(finer, finest):.1e} m")
    print(f"  at tolerance {tolerance:.1e}: largest position error {error:.1e} m against 1e-13")
    print(f"  {kernel().counts[ACCEPTED]} steps, {seconds:.4f} s ({spread(times['kernel'])}), to reach: 1 s")
    print(f"  with assembly and outputs {np.median(times['whole run']):.4f} s ({spread(times['whole run'])})")
    print_ratio("one hour at 1e-4 m: faster than real time by", HOUR / seconds, target="at least 3600x")


def report_cost_of_step(whole: Design) -> None:
    """Print what an accepted step costs in a mission and in its first tenth."""
    lengths = {"first tenth": 0.1 * whole.mission.duration, "whole": whole.mission.duration}
    runs = {name: recorded_run(assemble(with_duration(whole, length))) for name, length in lengths.items()}
    times = interleaved_times(runs, rounds=21)
    each = {name: 1e6 * times[name] / run().counts[ACCEPTED] for name, run in runs.items()}
    for name, values in each.items():
        print(f"  {name}, {lengths[name]:g} s: {np.median(values):.2f} us a step ({spread(values)})")
    ratio = float(np.median(each["whole"]) / np.median(each["first tenth"]))
    print_ratio("cost of a step: whole mission over its first tenth", ratio, target="about 1x")


def report_energy() -> None:
    """Print the work-energy residual of every preset at the default tolerance."""
    tolerance = Solver().tolerance
    print(f"largest work-energy residual over the energy exchanged, tolerance {tolerance:g}   to reach: below 1e-6")
    for preset_id in preset_ids():
        run = simulate(with_solver(load_preset(preset_id), method="adaptive", tolerance=tolerance))
        print(f"  {preset_id:<32} {run.relative_residual:.1e}   ({run.model}, {run.status.name})")


def main() -> None:
    """Run everything and print the ratios."""
    report_beside_c()
    yo_yo = load_preset("quad-bellows-yo-yo")
    report_yo_yo(yo_yo)
    report_cost_of_step(yo_yo)
    report_energy()


if __name__ == "__main__":
    main()
