"""Rate limits, lags, stops and commands against closed forms."""

import math

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.kernel.actuators import command
from models.simulate import simulate
from tests.models.support import PISTON, document, run_kernel, schedule

TIGHT = {"tolerance": 1e-12, "output_interval": 0.05}
FIXED = {"method": "rk4", "step": 0.01, "output_interval": 0.05}
SOLVERS = pytest.mark.parametrize("solver", [TIGHT, FIXED], ids=["adaptive", "rk4"])
STROKE = 0.02


def follow(moving, *points, solver=TIGHT, duration=6.0):
    """Times and extensions of a piston (stops +-10 mm) that follows a schedule, and the run's events."""
    control = schedule("Piston", *points)
    changed = document(PISTON | moving, control=control, solver=solver, duration=duration)
    assembly = assemble(parse_design(changed))
    run = run_kernel(assembly)
    assert run.code == 0
    return run.times, run.states[:, 8], run.events


@SOLVERS
def test_an_instant_cell_is_on_its_command(solver):
    t, e, _ = follow({}, (1.0, 0.004), (2.0, -0.008, "ramp"), (3.3, 0.001), solver=solver)
    expected = np.where(t < 1.0, 0.0, 0.004 - 0.012 * np.clip(t - 1.0, 0.0, 1.0))
    expected = np.where(t >= 3.3, 0.001, expected)
    assert np.abs(e - expected).max() <= 1e-15


@SOLVERS
def test_a_rate_limited_cell_runs_straight_to_its_command(solver):
    t, e, _ = follow({"rate_limit": 0.003}, (1.0, 0.008), (4.5, -0.002), solver=solver)
    up = np.minimum(0.003 * np.maximum(t - 1.0, 0.0), 0.008)
    down = np.maximum(0.008 - 0.003 * np.maximum(t - 4.5, 0.0), -0.002)
    assert np.abs(e - np.where(t < 4.5, up, down)).max() <= 1e-12  # straight lines: exact but for rounding


@SOLVERS
def test_a_rate_limited_cell_chases_a_ramp_and_catches_it(solver):
    """The command jumps by 6 mm, then climbs at 1 mm/s; at 3 mm/s the cell is on it after 6 / (3 - 1) = 3 s."""
    points = [(1.0, -0.006), (7.0, 0.0, "ramp")]
    t, e, _ = follow({"rate_limit": 0.003}, *points, solver=solver, duration=8.0)
    told = np.where(t < 1.0, 0.0, np.minimum(-0.006 + 0.001 * (t - 1.0), 0.0))
    meet = 1.0 + 0.006 / (0.003 + 0.001)
    expected = np.where(t < 1.0, 0.0, np.where(t < meet, -0.003 * (t - 1.0), told))
    assert np.abs(e - expected).max() <= 1e-12


@SOLVERS
def test_a_cell_too_slow_for_a_ramp_falls_behind_and_comes_in_later(solver):
    t, e, _ = follow({"rate_limit": 0.002}, (1.0, 0.0), (2.0, 0.01, "ramp"), solver=solver, duration=8.0)
    expected = np.minimum(0.002 * np.maximum(t - 1.0, 0.0), 0.01)
    assert np.abs(e - expected).max() <= 1e-12


@SOLVERS
def test_a_lag_is_an_exponential(solver):
    t, e, _ = follow({"lag": 0.5}, (1.0, 0.008), solver=solver)
    expected = 0.008 * (1.0 - np.exp(-np.maximum(t - 1.0, 0.0) / 0.5))
    # RK4: (h / T)^4 / 120 of the remaining gap at each time constant, 1.4e-9 of 8 mm; and the cubic between steps
    assert np.abs(e - expected).max() <= (1e-12 if solver is TIGHT else 2e-11)


@SOLVERS
def test_a_lag_trails_a_ramp_by_slope_times_lag(solver):
    t, e, _ = follow({"lag": 0.5}, (1.0, 0.0), (6.0, 0.01, "ramp"), solver=solver)
    since = np.maximum(t - 1.0, 0.0)
    expected = 0.002 * (since - 0.5 * (1.0 - np.exp(-since / 0.5)))
    assert np.abs(e - expected).max() <= (1e-12 if solver is TIGHT else 2e-11)


@SOLVERS
def test_a_saturated_lag_runs_straight_then_settles(solver):
    """Gap 8 mm, rate 4 mm/s, lag 0.5 s: saturated until the gap is rate * lag = 2 mm, at 1.5 s after the step."""
    t, e, _ = follow({"lag": 0.5, "rate_limit": 0.004}, (1.0, 0.008), solver=solver)
    since = np.maximum(t - 1.0, 0.0)
    expected = np.where(since < 1.5, 0.004 * since, 0.008 - 0.002 * np.exp(-(since - 1.5) / 0.5))
    assert np.abs(e - expected).max() <= (1e-12 if solver is TIGHT else 2e-11)


