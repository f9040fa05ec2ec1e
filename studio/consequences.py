"""Owns the consequences of a design and its run: floating, trims, margins, energy, stops, and what to warn of.

They are worked out after each edit, once the new path is drawn; the newest counts. SI units and radians.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.assemble import Assembly
from models.energy import EnergyBill, Spent, energy_bill
from models.margins import hydrodynamics, hydrostatics
from models.mass_properties import mass_balance
from models.run import Run
from models.stability import QUANTITIES, Quantity, worst_of
from models.warm import analyses_are_ready, warm_analyses
from studio.cell_reach import NEAR_STOP, CellReach, cell_reach, reach_document
from studio.consequence_warnings import Warned, warnings_of
from studio.curves import rounded
from studio.held_glides import HeldGlide, glide_document, held_glide
from studio.holds import Span, holds_of, spans_of
from studio.listeners import Listeners
from studio.polar import source_range

Array = NDArray[np.float64]

MARGIN_SAMPLES = 120
"""Instants of a run at which margins are told."""


@dataclass(frozen=True, eq=False)
class Margins:
    """Margins at `times` (n,) s, by the names of `quantities`; `length` (m) is what the hydrodynamic ones count by."""

    quantities: tuple[Quantity, ...]
    times: Array
    series: Mapping[str, Array]
    length: float


@dataclass(frozen=True, eq=False)
class Consequences:
    """What follows from a design; without a run there are no margins, no energy and no reach of the cells.

    `left_out` counts holds that are too many to be told, `left_out_spans` is when the run is in one of them, s.
    """

    assembly: Assembly
    mass: float
    glides: tuple[HeldGlide, ...]
    left_out: int
    left_out_spans: tuple[Span, ...]
    analyses: bool
    margins: Margins | None
    energy: EnergyBill | None
    cells: tuple[CellReach, ...]
    warnings: tuple[Warned, ...]


def consequences_of(assembly: Assembly, run: Run | None, *, analyses: bool = True) -> Consequences:
    """Return the consequences of a design, `run` being its own run; without `analyses` there are no trims."""
    design = assembly.design
    end = design.mission.duration if run is None else float(run.times[-1])
    holds, left_out = holds_of(assembly, run)
    glides = tuple(held_glide(assembly, hold, run, analyses=analyses) for hold in holds)
    margins = None if run is None else margins_along(assembly, run)
    cells = () if run is None else tuple(cell_reach(assembly, run, k) for k in range(len(run.cells)))
    return Consequences(
        assembly, mass_balance(design.vehicle).mass, glides, len(left_out), spans_of(left_out), analyses,
        margins, None if run is None else energy_bill(run), cells,
        tuple(warnings_of(design, glides, margins, cells, end=end)),
    )  # fmt: skip


def margins_along(assembly: Assembly, run: Run, samples: int = MARGIN_SAMPLES) -> Margins:
    """Return the static margins at up to `samples` evenly spread instants of a run."""
    chosen = np.linspace(0, len(run.times) - 1, min(samples, len(run.times))).round().astype(np.intp)
    thin = run.select(chosen)
    still, flow = hydrostatics(thin), hydrodynamics(thin, assembly)
    series = {
        "hydrostatic_margin": still.margin, "pitch_stiffness": still.pitch, "pitch_margin": flow.pitch,
    }  # fmt: skip
    if run.model == "spatial":
        series |= {"roll_stiffness": still.roll, "yaw_margin": flow.yaw}
    told = tuple(quantity for quantity in QUANTITIES if quantity.name in series)
    return Margins(told, thin.times, series, flow.length)


def consequences_document(found: Consequences) -> dict[str, Any]:
    """Return consequences as the page shows them."""
    return {
        "analyses": "ready" if found.analyses else "compiling",
        "mass": found.mass,
        "holds": [glide_document(glide) for glide in found.glides],
        "left_out": found.left_out,
        "left_out_spans": found.left_out_spans,
        "margins": None if found.margins is None else _margins_document(found.margins),
        "energy": None if found.energy is None else _energy_document(found.energy),
        "cells": [reach_document(cell) for cell in found.cells],
        "near_stop": NEAR_STOP,
        "warnings": [warned.as_dict() for warned in found.warnings],
        "source": source_range(found.assembly.design.vehicle.hydrodynamics),
    }


def _margins_document(margins: Margins) -> dict[str, Any]:
    worst = [worst_of(quantity, margins.times, margins.series[quantity.name]) for quantity in margins.quantities]
    times, *series = rounded(np.array([margins.times, *margins.series.values()]))
    return {
        "length": margins.length,
        "times": times,
        "series": dict(zip(margins.series, series, strict=True)),
        "worst": {one.name: {"value": one.value, "time": one.time, "unit": one.unit} for one in worst if one},
    }


def _energy_document(bill: EnergyBill) -> dict[str, Any]:
    def told(spent: Spent) -> dict[str, Any]:
        return asdict(spent) | {"total": spent.total, "per_km": spent.per_km}

    return {"whole": told(bill.whole), "dives": len(bill.dives)}


class LiveConsequences:
    """The newest consequences of a session's work, as a document, and who wants to hear of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: Listeners[Callable[[], None]] = Listeners()
        self._asked: tuple[Assembly, Run, int] | None = None
        self._waits = False
        self._found: Consequences | None = None
        self._document: dict[str, Any] | None = None

    @property
    def found(self) -> Consequences | None:
        """The newest; None before the first."""
        return self._found

    @property
    def document(self) -> dict[str, Any] | None:
        """The newest as JSON, with their run's number, so that a page can tell older ones; None before the first."""
        return self._document

    def update(self, assembly: Assembly, run: Run, number: int) -> None:
        """Work them out for a design and its run, of a number that rises, and tell.

        As long as the analyses are being compiled they come without trims, and once more when that is done.
        """
        with self._lock:
            self._asked = assembly, run, number
            ready = analyses_are_ready()
            wait, self._waits = not ready and not self._waits, not ready
        self._work_out(assembly, run, number, analyses=ready)
        if wait:
            threading.Thread(target=self._once_compiled, name="consequences", daemon=True).start()

    def _once_compiled(self) -> None:
        warm_analyses()
        with self._lock:
            self._waits, asked = False, self._asked
        if asked is not None:
            self._work_out(*asked, analyses=True)

    def _work_out(self, assembly: Assembly, run: Run, number: int, *, analyses: bool) -> None:
        began = time.perf_counter()
        found = consequences_of(assembly, run, analyses=analyses)
        document = consequences_document(found)
        elapsed = 1e3 * (time.perf_counter() - began)
        with self._lock:
            if self._asked is not None and self._asked[2] > number:
                return  # a newer one is being worked out
            self._found = found
            self._document = {"run": number, "elapsed_ms": elapsed} | document
        for listener in self._listeners:
            listener()

    def subscribe(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Have `listener` called after each update, in the thread that worked it out; returns how to stop that."""
        return self._listeners.add(listener)
