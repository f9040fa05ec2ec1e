"""Owns what may be wanted of a trim: targets by name, how they contradict each other, and where to start for them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.kernel.steady import EXTENSIONS, HEAVE, PITCH, ROLL, ROWS, SURGE, TURN
from models.problems import DesignError, Problem, echo, pointer_to
from models.steady_problem import SteadyProblem
from models.trim_search import motions_at, straight_motions

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
UNITS = {
    "glide_angle": "rad", "speed": "m/s", "sink_rate": "m/s", "turn_rate": "rad/s", "pitch": "rad", "roll": "rad",
    "turn_radius": "m",
}  # fmt: skip
"""Targets and their units; the glide angle is positive on a climb, turn rate and radius to the right."""
OF_TURNS = ("turn_rate", "turn_radius", "roll")
"""Targets that only a turn can meet, or that leave the turn rate open; without any of them, a trim is straight."""
SMALLEST = {
    "glide_angle": -0.5 * math.pi, "speed": 1e-4, "sink_rate": -100.0, "turn_rate": -10.0, "pitch": -0.5 * math.pi,
    "roll": -math.pi, "turn_radius": -1e6,
}  # fmt: skip
LARGEST = {name: -value for name, value in SMALLEST.items()} | {"speed": 100.0}
TURN_ROW = ROWS.index("turn_rate")
AGREE = 1e-9
"""Targets that depend on each other agree within this share."""
LEAST_DRIVE = 1e-6
"""Net weights below this share of the weight drive no start."""
WELL_DRIVEN = 0.25
"""Extensions whose net weight is at least this share of what the free cells can add to it are kept as a start."""
USUAL_PATH, USUAL_SPEED = math.radians(30.0), 0.3
"""Where nothing says otherwise, a start glides at this angle (rad) and speed (m/s)."""
ATTACKS = tuple(math.radians(angle) for angle in (1.5, 4.0, 9.0))
"""Angles of attack of starts, to the side on which lift carries."""
STEEP = math.radians(65.0)
"""On steeper paths lift may point to either side."""
BANKS = tuple(math.radians(bank) for bank in (8.0, 30.0))


@dataclass(frozen=True)
class Targets:
    """Targets by name, and as the kernel wants them: `rows` (targets,) and `wanted` (rows,).

    `straight` says that none is of a turn, so that the trim must not turn; `scale` (rows,) is what counts as far off.
    """

    values: Mapping[str, float]
    rows: Indices
    wanted: Array
    scale: Array
    straight: bool


def targets_of(values: Mapping[str, float], *, spatial: bool) -> Targets:
    """Return checked targets.

    Raises
    ------
    DesignError
        Where one is unknown, no finite number, out of bounds, needs the spatial model, or contradicts another.

    """
    problems = list(_each(values, spatial))
    if not values:
        problems.append(Problem("/options/targets", "no target is given", hint=f"give any of {', '.join(UNITS)}"))
    if not problems:
        problems = list(_contradictions(values))
    if problems:
        raise DesignError(problems)
    rows, wanted, scale = [], np.zeros(len(ROWS)), np.ones(len(ROWS))
    for name in _independent(values):
        row = ROWS.index("curvature" if name == "turn_radius" else name)
        rows.append(row)
        wanted[row] = 1.0 / values[name] if name == "turn_radius" else values[name]
        scale[row] = max(abs(wanted[row]), {"m/s": 0.05, "rad/s": 0.01, "m": 1e-3}.get(UNITS[name], 1.0))
    scale[TURN_ROW] = max(abs(wanted[TURN_ROW]), 0.01)
    straight = spatial and not any(name in OF_TURNS for name in values)
    return Targets(dict(values), np.array(rows, dtype=np.int64), wanted, scale, straight)


def _each(values: Mapping[str, float], spatial: bool) -> Iterator[Problem]:
    """Yield what is wrong with a target by itself."""
    for name, value in values.items():
        at = pointer_to("options", "targets", name)
        if name not in UNITS:
            yield Problem(at, f"there is no target '{name}'", hint=f"those are: {', '.join(UNITS)}")
        elif not isinstance(value, int | float) or not math.isfinite(value):
            yield Problem(at, f"{name} is a finite number of {UNITS[name]}, not {echo(value)}")
        elif not SMALLEST[name] <= value <= LARGEST[name]:
            limit = SMALLEST[name] if value < SMALLEST[name] else LARGEST[name]
            within = f"{SMALLEST[name]:.4g} to {LARGEST[name]:.4g} {UNITS[name]}"
            yield Problem(at, f"{name} {value:g} {UNITS[name]} is not within {within}", limit=limit)
        elif name == "turn_radius" and value == 0.0:
            yield Problem(at, "a turn has no radius of 0 m", limit=0.0, hint="positive turns to the right")
        elif name in OF_TURNS and not spatial:
            hint = "set /mission/solver/model to spatial"
            yield Problem(at, f"{name} needs the spatial model: a planar design stays in its plane", hint=hint)


def _contradictions(values: Mapping[str, float]) -> Iterator[Problem]:
    """Yield targets that no motion meets together, whatever the glider."""

    def against(name: str, other: str, why: str) -> Problem:
        return Problem(pointer_to("options", "targets", name), f"{name} contradicts {other}: {why}", hint="drop one")

    speed, sink, path = values.get("speed"), values.get("sink_rate"), values.get("glide_angle")
    rate, radius = values.get("turn_rate"), values.get("turn_radius")
    if speed is not None and sink is not None and abs(sink) > speed * (1.0 + AGREE):
        yield against("sink_rate", "speed", f"{sink:g} m/s down is more than {speed:g} m/s in all")
    elif speed is not None and sink is not None and path is not None:
        if abs(sink + speed * math.sin(path)) > AGREE * speed:
            yield against("sink_rate", "speed and glide_angle", f"those sink by {-speed * math.sin(path):g} m/s")
    elif sink is not None and path is not None and (sink * path > 0.0 or (sink == 0.0) != (path == 0.0)):
        yield against("sink_rate", "glide_angle", "a path with a negative angle sinks, one with a positive climbs")
    if rate is None or radius is None:
        return
    if rate * radius <= 0.0:
        yield against("turn_radius", "turn_rate", "both are positive to the right")
    elif speed is not None and rate * radius > speed * (1.0 + AGREE):
        yield against("turn_radius", "turn_rate and speed", f"together they take {rate * radius:g} m/s over ground")
    elif speed is not None and path is not None and abs(rate * radius - speed * math.cos(path)) > AGREE * speed:
        yield against(
            "turn_radius", "turn_rate, speed and glide_angle", f"those turn at {speed * math.cos(path) / rate:g} m"
        )


def _independent(values: Mapping[str, float]) -> list[str]:
    """Return the targets without those that follow from the others."""
    left = list(values)
    if {"speed", "sink_rate", "glide_angle"} <= set(left):
        left.remove("sink_rate")
    if {"speed", "glide_angle", "turn_rate", "turn_radius"} <= set(left):
        left.remove("turn_radius")
    return left


def driven(problem: SteadyProblem, free: Indices, targets: Targets) -> SteadyProblem:
    """Return the problem with the free cells moved to where they drive the wanted motion, where the given ones do not.

    The trim nearest to extensions at which the glider weighs what it displaces, or nearly, would be one that hardly
    moves. So where no speed is wanted, and the net weight that drives the wanted path is less than `WELL_DRIVEN` of
    what the free cells add on the way to their stops (or drives the other way), they go toward those stops until there
    is half of what can be had: half way from neutral.
    """
    if "speed" in targets.values or "sink_rate" in targets.values or not len(free):
        return problem
    path = _paths(problem, targets.values)[0]
    steps = np.zeros(len(problem.steps))
    steps[free] = problem.steps[free]
    _rows, slope = problem.slopes(problem.rest(problem.extensions), steps)
    cells = free - EXTENSIONS
    # slopes that are rounding move nothing: of masses that slide, and change no weight
    per_extension = np.where(
        np.abs(slope[2, free]) * (problem.high - problem.low)[cells] > LEAST_DRIVE * problem.weight, slope[2, free], 0.0
    )
    toward = np.sign(-path * per_extension)
    way = np.where(toward > 0.0, problem.high[cells], problem.low[cells]) - problem.extensions[cells]
    along, more = -math.copysign(1.0, path) * problem.net_weight, float(np.abs(per_extension * way).sum())
    if path == 0.0 or along >= WELL_DRIVEN * more or along + more <= 0.0:
        return problem
    e = problem.extensions.copy()
    e[cells] += 0.5 * (1.0 - along / more) * np.abs(toward) * way
    return replace(problem, extensions=e, net_weight=float(problem.rows(problem.rest(e))[2]))


def starts_for(problem: SteadyProblem, targets: Targets, *, at_hand_first: bool = True) -> Array:
    """Return starts (m, unknowns) for a search: the straight trims at hand, and motions like those wanted."""
    values = targets.values
    rows = []
    for path in _paths(problem, values):
        for attack in _attacks(path, values):
            speed = _speed(problem, values, path, attack)
            s = problem.rest(problem.extensions)
            s[PITCH], s[SURGE], s[HEAVE] = path + attack, speed * math.cos(attack), speed * math.sin(attack)
            rows.append(s)
    starts = np.array(rows)
    if abs(problem.net_weight) > LEAST_DRIVE * problem.weight:
        near, met = straight_motions(problem, math.radians(4.0))
        forward = met & (near[:, SURGE] > np.abs(near[:, HEAVE]))
        starts = np.concatenate([near[forward], starts] if at_hand_first else [starts, near[forward]])
    if not problem.spatial or targets.straight:
        return starts
    return np.concatenate([_banked(problem, values, start) for start in starts])


def _paths(problem: SteadyProblem, values: Mapping[str, float]) -> list[float]:
    """Return path angles of starts, rad."""
    if "glide_angle" in values:
        return [values["glide_angle"]]
    sink = values.get("sink_rate")
    if sink and "speed" in values:
        return [-math.asin(max(-1.0, min(1.0, sink / values["speed"])))]
    if sink:
        return [-math.copysign(USUAL_PATH, sink)]
    pitch = values.get("pitch", 0.0)
    if pitch:
        return [pitch * 1.1]
    if abs(problem.net_weight) > LEAST_DRIVE * problem.weight:
        return [-math.copysign(USUAL_PATH, problem.net_weight)]
    return [-USUAL_PATH, USUAL_PATH]


def _attacks(path: float, values: Mapping[str, float]) -> list[float]:
    if "pitch" in values and "glide_angle" in values:
        return [values["pitch"] - path]
    carrying = [-math.copysign(attack, path) for attack in ATTACKS]
    return carrying if abs(path) < STEEP else [*carrying, *(-attack for attack in carrying)]


def _speed(problem: SteadyProblem, values: Mapping[str, float], path: float, attack: float) -> float:
    """Return the speed of a start, m/s: as wanted, or as the net weight at hand drives it."""
    if "speed" in values:
        return values["speed"]
    if values.get("sink_rate") and abs(math.sin(path)) > 0.02:
        return abs(values["sink_rate"] / math.sin(path))
    if abs(problem.net_weight) > LEAST_DRIVE * problem.weight:
        s = motions_at(problem, np.array([attack]), problem.extensions)[0]
        return min(math.hypot(s[SURGE], s[HEAVE]), LARGEST["speed"])
    return USUAL_SPEED


def _banked(problem: SteadyProblem, values: Mapping[str, float], start: Array) -> Array:
    """Return a straight start, banked and turning as wanted or as lift would make it."""
    speed, path = math.hypot(start[SURGE], start[HEAVE]), start[PITCH] - math.atan2(start[HEAVE], start[SURGE])
    level = speed * math.cos(path)
    leans = math.copysign(1.0, -path * values.get("turn_rate", values.get("turn_radius", 1.0)))  # as its lift would
    banks = [values["roll"]] if "roll" in values else [sign * bank for sign in (leans, -leans) for bank in BANKS]
    mass = float(problem.params.space[0]["mass"]) + float(problem.params.added[1, 1])
    rows = np.repeat(start[None, :], len(banks), axis=0)
    for s, bank in zip(rows, banks, strict=True):
        s[ROLL] = bank
        if "turn_rate" in values:
            s[TURN] = values["turn_rate"]
        elif "turn_radius" in values:
            s[TURN] = level / values["turn_radius"]
        else:
            s[TURN] = problem.net_weight * math.tan(max(-1.4, min(1.4, bank))) / (mass * max(speed, 1e-3))
    return rows


def distance_in_strokes(problem: SteadyProblem, motion: Array) -> float:
    """Return how far a motion's extensions are from the given ones, in strokes."""
    return float(np.linalg.norm((motion[EXTENSIONS:] - problem.extensions) / (problem.high - problem.low)))
