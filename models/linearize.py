"""Owns linearisation: a design's slopes at an operating point, as a linear model with named states, inputs and outputs.

States are minimal: Euler angles (Z-Y-X) for the quaternion, and no position north or east, since nothing depends on it.
Velocities are those seen from the water at the point's depth and time: in a uniform current everything is carried
along, and only its change with depth and time acts. SI units and radians.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly, assemble
from models.attitude import quaternion_from_rpy_radians, rotation_of
from models.components import extension_unit
from models.design import Design
from models.kernel import linear, spatial_outputs
from models.kernel import outputs as planar_outputs
from models.kernel.params import Params
from models.linear_model import DRIFTING, STILL, LinearModel, Signal
from models.operating_point import OperatingPoint, minimal_of_state, minimal_state
from models.variables import ALL_VARIABLES

Array = NDArray[np.float64]
STEP = 2e-6
"""Step of the differences in angles (rad), velocities (m/s) and rates (rad/s)."""
DEPTH_STEP = 1e-3
"""Step in depth, m: density changes by 1e-5 a metre, and a smaller one would leave its slope to rounding."""
STROKE_STEP = 1e-5
"""Step in extension, as a share of the stroke."""


ROUNDING = 1e-11
"""Slopes over depth below this are rounding: that of a weight, over the step in depth."""
SLOWEST = 1e-3
"""Below this speed (m/s) the flow has no direction, and speed no slope."""
COLUMNS_KEPT = (
    "speed", "alpha", "beta", "flow_angle", "x_dot", "y_dot", "z_dot", "turn_rate", "lift", "drag", "net_buoyancy",
)  # fmt: skip
"""Output columns of the kernel that a linear model keeps."""
OF_DIRECTION = ("speed", "alpha", "beta", "flow_angle")
NEARLY_BACKWARD = np.pi - 1e-3
"""Angles beyond this jump by a whole turn nearby, rad."""


def state_names(assembly: Assembly) -> tuple[str, ...]:
    """Return the names of the minimal states, without extensions."""
    return linear.SPATIAL_STATES if assembly.params.space[0]["spatial"] else linear.PLANAR_STATES


def column_names(assembly: Assembly) -> tuple[str, ...]:
    """Return the names of the kernel's output columns."""
    return spatial_outputs.COLUMNS if assembly.params.space[0]["spatial"] else planar_outputs.COLUMNS


def carried(p: Params, depth: float, time: float) -> tuple[Params, tuple[float, float]]:
    """Return the constants as seen from the water at a depth and a time, and its velocity north and east, m/s."""
    if not p.current[:, 1:].any():
        return p, (0.0, 0.0)
    names = spatial_outputs.COLUMNS
    at = np.zeros(len(linear.SPATIAL_STATES) + len(p.parts))
    at[0] = depth
    row = np.zeros(len(linear.SPATIAL_STATES) + len(names))
    linear.rates_and_outputs(at, time, p, _work(p, len(linear.SPATIAL_STATES), len(names)), row)
    north, east = row[-len(names) :][[names.index("current_x"), names.index("current_y")]].tolist()
    seen = p.current.copy()
    seen[:, 1] -= north
    seen[:, 5] -= east
    return p._replace(current=seen), (north, east)


def _work(p: Params, states: int, columns: int) -> linear.LinearWork:
    parts = len(p.parts)
    length = int(p.space[0]["extensions"]) + parts * (2 if p.space[0]["spatial"] else 1)
    return linear.make_linear_work(length, parts, states, columns)


def steps_of(p: Params, states: int) -> Array:
    """Return the steps of the differences, (states + parts,)."""
    strokes = p.parts["stop_high"] - p.parts["stop_low"]
    steps = np.full(states + len(strokes), STEP)
    steps[0] = DEPTH_STEP
    steps[states:] = STROKE_STEP * strokes
    return steps


def slopes_at(p: Params, minimal: Array, *, columns: int, time: float = 0.0) -> tuple[Array, Array]:
    """Return rates and output columns at minimal states and extensions, and their slopes, from the kernel.

    `minimal` (states + parts,) as of `models.kernel.linear`, velocities as in `p`; the rows of the slopes are the rates
    and then the columns.
    """
    states = len(minimal) - len(p.parts)
    work = _work(p, states, columns)
    row, slope = np.zeros(states + columns), np.zeros((states + columns, len(minimal)))
    linear.rates_and_outputs(minimal, time, p, work, row)
    linear.slopes(minimal, steps_of(p, states), time, p, work, slope)
    return row, slope


