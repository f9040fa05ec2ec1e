"""Where a formula has a corner: empty cells, jumps of laws that bend, timed currents, shallow water, empty volumes."""

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.run import Status
from models.run_warnings import run_warnings
from models.simulate import simulate
from tests.models.support import observed_orders
from tests.models.test_battery import held, piston
from tests.models.test_spatial_oracle import moving_design
from tests.models.test_surface_and_bed import body, fly

STRATIFIED = {"kind": "density_profile", "depths": [0.0, 50.0], "densities": [998.0, 1003.0]}


@pytest.mark.parametrize("water", [{"density": 1000.0}, STRATIFIED])
def test_a_cell_can_be_emptied_and_filled_again(water):
    """Its centre of buoyancy runs away as it empties, its first moment does not."""
    document = moving_design({}).model_dump(mode="json")
    cell = piston(name="Engine", volume=1e-4, volume_range=[0.0, 2e-4], area=1e-2, position=[0.1, 0.0, 0.0])
    points = [(1.0, -0.01, "ramp"), (2.0, -0.01, "ramp"), (4.0, 0.005, "ramp")]
    document["vehicle"]["components"] = [document["vehicle"]["components"][0], cell]
    document["mission"]["environment"] |= {"water": water, "current": None}
    document["mission"] |= {
        "control": {"schedules": [{"cell": "Engine", "points": [
            {"time": t, "extension": e, "shape": s} for t, e, s in points
        ]}]},
        "duration": 5.0,
    }  # fmt: skip
    run = simulate(parse_design(document))
    assert run.status is Status.completed
    assert run.cell_values["volume"].min() == pytest.approx(0.0, abs=1e-12)
    assert run.relative_residual < 1e-6


def test_planar_and_spatial_agree_on_an_empty_cell():
    from models.presets import load_preset

    document = load_preset("three-cell-glider").model_dump(mode="json")
    cell = next(c for c in document["vehicle"]["components"] if c["kind"] == "piston")
    cell |= {"volume_range": [0.0, 8e-5], "axis": [1.0, 0.0, 0.3]}
    told = next(s for s in document["mission"]["control"]["schedules"] if s["cell"] == cell["name"])
    for point in told["points"]:
        point["extension"] = -0.08 if point["extension"] < 0.0 else point["extension"]
    document["mission"] |= {"duration": 60.0}
    document["mission"]["environment"]["bed_depth"] = None
    plane = simulate(parse_design(document))
    document["mission"]["solver"]["model"] = "spatial"
    space = simulate(parse_design(document))
    assert plane.cell_values["volume"].min() == pytest.approx(0.0, abs=1e-12)
    for name in ("x", "z", "theta"):
        np.testing.assert_allclose(space.values[name], plane.values[name], atol=1e-5, err_msg=name)


def timed(**solver):
    document = moving_design({}).model_dump(mode="json")
    table = [[0.0, 0.1], [0.3, 0.2], [-0.1, 0.0], [0.2, 0.2]]
    document["mission"]["environment"]["current"] = {
        "kind": "tabulated", "depths": [0.0, 40.0], "times": [0.0, 1.0, 2.0, 4.0], "north": table,
        "east": [row[::-1] for row in table],
    }  # fmt: skip
    document["mission"] |= {"control": {"schedules": []}, "duration": 4.0}
    document["mission"]["solver"] |= {"output_interval": 4.0, **solver}
    return simulate(parse_design(document))


def test_a_timed_current_costs_no_order():
    """A step that ends at a corner of the current must not read what comes after it."""
    best = timed(tolerance=1e-12)
    assert best.status is Status.completed
    errors = []
    for step in (0.2, 0.1, 0.05, 0.025):
        run = timed(method="rk4", step=step)
        errors.append(max(abs(run.final[name] - best.final[name]) for name in "xyz"))
    assert observed_orders(errors)[-1] > 3.5
    assert timed(tolerance=1e-8).statistics["rejected_steps"] < 20


def test_the_bed_is_met_in_water_shallower_than_the_glider():
    run = fly(body(mass=2.2, height=0.4), environment={"surface": "float", "bed_depth": 0.1}, depth=0.0)
    assert run.status is Status.bed
    assert [event.kind for event in run.events] == ["bed"]


