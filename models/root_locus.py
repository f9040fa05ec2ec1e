"""Owns root loci: the eigenvalues of a design's steady motion as one number of the design changes. SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from jsonpointer import JsonPointer, JsonPointerException
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from models.assemble import Assembly, assemble
from models.design import Design, parse_design
from models.limits import DEFAULT_LIMITS, Limits
from models.linearize import linearize
from models.modes import NEUTRAL, STEADY, SUBSIDENCES, Mode, modes_of
from models.operating_point import OperatingPoint, point_of
from models.problems import DesignError, Problem, echo, pointer_to
from models.targeted_trim import TrimFailure, check_wish, trim_for
from models.trim import TrimSearch, find_trims

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
EXTENSIONS = "/extensions/"
"""Pointers that begin so name the extension of a cell in the steady motion, not a field of the document."""
MOST_VALUES = 10_000
STEADY_NAMES = tuple(SUBSIDENCES[state] for state in STEADY)

TrimAt = Callable[[Design, Mapping[str, float], OperatingPoint | None], OperatingPoint]
"""Finds the steady motion of a design at extensions by name (those not named as it chooses), near the last one found.

Raises `DesignError` where there is none.
"""
_Find = Callable[[Assembly, Mapping[str, float], OperatingPoint | None], OperatingPoint]


@dataclass(frozen=True)
class Crossing:
    """A branch becomes unstable, or stable: at which value of the parameter (by interpolation), at which frequency."""

    branch: int
    name: str
    value: float
    frequency: float
    becomes_stable: bool

    def as_dict(self) -> dict[str, Any]:
        """Return it as a JSON object; the frequency in rad/s."""
        return {
            "branch": self.branch, "name": self.name, "value": self.value, "frequency": self.frequency,
            "becomes_stable": self.becomes_stable,
        }  # fmt: skip


@dataclass(frozen=True)
class RootLocus:
    """Eigenvalues (values, branches) in 1/s over the values of a parameter, each branch followed by continuity.

    Rows of values without a steady motion are not numbers; `failures` says why, by value. `names` are those of the
    modes where a branch begins; `points` the steady motions, None where there is none.
    """

    pointer: str
    values: Array
    eigenvalues: ComplexArray
    names: tuple[str, ...]
    points: tuple[OperatingPoint | None, ...]
    failures: tuple[tuple[float, str], ...]
    crossings: tuple[Crossing, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the locus as a JSON object; eigenvalues of values without a steady motion are null."""
        found = [point is not None for point in self.points]
        rows = [
            [[root.real, root.imag] for root in row] if is_found else None
            for row, is_found in zip(self.eigenvalues.tolist(), found, strict=True)
        ]
        return {
            "pointer": self.pointer, "values": self.values.tolist(), "eigenvalues": rows, "names": list(self.names),
            "points": [None if point is None else point.as_dict() for point in self.points],
            "failures": [{"value": value, "message": message} for value, message in self.failures],
            "crossings": [crossing.as_dict() for crossing in self.crossings],
        }  # fmt: skip


def with_value(design: Design, pointer: str, value: float) -> Design:
    """Return the design with the number at a JSON Pointer (RFC 6901) replaced.

    Raises
    ------
    DesignError
        Where the pointer names no number, or the changed document is not a design.

    """
    document = design.model_dump(mode="json")
    try:
        place = JsonPointer(pointer)
        present = place.resolve(document)
    except JsonPointerException as error:
        message = f"the design has no such field: {error}"
        raise DesignError([Problem(pointer, message, hint="check the pointer")]) from None
    if pointer == "" or isinstance(present, bool) or not isinstance(present, int | float | None):
        raise DesignError([Problem(pointer, f"{echo(present)} is not a number", hint="point to a number")])
    place.set(document, value)
    return parse_design(document)


