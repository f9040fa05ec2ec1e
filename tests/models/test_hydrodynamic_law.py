"""The law in the angle of attack: exact symmetries, what lies between the data, fits, and the kernel's copy of it."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from models.assemble import assemble
from models.design import parse_design
from models.hydrodynamic_law import DEGREES, build_law, coefficients_by_speed, select_data
from models.hydrodynamics import PolarTable
from models.kernel.planar import evaluate_law, hydrodynamics
from models.presets import load_preset
from models.problems import DesignError
from tests.models.support import document, polar
from tests.strategies import hydrodynamics as tables

LAWS = pytest.mark.parametrize("law", ["pchip", "polynomial"])
CIRCLE = np.deg2rad(np.linspace(-179.97, 179.93, 2003))
"""Angles that are no knots of a table in whole degrees."""


def standin(**changes):
    return load_preset("canete-dual-bellows").vehicle.hydrodynamics.model_copy(update=changes)


def rounding(law):
    return 1e-13 * np.abs(law(CIRCLE)).max(axis=1, keepdims=True)


@given(tables())
def test_lift_and_moment_are_odd_and_drag_even(table):
    law = build_law(PolarTable.model_validate(table))
    up, down = law(CIRCLE), law(-CIRCLE)
    assert (np.abs(up - np.array([[-1.0], [1.0], [-1.0]]) * down) <= rounding(law) + 1e-13).all()


@given(tables())
def test_past_90_degrees_drag_and_moment_keep_their_value_and_lift_turns(table):
    law = build_law(PolarTable.model_validate(table))
    front = np.deg2rad(np.linspace(0.013, 89.97, 700))
    signs = np.array([[-1.0], [1.0], [1.0]])
    assert (np.abs(law(np.pi - front) - signs * law(front)) <= rounding(law) + 1e-13).all()


@given(tables(law="pchip"))
def test_pchip_has_exact_zeros(table):
    law = build_law(PolarTable.model_validate(table))
    at = law(np.array([0.0, math.pi / 2, -math.pi / 2]))
    assert at[0].tolist() == [0.0, 0.0, 0.0]
    assert at[2, 0] == 0.0
    ends = law(np.array([math.pi, -math.pi]))
    # evaluated at the far end of the last piece: zero to the rounding of a cubic
    assert np.abs(ends[[0, 2]]).max() <= 1e-13 * np.abs(law(CIRCLE)).max()
    assert ends[1] == pytest.approx(at[1, 0], rel=1e-13)


@given(tables(law="polynomial"))
def test_polynomials_have_exact_zeros_at_zero(table):
    law = build_law(PolarTable.model_validate(table))
    assert law(0.0)[0] == law(0.0)[2] == 0.0
    assert (np.abs(law(math.nextafter(0.0, -1.0))) <= rounding(law)[:, 0] + np.array([0.0, np.inf, 0.0])).all()
    assert law(-math.pi)[0] == law(-math.pi)[2] == 0.0


@given(tables(law="pchip"))
def test_pchip_equals_the_data_at_its_knots(table):
    data = PolarTable.model_validate(table)
    law = build_law(data)
    angles, values = select_data(data)
    got = law(angles)
    np.testing.assert_allclose(got[1], values[1], rtol=1e-14)
    np.testing.assert_allclose(got[0, 1:-1], values[0, 1:-1], rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(got[2, 1:], values[2, 1:], rtol=1e-14, atol=1e-16)


@given(tables(law="pchip"))
def test_pchip_stays_between_neighbouring_data(table):
    data = PolarTable.model_validate(table)
    law = build_law(data)
    angles, values = select_data(data)
    values = values.copy()
    values[0, [0, -1]] = values[2, 0] = 0.0
    for a, b, left, right in zip(angles, angles[1:], values.T, values.T[1:], strict=False):
        inside = law(np.linspace(a, b, 23)[:-1])
        low, high = np.minimum(left, right)[:, None], np.maximum(left, right)[:, None]
        slack = 1e-12 * (1.0 + np.abs(values).max())
        assert (inside >= low - slack).all() and (inside <= high + slack).all()
        steps = np.diff(inside, axis=1) * np.sign(right - left)[:, None]
        assert steps.min() >= -slack  # monotone from knot to knot


def test_drag_has_no_kink_at_zero_or_180():
    """Made through the mirrored data; on 0 to 90 deg alone PCHIP would start with a slope."""
    law = build_law(standin())
    h = 1e-6
    for alpha in (0.0, math.pi - h):
        slope = (law(min(alpha + h, math.pi))[1] - law(alpha - h)[1]) / (2 * h)
        assert abs(slope) < 1e-3  # curvature of 70 N s2/m2 over 1e-6 rad
    assert law.coefficients[np.searchsorted(law.breaks, 0.0), 1, 1] == pytest.approx(0.0, abs=1e-14)


@given(tables(law="polynomial"))
def test_polynomials_are_least_squares_in_all_powers_without_constants(table):
    data = PolarTable.model_validate(table)
    law = build_law(data)
    angles, values = select_data(data)
    inner = np.deg2rad(np.linspace(0.01, 89.99, 91))
    for row, (quantity, lowest) in enumerate((("lift", 1), ("drag", 0), ("moment", 1))):
        powers = np.arange(lowest, DEGREES[quantity] + 1)
        fit, *_ = np.linalg.lstsq(angles[:, None] ** powers, values[row], rcond=None)
        expected = inner[:, None] ** powers @ fit
        np.testing.assert_allclose(law(inner)[row], expected, rtol=0, atol=1e-11 * (1.0 + np.abs(expected).max()))


def test_odd_powers_alone_would_miss_the_lift():
    """Why all powers of |alpha| are used: odd ones miss the stand-in's lift by about a third of its range."""
    angles, values = select_data(standin())
    odd = angles[:, None] ** np.array([1, 3, 5])
    miss = odd @ np.linalg.lstsq(odd, values[0], rcond=None)[0] - values[0]
    assert 0.25 < np.abs(miss).max() / np.ptp(values[0]) < 0.37
    assert build_law(standin(law="polynomial")).errors[0].relative < 0.5 * np.abs(miss).max() / np.ptp(values[0])


