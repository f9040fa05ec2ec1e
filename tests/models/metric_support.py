"""Owns runs that are written down rather than simulated, for the tests of metrics."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from models.metrics import evaluate, metrics_for
from models.presets import load_preset
from models.run import Event, Run, Status, variables_of
from models.variables import CELL_VARIABLES

SPATIAL, PLANAR = load_preset("quad-bellows-glide"), load_preset("slocum-glide")
CELL = "Front port cell"


def run_of(times: Any, *, design=SPATIAL, events: tuple[Event, ...] = (), cells=None, **values: Any) -> Run:
    """A run with the values given, all else zero."""
    t = np.asarray(times, dtype=float)
    names = tuple(part.name for _, part in design.vehicle.actuated)
    tables = {name: np.zeros((len(t), len(names))) for name in CELL_VARIABLES[design.mission.solver.model]}
    return Run(
        design=design, times=t, cells=names, cell_values=tables | (cells or {}), status=Status.completed,
        values={name: np.zeros(len(t)) for name in variables_of(design)} | values, events=events, statistics={},
        kernel="",
    )  # fmt: skip


def value(run: Run, request: Any) -> float:
    """The value of one metric."""
    return evaluate(run, metrics_for(run.design, [request]))[0]


def refined(run: Run, times: Any) -> Run:
    """The same lines from sample to sample, with samples at further times."""
    t = np.union1d(run.times, times)
    t = t[(t >= run.times[0]) & (t <= run.times[-1])]
    values = {name: np.interp(t, run.times, column) for name, column in run.values.items()}
    cells = {
        name: np.column_stack([np.interp(t, run.times, column) for column in table.T])
        for name, table in run.cell_values.items()
    }
    return replace(run, times=t, values=values, cell_values=cells)