BLADDER = {
    "kind": "bladder", "name": "Piston", "mass": 0.0, "position": [0.0, 0.0, 0.5], "neutral_extension": 0.0,
    "extensions": [0.0, 0.01, 0.02, 0.03], "volumes": [1e-4, 1.02e-4, 1.9e-4, 2e-4],
}  # fmt: skip
ROLLER = {
    "kind": "rolling_mass", "name": "Piston", "mass": 2.0, "position": [0.0, 0.0, 0.05], "angle_range": [-3.2, 3.2],
    "inertia": {"xx": 1e-3, "yy": 1e-3, "zz": 1e-3},
}  # fmt: skip


@pytest.mark.parametrize(("part", "end"), [(BLADDER, 0.03), (ROLLER, 3.0)])
def test_a_jump_costs_what_a_fast_ramp_does(part, end):
    jump = held(part, points=[(2.0, end, "step")])
    ramp = held(part, points=[(2.0, 0.0, "step"), (2.001, end, "ramp")])
    cost = ramp.cell_values["energy"][-1, 0]
    assert cost > 0.1
    assert jump.cell_values["energy"][-1, 0] == pytest.approx(cost, rel=1e-4)


def test_a_cell_that_starts_empty_loses_its_lift_above_the_water():
    cell = {
        "kind": "bladder", "name": "Engine", "mass": 0.0, "position": [0.0, 0.0, -0.3], "neutral_extension": 0.0,
        "extensions": [0.0, 0.01], "volumes": [0.0, 2e-3],
    }  # fmt: skip
    run = fly(body(mass=3.0), cell, environment={"surface": "float"}, damping=20.0, depth=1.0, points=[(0.0, 0.01)])
    top = run.final["z"] - 0.3
    assert -0.08 < top < 0.08, "it floats at the surface, not above it"


def test_a_massless_mover_keeps_its_inertia():
    roller = ROLLER | {"mass": 0.0}
    still = {"kind": "rigid", "name": "Body", "mass": 2.0, "volume": 2e-3, "position": [0.0, 0.0, 0.0]}
    run = fly(still, roller, environment={}, duration=2.0)
    assert run.status is Status.completed


def test_huge_damping_shrinks_the_step_instead_of_ending_the_run():
    document = moving_design({}).model_dump(mode="json")
    document["vehicle"] |= {"components": [body(mass=1e-3, volume=1e-6)], "damping": {"surge": 1e4}, "added_mass": None}
    document["mission"] |= {"control": {"schedules": []}, "duration": 1e-3}
    document["mission"]["solver"] |= {"tolerance": 1e-6, "output_interval": 1e-3}
    run = simulate(parse_design(document))
    assert run.status is Status.completed and run.statistics["rejected_steps"] > 0


def test_compression_leaves_nothing_at_the_end_and_says_so():
    run = fly(body(bulk_modulus=1e5), environment={}, damping=1.0, depth=20.0, duration=1.0)
    assert run.values["net_buoyancy"][0] == pytest.approx(-2.0 * 9.81)
    told = [w.message for w in run_warnings(run) if w.pointer == "/vehicle/components/0/bulk_modulus"]
    assert told and "100 % of the volume of 'Body'" in told[0]


def test_profiles_and_times_that_do_not_reach_are_told():
    document = moving_design({}).model_dump(mode="json")
    document["mission"]["environment"] |= {
        "water": {"kind": "density_profile", "depths": [30.0, 60.0], "densities": [998.0, 999.0]},
        "current": {"kind": "tabulated", "depths": [0.0, 60.0], "times": [0.0, 2.0],
                    "north": [[0.1, 0.1], [0.2, 0.2]], "east": [[0.0, 0.0], [0.0, 0.0]]},
    }  # fmt: skip
    told = {w.pointer: w.message for w in run_warnings(simulate(parse_design(document)))}
    assert "above the first level of the water at 30 m" in told["/mission/environment/water/depths"]
    assert "outside the times of the current, 0 to 2 s" in told["/mission/environment/current/times"]


def test_damping_that_feeds_the_motion_is_warned():
    document = moving_design({}).model_dump(mode="json")
    matrix = np.zeros((6, 6))
    matrix[0, 0] = -50.0
    document["vehicle"]["damping"] = {"matrix": matrix.tolist()}
    told = {w.pointer: w.message for w in assemble(parse_design(document)).warnings}
    assert "eigenvalue -50" in told["/vehicle/damping/matrix"]


def test_coefficients_without_side_force_are_warned_in_space():
    from models.presets import load_preset

    document = load_preset("slocum-glide").model_dump(mode="json")
    document["mission"]["solver"]["model"] = "spatial"
    told = {w.pointer: w.message for w in assemble(parse_design(document)).warnings}
    assert "nothing holds the glider against sideslip" in told["/vehicle/hydrodynamics/yaw_sideslip"]
