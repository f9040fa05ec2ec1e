"""Owns the State: the JSON that the page draws its lanes, plots and readouts from."""

from __future__ import annotations

from typing import Any

from models.components import Rigid, RollingMass, extension_unit
from models.controllers import names_under_control
from models.design import Design
from models.mass_properties import initial_extensions, mass_balance
from models.problems import Problem
from models.run import Run
from models.run_warnings import run_warnings
from models.schedule import Schedule
from models.water import gravity_of, surface_density
from server.answers import series_json
from studio.bodies import drawn_length, pleat
from studio.consequence_warnings import severity_of
from studio.curves import run_document
from studio.origin import origin_document
from studio.palette import component_colors
from studio.part_rows import part_rows
from studio.polar import source_in_short
from studio.run_marks import warning_times
from studio.scene import vehicle_length
from studio.scene_state import scene_document
from studio.session import Session
from studio.source_range import range_in_short

REFUSED = "The change was refused"


def state_json(session: Session, *, saved_at: str | None) -> bytes:
    """Return the State of a session as JSON."""
    return series_json(state_of(session, saved_at=saved_at))


def state_of(session: Session, *, saved_at: str | None) -> dict[str, Any]:
    """Return the State of a session."""
    # what a run of an older document means is told by that document, so both are read once
    revision, design, number, run = session.revision, session.design, session.run_number, session.run
    colors = component_colors(design.vehicle.components)
    return {
        "id": session.id,
        "revision": revision,
        "name": design.name,
        "saved_at": saved_at,
        "origin": _origin(session),
        "can_undo": session.can_undo,
        "can_redo": session.can_redo,
        "kernel": "compiling" if session.compiling else "ready",
        "simulating": session.simulating,
        "selected": session.selected,
        "linked": session.linked,
        "components": _components(design, colors, part_rows(design, session.marks)),
        "schedules": _schedules(design, colors),
        "model": design.mission.solver.model,
        "length": vehicle_length(design),
        "duration": design.mission.duration,
        "initial_depth": design.mission.initial.position[2],
        "bed_depth": design.mission.environment.bed_depth,
        "problem": problem_document(session.problem),
        "warnings": [
            {"message": _sentence(w), "pointer": w.pointer, "times": warning_times(w), "severity": severity_of(w)}
            for w in _warnings(session, run)
        ],
        "hydrodynamics": _hydrodynamics(design),
        "hydrodynamics_range": range_in_short(design.vehicle.hydrodynamics),
        "solver": _solver(design),
        "mass": _mass(design),
        "kept": [kept.document() for kept in session.kept],
        "consequences": session.consequences.document,
        "scene": scene_document(session, run),
        "run": None if run is None else {"number": number} | run_document(run, design),
    }


def _origin(session: Session) -> dict[str, Any] | None:
    document = origin_document(session.origin)
    return None if document is None else document | {"changed": session.changed}


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


def _components(design: Design, colors: list[str], marks: list[dict[str, Any]]) -> list[dict[str, Any]]:
    rows = []
    for i, component in enumerate(design.vehicle.components):
        row: dict[str, Any] = {
            "index": i, "name": component.name, "kind": component.kind, "color": colors[i], "mass": component.mass,
            "position": component.position, "moves": False, "cell": False, "drawn_length": None,
        } | marks[i]  # fmt: skip
        if not isinstance(component, Rigid):
            row |= {
                "moves": True, "cell": component.kind in ("bellows", "piston", "bladder"),
                "unit": extension_unit(component), "axis": component.axis,
                "extension_min": component.stroke[0], "extension_max": component.stroke[1],
                "extension_neutral": component.neutral, "drawn_length": drawn_length(component),
                "pleat": pleat(component),
                "pivot": component.pivot if isinstance(component, RollingMass) else None,
            }  # fmt: skip
        rows.append(row)
    return rows


def _schedules(design: Design, colors: list[str]) -> list[dict[str, Any]]:
    by_name: dict[str, tuple[int, Schedule]] = {s.cell: (i, s) for i, s in enumerate(design.mission.control.schedules)}
    start = initial_extensions(design)
    controlled = names_under_control(
        design.mission.control.controller, [part.name for _, part in design.vehicle.actuated]
    )
    rows = []
    for i, part in design.vehicle.actuated:
        index, schedule = by_name.get(part.name, (None, None))
        points = [] if schedule is None else [p.model_dump() for p in schedule.points]
        rows.append(
            {
                "index": index, "cell": part.name, "color": colors[i], "points": points, "initial": start[part.name],
                "controlled": part.name in controlled,
            }
        )  # fmt: skip
    return rows


def _hydrodynamics(design: Design) -> str:
    source = design.vehicle.hydrodynamics
    return f"{source.provenance.title} · {source_in_short(source)}"


def _solver(design: Design) -> str:
    solver = design.mission.solver
    how = f"adaptive {solver.tolerance:.0e}" if solver.method == "adaptive" else f"RK4 {solver.step * 1e3:g} ms"
    return f"{solver.model.capitalize()} · {how.replace('e-0', 'e-')}"


def _mass(design: Design) -> dict[str, Any]:
    balance = mass_balance(design.vehicle, initial_extensions(design))
    environment = design.mission.environment
    return {
        "mass": balance.mass,
        "net_buoyancy": balance.net_buoyancy(surface_density(environment.water), gravity_of(environment)),
        "displaced_volume": balance.volume,
        "center_of_mass": balance.center_of_mass.tolist(),
        "center_of_buoyancy": balance.center_of_buoyancy.tolist(),
        "com_below_cob": float(balance.center_of_mass[2] - balance.center_of_buoyancy[2]),
    }
