"""Owns the State: the JSON that the page draws its lanes, plots and readouts from."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from models.components import Actuated, Rigid
from models.design import Design
from models.mass_properties import initial_extensions, mass_balance
from models.problems import Problem
from models.run import VARIABLES, Run
from models.run_warnings import run_warnings
from models.schedule import Schedule
from server.decimation import choose_samples
from studio.bodies import drawn_length
from studio.palette import component_colors
from studio.session import Session

MAX_POINTS = 800
DIGITS = 7
FLAT_VARIABLES = ("z", "theta", "alpha", "flow_angle", "speed", "net_buoyancy")
"""Columns whose extremes decimation keeps, beside the cells'."""
REFUSED = "The change was refused"


def state_json(session: Session, *, saved_at: str | None) -> bytes:
    """Return the State of a session as JSON."""
    return to_json(state_of(session, saved_at=saved_at), inf_nan_mode="null")


def state_of(session: Session, *, saved_at: str | None) -> dict[str, Any]:
    """Return the State of a session."""
    # what a run of an older document means is told by that document, so both are read once
    revision, design, run = session.revision, session.design, session.run
    colors = component_colors(design.vehicle.components)
    return {
        "id": session.id,
        "revision": revision,
        "name": design.name,
        "saved_at": saved_at,
        "can_undo": session.can_undo,
        "can_redo": session.can_redo,
        "kernel": "compiling" if session.compiling else "ready",
        "simulating": session.simulating,
        "selected": session.selected,
        "components": _components(design, colors),
        "schedules": _schedules(design, colors),
        "duration": design.mission.duration,
        "initial_depth": design.mission.initial.position[2],
        "bed_depth": design.mission.environment.bed_depth,
        "problem": problem_document(session.problem),
        "warnings": [{"message": _sentence(w), "pointer": w.pointer} for w in _warnings(session, run)],
        "hydrodynamics": _hydrodynamics(design),
        "solver": _solver(design),
        "mass": _mass(design),
        "run": None if run is None else run_document(run, design),
    }


def _warnings(session: Session, run: Run | None) -> list[Problem]:
    return [*session.assembly.warnings, *(() if run is None else run_warnings(run))]


def problem_document(problems: tuple[Problem, ...]) -> dict[str, Any] | None:
    """Return problems in the shape of RFC 9457, or None where there are none."""
    if not problems:
        return None
    return {
        "type": "about:blank",
        "title": REFUSED,
        "status": 422,
        "detail": problems[0].message,
        "errors": [problem.as_dict() for problem in problems],
    }


def _sentence(problem: Problem) -> str:
    return f"{problem.message}: {problem.hint}" if problem.hint else problem.message


def _components(design: Design, colors: list[str]) -> list[dict[str, Any]]:
    rows = []
    for i, component in enumerate(design.vehicle.components):
        low = high = neutral = None
        if not isinstance(component, Rigid):
            (low, high), neutral = component.stroke, component.neutral
        rows.append(
            {
                "index": i, "name": component.name, "kind": component.kind, "color": colors[i], "mass": component.mass,
                "cell": component.kind in ("bellows", "piston", "bladder"), "moves": not isinstance(component, Rigid),
                "extension_min": low, "extension_max": high, "extension_neutral": neutral,
                "drawn_length": drawn_length(component),
                "position": component.position,
                "axis": None if isinstance(component, Rigid) else component.axis,
            }
        )  # fmt: skip
    return rows


def _schedules(design: Design, colors: list[str]) -> list[dict[str, Any]]:
    by_name: dict[str, tuple[int, Schedule]] = {s.cell: (i, s) for i, s in enumerate(design.mission.control.schedules)}
    start = initial_extensions(design)
    rows = []
    for i, part in design.vehicle.actuated:
        index, schedule = by_name.get(part.name, (None, None))
        points = [] if schedule is None else [p.model_dump() for p in schedule.points]
        rows.append(
            {"index": index, "cell": part.name, "color": colors[i], "points": points, "initial": start[part.name]}
        )
    return rows


def _hydrodynamics(design: Design) -> str:
    table = design.vehicle.hydrodynamics
    law = "PCHIP" if table.law == "pchip" else "polynomials"
    data = (
        "mean of speeds" if table.speed is None and len(table.speeds) > 1 else f"{table.speed or table.speeds[0]:g} m/s"
    )
    return f"{table.provenance.title} · {law} · {data}"


def _solver(design: Design) -> str:
    solver = design.mission.solver
    how = f"adaptive {solver.tolerance:.0e}" if solver.method == "adaptive" else f"RK4 {solver.step * 1e3:g} ms"
    return f"{solver.model.capitalize()} · {how.replace('e-0', 'e-')}"


def _mass(design: Design) -> dict[str, Any]:
    balance = mass_balance(design.vehicle, initial_extensions(design))
    environment = design.mission.environment
    return {
        "mass": balance.mass,
        "net_buoyancy": balance.net_buoyancy(environment.water.density, environment.gravity),
        "displaced_volume": balance.volume,
        "center_of_mass": balance.center_of_mass.tolist(),
        "center_of_buoyancy": balance.center_of_buoyancy.tolist(),
        "com_below_cob": float(balance.center_of_mass[2] - balance.center_of_buoyancy[2]),
    }


def run_document(run: Run, design: Design) -> dict[str, Any]:
    """Return a run's curves, thinned to what a screen shows; its cells by their index in the present design."""
    columns, cells = run.values, run.cell_values
    # the cells' columns too: a step of a command must not be thinned away
    leading = [columns[name] for name in FLAT_VARIABLES] + list(cells["command"].T) + list(cells["extension"].T)
    chosen = choose_samples(leading, MAX_POINTS)
    indices = {c.name: i for i, c in enumerate(design.vehicle.components) if isinstance(c, Actuated)}
    return {
        "status": run.status.name,
        "message": run.status.value,
        "events": [{"time": e.time, "kind": e.kind, "label": str(e)} for e in run.events],
        "energy_residual": run.largest_residual,
        "energy_exchanged": run.energy_exchanged,
        "elapsed_ms": 1e3 * run.statistics["elapsed"],
        "units": {"t": "s"} | {name: unit for name, (unit, _) in VARIABLES.items()},
        "columns": {"t": rounded(run.times[chosen])}
        | {name: rounded(column[chosen]) for name, column in columns.items()},
        "cells": [
            {"name": name, "component": indices[name]}
            | {kind: rounded(values[chosen, k]) for kind, values in cells.items()}
            for k, name in enumerate(run.cells)
            if name in indices
        ],
    }


def rounded(values: NDArray[np.float64]) -> list[float]:
    """Return values at seven significant digits, whose JSON is short."""
    with np.errstate(divide="ignore", invalid="ignore"):
        exponent = np.floor(np.log10(np.abs(values)))
    exponent = np.where(np.isfinite(exponent), exponent, 0.0)
    # dividing by an exact power of ten rounds once, so that the shortest text of the result has few digits
    scale = 10.0 ** np.clip(DIGITS - 1 - exponent, 0.0, 22.0)
    shortened: list[float] = (np.round(values * scale) / scale).tolist()
    return shortened
