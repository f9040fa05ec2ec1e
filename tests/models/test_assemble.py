"""The one door: what it refuses, with which numbers, and that all designs reach the kernel as one type."""

import numpy as np
import pytest
from hypothesis import given

from models.allocation import allocate, effectiveness
from models.assemble import assemble
from models.controllers import MEASURED
from models.design import loads_design, parse_design
from models.glider_fleet import Fleet
from models.kernel import allocate as kernel_allocate
from models.kernel import control_layout as layout
from models.kernel import environments, linear, params, steady
from models.kernel.control_layout import CONTROL
from models.kernel.integrate import integrate
from models.kernel.outputs import outputs
from models.kernel.spatial_layout import MEMBER, SPACE
from models.limits import Limits
from models.linearize import linearize
from models.operating_point import OperatingPoint
from models.presets import load_preset, preset_ids
from models.problems import DesignError
from models.simulate import simulate
from models.trim import find_trims
from tests.models.support import BODY, PISTON, document, polar, schedule
from tests.strategies import designs


def problems_of(changed, limits=None):
    design = parse_design(changed)
    with pytest.raises(DesignError) as refused:
        assemble(design, limits or Limits())
    return refused.value.problems


def only_problem(changed, limits=None):
    (problem,) = problems_of(changed, limits)
    return problem


def with_added_mass(A, **changes):
    changed = document()
    changed["vehicle"]["added_mass"] = {"matrix": np.asarray(A, dtype=float).tolist(), **changes}
    return changed


def test_one_signature_is_compiled_for_all_presets():
    for preset_id in preset_ids():
        simulate(load_preset(preset_id))
    body = document()
    body["vehicle"]["components"] = body["vehicle"]["components"][:1]  # no part moves
    simulate(parse_design(body))
    assert len(integrate.signatures) == 1
    assert len(outputs.signatures) == 1


def test_one_signature_is_compiled_of_what_analyses_and_trains():
    for preset_id in ("canete-dual-bellows", "quad-bellows-glide", "movable-mass-twin", "seawing-spiral"):
        design = load_preset(preset_id)
        find_trims(design)
        linearize(design, OperatingPoint(depth=5.0, velocity=(0.3, 0.0, 0.01)))
        fleet = Fleet(design, 2, step_time=0.02, step=0.01)
        fleet.advance()
        cells = effectiveness(design)
        allocate(cells, (0.1, 0.0, 0.0))
    of_steady = (steady.newton_from_each, steady.balance_along)
    for compiled in (*of_steady, linear.slopes, environments.advance_many, kernel_allocate.allocate):
        assert len(compiled.signatures) == 1, compiled


def test_what_state_feedback_may_use_is_in_the_kernels_order():
    in_order = (
        layout.DEPTH, layout.ROLL, layout.PITCH, layout.YAW, layout.SURGE, layout.SWAY, layout.HEAVE,
        layout.ROLL_RATE, layout.PITCH_RATE, layout.YAW_RATE,
    )  # fmt: skip
    assert MEASURED == ("z", "phi", "theta", "psi", "u", "v", "w", "p", "q", "r")
    assert in_order == tuple(range(len(MEASURED)))


@given(designs(neutral=False))
def test_one_signature_is_compiled_for_random_designs(design):
    simulate(design)
    assert len(integrate.signatures) == 1
    assert len(outputs.signatures) == 1


@given(designs(neutral=False))
def test_records_are_of_one_exact_type(design):
    for array in (*assemble(design).params, assemble(design).initial_state):
        assert array.flags.c_contiguous and array.flags.writeable and array.flags.aligned
    kinds = {array.dtype.fields is not None and array.dtype.names for array in assemble(design).params}
    assert kinds == {False, params.BODY.names, params.PART.names, SPACE.names, MEMBER.names, CONTROL.names}


@given(designs())
def test_assembling_twice_gives_the_same_numbers(design):
    for one, two in zip(assemble(design).params, assemble(design).params, strict=True):
        np.testing.assert_array_equal(one, two)


