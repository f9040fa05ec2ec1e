"""What control costs: `python -m benchmarks.control`. One loop of the kernel, and steps of the environments.

The closed loop is compared with the open loop that replays its very commands as a schedule: the same motion, the same
breakpoints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import cycle

import numpy as np
from numpy.typing import NDArray

from benchmarks.bare import recorded_run
from benchmarks.timing import interleaved_medians, interleaved_times, print_ratio, spread
from models.assemble import Assembly, assemble
from models.design import Design, parse_design
from models.gym_environment import STEP_TIME, GliderEnv, GliderVectorEnv
from models.presets import load_preset
from models.simulate import simulate

PRESET = "quad-bellows-glide"
DURATION, GLIDERS = 600.0, 1024
CASCADE = {
    "kind": "cascade",
    "vertical": {"kind": "depth_band", "top": 5.0, "bottom": 25.0, "dive_heave": -4.0, "climb_heave": 4.0},
    "pitch": {"dive": -0.35, "loop": {"proportional": 2.0, "integral": 0.05, "derivative": 4.0, "limit": 3.0}},
    "lateral": {
        "guidance": {"kind": "heading", "heading": 1.0},
        "roll_loop": {"proportional": 1.0, "integral": 0.02, "derivative": 1.0, "limit": 1.0},
        "heading_loop": {"proportional": 0.6, "derivative": 3.0, "limit": 0.35},
    },
}


def controlled(sample_time: float, **solver: object) -> Design:
    """Return the quad-bellows glider under a cascade, sampled in the result as it samples."""
    document = load_preset(PRESET).model_dump(mode="json")
    document["mission"]["control"] = {"controller": CASCADE | {"sample_time": sample_time}}
    document["mission"]["duration"] = DURATION
    document["mission"]["solver"] |= {"output_interval": sample_time} | solver
    return parse_design(document)


def replayed(design: Design) -> Design:
    """Return the design with the commands of its controller as a schedule."""
    run = simulate(design)
    document = design.model_dump(mode="json")
    document["mission"]["control"] = {
        "schedules": [
            {
                "cell": cell,
                "points": [
                    {"time": time, "extension": extension}
                    for time, extension in zip(
                        run.times[:-1].tolist(), run.cell_values["command"][:-1, k].tolist(), strict=True
                    )
                ],
            }
            for k, cell in enumerate(run.cells)
        ]
    }
    return parse_design(document)


def compare_loops(sample_time: float, **solver: object) -> None:
    """Print what closing the loop costs."""
    design = controlled(sample_time, **solver)
    closed, opened = assemble(design), assemble(replayed(design))
    depths = [final_depth(assembly) for assembly in (closed, opened)]
    assert abs(depths[0] - depths[1]) < 1e-6, depths
    times = interleaved_times({"closed": recorded_run(closed), "open": recorded_run(opened)}, rounds=31)
    ratios = times["closed"] / times["open"]
    method = "RK4" if solver["method"] == "rk4" else "adaptive"
    print(
        f"{method}, sampled every {sample_time:g} s: closed {1e3 * np.median(times['closed']):.2f} ms, open "
        f"{1e3 * np.median(times['open']):.2f} ms for {DURATION:g} s of gliding; ratios {spread(ratios)}"
    )
    print_ratio(f"  closed loop over open loop, {method}", float(np.median(ratios)), target="<= 1.3x")


def final_depth(assembly: Assembly) -> float:
    """Return the depth at the end of a run, m."""
    record = recorded_run(assembly)()
    return float(record.states[record.counts[0] - 1, 2])


def measure_environments() -> None:
    """Print what a step costs, one glider and many."""
    many, one = GliderVectorEnv(GLIDERS, PRESET), GliderEnv(PRESET, duration=1e6)
    two = GliderVectorEnv(GLIDERS, PRESET, threads=2)
    random = np.random.default_rng(0)
    batches = cycle([random.uniform(-1.0, 1.0, many.action_space.shape or ()).astype(np.float32) for _ in range(8)])
    actions = cycle([random.uniform(-1.0, 1.0, 4).astype(np.float32) for _ in range(8)])
    for env in (many, two, one):
        env.reset(seed=0)
    cases = {
        "many": repeated(many, batches, 8), "two threads": repeated(two, batches, 8),
        "one": repeated(one, actions, 500),
    }  # fmt: skip
    medians = interleaved_medians(cases, rounds=21)
    print(f"a step of {STEP_TIME:g} s, RK4 steps of {many.step_size:g} s, {PRESET}:")
    print_time(f"{GLIDERS} gliders, a glider", medians["many"] / (8 * GLIDERS), target="<= 3 us")
    print_time(f"{GLIDERS} gliders on two threads, a glider", medians["two threads"] / (8 * GLIDERS), target="")
    print_time("one glider", medians["one"] / 500, target="<= 40 us")
    many.close()
    two.close()


def repeated(
    env: GliderEnv | GliderVectorEnv, actions: Iterator[NDArray[np.float32]], count: int
) -> Callable[[], object]:
    """Return a function that makes as many steps."""

    def steps() -> None:
        for _ in range(count):
            env.step(next(actions))

    return steps


def print_time(label: str, seconds: float, *, target: str) -> None:
    print(f"  {label:<62} {1e6 * seconds:8.2f} us" + (f"  to reach: {target}" if target else ""))


if __name__ == "__main__":
    for interval in (2.0, 0.5):
        compare_loops(interval, method="rk4", step=0.25)
        compare_loops(interval, method="adaptive")
    measure_environments()
