"""Owns how benchmarks measure: medians of interleaved runs, single-threaded, printed as ratios of one run."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def interleaved_times(cases: Mapping[str, Callable[[], object]], *, rounds: int = 15) -> dict[str, Array]:
    """Return the times of each case by round, s; the cases take turns, so that a busy machine slows all alike."""
    times: dict[str, list[float]] = {name: [] for name in cases}
    for case in cases.values():
        case()
    for _ in range(rounds):
        for name, case in cases.items():
            began = time.perf_counter()
            case()
            times[name].append(time.perf_counter() - began)
    return {name: np.array(values) for name, values in times.items()}


def interleaved_medians(cases: Mapping[str, Callable[[], object]], *, rounds: int = 15) -> dict[str, float]:
    """Return the median time of each case, s."""
    return {name: float(np.median(values)) for name, values in interleaved_times(cases, rounds=rounds).items()}


def spread(values: Array) -> str:
    """Return the middle half of repeated measurements as text."""
    low, high = np.percentile(values, [25, 75])
    return f"{low:.3g} to {high:.3g}"


def print_ratio(label: str, ratio: float, *, target: str) -> None:
    """Print one ratio beside the figure to reach."""
    print(f"{label:<64} {ratio:8.2f}x   to reach: {target}")
