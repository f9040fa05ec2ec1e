"""Owns the preview: one capped run at once, and its answer as JSON, CSV or NetCDF. It knows no HTTP."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from models.assemble import assemble
from models.design import Design
from models.energy import Spent, energy_bill
from models.limits import Limits
from models.problems import DesignError, Problem, pointer_to
from models.run import Run, Status
from models.run_warnings import run_warnings
from models.simulate import Control, run_assembly
from models.warm import kernel_is_ready, warm_kernel
from server.decimation import choose_samples
from server.schemas import COLUMN_NAMES
from server.settings import Settings
from server.time_limits import TimeLimits

DEFAULT_POINTS = 2000
_TIME_LIMITS = TimeLimits()


@dataclass(frozen=True)
class PreviewRun:
    """A run, how it ended in words, and what the user should be warned of."""

    run: Run
    message: str
    warnings: tuple[Problem, ...]


def preview_limits(settings: Settings) -> Limits:
    """Return the limits of a preview: its samples are fewer, the more cells each of them describes."""
    steps = min(settings.max_steps, settings.preview_steps)
    return dataclasses.replace(settings.limits, numbers=settings.preview_numbers, steps=steps)


def run_preview(design: Design, settings: Settings, control: Control) -> PreviewRun:
    """Simulate a design within the limits of a preview; waits for the kernel's compilation first.

    Raises
    ------
    DesignError
        Where the design cannot be simulated, or asks for more than a preview gives.

    """
    limits = preview_limits(settings)
    assembly = assemble(design, limits)
    if not kernel_is_ready():
        warm_kernel()
    out_of_time = threading.Event()

    def stop() -> None:
        out_of_time.set()
        control.cancel()

    with _TIME_LIMITS.within(settings.preview_seconds, stop):
        run = run_assembly(assembly, limits=limits, control=control)
    message = run.message
    if run.status is Status.cancelled and out_of_time.is_set():
        message = (
            f"The preview was stopped after {settings.preview_seconds:g} s of computing, at t = "
            f"{control.time_reached:.6g} s; what was computed is kept. Shorten the mission or raise the tolerance."
        )
    return PreviewRun(run, message, (*assembly.warnings, *run_warnings(run)))


def check_columns(columns: Sequence[str] | None) -> tuple[str, ...]:
    """Return the columns asked for, each once, and all where none are; raises `DesignError` for an unknown one."""
    if columns is None:
        return COLUMN_NAMES
    problems = [
        Problem(pointer_to("options", "columns", i), f"there is no column '{name}'", hint=f"use {_listed()}")
        for i, name in enumerate(columns)
        if name not in COLUMN_NAMES
    ]
    if problems:
        raise DesignError(problems)
    return tuple(name for name in COLUMN_NAMES if name in columns)


def _listed() -> str:
    return ", ".join(COLUMN_NAMES)


def thinned(run: Run, max_points: int | None) -> Run:
    """Return a run with at most `max_points` samples that keep the extremes of every variable over time."""
    if max_points is None or len(run.times) <= max_points:
        return run
    series = [run.values[name] for name in run.variables]
    series += [column for name in run.cell_variables for column in run.cell_values[name].T]
    return run.select(choose_samples(series, max_points))


def as_mapping(preview: PreviewRun, columns: Sequence[str], max_points: int | None) -> dict[str, Any]:
    """Return a run as plain values and arrays: samples of the columns that were asked for, with their extremes."""
    run = preview.run
    series = {name: run.values[name] for name in run.variables if name in columns}
    of_cells = {name: run.cell_values[name] for name in run.cell_variables if name in columns}
    shown = [*series.values(), *(column for table in of_cells.values() for column in table.T)]
    times = run.times
    samples = choose_samples(shown or [times], max_points or DEFAULT_POINTS)
    return {
        "status": run.status.name,
        "message": preview.message,
        "events": [{"time": e.time, "kind": e.kind, "cell": e.cell, "label": str(e)} for e in run.events],
        "units": {"t": "s"} | _units(run.variables, series) | _units(run.cell_variables, of_cells),
        "columns": {"t": times[samples]} | {name: values[samples] for name, values in series.items()},
        "cells": [
            {"name": cell, "unit": run.extension_units[j]}
            | {name: table[samples, j] for name, table in of_cells.items()}
            for j, cell in enumerate(run.cells)
        ],
        "final": run.final,
        "energy": _energy(run),
        "bill": bill_document(run),
        "statistics": run.statistics,
        "warnings": [problem.as_dict() for problem in preview.warnings],
    }


def _units(table: Mapping[str, tuple[str, str]], shown: Mapping[str, Any]) -> dict[str, str]:
    return {name: table[name][0] for name in shown}


def _energy(run: Run) -> dict[str, float]:
    return {
        "residual": run.largest_residual,
        "exchanged": run.energy_exchanged,
        "relative_residual": run.relative_residual,
    }


def bill_document(run: Run) -> dict[str, Any] | None:
    """Return the energy bill of a run as plain values; None where the model keeps none."""
    bill = energy_bill(run)
    if bill is None:
        return None
    return {"whole": _spent(bill.whole), "dives": [_spent(dive) for dive in bill.dives]}


def _spent(spent: Spent) -> dict[str, Any]:
    return dataclasses.asdict(spent) | {"total": spent.total, "per_km": spent.per_km}
