"""Owns what masses, inertias and added mass must be for the equations to have one solution that does not run away.

Thousands of cases pass a bound in plain numbers that is enough; eigenvalues are sought where it leaves a doubt.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from models.added_mass import added_mass
from models.design import Design
from models.hydrodynamics import AddedMass
from models.mass_properties import MassBalance, Masses, initial_extensions, mass_balance, masses, smallest_moment
from models.memory import remembered
from models.problems import Problem, pointer_to

ADDED_ROUNDING = 1e-9
"""An eigenvalue of the added mass may be negative by this share of its largest entry."""
PIVOT_ROUNDING = 1e-9
"""A pivot of an inertia above this share of the trace is positive beyond rounding."""
MOMENT_ROUNDING = 1e-9
"""A moment of inertia above this (kg m2) for a mass of 1 kg within 1 m is one beyond rounding."""


def mass_problems(design: Design) -> Iterator[Problem]:
    """Yield what is wrong with mass, inertia and added mass."""
    vehicle, planar = design.vehicle, design.mission.solver.model == "planar"
    problems = () if vehicle.added_mass is None else _added_mass_problems(vehicle.added_mass)
    yield from problems
    yield from _component_inertia_problems(design)
    extensions = initial_extensions(design)
    found = masses(vehicle, extensions)
    if found.mass <= 0.0:
        yield Problem("/vehicle/components", "the components weigh nothing", limit=0.0, hint="give one a mass")
        return
    added, least = added_mass(design), least_moment(found.inertia)
    moment = found.inertia[1][1] if planar else least
    if least > 0.0 and (problems or turns_hard(found, moment, largest_added=_largest(added))):
        return
    balance = mass_balance(vehicle, extensions)
    declared = vehicle.mass_properties.kind == "declared"
    pointer = "/vehicle/mass_properties/inertia" if declared else "/vehicle/components"
    yield from _negative_moments(balance, pointer)
    if not problems:
        yield from _free_turns(turning_inertia(balance, added), balance.mass, pointer, planar=planar)


@remembered(most=100)
def _largest(matrix: NDArray[np.float64]) -> float:
    return float(np.abs(matrix).max())


def least_moment(inertia: Sequence[Sequence[float]]) -> float:
    """Return a moment (kg m2) that no principal one lies below; 0 where one may be zero or negative to rounding.

    Of the pivots p of a symmetric matrix none is more than the trace, det = p1 p2 p3, and the smallest of three
    positive eigenvalues is det over the product of the others, which is at most a quarter of the trace squared.
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    trace = xx + yy + zz
    if not xx > (rounding := PIVOT_ROUNDING * trace):
        return 0.0
    second = yy - xy * xy / xx
    if not second > rounding:
        return 0.0
    mixed = yz - xy * xz / xx
    third = zz - xz * xz / xx - mixed * mixed / second
    return 4.0 * xx * second * third / (trace * trace) if third > rounding else 0.0


def turns_hard(found: Masses, moment: float, *, largest_added: float) -> bool:
    """Whether a moment about the centre of mass (kg m2) is one of the whole as well, whatever the added mass couples.

    Added mass A that is positive semi-definite makes nothing turn more easily. To rounding it is A + d 1, which takes
    from the moment at most d (1 + r^2 m / (m - d)); r is the distance of the centre of mass from the origin.
    """
    mass, (x, y, z), _ = found
    rounding = ADDED_ROUNDING * largest_added
    enough = (MOMENT_ROUNDING * mass + 2.0 * rounding) * (1.0 + x * x + y * y + z * z)
    return mass > 2.0 * rounding and moment > enough


def _negative_moments(balance: MassBalance, pointer: str) -> Iterator[Problem]:
    smallest = float(np.linalg.eigvalsh(balance.inertia)[0])
    tolerance = 1e-9 * max(float(np.trace(balance.inertia)), 1e-12)
    if smallest < -tolerance:
        yield Problem(
            pointer, f"the inertia about the centre of mass has a negative principal moment, {smallest:.4g} kg m2",
            limit=0.0, hint="check the products of inertia",
        )  # fmt: skip


def _free_turns(turning: NDArray[np.float64], mass: float, pointer: str, *, planar: bool) -> Iterator[Problem]:
    if planar:
        moment, axis = float(turning[1, 1]), "pitch"
    else:
        moments, directions = np.linalg.eigh(turning)
        moment, axis = float(moments[0]), ("roll", "pitch", "yaw")[int(np.abs(directions[:, 0]).argmax())]
    if moment <= 1e-12 * mass:
        yield Problem(
            pointer, f"the moment of inertia in {axis} is {moment:.4g} kg m2: the equations are singular",
            limit=0.0, hint="give the components inertia, or put them apart",
        )  # fmt: skip


def _component_inertia_problems(design: Design) -> Iterator[Problem]:
    """Yield components whose own inertia no body has: one that rolls would carry it into every attitude."""
    if design.mission.solver.model == "planar" or design.vehicle.mass_properties.kind == "declared":
        return
    for i, component in enumerate(design.vehicle.components):
        smallest = smallest_moment(component.inertia)
        if smallest < 0.0:
            yield Problem(
                pointer_to("vehicle", "components", i, "inertia"),
                f"the inertia of '{component.name}' has a negative principal moment, {smallest:.4g} kg m2",
                limit=0.0, hint="check the products of inertia",
            )  # fmt: skip


def turning_inertia(balance: MassBalance, A: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inertia about the point that turns most freely, (3, 3) kg m2: the Schur complement of M_RB + M_A."""
    mass, (x, y, z) = balance.mass, (balance.mass * balance.center_of_mass).tolist()
    whole = A[:3, :3] + np.array([[mass, 0.0, 0.0], [0.0, mass, 0.0], [0.0, 0.0, mass]])
    mixed = A[:3, 3:] + np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    turning = A[3:, 3:] + balance.inertia_about_origin - mixed.T @ np.linalg.solve(whole, mixed)
    return np.asarray(turning, dtype=np.float64)


@remembered(most=100)
def _added_mass_problems(added: AddedMass) -> tuple[Problem, ...]:
    return tuple(_matrix_problems(added))


def _matrix_problems(added: AddedMass) -> Iterator[Problem]:
    pointer = "/vehicle/added_mass/matrix"
    A = np.array(added.matrix)
    size = float(np.abs(A).max())
    skew = np.abs(A - A.T)
    if skew.max() > 1e-9 * size:
        i, j = (int(k) for k in np.unravel_index(skew.argmax(), skew.shape))
        yield Problem(
            f"{pointer}/{i}/{j}", f"added mass is not symmetric: [{i}][{j}] = {A[i, j]:g}, [{j}][{i}] = {A[j, i]:g}",
            limit=float(A[j, i]), hint="make both entries equal",
        )  # fmt: skip
        return
    smallest = float(np.linalg.eigvalsh(A)[0])
    if smallest < -ADDED_ROUNDING * size:
        yield Problem(
            pointer, f"added mass is not positive semi-definite: its smallest eigenvalue is {smallest:.4g}",
            limit=0.0, hint="check the signs of the couplings",
        )  # fmt: skip
