"""The loop over segments and steps: breakpoints, sampling, and the ways a run can end."""

import math
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.assemble import assemble
from models.design import parse_design
from models.kernel.integrate import (
    CANCELLED,
    COMPLETED,
    DIVERGED,
    STEP_TOO_SMALL,
    TOO_MANY_STEPS,
)  # fmt: skip
from models.limits import Limits
from models.run import Status
from models.simulate import Control, simulate
from tests.models.support import document, run_kernel, schedule

METHODS = pytest.mark.parametrize("solver", [{}, {"method": "rk4", "step": 0.01}], ids=["adaptive", "rk4"])
IRRATIONAL = math.sqrt(2.0)


@METHODS
def test_no_step_straddles_a_switch(solver):
    """A command that switches at an irrational time = two runs, the second from the first one's end."""
    whole = assemble(parse_design(document(
        control=schedule("Piston", (0.0, -0.008), (IRRATIONAL, 0.008)), duration=3.0, solver=solver,
    )))  # fmt: skip
    first = assemble(parse_design(document(
        control=schedule("Piston", (0.0, -0.008)), duration=IRRATIONAL, solver=solver,
    )))  # fmt: skip
    second = assemble(parse_design(document(
        control=schedule("Piston", (0.0, 0.008)), duration=3.0 - IRRATIONAL, solver=solver,
    )))  # fmt: skip
    middle = run_kernel(first).states[-1]
    expected = run_kernel(second, middle).states[-1]
    got = run_kernel(whole).states[-1]
    # fixed steps: the same steps but for rounding of t; adaptive: another first step, so two errors of the tolerance
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13 if solver else 1e-6)


def test_a_switch_between_fixed_steps_costs_no_order():
    """RK4 keeps its order through a step command at an irrational time; straddling it would leave order one."""

    def end(h):
        control = schedule("Piston", (0.0, -0.008), (0.1 * IRRATIONAL, 0.008))
        solver = {"method": "rk4", "step": h, "output_interval": 5.0}
        initial = {"position": [0.0, 0.0, 5.0], "velocity": [0.1, 0.0, 0.1]}  # the flow never crosses a piece's edge
        changed = document(control=control, duration=0.5, solver=solver, initial=initial)
        changed["vehicle"]["hydrodynamics"]["law"] = "polynomial"
        return run_kernel(assemble(parse_design(changed))).states[-1, :6]

    exact = end(1e-3)
    errors = [np.abs(end(h) - exact).max() for h in (0.04, 0.02, 0.01)]
    assert errors[-1] > 1e-11
    assert np.log2(errors[0] / errors[2]) / 2 > 3.5


@METHODS
@given(st.floats(0.003, 0.7), st.floats(0.5, 3.0))
def test_samples_are_at_exact_multiples_and_the_end(solver, interval, duration):
    changed = document(duration=duration, solver=solver | {"output_interval": interval})
    run = run_kernel(assemble(parse_design(changed)))
    assert run.code == COMPLETED
    assert run.times[-1] == duration
    assert (run.times[:-1] == np.arange(len(run.times) - 1) * interval).all()
    assert (np.diff(run.times) > 0.0).all()
    assert len(run.times) >= duration / interval


@pytest.mark.parametrize(("interval", "duration"), [(0.05, 20.0), (0.1, 0.7), (0.1, 130.0), (0.3, 0.9), (0.7, 4.9)])
def test_the_end_is_sampled_once(interval, duration):
    """Also where a multiple of the interval misses the end by rounding, as 3 * 0.3 = 0.8999999999999999 does."""
    run = run_kernel(assemble(parse_design(document(duration=duration, solver={"output_interval": interval}))))
    assert len(run.times) == round(duration / interval) + 1
    assert np.diff(run.times).min() > 0.5 * interval


@METHODS
def test_samples_lie_on_the_solution(solver):
    """Samples between steps agree with a run whose steps end there."""
    changed = document(duration=1.0, solver=solver | {"tolerance": 1e-11, "output_interval": 0.037})
    assembly = assemble(parse_design(changed))
    run = run_kernel(assembly)
    for t, state in list(zip(run.times, run.states, strict=True))[1:-1:5]:
        ended = run_kernel(assembly, duration=float(t)).states[-1]
        # the pair's polynomial is one order below its step; RK4's cubic: h^4 / 384 of a fourth derivative of 50 or so
        np.testing.assert_allclose(state, ended, rtol=0, atol=1e-9 if not solver else 5e-9)


@METHODS
def test_samples_are_right_continuous_at_a_jump(solver):
    changed = document(
        control=schedule("Piston", (1.0, 0.007), (2.0, -0.007)), solver=solver | {"output_interval": 0.5}, duration=2.0
    )
    run = run_kernel(assemble(parse_design(changed)))
    assert run.states[:, 8].tolist()[:4] == [0.0, 0.0, 0.007, 0.007]
    data = simulate(parse_design(changed)).data
    assert data["command"].values[:4, 0].tolist() == [0.0, 0.0, 0.007, 0.007]


