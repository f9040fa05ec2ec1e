"""Owns check 2 of docs/validation.md: energy without dissipation, and the orders at which drift and states converge."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.assemble import assemble
from models.kernel.model import energies
from models.kernel.params import Params
from models.presets import load_preset
from tests.models.support import fixed_steps, observed_orders, without_water
from tests.models.test_spatial_oracle import moving_design
from tests.models.test_spatial_truths import changed, without_forces

Array = NDArray[np.float64]
METHODS = {"RK4": (False, 4), "Dormand-Prince 5(4)": (True, 5)}
"""Whether it is the pair, and the order by theory."""
ALLOWED = 0.35
"""How far below the theory an observed order may lie, and that of states above it."""


class Convergence(NamedTuple):
    """An error against the step: `what` is drift or state, `order` that observed between the two finest steps."""

    model: str
    what: str
    method: str
    theory: int
    steps: Array
    errors: Array

    @property
    def order(self) -> float:
        """The observed order between the two finest steps."""
        return float(observed_orders(list(self.errors))[-1])


def swinging() -> tuple[Params, Array]:
    """Return the paper's glider without forces of the water, in a slow swing."""
    assembly = assemble(load_preset("canete-dual-bellows"))
    y = assembly.initial_state.copy()
    y[2:6] = [1.5, 0.5, -0.3, 0.5]
    return without_water(assembly.params), y


def tumbling_in_space() -> tuple[Params, Array]:
    """Return a glider with all parts off its plane of symmetry, in stratified water that takes no energy, turning."""
    assembly = assemble(without_forces(moving_design({})))
    return assembly.params, assembly.initial_state


def tumbling_in_the_plane() -> tuple[Params, Array]:
    """Return a glider with added mass in a fast tumble, without forces of the water: their table has corners."""
    assembly = assemble(load_preset("three-cell-glider"))
    y = assembly.initial_state.copy()
    y[2:6] = [0.4, 0.5, -0.3, 3.0]
    return without_water(assembly.params), y


def gliding_in_space() -> tuple[Params, Array]:
    """Return a spatial glide with all its forces, which are smooth."""
    assembly = assemble(changed(moving_design({}), control={"schedules": []}))
    return assembly.params, assembly.initial_state


def _drifts(p: Params, y: Array, *, pair: bool, length: float, coarse: int) -> tuple[Array, Array]:
    steps, drifts = [], []
    for halving in range(4):
        count = coarse * 2**halving
        saved = fixed_steps(pair, p, y, h=length / count, steps=count)
        totals = np.array([sum(energies(0.0, state, p)) for state in saved])
        steps.append(length / count)
        drifts.append(float(np.abs(totals - totals[0]).max()))
    return np.array(steps), np.array(drifts)


def _state_errors(p: Params, y: Array, *, pair: bool, length: float, coarse: int, moving: int) -> tuple[Array, Array]:
    best = fixed_steps(True, p, y, h=length / (64 * coarse), steps=64 * coarse)[-1]
    steps, errors = [], []
    for halving in range(4):
        count = coarse * 2**halving
        last = fixed_steps(pair, p, y, h=length / count, steps=count)[-1]
        steps.append(length / count)
        errors.append(float(np.abs(last[:moving] - best[:moving]).max()))
    return np.array(steps), np.array(errors)


@cache
def convergences() -> tuple[Convergence, ...]:
    """Return the drift of the energy and the error of the states against the step, for both models and methods."""
    results = []
    for method, (pair, theory) in METHODS.items():
        found = _drifts(*swinging(), pair=pair, length=3.2, coarse=10 if pair else 80)
        results.append(Convergence("planar", "drift", method, theory, *found))
        found = _drifts(*tumbling_in_space(), pair=pair, length=4.0, coarse=100)
        results.append(Convergence("spatial", "drift", method, theory, *found))
        found = _state_errors(*tumbling_in_the_plane(), pair=pair, length=1.6, coarse=40, moving=6)
        results.append(Convergence("planar", "state", method, theory, *found))
        found = _state_errors(*gliding_in_space(), pair=pair, length=2.0, coarse=20, moving=13)
        results.append(Convergence("spatial", "state", method, theory, *found))
    return tuple(results)
