"""Floating at the surface and landing on the bed: closed forms, events that happen once, and energy that closes."""

import math

import numpy as np
import pytest

from models.design import parse_design
from models.run import Status
from models.simulate import simulate
from tests.models.test_spatial_oracle import moving_design

GRAVITY, DENSITY = 9.81, 1000.0
NO_LIFT = {"lift_attack": 0.0, "pitch_attack": 0.0, "pitch_rate": 0.0}


def body(**changes):
    return {
        "kind": "rigid", "name": "Body", "mass": 2.0, "volume": 2e-3, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [0.0, 0.0, 0.01], "inertia": {"xx": 0.02, "yy": 0.05, "zz": 0.05},
    } | changes  # fmt: skip


def engine(**changes):
    return {
        "kind": "piston", "name": "Engine", "mass": 0.0, "position": [0.0, 0.0, 0.0], "volume": 1e-4,
        "volume_range": [5e-5, 1.5e-4], "area": 1e-3, "height": 0.1,
    } | changes  # fmt: skip


def fly(*parts, environment, points=(), damping=0.0, depth=5.0, duration=60.0, **mission):
    document = moving_design(NO_LIFT).model_dump(mode="json")
    document["vehicle"] |= {
        "components": list(parts),
        "added_mass": None,
        "damping": {"heave": damping, "pitch": 0.05 * damping},
    }
    told = [{"cell": "Engine", "points": [{"time": t, "extension": e} for t, e in points]}] if points else []
    document["mission"] |= {
        "environment": {"gravity": GRAVITY, "water": {"density": DENSITY}} | environment,
        "initial": {"position": [0.0, 0.0, depth]}, "control": {"schedules": told}, "duration": duration,
        "solver": {"model": "spatial", "output_interval": 0.1},
    } | mission  # fmt: skip
    return simulate(parse_design(document))


def test_half_the_weight_of_its_water_floats_half_immersed():
    run = fly(body(mass=1.0), environment={"surface": "float"}, damping=20.0, depth=0.03)
    assert run.status is Status.completed
    assert run.final["z"] == pytest.approx(0.0, abs=1e-6)
    assert run.final["net_buoyancy"] == pytest.approx(0.0, abs=1e-4)


def test_a_sphere_floats_as_deep_as_archimedes_says():
    """Immersed share of a sphere to the depth s of its diameter: s^2 (3 - 2 s)."""
    mass = 1.7
    run = fly(body(mass=mass, height=0.2), environment={"surface": "float"}, damping=20.0, depth=0.05)
    shares = np.roots([-2.0, 3.0, 0.0, -mass / (DENSITY * 2e-3)])
    share = next(s.real for s in shares if 0.0 <= s.real <= 1.0 and abs(s.imag) < 1e-12)
    assert run.final["z"] == pytest.approx(0.2 * (share - 0.5), abs=1e-6)


@pytest.mark.parametrize("water", [
    {"density": DENSITY},
    {"kind": "density_profile", "depths": [0.0, 0.4, 5.0], "densities": [996.0, 998.0, 1001.0]},
])  # fmt: skip
def test_bobbing_keeps_its_energy(water):
    """It leaps out and falls back without losing any: the head is the integral of what the force says."""
    free = {"drag_zero": 1e-300, "drag_attack": 0.0, "lift_attack": 0.0, "pitch_attack": 0.0, "pitch_rate": 0.0}
    document = moving_design(free).model_dump(mode="json")
    document["vehicle"] |= {"components": [body(mass=1.9)], "added_mass": None, "damping": {}}
    document["mission"] |= {
        "environment": {"gravity": GRAVITY, "surface": "float", "water": water},
        "initial": {"position": [0.0, 0.0, 1.0]}, "control": {"schedules": []}, "duration": 20.0,
    }  # fmt: skip
    run = simulate(parse_design(document))
    assert run.values["z"].min() < 0.0 < run.values["z"].max()
    total = run.values["kinetic_energy"] + run.values["potential_energy"]
    assert np.ptp(total) < 1e-8 * run.values["kinetic_energy"].max()


def test_each_surfacing_is_an_event_and_the_run_goes_on():
    points = [(0.0, 0.02), (40.0, -0.03), (80.0, 0.03)]
    parts = body(mass=2.1), engine()
    run = fly(*parts, environment={"surface": "float"}, points=points, damping=3.0, depth=1.5, duration=160.0)
    assert run.status is Status.completed
    met = [event for event in run.events if event.kind == "surface"]
    assert len(met) == 2 and met[0].time < 40.0 and met[1].time > 80.0
    assert run.values["z"].max() > 1.0 and run.relative_residual < 1e-6


