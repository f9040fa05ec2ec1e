"""Owns the rows of the glider's mass properties: composed of its parts, or declared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from models.components import Inertia
from models.design import DeclaredMass, Design, Vehicle
from models.mass_properties import initial_extensions, mass_balance
from studio.changes import Patch
from studio.panel.rows import GRAM, KG_CM2, MM, Row, field_row, hint_for, is_spatial, readout

CENTERS = (("CoM x", 0), ("CoM y", 1), ("CoM z", 2))
INERTIAS = (("Inertia in roll", 0), ("Inertia in pitch", 1), ("Inertia in yaw", 2))


def mass_rows(design: Design) -> list[Row]:
    """Return the switch between composed and declared mass properties, and their numbers."""
    choices = (("composed", "composite"), ("declared", "declared"))
    switch = Row(
        "Properties", "choice", lambda d: d.vehicle.mass_properties.kind, _switch_mass,
        hint=hint_for(Vehicle, "mass_properties"), choices=choices,
    )  # fmt: skip
    # in the plane only x, z and pitch count
    centers = [c for c in CENTERS if is_spatial(design) or c[1] != 1]
    inertias = [i for i in INERTIAS if is_spatial(design) or i[1] == 1]
    declared = isinstance(design.vehicle.mass_properties, DeclaredMass)
    return [switch, *(_declared_rows(centers, inertias) if declared else _composed_rows(centers, inertias))]


def _declared_rows(centers: list[tuple[str, int]], inertias: list[tuple[str, int]]) -> list[Row]:
    root = ("vehicle", "mass_properties")
    return [
        field_row("Total mass", (*root, "mass"), DeclaredMass, unit=GRAM),
        *(field_row(label, (*root, "center_of_mass", i), DeclaredMass, unit=MM, step=0.1) for label, i in centers),
        *(field_row(label, (*root, "inertia", "xyz"[i] * 2), Inertia, unit=KG_CM2) for label, i in inertias),
    ]


def _composed_rows(centers: list[tuple[str, int]], inertias: list[tuple[str, int]]) -> list[Row]:
    def of_balance(pick: Callable[[Any], float]) -> Callable[[Design], float]:
        return lambda d: pick(mass_balance(d.vehicle, initial_extensions(d)))

    def center(i: int) -> Callable[[Design], float]:
        return of_balance(lambda b: b.center_of_mass[i])

    def inertia(i: int) -> Callable[[Design], float]:
        return of_balance(lambda b: b.inertia[i, i])

    return [
        readout("Total mass", of_balance(lambda b: b.mass), GRAM),
        *(readout(label, center(i), MM) for label, i in centers),
        *(readout(label, inertia(i), KG_CM2) for label, i in inertias),
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