def test_commands_and_extensions_of_a_sample_agree_where_rounding_puts_it_before_a_switch():
    """3 * 0.3 lies 1e-16 before 0.9: an ideal cell is on its command at every sample all the same."""
    changed = document(control=schedule("Piston", (0.9, 0.007)), solver={"output_interval": 0.3}, duration=2.0)
    data = simulate(parse_design(changed)).data
    np.testing.assert_array_equal(data["command"].values, data["extension"].values)


def test_two_runs_of_one_design_are_identical():
    design = parse_design(document(control=schedule("Piston", (0.0, -0.008), (2.0, 0.008, "ramp"))))
    one, two = simulate(design), simulate(design)
    assert one.data.identical(two.data)


def test_a_run_can_be_cancelled_from_another_thread():
    solver = {"method": "rk4", "step": 1e-4, "output_interval": 100.0}
    design = parse_design(document(duration=2e4, solver=solver))
    control, runs = Control(), []
    limits = Limits(steps=300_000_000)
    thread = threading.Thread(target=lambda: runs.append(simulate(design, limits=limits, control=control)))
    thread.start()
    while control.time_reached < 0.1 and thread.is_alive():
        pass
    control.cancel()
    thread.join(timeout=20.0)
    assert not thread.is_alive()
    assert runs[0].status is Status.cancelled
    assert 0.1 <= runs[0].final["t"] < 2e4
    assert runs[0].final["t"] == control.time_reached


def test_a_run_cancelled_before_it_starts_keeps_its_first_step():
    control = Control()
    control.cancel()
    run = simulate(parse_design(document()), control=control)
    assert run.status is Status.cancelled
    assert run.statistics["steps"] == 1


def test_too_many_steps_are_told_and_what_was_computed_is_kept():
    run = simulate(parse_design(document(duration=100.0)), limits=Limits(steps=20))
    assert run.status is Status.too_many_steps
    assert run.statistics["steps"] + run.statistics["rejected_steps"] == 20
    assert 0.0 < run.final["t"] < 100.0
    assert np.isfinite(run.data["z"].values).all()


def test_just_enough_steps_complete():
    design = parse_design(document())
    needed = simulate(design).statistics
    run = simulate(design, limits=Limits(steps=int(needed["steps"] + needed["rejected_steps"])))
    assert run.status is Status.completed


@METHODS
def test_nan_is_seen(solver):
    """Fast arithmetic must not hide it: a table with NaN ends the run, and only finite states are kept."""
    assembly = assemble(parse_design(document(solver=solver)))
    p = assembly.params._replace(table=assembly.params.table.copy())
    p.table[:, 1:] = np.nan
    run = run_kernel(assembly, p=p)
    assert run.code == DIVERGED
    assert np.isfinite(run.states).all()
    assert run.times.tolist() == [0.0]


def test_infinite_growth_is_seen():
    """RK4 far beyond its stability limit: the pitch rate of a body that only spins overflows."""
    body = {"kind": "rigid", "name": "Body", "mass": 1.0, "volume": 1e-3, "position": [0.0, 0.0, 0.0],
            "inertia": {"yy": 0.02}}  # fmt: skip
    initial = {"position": [0.0, 0.0, 5.0], "angular_velocity": [0.0, 1.0, 0.0]}
    changed = document(initial=initial, solver={"method": "rk4", "step": 1.0}, duration=500.0)
    changed["vehicle"] |= {"components": [body], "damping": {"pitch": 1e5}}
    run = run_kernel(assemble(parse_design(changed)))
    assert run.code == DIVERGED
    assert np.isfinite(run.states).all()


def test_the_adaptive_pair_masters_what_rk4_cannot():
    changed = document(duration=0.01)
    changed["vehicle"]["damping"] = {"pitch": 1e3}
    run = run_kernel(assemble(parse_design(changed)))
    assert run.code == COMPLETED


def test_a_step_that_cannot_shrink_is_told():
    """A scale of zero asks for an exact step, which there is none of."""
    assembly = assemble(parse_design(document()))
    p = assembly.params._replace(error_scale=assembly.params.error_scale * 1e-30)
    assert run_kernel(assembly, p=p).code in (STEP_TOO_SMALL, TOO_MANY_STEPS)


def test_status_codes_have_their_statuses():
    from models.kernel import integrate as kernel
    from models.simulate import STATUS_BY_CODE

    names = {kernel.COMPLETED: "completed", kernel.AT_SURFACE: "surface", kernel.AT_BED: "bed",
             DIVERGED: "diverged", STEP_TOO_SMALL: "step_too_small", TOO_MANY_STEPS: "too_many_steps",
             CANCELLED: "cancelled"}  # fmt: skip
    assert {code: status.name for code, status in enumerate(STATUS_BY_CODE)} == names


@pytest.mark.parametrize("duration", [1e-9, 1e-5, 0.00123])
def test_the_shortest_missions_have_a_start_and_an_end(duration):
    run = run_kernel(assemble(parse_design(document(duration=duration))))
    assert run.code == COMPLETED
    assert run.times.tolist() == [0.0, duration]


def test_a_schedule_beyond_the_missions_end_does_nothing():
    design = parse_design(document(control=schedule("Piston", (100.0, 0.01)), duration=1.0))
    plain = parse_design(document(duration=1.0))
    assert (run_kernel(assemble(design)).states == run_kernel(assemble(plain)).states).all()
