"""Owns the colours of a path by a quantity of its run: which there are, over which range, and how each value looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.memory import remembered_for_life
from models.run import Run
from studio.palette import PATH_SCALE, rgb

Array = NDArray[np.float64]

QUANTITIES = {
    "z": "Depth",
    "speed": "Speed",
    "alpha": "Attack angle",
    "beta": "Sideslip",
    "theta": "Pitch",
    "phi": "Roll",
    "net_buoyancy": "Net buoyancy",
    "turn_rate": "Turn rate",
    "battery_energy": "Energy used",
}
"""What may colour a path, in the page's words; a planar run has not all of them."""
TAIL = 5.0
"""Percent of a run, at either end of what it goes through, that may lie beyond the scale."""
NOISE = 1e-9
"""Share of the largest value (in SI units, of values below 1) that is a rounding error: no end and no colour."""
OUTLYING = 2.0
"""A scale leaves the tails out where with them it would span this many times as much."""


@dataclass(frozen=True, slots=True)
class Scale:
    """The range over which colours change; `below` and `above` tell that the run goes beyond it."""

    name: str
    unit: str
    low: float
    high: float
    below: bool
    above: bool

    def document(self) -> dict[str, Any]:
        """Return what the page's legend needs."""
        return {
            "name": self.name, "label": QUANTITIES[self.name], "unit": self.unit, "low": self.low, "high": self.high,
            "below": self.below, "above": self.above,
        }  # fmt: skip


def quantities_of(run: Run) -> list[dict[str, str]]:
    """Return name and label of what can colour this run's path."""
    return [{"name": name, "label": label} for name, label in QUANTITIES.items() if name in run.values]


@remembered_for_life
def scale_of(run: Run, name: str | None) -> Scale | None:
    """Return the scale of a quantity along a run; None where the run has none of it.

    The short transient after the launch would take all the colours from the glide, so rare values may lie beyond.
    """
    if name is None or name not in run.values:
        return None
    values = run.values[name]
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    least, most = _without_noise(float(known.min()), float(known.max()))
    low, high = _without_noise(*_beyond_tails(known))
    if most - least <= OUTLYING * (high - low) or high <= low:
        low, high = least, most
    return Scale(name, run.variables[name][0], low, high, below=least < low, above=most > high)


def _without_noise(low: float, high: float) -> tuple[float, float]:
    """Return the ends of a range, 0 where they are rounding errors, and equal where only those part them."""
    noise = NOISE * max(abs(low), abs(high), 1.0)
    low, high = (0.0 if abs(end) <= noise else end for end in (low, high))
    return (low, high) if high - low > noise else (low, low)


def _beyond_tails(values: Array) -> tuple[float, float]:
    """Return the percentiles between which the scale lies (np.percentile, which takes much longer)."""
    ordered = np.sort(values)
    at = (len(ordered) - 1) * np.array([TAIL, 100.0 - TAIL]) / 100.0
    low, high = np.interp(at, np.arange(len(ordered)), ordered).tolist()
    return low, high


def colors_of(values: Array, scale: Scale) -> NDArray[np.uint8]:
    """Return the colour of each value (n, 3); what is not a number has that of the middle."""
    span = scale.high - scale.low
    share = np.full(len(values), 0.5) if span <= 0.0 else np.clip((values - scale.low) / span, 0.0, 1.0)
    at = np.where(np.isfinite(share), share, 0.5) * (len(SHADES) - 1)
    return SHADES[at.round().astype(np.intp)]


def _shades(steps: int) -> NDArray[np.uint8]:
    """Return the colours (steps, 3) from one end of the scale to the other."""
    stops = np.array([rgb(color) for color in PATH_SCALE], dtype=np.float64)
    at = np.linspace(0.0, len(stops) - 1, steps)
    channels = [np.interp(at, np.arange(len(stops)), column) for column in stops.T]
    return np.column_stack(channels).round().astype(np.uint8)


SHADES = _shades(1 + 512 * (len(PATH_SCALE) - 1))


def linear(colors: NDArray[Any]) -> NDArray[np.uint8]:
    """Return channels as Viser's client takes a colour for each end of a line: as light, not as #rrggbb.

    It would show #rrggbb paler; one colour for the whole of a line it takes as it is written.
    """
    share = np.asarray(colors, dtype=np.float64) / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.asarray((255.0 * light).round(), dtype=np.uint8)
