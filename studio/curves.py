"""Owns a run's curves for the page: only the columns that it draws, thinned to what a screen shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.components import Actuated
from models.design import Design
from models.memory import remembered_for_life
from models.run import Run
from server.decimation import choose_samples
from studio.attitude import attitudes
from studio.run_marks import outside_spans, phases_of

Array = NDArray[np.float64]

MAX_POINTS = {"planar": 800, "spatial": 1200}
KEPT = {
    "planar": ("z", "theta", "alpha", "flow_angle", "speed", "net_buoyancy"),
    "spatial": ("z", "phi", "theta", "alpha", "beta", "speed", "net_buoyancy", "turn_rate"),
}
"""Columns whose extremes thinning keeps, beside the cells'."""
SHARED = (
    "x", "z", "theta", "alpha", "flow_angle", "speed", "net_buoyancy", "lift", "drag", "moment",
    "com_x", "com_z", "cob_x", "cob_z",
)  # fmt: skip
SHOWN = {
    "planar": SHARED,
    "spatial": (
        *SHARED, "y", "phi", "beta", "side_force", "turn_rate", "turn_radius", "battery_energy", "com_y", "cob_y",
        "hydro_K", "hydro_N",
    ),
}  # fmt: skip
"""Columns that the page uses as they are."""
OF_CELL = ("command", "extension")
MADE_UNITS = {"heading": "rad", "travelled": "m", "q0": "1", "q1": "1", "q2": "1", "q3": "1"}


def run_document(run: Run, design: Design) -> dict[str, Any]:
    """Return a run as the page draws it; its cells by their index in the present design."""
    chosen = curve_samples(run, MAX_POINTS[run.model])
    columns = {name: run.values[name] for name in SHOWN[run.model]} | made_columns(run)
    units = {name: about[0] for name, about in run.variables.items()} | MADE_UNITS
    indices = {c.name: i for i, c in enumerate(design.vehicle.components) if isinstance(c, Actuated)}
    shown = {"t": run.times} | columns
    cells = [k for k, name in enumerate(run.cells) if name in indices]
    of_cells = [run.cell_values[kind][:, k] for k in cells for kind in OF_CELL]
    drawn = iter(rounded(np.array([column[chosen] for column in (*shown.values(), *of_cells)])))
    return {
        "model": run.model,
        "status": run.status.name,
        "message": run.message,
        "events": [{"time": e.time, "kind": e.kind, "cell": e.cell, "label": str(e)} for e in run.events],
        "phases": phases_of(run),
        "outside": outside_spans(run),
        "energy_residual": run.largest_residual,
        "energy_exchanged": run.energy_exchanged,
        "elapsed_ms": 1e3 * run.statistics["elapsed"],
        "units": {"t": "s"} | {name: units[name] for name in columns},
        "columns": {name: next(drawn) for name in shown},
        "cells": [
            {"name": run.cells[k], "component": indices[run.cells[k]], "unit": run.extension_units[k]}
            | {kind: next(drawn) for kind in OF_CELL}
            for k in cells
        ],
    }


def made_columns(run: Run) -> dict[str, Array]:
    """Return what only all samples together tell: the heading without jumps, the way over ground, neighbouring signs.

    `heading` rad, `travelled` m along the horizontal track, `q0` to `q3` the attitude.
    """
    if run.model == "planar":
        return {}
    steps = np.hypot(np.diff(run.values["x"]), np.diff(run.values["y"]))
    return {
        "heading": np.unwrap(run.values["psi"]),
        "travelled": np.concatenate([[0.0], np.cumsum(steps)]),
    } | {f"q{i}": column for i, column in enumerate(attitudes(run).T)}


@remembered_for_life
def curve_samples(run: Run, most: int) -> NDArray[np.int64]:
    """Return the samples to draw, rising, at most `most`: the extremes of what is shown, and an even rest.

    A turning path needs the even rest, else a circle between two extremes would have corners: half of all points.
    """
    cells = run.cell_values
    # the cells' columns too: a step of a command must not be thinned away
    leading = [run.values[name] for name in KEPT[run.model]] + list(cells["command"].T) + list(cells["extension"].T)
    if run.model == "planar" or len(run.times) <= most:
        return choose_samples(leading, most)
    even = np.linspace(0, len(run.times) - 1, most // 2).round().astype(np.int64)
    return np.union1d(choose_samples(leading, most - len(even)), even)


def rounded(values: Array) -> NDArray[np.float32]:
    """Return values at seven significant digits, whose JSON is short: its numbers are the shortest of these floats."""
    return values.astype(np.float32)
