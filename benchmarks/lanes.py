"""Speed of many designs flown side by side, beside one at a time and C: `python -m benchmarks.lanes`.

Everything runs single-threaded in one process; the C yardsticks (planar_rk4.c, spatial.c) are compiled here with
`gcc -O3 -march=native` and fly one of the designs.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import planar, spatial
from benchmarks.bare import compile_c, kernel_run, with_solver
from benchmarks.timing import interleaved_times, print_ratio, spread
from models.assemble import Assembly, assemble
from models.batch import cases_of, hold_for
from models.design import Design, parse_design
from models.kernel.lanes import fly_lanes
from models.presets import load_preset
from models.simulate import Control

Array = NDArray[np.float64]
DESIGNS = 32
MOST_STEPS = 10_000_000


def varied(design: Design, k: int) -> Design:
    """Return the design with another start, and its first component moved a little."""
    document: dict[str, Any] = design.model_dump(mode="json")
    x, y, z = document["vehicle"]["components"][0]["position"]
    document["vehicle"]["components"][0]["position"] = [x + 1e-5 * k, y, z + 1e-5 * k]
    document["mission"]["initial"]["pitch"] += 1e-3 * k
    return parse_design(document)


def lanes_run(assemblies: list[Assembly]) -> Callable[[], Array]:
    """Return a function that makes the bare kernel call and returns the states of all designs, one after another."""
    cases = cases_of(assemblies, Control())
    hold = hold_for(cases)

    def run() -> Array:
        cases.record.counts[:] = 0
        fly_lanes(False, MOST_STEPS, cases, hold)
        return cases.record.states

    return run


def largest_difference(assemblies: list[Assembly], flown: Array) -> float:
    """Return by how much any state differs from that of a single run, as a share of its size or of 1."""
    worst, first = 0.0, 0
    rows = len(flown) // len(assemblies)
    for assembly in assemblies:
        alone = kernel_run(assembly)()
        difference = np.abs(flown[first : first + len(alone)] - alone)
        worst = max(worst, float((difference / np.maximum(np.abs(alone).max(axis=0), 1.0)).max()))
        first += rows
    return worst


def report(name: str, design: Design, in_c: Callable[[Assembly], Callable[[], Array]], target: float) -> None:
    """Print what a design and step cost by each way, and their ratios."""
    assemblies = [assemble(varied(design, k)) for k in range(DESIGNS)]
    steps = round(design.mission.duration / design.mission.solver.step)
    lanes = lanes_run(assemblies)
    cases = {"lanes": lanes, "single kernel": kernel_run(assemblies[0]), "c": in_c(assemblies[0])}
    times = interleaved_times(cases, rounds=21)
    times["lanes"] /= DESIGNS
    print(f"{name}: {DESIGNS} designs, RK4, {steps} steps of {design.mission.solver.step:g} s")
    for case, values in times.items():
        each = 1e9 * values / steps
        print(f"  {case:<14} {np.median(each):8.1f} ns a design and step ({spread(each)})")
    print(f"  largest difference from single runs: {largest_difference(assemblies, lanes()):.1e}")
    print(f"  rate over C round by round: {spread(times['c'] / times['lanes'])}")
    for case, goal in (("c", f"at least {target:g}x"), ("single kernel", "no target")):
        ratio = float(np.median(times[case]) / np.median(times["lanes"]))
        print_ratio(f"{name} in lanes: rate over {case}", ratio, target=goal)


def main() -> None:
    """Run everything and print the ratios."""
    with tempfile.TemporaryDirectory() as folder:
        glide = with_solver(load_preset("canete-dual-bellows"), method="rk4", step=planar.STEP)
        library = compile_c("planar_rk4", Path(folder))
        report("planar", glide, lambda assembly: planar.c_run(library, assembly), 3.0)
        for water, environment in spatial.WATERS.items():
            library = compile_c("spatial", Path(folder))
            flight = spatial.four_cells(environment)
            report(f"spatial, {water}", flight, lambda assembly, c=library: spatial.c_run(c, assembly), 2.0)


if __name__ == "__main__":
    main()