def test_added_mass_must_be_symmetric():
    A = np.diag([0.1, 0.5, 1.0, 0.01, 0.02, 0.01])
    A[2, 4] = 0.05
    problem = only_problem(with_added_mass(A))
    assert problem.pointer in ("/vehicle/added_mass/matrix/2/4", "/vehicle/added_mass/matrix/4/2")
    assert "[2][4] = 0.05, [4][2] = 0" in problem.message or "[4][2] = 0, [2][4] = 0.05" in problem.message


def test_added_mass_must_be_positive_semi_definite():
    A = np.diag([0.1, 0.5, 1.0, 0.01, 0.02, 0.01])
    A[2, 4] = A[4, 2] = 0.2
    problem = only_problem(with_added_mass(A))
    assert problem.pointer == "/vehicle/added_mass/matrix"
    smallest = float(np.linalg.eigvalsh(A)[0])
    assert f"{smallest:.4g}" in problem.message


def test_added_mass_may_be_singular_or_off():
    assemble(parse_design(with_added_mass(np.zeros((6, 6)))))
    assembly = assemble(parse_design(with_added_mass(np.eye(6), enabled=False)))
    assert assembly.params.body["a11"][0] == 0.0


def test_added_mass_scales_with_the_waters_density():
    changed = with_added_mass(np.diag([0.1, 0.5, 1.0, 0.01, 0.02, 0.01]), density=1000.0)
    changed["mission"]["environment"] = {"water": {"density": 1025.0}}
    assert assemble(parse_design(changed)).params.body["a33"][0] == pytest.approx(1.025, rel=1e-15)


def test_no_inertia_is_refused():
    point = {"kind": "rigid", "name": "Point", "mass": 1.0, "volume": 1e-3, "position": [0.0, 0.0, 0.0]}
    changed = document()
    changed["vehicle"]["components"] = [point]
    problem = only_problem(changed)
    assert problem.pointer == "/vehicle/components"
    assert "moment of inertia in pitch is 0 kg m2" in problem.message


def test_a_point_mass_with_the_added_mass_of_a_point_is_refused():
    """Both inertias turn freely about one point: their sum is singular although A55 is not zero."""
    r = 0.3
    A = np.zeros((6, 6))
    A[np.ix_([2, 4], [2, 4])] = 0.5 * np.array([[1.0, -r], [-r, r * r]])
    changed = with_added_mass(A)
    changed["vehicle"]["components"] = [
        {"kind": "rigid", "name": "Point", "mass": 1.0, "volume": 1e-3, "position": [r, 0.0, 0.0]}
    ]
    assert "singular" in only_problem(changed).message


def test_no_mass_is_refused():
    changed = document(PISTON | {"mass": 0.0}, body=BODY | {"mass": 0.0})
    assert only_problem(changed).message == "the components weigh nothing"


def test_a_negative_principal_moment_is_refused():
    changed = document(body=BODY | {"inertia": {"xx": 0.01, "yy": 0.02, "zz": 0.01, "xz": 0.5}})
    problem = only_problem(changed)
    assert "negative principal moment" in problem.message
    assert problem.limit == 0.0


def test_a_schedule_outside_the_stops_is_refused_with_both():
    problem = only_problem(document(control=schedule("Piston", (0.0, 0.005), (1.0, 0.012))))
    assert problem.pointer == "/mission/control/schedules/0/points/1/extension"
    assert "12 mm" in problem.message and "[-10, 10] mm" in problem.message
    assert problem.limit == pytest.approx(0.01)


def test_an_initial_extension_outside_the_stops_is_refused():
    problem = only_problem(document(initial={"extensions": {"Piston": -0.02}}))
    assert problem.pointer == "/mission/initial/extensions/Piston"
    assert problem.limit == pytest.approx(-0.01)


def test_unknown_cells_are_refused_with_those_there_are():
    problem = only_problem(document(control=schedule("Pistol", (0.0, 0.0))))
    assert problem.pointer == "/mission/control/schedules/0/cell"
    assert "'Pistol'" in problem.message and problem.hint == "those are: 'Piston'"
    assert only_problem(document(control=schedule("Body", (0.0, 0.0)))).pointer.endswith("/cell")
    unknown = document(initial={"extensions": {"Body": 0.0}})
    assert only_problem(unknown).pointer == "/mission/initial/extensions/Body"