def test_the_surface_ends_the_run_where_that_is_asked():
    run = fly(body(mass=1.98), environment={"surface": "end"}, damping=3.0, depth=1.0)
    assert run.status is Status.surface
    assert run.final["z"] == pytest.approx(0.0, abs=1e-8)
    assert [event.kind for event in run.events] == ["surface"]


def test_it_lands_slides_and_takes_off_again():
    points = [(0.0, -0.02), (60.0, 0.02)]
    run = fly(
        body(mass=2.1), engine(), environment={"bed_depth": 6.0, "bed_contact": "slide"}, points=points, damping=3.0,
        duration=120.0, initial={"position": [0.0, 0.0, 5.9], "velocity": [0.2, 0.0, 0.0]},
    )  # fmt: skip
    assert run.status is Status.completed
    assert [event.kind for event in run.events if event.kind == "bed"] == ["bed"]
    landed = run.data.sel(time=59.0, method="nearest")
    sunk = float(landed["z"]) - 6.0
    assert 0.0 < sunk < 5e-3, "a spring holds it up: a fraction of a millimetre to a few"
    theta = float(landed["theta"])
    along, across = (float(landed[f"hydro_{axis}"] + landed[f"damping_{axis}"]) for axis in "XZ")
    down = -math.sin(theta) * along + math.cos(theta) * across
    # all that is left is how fast it slows down
    assert float(landed["bed_force"]) == pytest.approx(down - float(landed["net_buoyancy"]), rel=1e-4)
    assert abs(float(landed["z_dot"])) < 1e-5
    touched = next(event.time for event in run.events if event.kind == "bed")
    way = run.data["x"].sel(time=[touched, touched + 5.0], method="nearest").values
    assert way[1] - way[0] > 0.05, "it slides on: there is no friction"
    assert run.final["z"] < 5.0, "lighter, it leaves the bed"
    assert run.relative_residual < 1e-6


def test_the_bed_ends_the_run_where_that_is_asked():
    run = fly(body(mass=2.02), environment={"bed_depth": 6.0}, damping=3.0)
    assert run.status is Status.bed
    assert run.final["z"] == pytest.approx(6.0, abs=1e-8)


def test_an_oscillation_in_stratified_water_has_the_buoyancy_frequency():
    """A body that keeps its volume swings about its neutral depth: omega^2 = g rho' V / (m + A33)."""
    A = np.diag([0.1, 1.0, 1.5, 0.02, 0.05, 0.05])
    slope, volume, amplitude = 0.4, 2e-3, 0.02
    free = {"drag_zero": 1e-300, "drag_attack": 0.0, "lift_attack": 0.0, "pitch_attack": 0.0, "pitch_rate": 0.0}
    document = moving_design(free).model_dump(mode="json")
    document["vehicle"] |= {
        "components": [body(mass=(998.0 + slope * 10.0) * volume, volume=volume)], "damping": {},
        "added_mass": {"matrix": A.tolist(), "density": 998.0},
    }  # fmt: skip
    water = {"kind": "density_profile", "depths": [0.0, 50.0], "densities": [998.0, 998.0 + 50.0 * slope]}
    document["mission"] |= {
        "environment": {"gravity": GRAVITY, "water": water}, "control": {"schedules": []},
        "initial": {"position": [0.0, 0.0, 10.0 + amplitude]}, "duration": 60.0,
    }  # fmt: skip
    run = simulate(parse_design(document))
    mass = document["vehicle"]["components"][0]["mass"]
    omega = math.sqrt(GRAVITY * slope * volume / (mass + A[2, 2]))
    # the centre of buoyancy is the origin, and a linear profile makes the restoring force linear: exact
    np.testing.assert_allclose(run.values["z"], 10.0 + amplitude * np.cos(omega * run.times), atol=1e-7)


def test_a_compressible_hull_loses_its_lift_with_depth():
    K = 2e7
    heavy = fly(body(bulk_modulus=K), environment={}, damping=1.0, depth=50.0, duration=1.0)
    expected = GRAVITY * (DENSITY * 2e-3 * (1.0 - DENSITY * GRAVITY * 50.0 / K) - 2.0)
    assert heavy.values["net_buoyancy"][0] == pytest.approx(expected, rel=1e-12)