def motion_matrix(
    assembly: Assembly, params: Params, state: Array, *, time: float = 0.0
) -> tuple[tuple[str, ...], Array]:
    """Return the names of the motion's states and the matrix of their rates' slopes, extensions and depth held.

    Of phi, theta, u, v, w, p, q, r (spatial) or theta, u, w, q (planar): depth and heading are left out, as nothing but
    the water's layers depends on them. `state` is one of the kernel's, with velocities over ground; `params` its
    constants. Velocities are seen from the water.

    Raises
    ------
    DesignError
        Where pitch is within 0.1 deg of straight up or down in space.

    """
    minimal = minimal_of_state(assembly, state)
    names = state_names(assembly)
    seen, current = carried(params, float(minimal[0]), time)
    if current != (0.0, 0.0):
        minimal[4:7] -= rotation_of(quaternion_from_rpy_radians(*minimal[1:4])).T @ np.array([*current, 0.0])
    _row, slope = slopes_at(seen, minimal, columns=len(column_names(assembly)), time=time)
    kept = [i for i, name in enumerate(names) if name not in ("z", "psi")]
    return tuple(names[i] for i in kept), np.ascontiguousarray(slope[np.ix_(kept, kept)])


def linearize(design: Design | Assembly, point: OperatingPoint) -> LinearModel:
    """Return the linear model of a design about an operating point, by central differences, extrapolated (Richardson).

    Inputs are the commanded extensions. A part with a lag T adds the state e with e' = (command - e) / T; any other
    follows its command at once, as a rate limit does not act on small motions. The point need not be an equilibrium.

    Raises
    ------
    DesignError
        Where pitch is within 0.1 deg of straight up or down in space, or the point does not fit the design.

    """
    assembly = design if isinstance(design, Assembly) else assemble(design)
    minimal = minimal_state(assembly, point)
    names, columns = state_names(assembly), column_names(assembly)
    n = len(names)
    seen, current = carried(assembly.params, point.depth, point.time)
    row, slope = slopes_at(seen, minimal, columns=len(columns), time=point.time)
    _clear_rounding(slope, names, columns, seen)
    kept = _columns_kept(columns, row[n:], point.speed)
    rows = [n + columns.index(name) for name in kept]
    parts, units = assembly.params.parts, _extension_units(assembly)
    extensions = minimal[n:]
    commands = np.array([point.commands.get(c, e) for c, e in zip(assembly.cells, extensions, strict=True)])
    lagging = np.flatnonzero(parts["inverse_lag"] > 0.0)
    A, B, C, D = _matrices(slope, rows, n, parts["inverse_lag"])
    rates = (commands - extensions) * parts["inverse_lag"]
    drift = np.concatenate([row[:n], np.clip(rates, -parts["rate"], parts["rate"])[lagging]])
    of_cell = [
        Signal(f"extension of {cell}", unit, f"extension of '{cell}'", float(e))
        for cell, unit, e in zip(assembly.cells, units, extensions, strict=True)
    ]
    states = tuple(_signal(name, value) for name, value in zip(names, minimal[:n], strict=True))
    over_ground = {"x_dot": current[0], "y_dot": current[1]}
    outputs = [_signal(name, row[i] + over_ground.get(name, 0.0)) for name, i in zip(kept, rows, strict=True)]
    inputs = tuple(
        Signal(f"command of {cell}", unit, f"commanded extension of '{cell}'", float(c))
        for cell, unit, c in zip(assembly.cells, units, commands, strict=True)
    )
    return LinearModel(
        model=assembly.design.mission.solver.model, point=point,
        states=(*states, *(of_cell[k] for k in lagging)), inputs=inputs,
        outputs=(*states, *outputs, *of_cell), A=A, B=B, C=C, D=D, drift=drift,
        notes=tuple(_notes(assembly, minimal, commands, drift, kept)),
    )  # fmt: skip


