"""Without dissipation, at fixed extensions, T + U is constant; the drift shows each method's order (section 8.2)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.assemble import assemble
from models.kernel.model import energies
from models.presets import load_preset
from tests.models.support import fixed_steps, observed_orders, total_energy, without_water
from tests.strategies import designs, states


def tumbling(preset_id):
    """A preset without water forces, thrown into a tumble: every nonlinear term of the equations takes part."""
    assembly = assemble(load_preset(preset_id))
    y = assembly.initial_state.copy()
    y[2:6] = [0.4, 0.5, -0.3, 3.0]
    return without_water(assembly.params), y


def drift(pair, p, y, *, h, length):
    states_ = fixed_steps(pair, p, y, h=h, steps=round(length / h))
    return max(abs(total_energy(p, state) - total_energy(p, y)) for state in states_)


@pytest.mark.parametrize("preset_id", ["canete-dual-bellows", "three-cell-glider"])
@pytest.mark.parametrize(("pair", "order", "h"), [(False, 4, 0.04), (True, 5, 0.08)])
def test_energy_drift_falls_with_the_order_of_the_method(preset_id, pair, order, h):
    """At least: in a fast tumble RK4's leading error is nearly along the surface of constant energy, and 5 is seen."""
    p, y = tumbling(preset_id)
    drifts = [drift(pair, p, y, h=h / 2**k, length=3.2) for k in range(4)]
    assert drifts[-1] > 1e-13  # above rounding, or no order could be seen
    measured = observed_orders(drifts)
    assert measured[-1] > order - 0.2
    assert measured.min() > order - 0.5


def test_energy_drift_of_rk4_in_a_slow_swing_is_of_order_four():
    p, y = tumbling("canete-dual-bellows")
    y[2], y[5] = 1.5, 0.5
    measured = observed_orders([drift(False, p, y, h=0.04 / 2**k, length=3.2) for k in range(4)])
    assert np.abs(measured - 4.0).max() < 0.1


@pytest.mark.parametrize(("pair", "order", "h"), [(False, 4, 0.04), (True, 5, 0.04)])
def test_the_state_converges_with_the_order_of_the_method(pair, order, h):
    """Against the same method at a sixteenth of the finest step."""
    p, y = tumbling("three-cell-glider")

    def end(size):
        return fixed_steps(pair, p, y, h=size, steps=round(1.6 / size))[-1][:6]

    exact = end(h / 64)
    errors = [np.abs(end(h / 2**k) - exact).max() for k in range(3)]
    assert observed_orders(errors)[-1] == pytest.approx(order, abs=0.3)


@given(st.data(), designs(most=8))
def test_energy_is_constant_for_any_design(data, design):
    assembly = assemble(design)
    p = without_water(assembly.params)
    y = data.draw(states(assembly))
    y[3:6] *= 0.5
    start = total_energy(p, y)
    saved = fixed_steps(True, p, y, h=2e-3, steps=200)
    exchanged = max(abs(total_energy(p, state) - start) for state in saved)
    scale = max(abs(float(part)) for state in saved for part in energies(0.0, state, p))
    assert exchanged <= 1e-9 * scale  # truncation of the pair at 2 ms; potential energy has an arbitrary zero


def test_momentum_is_kept_where_the_vehicle_is_neutral():
    """No net force acts on a neutral vehicle: its linear momentum in the world is constant."""
    p, y = tumbling("canete-dual-bellows")
    saved = fixed_steps(True, p, y, h=1e-3, steps=2000)
    b = p.body[0]
    s, c, u, w, q = np.sin(saved[:, 2]), np.cos(saved[:, 2]), *saved[:, 3:6].T
    P_x, P_z = b["mass"] * u + b["mass_z"] * q, b["mass"] * w - b["mass_x"] * q
    along, down = c * P_x + s * P_z, -s * P_x + c * P_z
    assert np.ptp(along) <= 1e-11 * abs(along[0])
    assert np.ptp(down) <= 1e-11 * abs(along[0])
