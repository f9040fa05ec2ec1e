"""The energy bill against closed forms: pressure, weight, efficiency, recovery, dives."""

import math

import numpy as np
import pytest

from models.design import parse_design
from models.energy import energy_bill
from models.simulate import simulate
from tests.models.test_spatial_oracle import moving_design

DEPTH, GRAVITY, DENSITY = 30.0, 9.81, 1000.0


def held(part, *, points, hotel=0.0, **environment):
    """A vehicle so heavy and so damped that it hardly moves while its part does."""
    body = {
        "kind": "rigid", "name": "Body", "mass": 1000.0, "volume": 1.0, "position": [0.0, 0.0, 0.0],
        "center_of_mass": [0.0, 0.0, 0.1], "inertia": {"xx": 1e6, "yy": 1e6, "zz": 1e6},
    }  # fmt: skip
    document = moving_design({}).model_dump(mode="json")
    document["vehicle"] |= {"components": [body, part], "added_mass": None, "hotel_power": hotel}
    document["vehicle"]["damping"] = {name: 1e6 for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")}
    document["mission"] |= {
        "environment": {"water": {"density": DENSITY}, "gravity": GRAVITY} | environment,
        "initial": {"position": [0.0, 0.0, DEPTH]},
        "control": {"schedules": [{
            "cell": part["name"], "points": [{"time": t, "extension": e, "shape": s} for t, e, s in points],
        }]},
        "duration": 10.0,
        "solver": {"model": "spatial", "output_interval": 0.1},
    }  # fmt: skip
    return simulate(parse_design(document))


def piston(**changes):
    return {
        "kind": "piston", "name": "Piston", "mass": 0.0, "position": [0.0, 0.0, 0.5], "volume": 2e-4,
        "volume_range": [1e-4, 3e-4], "area": 1e-2, "axis": [0.0, 1.0, 0.0],
    } | changes  # fmt: skip


@pytest.mark.parametrize("points", [[(2.0, 0.005, "ramp")], [(2.0, 0.005, "step")]])
def test_expanding_costs_pressure_times_volume_over_efficiency(points):
    run = held(piston(efficiency=0.4), points=points)
    pressure = DENSITY * GRAVITY * (DEPTH + 0.5)
    # it is held by damping and inertia, not by a wall: within a few 1e-6 of its depth
    assert run.cell_values["energy"][-1, 0] == pytest.approx(pressure * 5e-5 / 0.4, rel=1e-5)


def test_contracting_returns_nothing_unless_told():
    down = [(0.0, 0.005, "step"), (4.0, 0.005, "ramp"), (8.0, 0.0, "ramp")]
    pressure = DENSITY * GRAVITY * (DEPTH + 0.5)
    plain, thrifty = held(piston(), points=down), held(piston(recovery=0.3), points=down)
    assert plain.cell_values["energy"][-1, 0] == pytest.approx(pressure * 5e-5, rel=1e-5)
    assert thrifty.cell_values["energy"][-1, 0] == pytest.approx(pressure * 5e-5 * 0.7, rel=1e-5)


def test_the_bill_is_no_part_of_the_balance():
    """The work on the glider is the same whatever the pump's efficiency."""
    points = [(2.0, 0.005, "ramp")]
    good, bad = held(piston(), points=points), held(piston(efficiency=0.1), points=points)
    assert bad.values["actuator_work"][-1] == pytest.approx(good.values["actuator_work"][-1], rel=1e-9)
    assert bad.cell_values["energy"][-1, 0] == pytest.approx(10.0 * good.cell_values["energy"][-1, 0], rel=1e-6)


def test_lifting_a_mass_costs_its_weight():
    slide = {
        "kind": "movable_mass", "name": "Slide", "mass": 2.0, "position": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, -1.0],
        "extension_range": [-0.5, 0.5], "neutral_extension": 0.0, "efficiency": 0.5,
    }  # fmt: skip
    run = held(slide, points=[(3.0, 0.4, "ramp"), (6.0, -0.4, "ramp")])
    assert run.cell_values["energy"][-1, 0] == pytest.approx(2.0 * GRAVITY * 0.4 / 0.5, rel=1e-5)


def test_turning_a_mass_costs_what_its_centre_rises():
    roller = {
        "kind": "rolling_mass", "name": "Roller", "mass": 2.0, "position": [0.0, 0.0, 0.05], "angle_range": [-2.0, 2.0],
    }  # fmt: skip
    run = held(roller, points=[(4.0, 1.2, "ramp")])
    assert run.cell_values["energy"][-1, 0] == pytest.approx(2.0 * GRAVITY * 0.05 * (1.0 - math.cos(1.2)), rel=1e-5)


def test_the_hotel_load_adds_power_times_time():
    run = held(piston(), points=[(20.0, 0.0, "step")], hotel=3.5)
    bill = energy_bill(run)
    assert bill.whole.hotel == pytest.approx(35.0) and bill.whole.total == pytest.approx(35.0)
    np.testing.assert_allclose(run.values["battery_energy"], 3.5 * run.times)
    assert bill.whole.per_km is None


def test_a_planar_run_keeps_no_account():
    design = moving_design({})
    from models.presets import load_preset

    assert energy_bill(simulate(load_preset("canete-dual-bellows"))) is None
    assert energy_bill(simulate(design)) is not None


def test_dives_add_up_to_the_whole():
    document = moving_design({}).model_dump(mode="json")
    body = document["vehicle"]["components"][0] | {"volume": 1.75e-3, "bulk_modulus": None}
    cell = piston(name="Engine", position=[0.0, 0.0, 0.0], volume=5e-5, volume_range=[0.0, 1e-4], area=1e-3)
    body["volume"] = (body["mass"] / 1000.0) - 5e-5
    document["vehicle"] |= {"components": [body, cell], "hotel_power": 1.0}
    legs = [(0.0, -0.03), (30.0, 0.03), (60.0, -0.03), (90.0, 0.03)]
    document["mission"] |= {
        "environment": {"water": {"density": 1000.0}, "gravity": GRAVITY},
        "control": {"schedules": [{"cell": "Engine", "points": [{"time": t, "extension": e} for t, e in legs]}]},
        "initial": {"position": [0.0, 0.0, 20.0], "velocity": [0.2, 0.0, 0.0]}, "duration": 120.0,
    }  # fmt: skip
    bill = energy_bill(simulate(parse_design(document)))
    assert len(bill.dives) == 2
    assert sum(dive.total for dive in bill.dives) == pytest.approx(bill.whole.total, rel=1e-12)
    assert sum(dive.distance for dive in bill.dives) == pytest.approx(bill.whole.distance, rel=1e-12)
    assert bill.whole.parts["Engine"] > 0.0
    assert bill.whole.per_km == pytest.approx(1e3 * bill.whole.total / bill.whole.distance)