def root_locus(
    design: Design, pointer: str, values: Sequence[float], *, trim_at: TrimAt | None = None,
    extensions: Mapping[str, float] | None = None, depth: float | None = None,
    targets: Mapping[str, float] | None = None, free: Sequence[str] | None = None, limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[int, int], bool] | None = None,
) -> RootLocus:  # fmt: skip
    """Follow the eigenvalues while the number at `pointer` takes the `values`, trimmed anew at each.

    A pointer "/extensions/<cell>" changes that extension of the steady motion. `trim_at` finds the motions, by default
    `models.trim`, at `extensions` (those the design begins with, where none are named) and `depth` (m). With `targets`
    and `free` cells each value is trimmed to the same motion instead, by `models.targeted_trim`. Each changed design is
    assembled within `limits`. `progress` is called with (values done, all of them) before each value.

    Raises
    ------
    DesignError
        Where the pointer names no number of the design, options contradict each other, no steady motion is found at any
        value, or `progress` returns False: then it says "cancelled".

    """
    steps = np.asarray(values, dtype=np.float64)
    if not 0 < steps.size <= MOST_VALUES or steps.ndim != 1 or not np.isfinite(steps).all():
        raise DesignError([Problem("/values", f"give 1 to {MOST_VALUES:,} finite values", limit=MOST_VALUES)])
    parameter = _Parameter(design, pointer, limits)
    if parameter.cell is None:
        with_value(design, pointer, float(steps[0]))  # a wrong pointer is told at once, not as so many failures
    _check_options(parameter, trim_at, targets, free)
    find = _finder(trim_at, targets, free, depth)
    branches = _Branches()
    points: list[OperatingPoint | None] = []
    failures: list[tuple[float, str]] = []
    last: OperatingPoint | None = None
    for done, value in enumerate(steps.tolist()):
        if progress is not None and not progress(done, len(steps)):
            raise DesignError([Problem("", f"cancelled after {done} of {len(steps)} values")])
        point: OperatingPoint | None = None
        try:
            changed, held = parameter.at(value, extensions or {})
            point = find(changed, held, last)
            model = linearize(changed, point)
            branches.extend(modes_of(model.A, model.state_names).modes)
            last = point
        except DesignError as error:
            point = None
            failures.append((value, str(error)))
            branches.skip()
        points.append(point)
    if last is None:
        raise DesignError([Problem(pointer, f"no steady motion at any of the values: {failures[0][1]}")])
    found = branches.table
    crossings = tuple(_crossings(steps, found, branches.names))
    return RootLocus(pointer, steps, found, branches.names, tuple(points), tuple(failures), crossings)


class _Branches:
    """Eigenvalues followed from one value to the next: each goes on to the nearest to where it was heading."""

    def __init__(self) -> None:
        self.rows: list[ComplexArray | None] = []
        self.names: tuple[str, ...] = ()

    @property
    def table(self) -> ComplexArray:
        """All rows, (values, branches); not numbers where one was skipped."""
        gap = np.full(len(self.names), complex(np.nan, np.nan))
        return np.array([gap if row is None else row for row in self.rows])

    def skip(self) -> None:
        """Leave a gap."""
        self.rows.append(None)

    def extend(self, modes: Sequence[Mode]) -> None:
        """Add the eigenvalues of the next value; raises `DesignError` where their number has changed."""
        both = [
            (value, mode.name)
            for mode in modes
            for value in ((mode.eigenvalue, mode.eigenvalue.conjugate()) if mode.oscillates else (mode.eigenvalue,))
        ]
        roots = np.array([value for value, _ in both])
        known = [row for row in self.rows[-2:] if row is not None]
        last = next((row for row in reversed(self.rows) if row is not None), None)
        if last is None:
            self.names = tuple(name for _, name in both)
            self.rows.append(roots)
            return
        if len(roots) != len(last):
            message = f"{len(roots)} states instead of {len(last)}: a lag begins or ends"
            raise DesignError([Problem("", message)])
        heading = 2.0 * known[1] - known[0] if len(known) == 2 else last
        # a step that is not even, or two roots that meet, make the guess worse than the last place: take half of it
        guess = 0.5 * (heading + last)
        _, order = linear_sum_assignment(np.abs(guess[:, None] - roots[None, :]))
        self.rows.append(roots[order])


class _Parameter:
    """The number that changes: the extension of `cell`, or where that is None a field of the design."""

    def __init__(self, design: Design, pointer: str, limits: Limits) -> None:
        self.design, self.pointer, self.limits = design, pointer, limits
        self.cell = _cell_of(design, pointer)
        self.assembly = assemble(design, limits) if self.cell is not None else None

    def at(self, value: float, extensions: Mapping[str, float]) -> tuple[Assembly, Mapping[str, float]]:
        """Return the assembly and the extensions (m or rad, by name) with the number set."""
        if self.assembly is not None and self.cell is not None:
            return self.assembly, {**extensions, self.cell: value}
        return assemble(with_value(self.design, self.pointer, value), self.limits), extensions


def _cell_of(design: Design, pointer: str) -> str | None:
    """Return the cell whose extension a pointer names, None where it begins otherwise.

    Raises
    ------
    DesignError
        Where it is not a JSON Pointer of two tokens, or names no part that moves.

    """
    if not pointer.startswith(EXTENSIONS):
        return None
    cells = [part.name for _, part in design.vehicle.actuated]
    hint = f"give {EXTENSIONS}<name>, the name one of: {', '.join(cells) or 'none'}"
    try:
        tokens = JsonPointer(pointer).parts
    except JsonPointerException as error:
        raise DesignError([Problem(pointer, f"this is no JSON Pointer: {error}", hint=hint)]) from None
    if len(tokens) != 2 or tokens[1] not in cells:
        name = "/".join(tokens[1:])
        raise DesignError([Problem(pointer, f"no component that moves is named '{name}'", hint=hint)])
    return str(tokens[1])


