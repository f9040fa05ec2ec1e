"""Time of linear models, their modes and what is made of them, on assembled designs: `python -m benchmarks.linear`.

Everything runs single-threaded in one process, after compilation; medians of interleaved rounds.
"""

from __future__ import annotations

import numpy as np

from benchmarks.timing import interleaved_times, spread
from models.assemble import assemble
from models.controllability import controllability
from models.design import Design
from models.frequency_response import frequency_response
from models.linearize import linearize, motion_matrix
from models.modes import modes_of
from models.operating_point import OperatingPoint
from models.presets import load_preset
from models.run_warnings import turning_over
from models.simulate import simulate
from models.stability import stability_over

LIMITS_MS = {"linearize": 2.0, "motion_matrix": 1.0, "turning_over": 1.0}
"""Most that each may take, ms."""
PRESETS = ("canete-dual-bellows", "quad-bellows-spiral", "seawing-spiral")


def measured(design: Design) -> dict[str, tuple[float, str]]:
    """Return the median time (ms) and its spread of each step for a design."""
    assembly, run = assemble(design), simulate(design)
    point = OperatingPoint.from_run(run, float(run.times[-1]))
    model = linearize(assembly, point)
    command = model.input_names[0]
    short = run.select(np.arange(min(2000, len(run.times))))
    times = interleaved_times(
        {
            "linearize": lambda: linearize(assembly, point),
            "motion_matrix": lambda: motion_matrix(assembly, assembly.params, assembly.initial_state),
            "modes": lambda: modes_of(model.A, model.state_names),
            "controllability": lambda: controllability(model),
            "frequency_response": lambda: frequency_response(model, input=command, output="theta"),
            "turning_over": lambda: list(turning_over(short)),
            "stability_over": lambda: stability_over(run, assembly=assembly),
        },
        rounds=31,
    )
    return {name: (1e3 * float(np.median(each)), spread(1e3 * each)) for name, each in times.items()}


def main() -> None:
    for preset_id in PRESETS:
        design = load_preset(preset_id)
        print(f"{preset_id} ({design.mission.solver.model})")
        for name, (median, middle) in measured(design).items():
            limit = f"   at most {LIMITS_MS[name]:g} ms" if name in LIMITS_MS else ""
            print(f"  {name:<20} {median:8.3f} ms  (middle half {middle}){limit}")


if __name__ == "__main__":
    main()
