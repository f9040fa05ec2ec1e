"""Bad input of spatial designs: refused or warned with the numbers, and a run that fails says where and why."""

import numpy as np
import pytest

from models.assemble import assemble
from models.design import parse_design
from models.problems import DesignError
from models.run import Run, Status
from models.simulate import simulate
from tests.models.test_spatial_oracle import moving_design


def document(**vehicle):
    changed = moving_design({}).model_dump(mode="json")
    changed["vehicle"] |= vehicle
    return changed


def refused(changed):
    with pytest.raises(DesignError) as error:
        assemble(parse_design(changed))
    told = {}
    for problem in error.value.problems:
        told[problem.pointer] = told.get(problem.pointer, "") + str(problem)
    return told


def warned(changed):
    return {warning.pointer: warning.message for warning in assemble(parse_design(changed)).warnings}


def test_an_inertia_that_is_not_positive_definite_is_refused():
    declared = {
        "kind": "declared", "mass": 2.0, "center_of_mass": [0.0, 0.0, 0.01],
        "inertia": {"xx": 0.01, "yy": 0.03, "zz": 0.03, "xz": 0.05},
    }  # fmt: skip
    told = refused(document(mass_properties=declared))
    assert "negative principal moment, -0.03099 kg m2" in told["/vehicle/mass_properties/inertia"]


@pytest.mark.parametrize(("axis", "name"), [("xx", "roll"), ("zz", "yaw")])
def test_a_singular_matrix_is_refused_with_its_axis(axis, name):
    declared = {
        "kind": "declared", "mass": 2.0, "center_of_mass": [0.0, 0.0, 0.0],
        "inertia": {"xx": 0.02, "yy": 0.03, "zz": 0.03} | {axis: 0.0},
    }  # fmt: skip
    told = refused(document(mass_properties=declared, added_mass=None))
    message = f"moment of inertia in {name} is 0 kg m2: the equations are singular"
    assert message in told["/vehicle/mass_properties/inertia"]


def test_added_mass_makes_a_light_axis_fly():
    """A11 or A44 larger than the body's own is no trouble: both are inverted together."""
    A = np.diag([50.0, 60.0, 70.0, 3.0, 5.0, 4.0])
    run = simulate(parse_design(document(added_mass={"matrix": A.tolist()})))
    assert run.status is Status.completed and run.relative_residual < 1e-6


def test_added_mass_must_be_symmetric_and_positive():
    A = np.diag([0.1, 1.2, 2.5, 0.02, 0.06, 0.05])
    A[1, 5] = 0.1
    told = refused(document(added_mass={"matrix": A.tolist()}))
    assert any("not symmetric: [1][5] = 0.1, [5][1] = 0" in message for message in told.values())
    A[5, 1] = 0.5
    A[1, 5] = 0.5
    told = refused(document(added_mass={"matrix": A.tolist()}))
    assert "not positive semi-definite: its smallest eigenvalue is -0.1" in told["/vehicle/added_mass/matrix"]


def test_cells_outside_their_stroke_are_refused_in_their_unit():
    changed = document()
    changed["mission"]["initial"]["extensions"] = {"Roller": 1.5, "Piston": 0.5}
    told = refused(changed)
    assert (
        "angle 85.9437 deg of 'Roller' lies outside its stops [-57.2958, 57.2958] deg"
        in told["/mission/initial/extensions/Roller"]
    )
    assert "extension 500 mm of 'Piston' lies outside its stops" in told["/mission/initial/extensions/Piston"]


def test_profiles_must_rise_in_depth():
    changed = document()
    changed["mission"]["environment"]["water"] |= {"depths": [0.0, 20.0, 10.0]}
    told = refused(changed)
    assert "level 2 is at 10.0 m, after 20.0 m" in told["/mission/environment/water"]


def test_a_broken_triangle_inequality_is_warned():
    changed = document()
    changed["vehicle"]["components"][0]["inertia"] = {"xx": 0.01, "yy": 0.02, "zz": 0.05}
    told = warned(changed)["/vehicle/components/0/inertia"]
    assert "breaks the triangle inequality: 0.05 exceeds 0.01 + 0.02 kg m2" in told


def test_unstable_water_is_warned():
    changed = document()
    changed["mission"]["environment"]["water"] |= {"densities": [998.0, 997.0, 1000.0]}
    told = warned(changed)["/mission/environment/water/depths"]
    assert "unstable between 0 and 10 m: its density falls by 1 kg/m3" in told


@pytest.mark.parametrize(("change", "pointer", "told"), [
    ({}, "/mission/environment/water/kind", "water that changes with depth"),
    ({}, "/mission/environment/current", "knows no current"),
    ({}, "/vehicle/components/3/kind", "'Roller' rolls out of the vertical plane"),
    ({}, "/vehicle/components/0/bulk_modulus", "no compression"),
    ({}, "/mission/initial/roll", "leaves the vertical plane"),
    ({"surface": "float"}, "/mission/environment/surface", "floating at the surface"),
    ({"bed_contact": "slide"}, "/mission/environment/bed_contact", "sliding on the bed"),
])  # fmt: skip
def test_a_planar_run_refuses_what_only_space_has(change, pointer, told):
    changed = document()
    changed["mission"]["solver"]["model"] = "planar"
    changed["mission"]["environment"] |= change
    message = refused(changed)[pointer]
    assert told in message and "use the spatial model" in message


def diverging():
    """Damping that a fixed step of this size cannot follow."""
    changed = document(damping={"surge": 1e5})
    changed["mission"]["solver"] |= {"method": "rk4", "step": 0.05, "output_interval": 0.05}
    return parse_design(changed)


def test_a_run_that_diverges_says_where_and_why_and_keeps_what_it_has(tmp_path):
    run = simulate(diverging())
    assert run.status is Status.diverged
    assert 1 <= len(run.times) < 81 and run.times[-1] < 4.0
    assert run.trouble == "u", "it is the surge that is damped too hard"
    assert f"stopped at t = {run.times[-1]:.6g} s" in run.message and "with u changing fastest" in run.message
    assert "with RK4 use a smaller step" in run.message
    path = tmp_path / "run.nc"
    run.to_netcdf(path)
    assert Run.from_netcdf(path).message == run.message


def test_the_adaptive_pair_flies_the_same_design():
    changed = diverging().model_dump(mode="json")
    changed["mission"]["solver"] |= {"method": "adaptive", "tolerance": 1e-6}
    assert simulate(parse_design(changed)).status is Status.completed
