"""Owns the energy bill of a run: what came from the battery, for what, in which dive, and for how far a way.

A separate account from the balance of works: an actuator that expands against pressure or lifts a mass pays the work
over its efficiency, one that is driven gives back only its stated share; the hotel load adds power times time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from models.run import Run

LEAST_PROMINENCE = 0.25
"""Share of the range of depths by which the glider must rise and sink again for a new dive to begin."""
SHORTEST_WAY = 1.0
"""Over less horizontal travel than this (m), energy per distance means nothing."""


@dataclass(frozen=True, slots=True)
class Spent:
    """Energy from the battery over a stretch of a run (J), the stretch (s), its greatest depth and way over ground (m).

    `parts` holds what each actuator took, by name; `total` is theirs and the hotel load's.
    """

    begin: float
    end: float
    depth: float
    distance: float
    hotel: float
    parts: Mapping[str, float]

    @property
    def total(self) -> float:
        """All energy taken, J."""
        return self.hotel + sum(self.parts.values())

    @property
    def per_km(self) -> float | None:
        """Energy per kilometre of horizontal travel, J/km; None where there was hardly any."""
        return 1e3 * self.total / self.distance if self.distance >= SHORTEST_WAY else None


@dataclass(frozen=True, slots=True)
class EnergyBill:
    """The bill of a whole run and of each of its dives."""

    whole: Spent
    dives: tuple[Spent, ...]


def energy_bill(run: Run) -> EnergyBill | None:
    """Return the bill of a spatial run; None for a planar one, which keeps no such account."""
    if run.model != "spatial":
        return None
    ways = np.hypot(np.diff(run.values["x"]), np.diff(run.values["y"]))
    way = np.concatenate([[0.0], np.cumsum(ways)])
    marks = dive_marks(run.values["z"])
    dives = tuple(_spent(run, way, a, b) for a, b in pairwise(marks))
    return EnergyBill(_spent(run, way, 0, len(run.times) - 1), dives)


def dive_marks(z: NDArray[np.float64]) -> list[int]:
    """Return the samples between which the dives lie: the ends of depths z (samples,), and shallow ones."""
    from scipy.signal import find_peaks  # loading it takes most of a second, which a start need not wait for

    reach = float(np.ptp(z))
    if reach <= 0.0:
        return [0, len(z) - 1]
    shallow, _ = find_peaks(-z, prominence=LEAST_PROMINENCE * reach)
    return [0, *(int(k) for k in shallow), len(z) - 1]


def _spent(run: Run, way: NDArray[np.float64], a: int, b: int) -> Spent:
    energy, t = run.cell_values["energy"], run.times
    before = np.zeros(energy.shape[1]) if a == 0 else energy[a]  # a jump at time zero is charged to the first dive
    return Spent(
        begin=float(t[a]),
        end=float(t[b]),
        depth=float(run.values["z"][a : b + 1].max()),
        distance=float(way[b] - way[a]),
        hotel=run.design.vehicle.hotel_power * float(t[b] - t[a]),
        parts=dict(zip(run.cells, (energy[b] - before).tolist(), strict=True)),
    )
