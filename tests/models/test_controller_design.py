"""Designed controllers: gains are those of other methods, and the kernel flies what the linear model promises."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm, solve_discrete_are

from models.controller_design import ControllerDesign, design_controller, gains_for
from models.controller_options import ControllerOptions, StepOptions
from models.controller_request import design_as_asked
from models.controllers import StateFeedback
from models.design import Design
from models.feedback_problem import feedback_problem
from models.limited_gains import cost_of, limited_gains, step_from
from models.loop_margins import gain_range
from models.loop_response import mission_from
from models.problems import DesignError
from models.run import Run, Status
from models.sampled_model import held_over, radius_of, sampled_model
from models.simulate import simulate
from tests.models.design_support import DIVE, designed, level_cells, planar_problem, uniform

PLANE = ("theta", "u", "w", "q")


@pytest.fixture(scope="module")
def quad() -> Design:
    return uniform()


@pytest.fixture(scope="module")
def held(quad: Design) -> ControllerDesign:
    """Least quadratic cost with all states, and the defaults."""
    return designed(quad)


def flown(result: ControllerDesign, *, factor: float = 1.0, late: float = 0.0, duration: float = 150.0) -> Run:
    """Fly from a pitch 0.2 mrad off the trim, with other gains or a longer delay than designed for."""
    problem = result.problem
    point = problem.point
    row = result.controller.points[0]
    gains = tuple(tuple(factor * k for k in each) for each in row.gains)
    changed = {
        "points": (row.model_copy(update={"gains": gains}),), "delay": result.controller.delay + late,
    }  # fmt: skip
    controller = result.controller.model_copy(update=changed)
    off = replace(point, pitch=point.pitch + 2e-4)
    return simulate(mission_from(problem.design, off, controller, duration=duration, interval=0.25))


def late_swing(result: ControllerDesign, run: Run) -> float:
    """How far pitch swings at the end, beside how far it was off at the start."""
    last = run.times > 0.8 * run.times[-1]
    return float(np.ptp(run.values["theta"][last])) / 2e-4


def test_a_sampled_model_is_the_motion_piece_by_piece_with_a_delay_between_samples():
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(3, 3)) - 1.5 * np.eye(3), rng.normal(size=(3, 2))
    K, T = 0.1 * rng.normal(size=(2, 4)), 0.5
    for delay in (0.0, 0.2, 0.5, 0.7, 1.0):
        model = sampled_model(A, B, states=("a", "b", "c"), cells=("x", "y"), sample_time=T, delay=delay, sums=1)
        X = np.zeros(len(model.states))
        X[:3] = 1.0, -1.0, 0.5
        x, total, waiting, told = X[:3].copy(), np.zeros(1), [], np.zeros(2)
        for k in range(10):
            waiting.append((k * T + delay, -K @ np.concatenate([x, total])))
            total, now, end = total + T * x[:1], k * T, (k + 1) * T
            while now < end - 1e-9:
                while waiting and waiting[0][0] <= now + 1e-9:
                    told = waiting.pop(0)[1]
                until = min([due for due, _ in waiting] + [end])
                F, G = held_over(A, B, until - now)
                x, now = F @ x + G @ told, until
            X = model.closed(K) @ X
            np.testing.assert_allclose(X[:4], [*x, *total], atol=1e-14)


def test_least_cost_is_that_of_another_solution(held: ControllerDesign):
    """Cost between samples by quadrature, the Riccati equation by SciPy in raw units."""
    problem, T = held.problem, held.problem.options.sample_time
    n, m = problem.B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = problem.A, problem.B
    weight = np.diag(np.concatenate([problem.deviations**-2.0, problem.commands**-2.0]))
    cost, _ = quad_vec(lambda t: expm(whole * t).T @ weight @ expm(whole * t), 0.0, T, epsabs=1e-12, epsrel=1e-12)
    F, G = expm(whole * T)[:n, :n], expm(whole * T)[:n, n:]
    Q, R, N = cost[:n, :n], cost[n:, n:], cost[:n, n:]
    P = solve_discrete_are(F, G, Q, R, s=N)
    K = np.linalg.solve(R + G.T @ P @ G, G.T @ P @ F + N.T)
    np.testing.assert_allclose(held.gains, K, rtol=1e-6, atol=1e-9)
    own = np.sort_complex(np.linalg.eigvals(problem.simple.closed(held.gains)))
    np.testing.assert_allclose(own, np.sort_complex(np.linalg.eigvals(F - G @ K)), atol=1e-9)
    # with every state fed back and no delay, the whole loop has the same eigenvalues
    np.testing.assert_allclose(
        sorted(abs(np.exp(mode.eigenvalue * T)) for mode in held.closed_loop.modes for _ in range(1 + mode.oscillates)),
        sorted(np.abs(own)), atol=1e-9,
    )  # fmt: skip


def test_weights_mean_the_same_at_any_sample_time(quad: Design):
    """Halving a short sample hardly changes the slow modes: the cost is that between samples too."""
    point, slow = designed(quad).problem.point, []
    for T in (0.1, 0.05, 0.025):
        problem = feedback_problem(quad, point, ControllerOptions(sample_time=T))
        model = problem.simple
        slow.append(sorted(mode.growth for mode in model.modes(model.closed(gains_for(problem)[0])).modes)[-3:])
    first, second = (np.abs(np.subtract(*pair)).max() for pair in ((slow[0], slow[1]), (slow[1], slow[2])))
    assert second < 0.6 * first < 0.01


def test_poles_are_where_they_are_asked_for(quad: Design):
    lags = ((-2.5, 0.0), (-2.6, 0.0), (-2.7, 0.0), (-2.8, 0.0))
    poles = ((-0.3, 0.2), (-0.3, -0.2), (-0.5, 0.0), (-0.5, 0.0), *lags)
    cells = tuple(part.name for _, part in quad.vehicle.actuated)
    result = designed(quad, method="poles", poles=poles, states=PLANE + cells)
    got = np.linalg.eigvals(result.problem.simple.closed(result.gains))
    wanted = np.exp([complex(*pole) for pole in poles])
    for value in wanted:
        # 1e-6: a pole that is asked for twice is split by the square root of rounding
        assert np.abs(got - value).min() < 1e-6
    assert result.stable and not any("met within" in word for word in result.warnings)


def test_cells_that_do_the_same_share_what_one_of_them_would_do(quad: Design):
    """Port and starboard act alike in the plane: poles are placed with two inputs for four cells."""
    poles = ((-0.3, 0.2), (-0.3, -0.2), (-0.2, 0.0), (-0.4, 0.0))
    result = designed(quad, method="poles", poles=poles, states=PLANE)
    np.testing.assert_allclose(result.gains[0], result.gains[1], atol=1e-9)
    got = np.linalg.eigvals(result.problem.simple.closed(result.gains))
    for value in np.exp([complex(*pole) for pole in poles]):
        assert np.abs(got - value).min() < 1e-9


def test_a_flight_near_the_trim_decays_as_the_linear_loop_says(held: ControllerDesign):
    """What the linear model leaves out is of second order: half the departure, a quarter of the difference."""
    for by in ({"theta": 8e-3}, {"psi": 8e-3}, {"phi": 2e-3, "r": 1e-4}):
        state = next(iter(by))
        left = []
        for scale in (1.0, 0.5):
            response = held.departure({name: scale * value for name, value in by.items()}, duration=60.0)
            left.append(
                np.abs(response.of_flight("theta") - response.linear[:, held.problem.states.index("theta")]).max()
            )
            off = np.abs(response.flown_state - response.predicted_state).max()
            assert off < 0.02 * abs(response.goal - response.start), state
        assert left[0] / left[1] == pytest.approx(4.0, rel=0.25)


def test_a_step_of_a_set_point_is_flown_as_predicted(held: ControllerDesign):
    theta = [held.step(StepOptions(state="theta", amount=a, duration=60.0)) for a in (4e-3, 2e-3)]
    off = [np.abs(each.flown_state - each.predicted_state).max() for each in theta]
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.25)
    assert theta[0].flown_state[-1] == pytest.approx(theta[0].goal, abs=1e-7)
    assert theta[0].predicted.rise_time == pytest.approx(theta[0].flown.rise_time, abs=0.05)
    assert theta[0].predicted.overshoot == pytest.approx(theta[0].flown.overshoot, abs=5e-3)
    psi = held.step(StepOptions(state="psi", amount=5e-3, duration=400.0))
    assert psi.difference < 2e-3 and abs(psi.flown.error) < 1e-3


def test_a_large_step_is_told_to_exceed_the_rates(held: ControllerDesign):
    response = held.step(StepOptions(state="theta", amount=0.1, duration=60.0))
    assert any("its limit is 0.001" in warning for warning in response.warnings)
    assert max(response.flown.rate.values()) == pytest.approx(1e-3, rel=1e-6)
    assert max(response.predicted.rate.values()) > 1e-3


@pytest.mark.parametrize("delay", [0.0, 1.3])
def test_a_delay_beyond_the_margin_makes_the_flight_swing_and_one_within_does_not(quad: Design, delay: float):
    result = designed(quad, share=0.1, delay=delay)
    margin = result.margins.delay
    assert late_swing(result, flown(result, late=0.7 * margin, duration=300.0)) < 0.1
    assert late_swing(result, flown(result, late=1.3 * margin, duration=300.0)) > 1.0


def test_a_gain_beyond_the_margin_makes_the_flight_swing_and_one_within_does_not(held: ControllerDesign):
    most = held.margins.gain_high
    assert late_swing(held, flown(held, factor=0.9 * most)) < 0.1
    assert late_swing(held, flown(held, factor=1.1 * most)) > 1.0


def test_margins_of_one_loop_are_those_of_python_control():
    import control  # loading it takes a second and a half

    result = planar_problem(trim={"depth": 20.0}, delay=0.7)
    problem = result.problem
    model = problem.whole()
    loop = control.ss(model.F, model.G, model.feedback(problem.widened(result.gains)), 0.0, model.sample_time)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it takes the frequency response in place of polynomials
        gain, phase, least, _, at, _ = control.stability_margins(loop)
    own = result.margins.cells[0]
    assert np.degrees(own.phase) == pytest.approx(phase, rel=1e-3)
    assert own.frequency == pytest.approx(at, rel=1e-3)
    assert result.margins.gain_high == pytest.approx(own.gain_high)
    assert own.gain_high == pytest.approx(gain, rel=1e-3)
    omega = np.pi / model.sample_time * np.logspace(-5, 0, 2000)
    disk, _, _ = control.disk_margins(loop, omega)
    assert own.disk == pytest.approx(disk, rel=1e-3)
    assert result.margins.disk == pytest.approx(own.disk)
    assert result.margins.return_difference == pytest.approx(least, rel=1e-3)


def test_disk_margins_hold_for_random_changes_of_all_cells(held: ControllerDesign):
    low, high = held.margins.disk_gain
    model, wide = held.problem.whole(), held.problem.widened(held.gains)
    rng = np.random.default_rng(1)
    for _ in range(200):
        factors = np.exp(rng.uniform(np.log(low), np.log(high), size=len(model.cells)))
        assert radius_of(model.closed(factors[:, None] * wide)) < 1.0
    one = np.array([1.0, 0.0, 0.0, 0.0])
    assert gain_range(model, wide, one)[1] == pytest.approx(held.margins.cells[0].gain_high)


def test_roll_that_two_cells_cannot_move_is_refused():
    design, cells = level_cells(), ("Front port cell", "Rear port cell")
    trim = {"extensions": {"Front port cell": 0.03, "Rear port cell": 0.045}, "depth": 50.0}
    states = ("theta", "phi", "u", "v", "w", "p", "q", "r")
    for method in ({}, {"method": "poles", "poles": tuple((-0.1 * (k + 1), 0.0) for k in range(8))}):
        with pytest.raises(DesignError, match="'Front port cell' and 'Rear port cell' cannot move the roll") as error:
            design_controller(design, ControllerOptions(trim=trim, cells=cells, states=states, **method))
        assert error.value.problems[0].pointer == "/options/states"
    result = design_controller(design, ControllerOptions(trim=trim, cells=cells))
    assert result.problem.states == (*PLANE, *cells)
    assert any("moved by no cell" in warning for warning in result.warnings)
    assert result.stable


@pytest.mark.parametrize(
    ("options", "pointer", "words"),
    [
        ({"states": ("theta", "z", "u", "w", "q")}, "/options/states/1", "z changes by .* nothing to hold"),
        ({"states": ("theta", "Nose")}, "/options/states/1", "no state 'Nose'"),
        ({"cells": ("Nose",)}, "/options/cells/0", "no component that moves is named 'Nose'"),
        ({"deviations": {"z": 1.0}}, "/options/deviations/z", "'z' is no state fed back"),
        ({"shares": {"Nose": 0.1}}, "/options/shares/Nose", "'Nose' is no cell under control"),
        ({"method": "poles", "poles": ((-1.0, 0.0),)}, "/options/poles", "1 poles are given, 13 are needed"),
        (
            {"method": "poles", "poles": ((-1.0, 0.0),) * 4, "states": PLANE, "cells": ("Front port cell",)},
            "/options/poles", "asked for 4 times; the cells allow 1",
        ),
        ({"delay": 100.0}, "/options/delay", "more than 63 samples"),
        ({"step": {"duration": 1e5}, "sample_time": 0.01}, "/options/step/duration", "10000000 samples"),
        ({"integrals": 3}, "/options/integrals", "cannot hold theta, psi and phi"),
        ({"step": {"state": "phi", "amount": 0.1}}, "/options/step/state", "its heading is held"),
        ({"trim": {"targets": {"glide_angle": -0.5, "speed": 9.0}}}, "/options/trim/targets", "no trim meets them"),
    ],
)  # fmt: skip
def test_what_cannot_be_designed_is_refused(quad: Design, options: dict[str, Any], pointer: str, words: str):
    with pytest.raises(DesignError, match=words) as error:
        designed(quad, **options)
    assert error.value.problems[0].pointer == pointer


def test_an_integral_takes_away_what_a_wrong_trim_leaves(quad: Design):
    """Extensions of the trim wrong by 0.5 mm front against rear: pitch settles off, with an integral it does not."""
    left = []
    for integrals in (0, 1):
        result = designed(quad, integrals=integrals, integral_time=20.0)
        row = result.controller.points[0]
        wrong = tuple(e + d for e, d in zip(row.extensions, (5e-4, 5e-4, -5e-4, -5e-4), strict=True))
        controller = result.controller.model_copy(update={"points": (row.model_copy(update={"extensions": wrong}),)})
        point = result.problem.point
        run = simulate(mission_from(quad, point, controller, duration=400.0, interval=1.0))
        left.append(abs(float(run.values["theta"][-1]) - point.pitch))
    assert left[0] > 1e-3 and left[1] < 1e-2 * left[0]


def test_states_and_lags_left_out_of_the_design_are_in_its_figures(quad: Design):
    result = designed(quad, states=PLANE)
    assert len(result.gains[0]) == 4
    assert any("lag" in mode.name for mode in result.closed_loop.modes)
    assert {"phi", "v"} <= set(result.problem.model.state_names)
    response = result.departure({"theta": 2e-3}, duration=60.0)
    assert response.difference < 5e-3


def test_a_delay_that_the_design_does_not_know_is_told(quad: Design):
    """Poles are placed without it."""
    poles = tuple((-0.5 - 0.1 * k, 0.0) for k in range(4))
    result = designed(quad, method="poles", poles=poles, states=PLANE, delay=4.0)
    assert not result.stable and result.margins is None
    assert "not stable with all states and the delay" in result.warnings[0]
    assert any("found without the delay of 4 s" in warning for warning in result.warnings)


def test_gains_of_least_cost_know_the_delay_and_what_is_not_fed_back(quad: Design, held: ControllerDesign):
    """From another start they are the Riccati equation's where that applies; elsewhere no gains nearby cost less."""
    none = np.zeros(0)
    again = limited_gains(held.problem, 0.6 * held.gains, none)
    np.testing.assert_allclose(again, held.gains, atol=1e-7 * np.abs(held.gains).max())
    rng = np.random.default_rng(2)
    for options in ({"delay": 1.3}, {"states": ("theta", "q"), "delay": 0.4}):
        result = designed(quad, **options)
        problem, model = result.problem, result.problem.whole()
        cost, wide = cost_of(problem, model, none), problem.widened(result.gains)
        columns = np.arange(len(problem.states))
        least = step_from(model, cost, model.feedback(wide), columns).cost
        # the cost is the sum over a response from each start, apart by the closed loop
        X, total = np.diag(cost.start), 0.0
        for _ in range(4000):
            U = -model.feedback(wide) @ X
            total += np.sum(X * (cost.Q @ X)) + 2.0 * np.sum(X * (cost.N @ U)) + np.sum(U * (cost.R @ U))
            X = model.F @ X + model.G @ U
        assert total == pytest.approx(least, rel=1e-6)
        for _ in range(50):
            nearby = result.gains * (1.0 + 0.02 * rng.normal(size=result.gains.shape))
            assert step_from(model, cost, model.feedback(problem.widened(nearby)), columns).cost > least


