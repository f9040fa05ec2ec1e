"""The coefficients of the pair against SciPy's and against the order conditions; steps, dense output, orders."""

import numpy as np
import pytest
from scipy.integrate import RK45

from models.assemble import assemble
from models.design import parse_design
from models.kernel import tableau
from models.kernel.step import interpolate, next_factor
from tests.models.support import document, fixed_steps, observed_orders, one_step_with_dense, polar


def test_tableau_is_scipys():
    np.testing.assert_array_equal(tableau.A[:6, :5], RK45.A)
    np.testing.assert_array_equal(tableau.A[6], RK45.B)
    np.testing.assert_array_equal(tableau.C[:6], RK45.C)
    np.testing.assert_array_equal(tableau.E, RK45.E)
    np.testing.assert_array_equal(tableau.D, RK45.P)


def test_tableau_meets_its_order_conditions():
    A = np.column_stack([tableau.A, np.zeros(7)])
    b, c = A[6], tableau.C
    np.testing.assert_allclose(A.sum(axis=1), c, rtol=0, atol=1e-15)
    for power in range(5):  # quadrature conditions up to order 5
        assert b @ c**power == pytest.approx(1.0 / (power + 1), abs=1e-15)
    assert b @ A @ c == pytest.approx(1 / 6, abs=1e-15)
    assert b @ (c * (A @ c)) == pytest.approx(1 / 8, abs=1e-15)
    assert b @ A @ A @ A @ c == pytest.approx(1 / 120, abs=1e-15)
    lower = b + tableau.E
    assert tableau.E.sum() == pytest.approx(0.0, abs=1e-16)
    assert lower @ c**3 == pytest.approx(1 / 4, abs=1e-15)
    assert abs(lower @ c**4 - 1 / 5) > 1e-4  # the other solution is of order 4 only, or there were no estimate


def test_dense_output_meets_the_end_of_the_step():
    np.testing.assert_allclose(tableau.D.sum(axis=1), np.append(tableau.A[6], 0.0), rtol=0, atol=1e-15)


def smooth():
    """A glide whose law is one polynomial: no corner of any derivative falls into a step."""
    changed = document(initial={"position": [0.0, 0.0, 5.0], "velocity": [0.1, 0.0, 0.1]})
    changed["vehicle"]["hydrodynamics"] = polar(law="polynomial")
    return assemble(parse_design(changed))


def exact_at(assembly, t):
    return fixed_steps(True, assembly.params, assembly.initial_state, h=t / 200, steps=200)[-1]


@pytest.mark.parametrize(("pair", "order"), [(False, 4), (True, 5)])
def test_global_error_falls_with_the_order(pair, order):
    assembly = smooth()
    exact = exact_at(assembly, 0.2)
    ends = [fixed_steps(pair, assembly.params, assembly.initial_state, h=0.2 / n, steps=n)[-1] for n in (8, 16, 32)]
    errors = [np.abs(end - exact)[:6].max() for end in ends]
    assert errors[-1] > 1e-13  # well above the rounding of a depth of 5 m
    assert observed_orders(errors)[-1] == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(("pair", "order"), [(False, 4), (True, 5)])
@pytest.mark.parametrize("share", [0.25, 0.6, 0.85])
def test_dense_output_has_the_local_order_of_its_polynomial(pair, order, share):
    """Cubic through values and slopes: h^4; fourth-order dense output of the pair: h^5 in one step."""
    assembly = smooth()
    errors = []
    for h in (0.05, 0.025, 0.0125):
        _, dense = one_step_with_dense(pair, assembly.params, assembly.initial_state, h)
        out = np.zeros_like(assembly.initial_state)
        interpolate(share, assembly.initial_state, dense, out)
        errors.append(np.abs(out - exact_at(assembly, share * h))[:6].max())
    assert observed_orders(errors)[-1] > order - 0.35


@pytest.mark.parametrize("pair", [False, True])
def test_dense_output_joins_both_ends(pair):
    assembly = smooth()
    y1, dense = one_step_with_dense(pair, assembly.params, assembly.initial_state, 0.05)
    out = np.zeros_like(y1)
    interpolate(0.0, assembly.initial_state, dense, out)
    assert (out == assembly.initial_state).all()
    interpolate(1.0, assembly.initial_state, dense, out)
    np.testing.assert_allclose(out, y1, rtol=0, atol=1e-14)


def test_step_factor_stays_within_its_bounds():
    assert next_factor(0.0, 1.0) == 5.0
    assert next_factor(1e-30, 1.0) == 5.0
    assert next_factor(1e30, 1.0) == 0.2
    assert next_factor(float("nan"), 1.0) == 0.1
    assert next_factor(float("inf"), 1.0) == 0.1
    assert next_factor(1.0, 1.0) == pytest.approx(0.9)