def three_phases(t, *, rate, lag, top, slope):
    """A lagging cell at 0 under a command that falls from `top`: at its limit upward, free, at its limit downward."""
    edge, tends = rate * lag, -slope * lag
    first = (top - edge) / (rate + slope)  # the gap top - (rate + slope) t reaches +edge
    second = first + lag * math.log((tends - edge) / (tends + edge))  # and passes to -edge
    assert rate * first < top - slope * first
    if t <= first:
        return rate * t
    if t <= second:
        return top - slope * t - tends - (edge - tends) * math.exp(-(t - first) / lag)
    return top - slope * second + edge - rate * (t - second)


@SOLVERS
@pytest.mark.parametrize("rate", [0.0010, 0.0013, 0.0017, 0.0020, 0.0022])
def test_a_lagging_cell_crosses_from_one_rate_limit_to_the_other(solver, rate):
    """No step straddles either corner: with a fixed step that would cost about h^2 rate / lag, 5e-7 m."""
    lag, top, slope = 0.3, 0.009, 0.006
    points = [(1.0, top), (1.0 + 0.018 / slope, top - 0.018, "ramp")]
    t, e, _ = follow({"lag": lag, "rate_limit": rate}, *points, solver=solver, duration=4.0)
    expected = [0.0 if x < 1.0 else three_phases(x - 1.0, rate=rate, lag=lag, top=top, slope=slope) for x in t]
    assert np.abs(e - expected).max() <= (1e-12 if solver is TIGHT else 5e-11)


@SOLVERS
@pytest.mark.parametrize("moving", [{"rate_limit": 0.004}, {"rate_limit": 0.004, "lag": 0.2}], ids=["rate", "lag"])
def test_a_stop_is_an_event_at_the_closed_forms_time(solver, moving):
    """Within a millionth of the stroke of the stop counts as there."""
    _, _, events = follow(moving, (1.0, 0.01), solver=solver)
    slack = 1e-6 * STROKE
    if "lag" in moving:
        edge = 0.004 * 0.2
        expected = 1.0 + (0.01 - edge) / 0.004 + 0.2 * math.log(edge / slack)
        allowed = 1e-6 if solver is TIGHT else 1e-4  # s: de/dt is 1e-7 m/s there, errors of 1e-13 and 2e-11 m
    else:
        expected, allowed = 1.0 + (0.01 - slack) / 0.004, 1e-9
    assert events.shape[0] == 1
    assert events[0].tolist() == [pytest.approx(expected, abs=allowed), 3.0, 0.0]


def test_every_arrival_at_a_stop_is_told_once_by_name():
    control = schedule("Piston", (0.5, 0.01), (1.0, 0.0), (1.5, -0.01), (2.0, 0.01))
    run = simulate(parse_design(document(control=control)))
    assert [(event.time, event.kind, event.cell) for event in run.events] == [
        (time, "end_of_stroke", "Piston") for time in (0.5, 1.5, 2.0)
    ]


def test_starting_at_a_stop_is_no_event():
    initial = {"position": [0.0, 0.0, 5.0], "extensions": {"Piston": -0.01}}
    assert simulate(parse_design(document(initial=initial))).events == ()


def test_commands_are_right_continuous_and_held_within_the_stops():
    control = schedule("Piston", (1.0, 0.004), (2.0, -0.008, "ramp"), (3.0, 0.01))
    p = assemble(parse_design(document(control=control))).params
    told = [command(p.parts[0], t, p) for t in (0.0, math.nextafter(1.0, 0.0) - 1e-9, 1.0, 1.5, 2.0, 2.5, 3.0, 1e6)]
    assert told == pytest.approx([0.0, 0.0, 0.004, -0.002, -0.008, -0.008, 0.01, 0.01], abs=1e-15)


def test_a_ramp_without_a_point_before_starts_from_the_initial_extension_at_zero():
    initial = {"position": [0.0, 0.0, 5.0], "extensions": {"Piston": -0.01}}
    changed = document(control=schedule("Piston", (2.0, 0.01, "ramp")), initial=initial)
    p = assemble(parse_design(changed)).params
    assert command(p.parts[0], 0.5, p) == pytest.approx(-0.005, abs=1e-15)


def test_many_switches_are_found():
    """A thousand points: the command in force is found by bisection, and every one is a breakpoint."""
    points = [(0.005 * k, 0.01 * math.sin(k)) for k in range(1000)]
    t, e, _ = follow({}, *points, solver={"output_interval": 0.005}, duration=5.0)
    expected = [0.01 * math.sin(min(round(x / 0.005), 999)) for x in t]
    assert np.abs(e - expected).max() <= 1e-15