def test_two_schedules_for_one_cell_are_refused():
    twice = schedule("Piston", (0.0, 0.0))["schedules"] * 2
    assert only_problem(document(control={"schedules": twice})).pointer == "/mission/control/schedules/1/cell"


def test_starting_above_the_surface_or_below_the_bed_is_refused():
    problem = only_problem(document(initial={"position": [0.0, 0.0, -0.5]}))
    assert problem.pointer == "/mission/initial/position/2"
    assert "-0.5 m, above the surface" in problem.message
    problem = only_problem(document(initial={"position": [0.0, 0.0, 7.0]}, environment={"bed_depth": 6.0}))
    assert problem.pointer == "/mission/initial/position/2" and problem.limit == 6.0


@pytest.mark.parametrize(("field", "value", "pointer"), [
    ("roll", 0.1, "/mission/initial/roll"),
    ("yaw", 0.1, "/mission/initial/yaw"),
    ("position", [0.0, 0.2, 5.0], "/mission/initial/position/1"),
    ("velocity", [0.0, 0.2, 0.0], "/mission/initial/velocity/1"),
    ("angular_velocity", [0.2, 0.0, 0.0], "/mission/initial/angular_velocity/0"),
    ("angular_velocity", [0.0, 0.0, 0.2], "/mission/initial/angular_velocity/2"),
])  # fmt: skip
def test_leaving_the_plane_is_refused(field, value, pointer):
    changed = document()
    changed["mission"]["initial"][field] = value
    assert only_problem(changed).pointer == pointer


def test_tables_that_make_no_law_are_refused_at_the_door():
    changed = document()
    changed["vehicle"]["hydrodynamics"] = polar(row_drag=[0.0, *polar()["row_drag"][1:]])
    problem = only_problem(changed)
    assert "falls to 0" in problem.message and problem.limit == 0.0
    several = polar(row_speed=[0.5] * 5 + [1.0] * 5, row_alpha_deg=[0, 20.0, 45, 70, 90, 0, 20, 46, 70, 90.0])
    changed["vehicle"]["hydrodynamics"] = several
    assert "cannot be averaged" in only_problem(changed).message


@pytest.mark.parametrize(("limits", "pointer", "value"), [
    (Limits(components=1), "/vehicle/components", 1),
    (Limits(schedule_points=2), "/mission/control/schedules", 2),
    (Limits(table_rows=9), "/vehicle/hydrodynamics/row_alpha_deg", 9),
    (Limits(duration=4.0), "/mission/duration", 4.0),
    (Limits(samples=50), "/mission/solver/output_interval", 50),
    (Limits(steps=4000), "/mission/solver/step", 4000),
])  # fmt: skip
def test_limits_are_named_with_their_value(limits, pointer, value):
    control = schedule("Piston", (0.0, 0.0), (1.0, 0.001), (2.0, 0.0))
    problem = only_problem(document(control=control, solver={"method": "rk4"}), limits)
    assert (problem.pointer, problem.limit) == (pointer, value)
    assert f"limit of {value:g}" in problem.message
    assert problem.hint


def test_several_problems_are_told_at_once():
    changed = document(control=schedule("Piston", (0.0, 1.0)), initial={"position": [0.0, 0.0, -1.0], "roll": 1.0})
    changed["vehicle"]["hydrodynamics"] = polar(row_drag=[-1.0] * 10)
    assert {problem.pointer for problem in problems_of(changed)} == {
        "/mission/control/schedules/0/points/0/extension", "/mission/initial/position/2", "/mission/initial/roll",
        "/vehicle/hydrodynamics/row_drag",
    }  # fmt: skip


def test_a_saved_controller_flies_as_the_one_that_was_not():
    """What a document leaves out and what its file then holds mean the same: here the moment on climbs."""
    document = load_preset("quad-bellows-heading").model_dump(mode="json")
    controller = document["mission"]["control"]["controller"]
    controller["vertical"] = {"kind": "heave", "heave": -1.0}
    controller["pitch"] = {"dive_moment": -0.4}
    design = parse_design(document)
    saved = loads_design(design.to_json())
    for made in (design, saved):
        record = assemble(made).params.control[0]
        assert (record["dive_moment"], record["climb_moment"]) == (-0.4, -0.4)