def test_plain_options_come_back_as_plain_results(quad: Design):
    """A route has a JSON object, and sends one."""
    options = {"trim": {"targets": {"speed": 0.2}, "depth": 20.0}, "share": 0.1}
    table = {"target": "pitch", "values": [-0.5, -0.4]}
    one = design_as_asked(quad, options | {"trim": DIVE, "step": {"state": "psi", "amount": 0.01}})
    for result in (one, design_as_asked(quad, options | {"table": table})):
        told = json.loads(json.dumps(result.as_dict(), allow_nan=False))
        assert StateFeedback.model_validate(told["controller"]) == result.controller
        assert simulate(result.mission(duration=2.0)).status is Status.completed
    assert {"margins", "closed_loop", "open_loop", "response", "warnings"} <= set(one.as_dict())


@pytest.mark.parametrize(
    ("options", "pointer"),
    [
        ({"sample_time": -1.0}, "/options/sample_time"),
        ({"step": {"amount": 0.0}}, "/options/step"),
        ({"trim": {"depths": 1.0}}, "/options/trim/depths"),
        ({"poles": [[-1.0, 1.0]], "method": "poles"}, "/options"),
        ({"method": "poles"}, "/options"),
    ],
)
def test_odd_options_are_refused_by_their_place(quad: Design, options: dict[str, Any], pointer: str):
    with pytest.raises(DesignError) as error:
        design_as_asked(quad, options)
    assert error.value.problems[0].pointer == pointer


def test_every_option_has_a_sentence_and_every_number_a_unit():
    schemas = ControllerOptions.model_json_schema()
    for schema in (schemas, *schemas["$defs"].values()):
        for name, field in schema.get("properties", {}).items():
            assert field.get("description"), name
            if field.get("type") in ("number", "integer"):
                assert "unit" in field and "symbol" in field, name


def test_a_planar_glider_is_held_by_one_mass():
    result = planar_problem(trim={"depth": 20.0}, step={"state": "theta", "amount": 0.01, "duration": 60.0})
    assert result.problem.states == PLANE
    assert result.stable and result.response.difference < 0.1
    assert isinstance(result.controller, StateFeedback)