def _clear_rounding(slope: Array, names: tuple[str, ...], columns: tuple[str, ...], p: Params) -> None:
    """Set to zero what is zero by symmetry: the slopes over heading where the water stands still, over a uniform depth.

    Only the velocities over ground, and the angle itself, know the heading.
    """
    slope[np.abs(slope[:, 0]) < ROUNDING, 0] = 0.0
    if "psi" in names and not p.current[:, 1:].any():
        turned = [name in ("x_dot", "y_dot") for name in (*names, *columns)]
        turned[len(names) + columns.index("psi")] = True
        slope[~np.array(turned), names.index("psi")] = 0.0


def _matrices(slope: Array, rows: list[int], n: int, inverse_lag: Array) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C, D from the kernel's slopes, those columns being outputs that `rows` names.

    States are the n minimal ones and then the lagging extensions; outputs the minimal ones, the columns, every
    extension.
    """
    parts = len(inverse_lag)
    lagging, at_once = np.flatnonzero(inverse_lag > 0.0), np.flatnonzero(inverse_lag <= 0.0)
    states = n + len(lagging)
    A, B = np.zeros((states, states)), np.zeros((states, parts))
    A[:n, :n], A[:n, n:] = slope[:n, :n], slope[:n, n + lagging]
    A[range(n, states), range(n, states)] = -inverse_lag[lagging]
    B[:n, at_once] = slope[:n, n + at_once]
    B[range(n, states), lagging] = inverse_lag[lagging]
    C, D = np.zeros((n + len(rows) + parts, states)), np.zeros((n + len(rows) + parts, parts))
    C[:n, :n] = np.eye(n)
    C[n : n + len(rows), :n], C[n : n + len(rows), n:] = slope[rows, :n], slope[rows][:, n + lagging]
    D[n : n + len(rows), at_once] = slope[rows][:, n + at_once]
    C[n + len(rows) + lagging, range(n, states)] = 1.0
    D[n + len(rows) + at_once, at_once] = 1.0
    return A, B, C, D


def _columns_kept(columns: tuple[str, ...], values: Array, speed: float) -> list[str]:
    """Return the columns that have slopes here: at rest nothing has a direction, and a half turn of angle jumps."""
    kept = []
    for name in COLUMNS_KEPT:
        if name not in columns or (name in OF_DIRECTION and speed < SLOWEST):
            continue
        if name in ("alpha", "flow_angle") and abs(values[columns.index(name)]) > NEARLY_BACKWARD:
            continue
        kept.append(name)
    return kept


def _extension_units(assembly: Assembly) -> list[str]:
    return [extension_unit(part) for _, part in assembly.design.vehicle.actuated]


def _signal(name: str, value: float) -> Signal:
    unit, meaning = ALL_VARIABLES[name]
    return Signal(name, unit, meaning, float(value))


def _notes(assembly: Assembly, minimal: Array, commands: Array, drift: Array, kept: list[str]) -> Iterator[str]:
    """Yield what the reader should know of a model, in words."""
    names = state_names(assembly)
    n = len(names)
    rates = {name: rate for name, rate in zip(names, drift[:n], strict=True) if name not in DRIFTING}
    worst = max(rates, key=lambda name: abs(rates[name]))
    if abs(rates[worst]) > STILL:
        unit = ALL_VARIABLES[worst][0]
        yield f"this is not an equilibrium: {worst} changes by {rates[worst]:.3g} {unit} a second, most of all"
    if abs(drift[0]) > STILL:
        yield f"depth changes at {drift[0]:.3g} m/s: the water is frozen as it is at this depth"
    for cell, part, e, command in zip(assembly.cells, assembly.params.parts, minimal[n:], commands, strict=True):
        low, high, rate, per_lag = (float(part[k]) for k in ("stop_low", "stop_high", "rate", "inverse_lag"))
        if not low + 1e-9 * (high - low) < e < high - 1e-9 * (high - low):
            yield f"'{cell}' is at its stop: it can follow one way only"
        lags = abs(command - e) * per_lag > rate * (1.0 + 1e-9)
        if np.isfinite(rate) and (lags or (per_lag == 0.0 and abs(command - e) > 1e-9 * (high - low))):
            yield f"'{cell}' is moving at its rate limit, which the model does not know"
        elif np.isfinite(rate):
            yield f"the rate limit of '{cell}' ({rate:g} a second) does not act on small motions"
    if "speed" not in kept:
        yield "at rest the flow has no direction: speed, angle of attack, sideslip and flow angle have no slopes"
    yield "position north and east are left out: nothing depends on them"
