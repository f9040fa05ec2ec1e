"""Owns a design's components in symbols: what each weighs and displaces as its extension moves it.

The laws are those of docs/physics.md, section 3, and docs/spatial.md, section 3. A mass, volume or moment of inertia
that the design sets to 0 gets no symbol; a point gets one for each axis of the model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy as sp

from models.components import Bladder, Component, MovableMass, Piston, Rigid, RollingMass, extension_unit
from models.design import DeclaredMass, Design
from models.equation_symbols import Notation
from models.mass_properties import (
    component_center_of_buoyancy,
    component_center_of_mass,
    inertia_matrix,
    initial_extensions,
)
from models.quasi_velocities import SpatialPart
from models.volumes import core_volume, unit_axis, volume, volume_law

AXES = "xyz"
SHARP = 1e-12
"""An axis this near to one of the body's counts as along it."""


class Composition(NamedTuple):
    """The symbolic parts that make T and U, one a component, and one more of declared mass properties."""

    parts: tuple[SpatialPart, ...]
    indices: tuple[str, ...]
    """Of each part: "0", "1", ..., and "" of the declared one."""


@dataclass(frozen=True)
class _Writer:
    """Writes the symbols of component n at an extension."""

    notation: Notation
    n: str
    component: Component
    extension: float
    axes: str

    def point(self, base: str, words: str, place: Any) -> sp.Matrix:
        """Return a point (3, 1) by its coordinates in the axes of the model; 0 across them."""
        named = [
            self.notation.given(f"{base}{self.n}{axis}", f"{words}, {axis}", "m", place[i]) if axis in self.axes else 0
            for i, axis in enumerate(AXES)
        ]
        return sp.Matrix(named)

    def direction(self, axis: Any) -> sp.Matrix:
        """Return a unit vector (3, 1), with numbers where it lies along an axis of the body."""
        entries = []
        for i, name in enumerate(AXES):
            nearest = round(float(axis[i]))
            if abs(axis[i] - nearest) < SHARP:
                entries.append(sp.Integer(nearest))
            elif name in self.axes:
                entries.append(self.notation.given(f"a_{self.n}{name}", f"axis of motion, {name}", "1", axis[i]))
            else:
                entries.append(sp.Integer(0))
        return sp.Matrix(entries)

    def tensor(self, base: str, words: str, tensor: Any) -> sp.Matrix:
        """Return an inertia (3, 3); of the planar model only its moment about y."""
        if "y" not in self.axes:
            own = (
                self.notation.given(f"{base}_{self.n}", f"{words}, pitch", "kg m2", tensor[1, 1]) if tensor[1, 1] else 0
            )
            return sp.diag(0, own, 0)
        named = sp.zeros(3, 3)
        for i in range(3):
            for j in range(i, 3):
                if tensor[i, j] != 0.0:
                    name = f"{base}_{self.n}{AXES[i]}{AXES[j]}"
                    entry = self.notation.given(name, f"{words}, {AXES[i]}{AXES[j]}", "kg m2", tensor[i, j])
                    named[i, j] = named[j, i] = entry
        return named

    def renamed(self, base: str, words: str, unit: str, forms: sp.Matrix, otherwise: Any = None) -> sp.Matrix:
        """Return symbols for the expressions of a vector or a tensor; what is 0 or a symbol already stays."""
        named = sp.zeros(*forms.shape)
        for i in range(forms.rows):
            for j in range(forms.cols):
                form, index = forms[i, j], AXES[i] + (AXES[j] if forms.cols > 1 else "")
                if forms.cols > 1 and j < i:
                    named[i, j] = named[j, i]
                elif form == 0 or form.is_Symbol:
                    named[i, j] = form
                else:
                    value = otherwise[i] if otherwise is not None else 0.0
                    named[i, j] = self.notation.defined(
                        f"{base}{self.n}{index}", f"{words}, {index}", unit, form, value
                    )
        return named

    def travel(self) -> tuple[Any, Any]:
        """Return the symbols of an extension and of its neutral value, 0 where that is 0."""
        part: Any = self.component
        unit, what = extension_unit(part), "angle" if isinstance(part, RollingMass) else "extension"
        e = self.notation.given(f"e_{self.n}", what, unit, self.extension)
        return e, self.notation.given(f"en_{self.n}", f"neutral {what}", unit, part.neutral) if part.neutral else 0


def compose(design: Design, notation: Notation, extensions: Mapping[str, float] | None = None) -> Composition:
    """Write every component of a design into `notation`, and return the parts that they make."""
    axes = "xz" if design.mission.solver.model == "planar" else "xyz"
    vehicle = design.vehicle
    declared = vehicle.mass_properties if isinstance(vehicle.mass_properties, DeclaredMass) else None
    at = initial_extensions(design) | dict(extensions or {})
    parts, indices = [], []
    for n, component in enumerate(vehicle.components):
        notation.begin(f"{n} {component.name} ({component.kind.replace('_', ' ')})")
        writer = _Writer(notation, str(n), component, at.get(component.name, 0.0), axes)
        parts.append(_part(writer, weighs=declared is None))
        indices.append(str(n))
    if declared is not None:
        parts.append(_declared_part(declared, notation, axes))
        indices.append("")
    return Composition(tuple(parts), tuple(indices))