@LAWS
def test_drag_is_positive_everywhere(law):
    assert build_law(standin(law=law))(np.linspace(-np.pi, np.pi, 10_001))[1].min() > 0.0


def test_drag_that_is_not_positive_is_refused_with_its_angle():
    drag = [2.0, 10.0, 9.0, -1.0, 14.0, 18.0, 22.0, 26.0, 29.0, 32.0]
    with pytest.raises(DesignError) as refused:
        build_law(PolarTable.model_validate(polar(row_drag=drag)))
    (problem,) = refused.value.problems
    assert problem.pointer == "/vehicle/hydrodynamics/row_drag"
    assert "30.0 deg" in problem.message and "-1" in problem.message
    assert problem.limit == 0.0


def test_polynomial_drag_that_dips_below_zero_points_at_the_law():
    drag = [0.001, 0.001, 0.001, 0.001, 0.001, 30.0, 0.001, 0.001, 0.001, 0.001]
    with pytest.raises(DesignError) as refused:
        build_law(PolarTable.model_validate(polar(law="polynomial", row_drag=drag)))
    assert refused.value.problems[0].pointer == "/vehicle/hydrodynamics/law"
    assert "pchip" in refused.value.problems[0].hint


def test_too_few_angles_for_the_polynomials_are_refused():
    few = {"row_speed": [1.0] * 5, "row_alpha_deg": [0.0, 20.0, 45.0, 70.0, 90.0], "row_lift": [0, 1, 2, 1, 0.0],
           "row_drag": [1, 2, 3, 4, 5.0], "row_moment": [0.0] * 5}  # fmt: skip
    build_law(PolarTable.model_validate(polar(**few)))
    with pytest.raises(DesignError) as refused:
        build_law(PolarTable.model_validate(polar(law="polynomial", **few)))
    assert refused.value.problems[0].limit == 7


def two_speeds(**changes):
    one = polar()
    both = {name: [*one[name], *one[name]] for name in one if name.startswith("row_")}
    both["row_speed"] = [1.0] * 10 + [2.0] * 10
    both["row_drag"] = [*one["row_drag"], *(6.0 * v for v in one["row_drag"])]
    return PolarTable.model_validate(one | both | changes)


def test_speeds_are_averaged_per_squared_speed_or_one_is_chosen():
    """At 2 m/s drag is 6 times that at 1 m/s: 1.5 times per squared speed, 1.25 on average."""
    at_one = np.array(polar()["row_drag"])
    for chosen, factor in ((None, 1.25), (1.0, 1.0), (2.0, 1.5)):
        table = two_speeds(speed=chosen)
        np.testing.assert_allclose(select_data(table)[1][1], factor * at_one, rtol=1e-14)
    assert set(coefficients_by_speed(two_speeds())) == {1.0, 2.0}


def test_speeds_with_other_angles_cannot_be_averaged_but_chosen():
    angles = np.tile(np.linspace(0.0, 90.0, 10), 2)
    angles[13] += 1.0
    with pytest.raises(DesignError) as refused:
        build_law(two_speeds(row_alpha_deg=angles.tolist()))
    assert "cannot be averaged" in str(refused.value)
    build_law(two_speeds(row_alpha_deg=angles.tolist(), speed=2.0))


