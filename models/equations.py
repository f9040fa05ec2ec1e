"""Owns the equations of motion of exactly one design, derived from its own T and U; for people to read, never in a run.

Canete et al., Eqs. 1 to 12, for any layout: planar designs by Euler-Lagrange (`derivation`), spatial ones by Lagrange's
equations in quasi-velocities (`quasi_velocities`). Extensions are held, water is still and of one density. SI units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from models import equations_planar, equations_spatial
from models.checks import extension_problems
from models.derivation import DENSITY, GRAVITY, Equations
from models.design import Design
from models.equation_forces import Forces
from models.equation_sections import Display, Section
from models.equation_symbols import Group, Notation, values_of
from models.problems import DesignError
from models.water import gravity_of, surface_density

Array = NDArray[np.float64]
DIGITS = 5
"""Significant digits of printed numbers."""


class Numbers(NamedTuple):
    """M (n, n), V (n,) and G (n,) as numbers, n = 3 or 6."""

    M: Array
    V: Array
    G: Array


@dataclass(frozen=True)
class DesignEquations:
    """M q'' + V + C q' + G = Q of a planar design, M nu' + V + G = forces of a spatial one.

    `legend` has every symbol by component, `values` its value; `sections` is what is printed. `equations` and `forces`
    are in the composite symbols, `position` and `velocity` the symbols they depend on besides.
    """

    design: Design
    legend: tuple[Group, ...]
    values: Mapping[Any, float]
    sections: tuple[Section, ...]
    equations: Equations
    forces: Forces
    position: tuple[Any, ...]
    velocity: tuple[Any, ...]

    def evaluate(self, position: Array, velocity: Array) -> Numbers:
        """Return M, V, G at a position (x, z, theta; or z, phi, theta) and a velocity (q'; or nu)."""
        at = dict(zip((*self.position, *self.velocity), (*position, *velocity), strict=True)) | dict(self.values)
        M, V, G = (
            np.array(matrix.xreplace({s: sp.Float(float(at[s])) for s in matrix.free_symbols}).evalf(), dtype=float)
            for matrix in self.equations
        )
        return Numbers(M, V.ravel(), G.ravel())

    def with_numbers(self, digits: int = DIGITS) -> DesignEquations:
        """Return the same equations with the values of the symbols in them, to so many significant digits."""
        return replace(self, sections=tuple(section.with_numbers(self.values, digits) for section in self.sections))


def derive_equations(design: Design, extensions: Mapping[str, float] | None = None) -> DesignEquations:
    """Derive the equations of a design, with values at the given extensions (m or rad, by name; else the initial ones).

    Raises
    ------
    DesignError
        Where an extension is that of no component that moves, or beyond its stops.

    """
    problems = list(extension_problems(design, extensions or {}, "/extensions"))
    if problems:
        raise DesignError(problems)
    notation = Notation()
    notation.begin("World")
    environment = design.mission.environment
    notation.add(GRAVITY, "gravity", "m/s2", gravity_of(environment))
    density = surface_density(environment.water)
    notation.add(DENSITY, "density of the water, one everywhere", "kg/m3", density)
    planar = design.mission.solver.model == "planar"
    derived = (equations_planar if planar else equations_spatial).derive(design, notation, extensions)
    return DesignEquations(
        design=design,
        legend=notation.groups,
        values=values_of(notation.groups),
        sections=derived.sections,
        equations=derived.equations,
        forces=derived.forces,
        position=derived.position,
        velocity=derived.velocity,
    )


__all__ = ["DesignEquations", "Display", "Numbers", "Section", "derive_equations"]
