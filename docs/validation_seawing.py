"""Owns check 7 of docs/validation.md: the Seawing's steady spiral from rest, beside published and independent ones."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from models.design import Design, parse_design
from models.presets import load_preset
from models.run import Run
from models.simulate import simulate
from tests.models.spatial_reference import SpatialReference, rotation_from_euler

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "tests" / "data" / "seawing_zhang_2013.json"
DURATION = 3600.0
SETTLED = 0.01
"""Share of its final value within which a quantity counts as settled."""
OWN_DIGITS = 1e-6
"""Largest difference of the simulated spiral from the root of the independent simulator's equations, deg or share."""


class Quantity(NamedTuple):
    """A number of the spiral: its name in a run, in the data file, the factor to the file's unit, and its words.

    `relative` says that the agreement demanded is a share of the published value.
    """

    name: str
    key: str
    factor: float
    words: str
    unit: str
    digits: int
    relative: bool = False


DEGREES = 180.0 / math.pi
QUANTITIES = (
    Quantity("phi", "phi_deg", DEGREES, "Roll", "deg", 3),
    Quantity("theta", "theta_deg", DEGREES, "Pitch", "deg", 3),
    Quantity("alpha", "alpha_deg", DEGREES, "Angle of attack", "deg", 3),
    Quantity("beta", "beta_deg", DEGREES, "Sideslip", "deg", 3),
    Quantity("speed", "V", 1.0, "Speed", "m/s", 4, relative=True),
    Quantity("turn_rate", "omega3_rad_s", 1.0, "Turn rate", "rad/s", 5, relative=True),
)


class Row(NamedTuple):
    """One quantity in the file's unit: published, by the independent solution, ours, and what is demanded."""

    quantity: Quantity
    published: float
    independent: float
    ours: float
    demanded: float

    @property
    def difference(self) -> float:
        """Ours less published; a share of it where the demand is one."""
        apart = self.ours - self.published
        return apart / abs(self.published) if self.quantity.relative else apart


@cache
def published() -> dict[str, Any]:
    """Return the data file."""
    return dict(json.loads(DATA.read_text(encoding="utf-8")))


def spiral_design() -> Design:
    """Return the preset started level and at rest, the battery in its place."""
    document = load_preset("seawing-spiral").model_dump(mode="json")
    document["mission"]["initial"] |= {"pitch": 0.0, "velocity": [0.0, 0.0, 0.0]}
    document["mission"]["solver"]["tolerance"] = 1e-10
    document["mission"]["duration"] = DURATION
    return parse_design(document)


@cache
def spiral() -> Run:
    """Simulate it."""
    return simulate(spiral_design())


def rows_of(final: dict[str, float]) -> tuple[Row, ...]:
    """Return the comparison of a last sample."""
    data, found = published(), []
    for q in QUANTITIES:
        demanded = data["agreement"][q.key.removesuffix("_rad_s") + "_relative" if q.relative else q.key]
        ours = q.factor * final[q.name]
        found.append(Row(q, data["published"][q.key], data["independent"][q.key], ours, demanded))
    return tuple(found)


def rows() -> tuple[Row, ...]:
    """Return the comparison at the end of the run."""
    return rows_of(spiral().final)


def worst_miss(final: dict[str, float]) -> float:
    """Return the largest difference from the published values in units of what is demanded."""
    return max(abs(row.difference) / row.demanded for row in rows_of(final))


@cache
def variants() -> dict[str, dict[str, float]]:
    """Return the last sample of the spiral with one thing wrong at a time, by words."""
    k = published()["parameters"]
    wrong: dict[str, dict[str, Any]] = {
        "rate terms times V": {"rate_scaling": "speed"},
        "K_M0, K_MY with the other sign": {"pitch_zero": -k["KM0"], "yaw_sideslip": -k["KMY"]},
        "no Munk moment": {"includes_munk_moment": True},
    }
    finals = {}
    for words, change in wrong.items():
        document = spiral_design().model_dump(mode="json")
        document["vehicle"]["hydrodynamics"] |= change
        finals[words] = simulate(parse_design(document)).final
    return finals


def published_radius(V: float, theta: float, alpha: float, turn_rate: float) -> float:
    """Return the radius as the source forms it, m: V cos(theta - alpha) / turn rate (angles in rad)."""
    return V * math.cos(theta - alpha) / turn_rate


def radii() -> dict[str, float]:
    """Return the radius (m): as printed; by its formula from the printed figures, and from ours; of the path itself."""
    data, final = published()["published"], spiral().final
    given = math.radians(data["theta_deg"]), math.radians(data["alpha_deg"])
    return {
        "printed": data["R_m"],
        "formula, printed": published_radius(data["V"], *given, data["omega3_rad_s"]),
        "formula, ours": published_radius(final["speed"], final["theta"], final["alpha"], final["turn_rate"]),
        "path": final["turn_radius"],
    }


def center() -> tuple[float, float]:
    """Return the axis of the steady spiral, (x, y) m: abeam of the last sample, by horizontal speed over turn rate."""
    final = spiral().final
    return final["x"] - final["y_dot"] / final["turn_rate"], final["y"] + final["x_dot"] / final["turn_rate"]


@cache
def steady_root() -> dict[str, float]:
    """Return the steady spiral by the tests' independent simulator: the root of its six accelerations, rad and m/s.

    Unknowns: roll, pitch, velocity in body axes and the turn rate about the vertical.
    """
    design = spiral_design()
    reference = SpatialReference(design)
    extensions = dict(design.mission.initial.extensions)

    def accelerations(unknowns: Array) -> Array:
        R = rotation_from_euler(unknowns[0], unknowns[1], 0.0)
        omega = unknowns[5] * R[2]
        parts = reference.acceleration(np.array([0.0, 0.0, 50.0]), R, unknowns[2:5], omega, extensions, 0.0)
        return np.concatenate(parts)

    found = root(accelerations, [-0.2, -0.6, 0.5, 0.0, 0.01, 0.004], tol=1e-13).x
    phi, theta, u, v, w, turn_rate = (float(value) for value in found)
    speed = math.sqrt(u * u + v * v + w * w)
    return {
        "phi": phi, "theta": theta, "alpha": math.atan2(w, u), "beta": math.asin(v / speed), "speed": speed,
        "turn_rate": turn_rate,
    }  # fmt: skip


def largest_from_root() -> float:
    """Return the largest difference of the simulated spiral from that root, in deg, or as a share."""
    differences = []
    for q in QUANTITIES:
        apart = q.factor * (spiral().final[q.name] - steady_root()[q.name])
        differences.append(abs(apart / (q.factor * steady_root()[q.name])) if q.relative else abs(apart))
    return max(differences)


@cache
def settled() -> float:
    """Return when pitch, roll, sideslip and turn rate are near their final values for good, s."""
    run, last = spiral(), 0.0
    for name in ("phi", "theta", "beta", "turn_rate"):
        off = np.abs(run.values[name] / run.final[name] - 1.0) > SETTLED
        last = max(last, float(run.times[off].max()))
    return last