def _check_options(
    parameter: _Parameter, trim_at: TrimAt | None, targets: Mapping[str, float] | None, free: Sequence[str] | None
) -> None:
    """Raise `DesignError` where the ways to find a motion contradict each other, or a target or a cell is wrong."""
    if targets is None and free is None:
        return
    if targets is None or free is None:
        wanted = "targets" if targets is None else "free"
        raise DesignError([Problem(f"/options/{wanted}", "targets and free cells go together", hint="give both")])
    if trim_at is not None:
        raise DesignError([Problem("/options/targets", "targets and trim_at both say what to seek", hint="give one")])
    if parameter.cell is not None and parameter.cell in free:
        at = pointer_to("options", "free", list(free).index(parameter.cell))
        message = f"'{parameter.cell}' takes the values, so it is not free"
        raise DesignError([Problem(at, message, hint="leave it out of the free cells")])
    check_wish(parameter.design, targets, free)


def _finder(
    trim_at: TrimAt | None, targets: Mapping[str, float] | None, free: Sequence[str] | None, depth: float | None
) -> _Find:
    """Return what finds the motion: the caller's way, one with targets, or the search for all at given extensions."""
    if trim_at is not None:
        given = trim_at
        return lambda assembly, extensions, last: given(assembly.design, extensions, last)
    if targets is not None and free is not None:
        return _trim_for_targets(targets, free, depth)
    return _trim_at_depth(depth)


def _trim_for_targets(targets: Mapping[str, float], free: Sequence[str], depth: float | None) -> _Find:
    """Return the search for a motion that meets targets by free cells, the others staying at given extensions."""

    def at(assembly: Assembly, extensions: Mapping[str, float], last: OperatingPoint | None) -> OperatingPoint:
        found = trim_for(assembly, targets, free, extensions=extensions, depth=depth)
        if isinstance(found, TrimFailure):
            raise DesignError([Problem("/options/targets", str(found))])
        return point_of(found)

    return at


def _trim_at_depth(depth: float | None) -> _Find:
    """Return the search for trims at a depth: the first one found, then the one most like the last."""

    def at(assembly: Assembly, extensions: Mapping[str, float], last: OperatingPoint | None) -> OperatingPoint:
        search = find_trims(assembly, extensions=extensions, depth=depth)
        if not search.solutions:
            return _at_rest(search, extensions)
        points = [point_of(trim) for trim in search.solutions]
        return points[0] if last is None else min(points, key=lambda point: _unlike(point, last))

    return at


def _at_rest(search: TrimSearch, extensions: Mapping[str, float]) -> OperatingPoint:
    if search.rest is None:
        raise DesignError([Problem("", f"no steady motion was found: {search.searched}")])
    return OperatingPoint.from_steady(
        extensions=extensions, roll=search.rest.roll, pitch=search.rest.pitch, velocity=(0.0, 0.0, 0.0),
        depth=search.depth,
    )  # fmt: skip


def _unlike(a: OperatingPoint, b: OperatingPoint) -> float:
    """Return how far two motions are apart: angles in rad, velocities as a share of the faster."""
    angles = [math.remainder(x - y, math.tau) for x, y in ((a.roll, b.roll), (a.pitch, b.pitch))]
    fastest = max(a.speed, b.speed, 1e-9)
    return math.hypot(*angles, math.dist(a.velocity, b.velocity) / fastest)


def _crossings(values: Array, found: ComplexArray, names: tuple[str, ...]) -> Iterator[Crossing]:
    """Yield where the real part of a branch changes sign between two values, by linear interpolation."""
    good = np.flatnonzero(np.isfinite(found.real).all(axis=1))
    for k, name in enumerate(names):
        if name in STEADY_NAMES:
            continue
        for i, j in pairwise(good):
            a, b = found[i, k], found[j, k]
            if a.real * b.real >= 0.0 or max(abs(a.real), abs(b.real)) <= NEUTRAL or a.imag + b.imag < 0.0:
                continue
            share = a.real / (a.real - b.real)
            at = values[i] + share * (values[j] - values[i])
            frequency = abs(a.imag + share * (b.imag - a.imag))
            yield Crossing(k, name, float(at), float(frequency), bool(b.real < 0.0))
