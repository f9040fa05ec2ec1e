"""Owns the built-in metrics: name, unit, meaning and exact definition of what a glider is usually judged by.

Each is a function of a `Stretch`, so it can be had of a whole run and of a dive. Horizontal ways are over ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from models.energy import SHORTEST_WAY
from models.metric_statistics import changes, mean
from models.metric_windows import Stretch
from models.run_warnings import SLOWEST

LEAST_TRAVEL = 1e-3
"""Over less travel than this (m), a ratio of ways means nothing."""
STEADY_SHARE = 0.2
"""A turn is judged over this last share of the time."""
STEADY = 0.1
"""A turn is steady where its rate departs from the mean by this share at most."""
LEAST_TURN = 0.01
"""A glider that turns by less than this (rad) in that time goes straight."""
BOTH, SPATIAL = ("planar", "spatial"), ("spatial",)


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """A built-in metric: `meaning` says what it is and when it is missing; `models` are those that have it."""

    unit: str
    meaning: str
    value: Callable[[Stretch], float]
    models: tuple[str, ...] = BOTH


def _range(s: Stretch) -> float:
    return math.hypot(_change(s, "x"), _change(s, "y") if "y" in s else 0.0)


def _change(s: Stretch, name: str) -> float:
    values = s[name]
    return float(values[-1] - values[0])


def _over(value: float, divisor: float, *, least: float = 0.0) -> float:
    """Return a ratio; not a number where the divisor is zero, or below the least that means anything."""
    return value / divisor if divisor >= least and divisor > 0.0 else math.nan


def _glide_angle(s: Stretch) -> float:
    moved = max(s.way, s.vertical_travel) >= LEAST_TRAVEL
    return math.atan2(s.vertical_travel, s.way) if moved else math.nan


def _largest_angle(s: Stretch, name: str) -> float:
    """Return the largest magnitude of an angle of the flow while there is a flow, rad."""
    angles = np.abs(s[name])[s["speed"] > SLOWEST]
    return float(angles.max()) if len(angles) else math.nan


def _turn_radius(s: Stretch) -> float:
    last = Stretch(s.glide, s.end - STEADY_SHARE * s.duration, s.end)
    rate = last["turn_rate"]
    middle = mean([(last.times, rate)])
    if not abs(middle) * last.duration >= LEAST_TURN or np.abs(rate - middle).max() > STEADY * abs(middle):
        return math.nan
    level = np.hypot(last["x_dot"] - last["current_x"], last["y_dot"] - last["current_y"])
    return mean([(last.times, level)]) / abs(middle)


def _course(s: Stretch) -> float:
    return math.atan2(_change(s, "y"), _change(s, "x")) if _range(s) >= LEAST_TRAVEL else math.nan


def _energy_residual(s: Stretch) -> float:
    return s.run.relative_residual if s is s.glide.whole else math.nan


def _cell_travel(s: Stretch) -> float:
    cells = [cell for cell, unit in zip(s.run.cells, s.run.extension_units, strict=True) if unit == "m"]
    return math.fsum(float(np.abs(changes(s.output("extension", cell))).sum()) for cell in cells)


def _bed_clearance(s: Stretch) -> float:
    bed = s.run.design.mission.environment.bed_depth
    return math.nan if bed is None else bed - float(s["z"].max())


def _dives(s: Stretch) -> float:
    return float(sum(s.holds(s.run.times[deepest]) for _, deepest, _ in s.glide.dives))


BUILT_IN: Mapping[str, BuiltIn] = {
    "range": BuiltIn("m", "horizontal distance from begin to end, over ground", _range),
    "way": BuiltIn("m", "length of the horizontal path over ground", lambda s: s.way),
    "duration": BuiltIn("s", "time that it took", lambda s: s.duration),
    "maximum_depth": BuiltIn("m", "greatest depth of the body origin", lambda s: float(s["z"].max())),
    "minimum_depth": BuiltIn("m", "least depth of the body origin", lambda s: float(s["z"].min())),
    "final_depth": BuiltIn("m", "depth of the body origin at the end", lambda s: float(s["z"][-1])),
    "vertical_travel": BuiltIn("m", "all way down and up, added", lambda s: s.vertical_travel),
    "bed_clearance": BuiltIn(
        "m", "least height of the body origin above the bed; missing where there is none", _bed_clearance),
    "glide_ratio": BuiltIn(
        "1", f"way over vertical_travel, whether down or up; missing below {LEAST_TRAVEL:g} m of the latter",
        lambda s: _over(s.way, s.vertical_travel, least=LEAST_TRAVEL)),
    "mean_glide_angle": BuiltIn(
        "rad", "angle of the mean path with the horizontal, steepness only: atan(vertical_travel / way)",
        _glide_angle),
    "mean_speed": BuiltIn(
        "m/s", "mean over time of the speed through the water", lambda s: mean([(s.times, s["speed"])])),
    "maximum_speed": BuiltIn("m/s", "largest speed through the water", lambda s: float(s["speed"].max())),
    "mean_horizontal_speed": BuiltIn("m/s", "way over duration", lambda s: _over(s.way, s.duration)),
    "mean_vertical_speed": BuiltIn(
        "m/s", "vertical_travel over duration", lambda s: _over(s.vertical_travel, s.duration)),
    "mean_sink_rate": BuiltIn(
        "m/s", "depth gained from begin to end over duration, down", lambda s: _over(_change(s, "z"), s.duration)),
    "maximum_pitch": BuiltIn("rad", "largest pitch, nose up", lambda s: float(s["theta"].max())),
    "minimum_pitch": BuiltIn("rad", "smallest pitch: the steepest nose down", lambda s: float(s["theta"].min())),
    "maximum_angle_of_attack": BuiltIn(
        "rad", f"largest magnitude of the angle of attack while it moves faster than {SLOWEST:g} m/s",
        lambda s: _largest_angle(s, "alpha")),
    "maximum_sideslip": BuiltIn(
        "rad", f"largest magnitude of the sideslip while it moves faster than {SLOWEST:g} m/s",
        lambda s: _largest_angle(s, "beta"), SPATIAL),
    "maximum_bank": BuiltIn(
        "rad", "largest magnitude of the roll angle", lambda s: float(np.abs(s["phi"]).max()), SPATIAL),
    "turn_radius": BuiltIn(
        "m", f"radius of the turn through the water over the last {100 * STEADY_SHARE:g} % of the time: mean "
        f"horizontal speed over mean turn rate; missing where it turns by less than {LEAST_TURN:g} rad in that, or "
        f"where the rate departs from its mean by more than {100 * STEADY:g} %", _turn_radius, SPATIAL),
    "heading_change": BuiltIn(
        "rad", "heading at the end less that at the begin, whole turns counted, to the right",
        lambda s: _change(s, "psi"), SPATIAL),
    "course": BuiltIn(
        "rad", f"direction from begin to end over ground, from north to the right; missing below {LEAST_TRAVEL:g} m",
        _course, SPATIAL),
    "maximum_pressure": BuiltIn(
        "Pa", "largest gauge pressure at the body origin", lambda s: float(s["pressure"].max()), SPATIAL),
    "energy": BuiltIn(
        "J", "energy taken from the battery, by actuators and hotel load", lambda s: s.gain("battery_energy"), SPATIAL),
    "energy_per_km": BuiltIn(
        "J/km", f"energy over way; missing below {SHORTEST_WAY:g} m of way",
        lambda s: 1e3 * _over(s.gain("battery_energy"), s.way, least=SHORTEST_WAY), SPATIAL),
    "mean_power": BuiltIn(
        "W", "energy over duration", lambda s: _over(s.gain("battery_energy"), s.duration), SPATIAL),
    "actuator_work": BuiltIn("J", "work of the actuators on the glider", lambda s: s.gain("actuator_work")),
    "energy_residual": BuiltIn(
        "1", "largest energy that the balance of works does not explain, as a share of the energy exchanged; of whole "
        "runs only", _energy_residual),
    "cell_travel": BuiltIn(
        "m", "changes of extension of all cells added, whatever the sign; those that roll are left out", _cell_travel),
    "end_stops": BuiltIn("1", "how often a cell reached a stop", lambda s: float(len(s.events("end_of_stroke")))),
    "surfacings": BuiltIn("1", "how often the glider reached the surface", lambda s: float(len(s.events("surface")))),
    "dives": BuiltIn("1", "how many dives of the energy bill have their deepest point in it", _dives),
}  # fmt: skip
"""By name. Missing means not a number."""
WHOLE_ONLY = ("energy_residual",)
"""Those that are of whole runs, not of stretches."""
