"""One assembly may be simulated by several threads at once: they share constants, never memory or scratch."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np

from models.assemble import assemble
from models.run import Run
from models.simulate import run_assembly
from tests.models.test_closed_loop import HEADING, controlled


def test_two_threads_with_one_controller_fly_as_alone() -> None:
    noise = {"attitude": 0.005, "depth": 0.05, "rate": 0.001, "seed": 3}
    assembly = assemble(controlled(300.0, lateral=HEADING, noise=noise, delay=0.5))
    alone = run_assembly(assembly)
    together = Barrier(2)

    def fly(_: int) -> Run:
        together.wait()
        return run_assembly(assembly)

    with ThreadPoolExecutor(2) as pool:
        for run in pool.map(fly, range(2)):
            np.testing.assert_array_equal(run.times, alone.times)
            for kind in ("values", "cell_values"):
                for name, rows in getattr(alone, kind).items():
                    np.testing.assert_array_equal(getattr(run, kind)[name], rows, err_msg=name)
            assert run.events == alone.events