def test_rows_of_several_speeds_may_be_interleaved():
    table = two_speeds()
    order = np.argsort(np.array(table.row_alpha_deg), kind="stable")
    shuffled = two_speeds(**{name: [float(column[i]) for i in order] for name, column in table.columns})
    np.testing.assert_array_equal(build_law(shuffled).coefficients, build_law(table).coefficients)


@LAWS
def test_fit_errors_are_what_the_law_misses(law):
    table = standin(law=law)
    made = build_law(table)
    angles, values = select_data(table)
    inside = np.minimum(angles, np.nextafter(np.pi / 2, 0.0)) if law == "polynomial" else angles
    miss = np.abs(made(inside) - values)
    for row, error in enumerate(made.errors):
        assert error.quantity == ("lift", "drag", "moment")[row]
        assert error.largest == pytest.approx(miss[row].max(), rel=1e-9, abs=1e-12)
        assert error.rms == pytest.approx(math.sqrt((miss[row] ** 2).mean()), rel=1e-9, abs=1e-12)
        assert error.range == pytest.approx(np.ptp(values[row]))
        assert error.rms <= error.largest
    if law == "pchip":
        assert made.errors[1].largest <= 1e-12  # drag passes through every point


@given(tables(), st.floats(-math.pi, math.pi))
@example(polar(), math.pi)
@example(polar(), -math.pi)
@example(polar(), 0.0)
@example(polar(), -0.0)
@example(polar(law="polynomial"), math.pi / 2)
def test_the_kernel_evaluates_the_same_law(table, alpha):
    changed = document()
    changed["vehicle"]["hydrodynamics"] = table
    assembly = assemble(parse_design(changed))
    law = assembly.law
    knots = np.concatenate([law.breaks, np.nextafter(law.breaks, 10.0), np.nextafter(law.breaks, -10.0), [alpha]])
    knots = np.clip(knots, -math.pi, math.pi)
    size = np.abs(law(CIRCLE)).max(axis=1)
    for angle in (*knots, *CIRCLE[::97]):
        got = np.array(evaluate_law(float(angle), assembly.params))
        assert (np.abs(got - law(angle)) <= 1e-13 * size + 1e-15).all()


def test_the_kernel_finds_the_piece_in_a_dense_table():
    """Angles 0.01 deg apart, the closest allowed: every bucket still holds one break at most."""
    alpha = np.array([0.0, 0.01, 0.02, 30.0, 30.01, 60.0, 89.99, 90.0])
    a = np.deg2rad(alpha)
    table = polar(
        row_speed=[1.0] * 8, row_alpha_deg=alpha.tolist(), row_lift=np.sin(2 * a).tolist(),
        row_drag=(1.0 + np.sin(a)).tolist(), row_moment=np.sin(a).tolist(),
    )  # fmt: skip
    changed = document()
    changed["vehicle"]["hydrodynamics"] = table
    assembly = assemble(parse_design(changed))
    for angle in np.concatenate([np.linspace(-math.pi, math.pi, 4001), np.linspace(-4e-4, 4e-4, 801)]):
        got = np.array(evaluate_law(float(angle), assembly.params))
        np.testing.assert_allclose(got, assembly.law(angle), rtol=0, atol=1e-13)


def test_forces_scale_with_density_and_move_to_the_origin():
    """X, Z turn with alpha; a moment about r_ref gains r x F; all scale with rho / rho_ref."""
    changed = document(environment={"water": {"density": 1025.0}})
    changed["vehicle"]["hydrodynamics"] = polar(reference_point=[0.2, 0.0, -0.05])
    assembly = assemble(parse_design(changed))
    u, w = 0.3, 0.2
    lift, drag, moment, X, Z, alpha, speed = hydrodynamics(u, w, assembly.params)
    L, D, M = assembly.law(math.atan2(w, u)) * (u * u + w * w) * 1.025
    assert (lift, drag) == pytest.approx((L, D), rel=1e-14)
    assert (alpha, speed) == pytest.approx((math.atan2(w, u), math.hypot(u, w)), rel=1e-15)
    expected = -D * math.cos(alpha) + L * math.sin(alpha), -D * math.sin(alpha) - L * math.cos(alpha)
    assert (X, Z) == pytest.approx(expected, rel=1e-14)
    assert moment == pytest.approx(M - 0.05 * X - 0.2 * Z, rel=1e-13)
    assert u * X + w * Z == pytest.approx(-D * speed, rel=1e-13)  # only drag takes power


def test_still_water_gives_no_force():
    assembly = assemble(load_preset("canete-dual-bellows"))
    assert hydrodynamics(0.0, 0.0, assembly.params) == (0.0,) * 7
