"""Surface and bed: where and when a run ends, against closed forms and against a run cut at that time."""

import math

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.kernel.events import SURFACE_SLACK
from models.kernel.integrate import AT_BED, AT_SURFACE, COMPLETED
from models.run import Status
from models.simulate import simulate
from tests.models.support import document, polar, run_kernel, schedule, without_water

METHODS = pytest.mark.parametrize("solver", [{}, {"method": "rk4", "step": 0.013}], ids=["adaptive", "rk4"])


def thrown(velocity, *, net=0.0, bed=None, depth=5.0, solver=None, duration=60.0):
    """A level body without water forces: depth is a parabola, z = depth + v t + a t^2 / 2."""
    body = {
        "kind": "rigid", "name": "Body", "mass": 1.0, "volume": 1e-3 * (1.0 + net), "position": [0.0, 0.0, 0.0],
        "inertia": {"yy": 0.02},
    }  # fmt: skip
    initial = {"position": [0.0, 0.0, depth], "velocity": [0.1, 0.0, velocity]}
    changed = document(initial=initial, environment={"bed_depth": bed}, duration=duration, solver=solver or {})
    changed["vehicle"]["components"] = [body]
    assembly = assemble(parse_design(changed))
    return run_kernel(assembly, p=without_water(assembly.params))


@METHODS
def test_surface_is_found_where_the_parabola_says(solver):
    run = thrown(-0.3, net=0.002, solver=solver)
    a = -0.002 * 9.8
    d = 5.0 + SURFACE_SLACK
    expected = (0.3 - math.sqrt(0.3**2 - 2 * a * d)) / a
    assert run.code == AT_SURFACE
    assert run.times[-1] == pytest.approx(expected, abs=1e-9)
    assert run.states[-1, 1] == pytest.approx(0.0, abs=2e-9)
    assert run.events[-1].tolist() == [run.times[-1], 1.0, -1.0]


@METHODS
def test_bed_is_found_where_the_parabola_says(solver):
    run = thrown(0.2, net=-0.003, bed=8.0, solver=solver)
    a = 0.003 * 9.8
    expected = (-0.2 + math.sqrt(0.2**2 + 2 * a * 3.0)) / a
    assert run.code == AT_BED
    assert run.times[-1] == pytest.approx(expected, abs=1e-9)
    assert run.states[-1, 1] == pytest.approx(8.0, abs=1e-12)
    assert run.events[-1].tolist() == [run.times[-1], 2.0, -1.0]


@METHODS
@pytest.mark.parametrize(("extension", "bed", "target"), [(-0.009, 6.0, 6.0), (0.009, None, -SURFACE_SLACK)])
def test_a_glide_cut_at_the_events_time_ends_there(solver, extension, bed, target):
    """The event is read off the polynomial of a step; a run that stops at its time gets there by a step of its own."""
    common = {"control": schedule("Piston", (0.0, extension)), "duration": 300.0,
              "solver": solver | {"tolerance": 1e-11}}  # fmt: skip
    assembly = assemble(parse_design(document(environment={"bed_depth": bed}, **common)))
    run = run_kernel(assembly)
    assert run.code in (AT_BED, AT_SURFACE)
    deep = assembly.params._replace(body=assembly.params.body.copy())
    deep.body["bed_depth"] = math.inf
    again = run_kernel(assembly, p=deep, duration=float(run.times[-1]))
    # fixed steps read the event off a cubic: h^4 z'''' / 384 of 13 ms; the pair's polynomial is at its tolerance
    assert again.states[-1, 1] == pytest.approx(target, abs=1e-9)


def test_without_a_bed_a_glider_sinks_on():
    assert thrown(0.5, net=-0.01, bed=None).code == COMPLETED


def test_a_glider_may_start_at_the_surface_and_dive():
    run = thrown(0.1, depth=0.0)
    assert run.code == COMPLETED
    assert run.states[-1, 1] == pytest.approx(6.0, abs=1e-9)


def test_a_glider_that_starts_at_the_surface_and_rises_ends_at_once():
    run = thrown(-0.1, depth=0.0)
    assert run.code == AT_SURFACE
    assert run.times[-1] == pytest.approx(SURFACE_SLACK / 0.1, abs=1e-12)


def test_a_neutral_glider_at_rest_at_the_surface_stays():
    changed = document(initial={"position": [0.0, 0.0, 0.0]}, duration=100.0)
    run = simulate(parse_design(changed))
    assert run.status is Status.completed
    assert run.events == ()


def test_the_run_names_its_event():
    changed = document(control=schedule("Piston", (0.0, -0.009)), environment={"bed_depth": 5.5}, duration=300.0)
    run = simulate(parse_design(changed))
    assert run.status is Status.bed
    assert run.events[-1].kind == "bed"
    assert run.events[-1].time == run.final["t"]
    assert run.final["z"] == pytest.approx(5.5, abs=1e-9)


def test_a_bed_below_a_fast_glider_is_not_stepped_over():
    """At a large tolerance steps are long; whichever step ends below the bed is the one searched."""
    changed = document(
        initial={"position": [0.0, 0.0, 1.0], "velocity": [0.0, 0.0, 3.0]}, environment={"bed_depth": 1.05},
        solver={"tolerance": 0.1, "output_interval": 1.0},
    )  # fmt: skip
    changed["vehicle"]["hydrodynamics"] = polar(row_lift=[0.0] * 10, row_moment=[0.0] * 10)
    run = run_kernel(assemble(parse_design(changed)))
    assert run.code == AT_BED
    assert run.states[-1, 1] == pytest.approx(1.05, abs=1e-9)
    assert np.isfinite(run.states).all()