def _declared_part(declared: DeclaredMass, notation: Notation, axes: str) -> SpatialPart:
    """Return the whole mass in one frozen centre, as the paper has it (Eq. 3)."""
    notation.begin("Declared mass properties, in the place of the components' own")
    mass = notation.given("M", "mass of the whole vehicle, frozen", "kg", declared.mass)
    center, inertia = sp.zeros(3, 1), sp.zeros(3, 3)
    for i, axis in enumerate(AXES):
        if axis in axes:
            center[i] = notation.given(f"l_g{axis}", f"centre of mass, {axis}", "m", declared.center_of_mass[i])
    tensor = inertia_matrix(declared.inertia)
    for i in range(3):
        for j in range(i, 3):
            if (axes == "xyz" and tensor[i, j] != 0.0) or (axes == "xz" and i == j == 1):
                name = f"I_{AXES[i]}{AXES[j]}" if axes == "xyz" else "I"
                words = "inertia about the centre of mass"
                inertia[i, j] = inertia[j, i] = notation.given(name, words, "kg m2", tensor[i, j])
    return SpatialPart(mass=mass, l_g=center, inertia=inertia)


def _part(writer: _Writer, *, weighs: bool) -> SpatialPart:
    component, extension = writer.component, writer.extension
    moves = not isinstance(component, Rigid) and (weighs or not isinstance(component, MovableMass | RollingMass))
    e, neutral = writer.travel() if moves else (sp.Integer(0), sp.Integer(0))
    mass, center, inertia = _weight(writer, e, neutral) if weighs else (0, sp.zeros(3, 1), sp.zeros(3, 3))
    displaced, middle = sp.Integer(0), sp.zeros(3, 1)
    if isinstance(component, Rigid):
        if component.volume > 0.0:
            displaced = writer.notation.given(f"V_{writer.n}", "displaced volume", "m3", volume(component, extension))
            middle = writer.point("l_b", "centre of buoyancy", component.position)
    elif not isinstance(component, MovableMass | RollingMass):
        displaced, middle = _cell(writer, component, e, neutral)
    return SpatialPart(mass, center, inertia, displaced, middle)


def _weight(writer: _Writer, e: Any, neutral: Any) -> tuple[Any, sp.Matrix, sp.Matrix]:
    """Return mass, centre and inertia of a component; a mass that slides or rolls takes them along."""
    component, notation, n = writer.component, writer.notation, writer.n
    mass, center = sp.Integer(0), sp.zeros(3, 1)
    if component.mass > 0.0:
        mass = notation.given(f"m_{n}", "mass", "kg", component.mass)
    own = inertia_matrix(component.inertia)
    home = component.center_of_mass or component.position
    if isinstance(component, RollingMass):
        return _rolled(writer, mass, e - neutral, own)
    inertia = writer.tensor("I", "inertia about its own centre", own)
    if component.mass > 0.0 and isinstance(component, MovableMass):
        axis = writer.direction(unit_axis(component))
        start = writer.point("r_", "centre of mass at neutral", home)
        center = writer.renamed("l_g", "centre of mass", "m", start + (e - neutral) * axis)
    elif component.mass > 0.0:
        center = writer.point("l_g", "centre of mass", home)
    return mass, center, inertia


def _rolled(writer: _Writer, mass: Any, angle: Any, own: Any) -> tuple[Any, sp.Matrix, sp.Matrix]:
    """Return mass, centre and inertia of a mass that turns about an axis through a pivot (Rodrigues)."""
    part: Any = writer.component
    x, y, z = writer.direction(unit_axis(part))
    skew = sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = sp.eye(3) + sp.sin(angle) * skew + (1 - sp.cos(angle)) * skew * skew
    turn = turn.applyfunc(sp.expand)
    start = writer.point("r_", "centre of mass at neutral", part.center_of_mass or part.position)
    pivot = writer.point("p_", "pivot", part.pivot) if any(part.pivot) else sp.zeros(3, 1)
    place = pivot + turn * (start - pivot)
    center = writer.renamed("l_g", "centre of mass", "m", place, component_center_of_mass(part, writer.extension))
    still = writer.tensor("J", "inertia about its own centre at neutral", own)
    turned = (turn * still * turn.T).applyfunc(sp.expand)
    return mass, center, writer.renamed("I_", "inertia about its own centre", "kg m2", turned)


def _cell(writer: _Writer, component: Any, e: Any, neutral: Any) -> tuple[Any, sp.Matrix]:
    """Return volume and centre of buoyancy of a cell: its fixed part stays, the stack's centroid moves by half."""
    notation, n, total = writer.notation, writer.n, volume(component, writer.extension)
    if isinstance(component, Bladder):
        law = sp.Function(f"V_{n}", real=True)(e)  # a table: its value at this extension is all that numbers know
        displaced = notation.defined(f"V_{n}", "displaced volume, by its table", "m3", law, total)
        return displaced, writer.point("l_b", "centre of buoyancy", component.position)
    words = "volume at neutral" if isinstance(component, Piston) else "volume that does not change"
    core = notation.given(f"Vc_{n}", words, "m3", core_volume(component))
    section = notation.given(f"Ac_{n}", "volume by extension, dV/de", "m2", volume_law(component)[0, 2])
    displaced = notation.defined(f"V_{n}", "displaced volume", "m3", core + section * e, total)
    start = writer.point("r_", "centre at neutral", component.position)
    stack = section * e * (e - neutral) / 2 * writer.direction(unit_axis(component))
    forms = ((displaced * start + stack) / displaced).applyfunc(lambda form: form if form.has(e) else sp.cancel(form))
    otherwise = component_center_of_buoyancy(component, writer.extension)
    return displaced, writer.renamed("l_b", "centre of buoyancy", "m", forms, otherwise)
