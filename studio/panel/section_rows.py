"""Owns the rows of what belongs to the whole glider: mass properties, forces of the water, mission and solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from models.components import Inertia
from models.design import DeclaredMass, Design, Vehicle
from models.environment import Environment, UniformWater
from models.hydrodynamic_law import FitError
from models.hydrodynamics import AddedMass, Damping, PolarTable
from models.mass_properties import initial_extensions, mass_balance
from models.mission import Initial, Mission, Solver
from studio.changes import Patch
from studio.panel.rows import (
    DAMPING,
    DAMPING_LINEAR,
    DEGREE,
    DENSITY,
    GRAM,
    GRAVITY,
    KG_CM2,
    METRE,
    MILLISECOND,
    MM,
    SECOND,
    Row,
    field_row,
    hint_for,
    note,
    readout,
)

TOLERANCES = tuple(10.0**-k for k in range(3, 13))


def mass_rows(design: Design) -> list[Row]:
    """Return the switch between composed and declared mass properties, and their numbers."""
    choices = (("composed", "composite"), ("declared", "declared"))
    switch = Row(
        "Properties", "choice", lambda d: d.vehicle.mass_properties.kind, _switch_mass,
        hint=hint_for(Vehicle, "mass_properties"), choices=choices,
    )  # fmt: skip
    root = ("vehicle", "mass_properties")
    if isinstance(design.vehicle.mass_properties, DeclaredMass):
        return [
            switch,
            field_row("Total mass", (*root, "mass"), DeclaredMass, unit=GRAM),
            field_row("CoM x", (*root, "center_of_mass", 0), DeclaredMass, unit=MM, step=0.1),
            field_row("CoM z", (*root, "center_of_mass", 2), DeclaredMass, unit=MM, step=0.1),
            field_row("Inertia in pitch", (*root, "inertia", "yy"), Inertia, unit=KG_CM2),
        ]

    def of_balance(pick: Callable[[Any], float]) -> Callable[[Design], float]:
        return lambda d: pick(mass_balance(d.vehicle, initial_extensions(d)))

    return [
        switch,
        readout("Total mass", of_balance(lambda b: b.mass), GRAM),
        readout("CoM x", of_balance(lambda b: b.center_of_mass[0]), MM),
        readout("CoM z", of_balance(lambda b: b.center_of_mass[2]), MM),
        readout("Inertia in pitch", of_balance(lambda b: b.inertia[1, 1]), KG_CM2),
    ]


def _switch_mass(design: Design, kind: str) -> Patch:
    """Declare what the components now amount to, or compose again."""
    value: dict[str, Any] = {"kind": kind}
    if kind == "declared":
        balance = mass_balance(design.vehicle, initial_extensions(design))
        names = (("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2))
        value |= {
            "mass": balance.mass,
            "center_of_mass": balance.center_of_mass.tolist(),
            "inertia": {name: float(balance.inertia[i, j]) for name, i, j in names},
        }
    return [{"op": "replace", "path": "/vehicle/mass_properties", "value": value}]


def hydrodynamics_rows(design: Design, errors: tuple[FitError, ...]) -> list[Row]:
    """Return the choice of law and speed, and how well the law fits its data."""
    root = ("vehicle", "hydrodynamics")
    table = design.vehicle.hydrodynamics
    speeds = (("average", None), *((f"{v:g} m/s", v) for v in table.speeds))
    laws = (("PCHIP", "pchip"), ("polynomial", "polynomial"))
    fits = "; ".join(f"{e.quantity} {100 * e.relative:.1f} % at {e.largest_at_deg:.0f}°" for e in errors)
    return [
        field_row("Law", (*root, "law"), PolarTable, widget="choice", choices=laws),
        field_row("Data speed", (*root, "speed"), PolarTable, widget="choice", choices=speeds),
        note(lambda _: f"Largest misfit of the data's range: {fits}."),
        note(lambda d: f"{d.vehicle.hydrodynamics.provenance.title}. {d.vehicle.hydrodynamics.provenance.limits}"),
    ]


def damping_rows(design: Design) -> list[Row]:
    """Return the switch of the added mass, and the linear damping."""
    root = ("vehicle", "damping")
    rows: list[Row] = []
    if design.vehicle.added_mass is not None:
        rows.append(field_row("Added mass", ("vehicle", "added_mass", "enabled"), AddedMass, widget="switch"))
    return [
        *rows,
        field_row("Pitch damping C33", (*root, "pitch"), Damping, unit=DAMPING, step=0.001),
        field_row("Surge damping", (*root, "surge"), Damping, unit=DAMPING_LINEAR, step=0.01),
        field_row("Heave damping", (*root, "heave"), Damping, unit=DAMPING_LINEAR, step=0.01),
    ]


def mission_rows(design: Design) -> list[Row]:
    """Return the water, the start and the length of the mission."""
    root = ("mission", "environment")
    return [
        field_row("Density", (*root, "water", "density"), UniformWater, unit=DENSITY),
        field_row("Gravity", (*root, "gravity"), Environment, unit=GRAVITY, step=0.01),
        field_row("Bed depth", (*root, "bed_depth"), Environment, unit=METRE, none=0.0, step=0.5, remark="0: no bed."),
        field_row("Start depth", ("mission", "initial", "position", 2), Initial, unit=METRE, step=0.1),
        field_row(
            "Initial pitch", ("mission", "initial", "pitch"), Initial, widget="slider", unit=DEGREE,
            span=lambda _: (-1.5707963267948966, 1.5707963267948966),
        ),
        field_row("Duration", ("mission", "duration"), Mission, unit=SECOND),
    ]  # fmt: skip


def solver_rows(design: Design) -> list[Row]:
    """Return how the equations are integrated."""
    root = ("mission", "solver")
    solver = design.mission.solver
    methods = (("adaptive 5(4)", "adaptive"), ("Runge-Kutta 4", "rk4"))
    rows = [field_row("Method", (*root, "method"), Solver, widget="choice", choices=methods)]
    if solver.method == "adaptive":
        known = sorted({*TOLERANCES, solver.tolerance}, reverse=True)
        tolerances = tuple((f"{v:.6g}", v) for v in known)
        rows.append(field_row("Tolerance", (*root, "tolerance"), Solver, widget="choice", choices=tolerances))
    else:
        rows.append(field_row("Step", (*root, "step"), Solver, unit=MILLISECOND))
    rows.append(field_row("Output interval", (*root, "output_interval"), Solver, unit=SECOND, step=0.01))
    return rows
