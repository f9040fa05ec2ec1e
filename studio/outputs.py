"""Owns the choice of a run's outputs to plot: every variable over time by name, and a cell's as `<name>@<cell>`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.problems import DesignError, Problem
from models.run import Run
from models.variables import IN_UNITS_OF_EXTENSION
from server.decimation import choose_samples
from studio.curves import MADE_UNITS, made_columns, rounded

Array = NDArray[np.float64]

MOST_POINTS = 1200
OF_CELL = "@"
MADE_MEANING = {"heading": "heading, to the right, full turns counted", "travelled": "way over ground"}
ATTITUDE = ("q0", "q1", "q2", "q3")
"""The page's own; nobody plots a quaternion's entries."""


def outputs_of(run: Run) -> list[dict[str, Any]]:
    """Return name, label and unit of each output of a run, those of cells with the cell's name."""
    items = [
        {"name": name, "label": label, "unit": unit, "cell": None}
        for name, (unit, label) in run.variables.items()
        if name not in ATTITUDE
    ]
    items += [
        {"name": name, "label": MADE_MEANING[name], "unit": MADE_UNITS[name], "cell": None}
        for name in made_columns(run)
        if name in MADE_MEANING
    ]
    for k, cell in enumerate(run.cells):
        items += [
            {"name": f"{name}{OF_CELL}{cell}", "label": label, "unit": _cell_unit(run, name, k, unit), "cell": cell}
            for name, (unit, label) in run.cell_variables.items()
        ]
    return items


def curves_of(run: Run, names: Sequence[str]) -> dict[str, Any]:
    """Return outputs over time, thinned together so that no extreme is lost.

    A name that this run has not (a cell added since, a variable of the other model) comes back in `missing`, since runs
    of different designs are laid over each other.
    """
    if not names:
        raise DesignError([Problem("/name", "no output is named", hint="send name=z&name=theta")])
    found = {name: column for name in dict.fromkeys(names) if (column := _column(run, name)) is not None}
    chosen = choose_samples([*found.values()] or [run.times], MOST_POINTS)
    units = {item["name"]: item["unit"] for item in outputs_of(run)}
    return {
        "t": rounded(run.times[chosen]),
        "columns": {name: rounded(column[chosen]) for name, column in found.items()},
        "units": {name: units[name] for name in found},
        "missing": [name for name in names if name not in found],
    }


def _column(run: Run, name: str) -> Array | None:
    variable, _, cell = name.partition(OF_CELL)
    if cell:
        known = cell in run.cells and variable in run.cell_variables
        return run.cell_values[variable][:, run.cells.index(cell)] if known else None
    if name in MADE_MEANING:
        return made_columns(run).get(name)
    return run.values[name] if name in run.variables and name not in ATTITUDE else None


def _cell_unit(run: Run, name: str, k: int, unit: str) -> str:
    return run.extension_units[k] if name in IN_UNITS_OF_EXTENSION else unit
