"""The design document: round trips, identity, and how wrong documents are told."""

import copy
import json

import pytest
from hypothesis import given

from models.assemble import assemble
from models.design import load_design, loads_design, parse_design
from models.presets import load_preset, preset_ids
from models.problems import DesignError, escape, pointer_to
from tests.models.support import PISTON, document, schedule
from tests.strategies import designs


def problems_of(changed):
    with pytest.raises(DesignError) as refused:
        parse_design(changed)
    return refused.value.problems


def pointers_of(changed):
    return [problem.pointer for problem in problems_of(changed)]


@given(designs(neutral=False))
def test_a_design_survives_its_file(design):
    again = loads_design(design.to_json())
    assert again == design
    assert again.identity == design.identity
    assert again.to_json() == design.to_json()


@pytest.mark.parametrize("preset_id", preset_ids())
def test_presets_survive_their_files(preset_id, tmp_path):
    design = load_preset(preset_id)
    path = tmp_path / "design.json"
    path.write_text(design.to_json(), encoding="utf-8")
    assert load_design(path) == design


@given(designs())
def test_random_designs_assemble(design):
    assembly = assemble(design)
    assert len(assembly.initial_state) == 8 + len(assembly.cells)


def reversed_keys(node):
    if isinstance(node, dict):
        return {key: reversed_keys(node[key]) for key in reversed(node)}
    return [reversed_keys(item) for item in node] if isinstance(node, list) else node


def test_identity_does_not_depend_on_the_order_of_keys_or_defaults_left_out():
    whole = load_preset("three-cell-glider").model_dump(mode="json")
    sparse = json.loads(load_preset("three-cell-glider").model_dump_json(exclude_defaults=True))
    sparse |= {"format": "glider-design", "version": 1}
    assert list(reversed_keys(whole)) != list(whole)
    assert parse_design(reversed_keys(whole)).identity == parse_design(whole).identity
    assert 1.0 == 1 and parse_design(document(duration=5)).identity == parse_design(document(duration=5.0)).identity


def test_identity_changes_with_any_number():
    one, two = document(), document()
    two["vehicle"]["components"][0]["mass"] += 1e-15 + 1e-16
    assert parse_design(one).identity != parse_design(two).identity


def test_designs_are_immutable():
    design = load_preset("canete-dual-bellows")
    with pytest.raises(ValueError, match="frozen"):
        design.name = "Other"


@pytest.mark.parametrize(("path", "pointer"), [
    ((), "/colour"),
    (("vehicle",), "/vehicle/colour"),
    (("vehicle", "components", 0), "/vehicle/components/0/colour"),
    (("vehicle", "components", 1), "/vehicle/components/1/colour"),
    (("vehicle", "components", 0, "inertia"), "/vehicle/components/0/inertia/colour"),
    (("vehicle", "hydrodynamics"), "/vehicle/hydrodynamics/colour"),
    (("mission", "initial"), "/mission/initial/colour"),
    (("mission", "control", "schedules", 0, "points", 1), "/mission/control/schedules/0/points/1/colour"),
])  # fmt: skip
def test_an_unknown_field_is_refused_by_its_pointer(path, pointer):
    changed = document(control=schedule("Piston", (0.0, 0.001), (1.0, 0.002)))
    node = changed
    for key in path:
        node = node[key]
    node["colour"] = 1
    (problem,) = problems_of(changed)
    assert problem.pointer == pointer
    assert problem.message == "there is no field 'colour' here"
    assert problem.hint is not None
    assert problem.hint.startswith(("remove it; there are ", "did you mean color?"))


@pytest.mark.parametrize(("pointer", "value"), [
    ("/vehicle/components/0/mass", -1.0),
    ("/vehicle/components/0/mass", "heavy"),
    ("/vehicle/components/0/mass", True),
    ("/vehicle/components/0/mass", None),
    ("/vehicle/components/0/position/2", 1e9),
    ("/vehicle/components/1/volume_range/0", -1e-6),
    ("/vehicle/components/1/kind", "rocket"),
    ("/vehicle/damping/pitch", -0.1),
    ("/vehicle/hydrodynamics/row_drag/3", "2"),
    ("/vehicle/hydrodynamics/includes_munk_moment", 1),
    ("/mission/duration", 0.0),
    ("/mission/solver/method", "euler"),
    ("/mission/environment/gravity", 1e9),
    ("/name", ""),
])  # fmt: skip
def test_a_wrong_value_is_refused_by_its_pointer(pointer, value):
    changed = document(environment={"gravity": 9.8}, solver={"method": "rk4"})
    *path, last = [int(token) if token.isdigit() else token for token in pointer.split("/")[1:]]
    node = changed
    for key in path:
        node = node[key]
    node[last] = value
    expected = pointer.removesuffix("/kind") if value == "rocket" else pointer
    assert pointers_of(changed) in ([expected], [pointer])


def test_a_bound_and_the_value_are_told():
    changed = document(duration=-3.0)
    (problem,) = problems_of(changed)
    assert problem.limit == 0.0
    assert "-3.0" in problem.message


@pytest.mark.parametrize("token", ["NaN", "Infinity", "-Infinity"])
def test_numbers_that_are_not_finite_are_refused_in_files_and_objects(token):
    content = json.dumps(document()).replace('"duration": 5.0', f'"duration": {token}')
    assert token in content
    with pytest.raises(DesignError, match="numbers must be finite"):
        loads_design(content)
    assert pointers_of(document(duration=float(token.replace("Infinity", "inf")))) == ["/mission/duration"]


def test_a_number_too_large_for_a_float_is_refused():
    content = json.dumps(document()).replace('"duration": 5.0', '"duration": 1e999')
    with pytest.raises(DesignError):
        loads_design(content)


def test_a_document_of_a_newer_version_is_refused_politely():
    (problem,) = problems_of(document() | {"version": 2, "something_new": 1})
    assert problem.pointer == "/version"
    assert "version 2" in problem.message and "up to 1" in problem.message
    assert problem.hint == "open it with a newer glider studio"


@pytest.mark.parametrize("version", [0, "1", 1.5, None])
def test_a_version_that_is_none_is_refused_at_its_place(version):
    assert pointers_of(document() | {"version": version}) == ["/version"]


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe", b"[" * 100_000, b"glider", b"[1, 2]", b"3", b'{"a": 1}'])
def test_what_is_no_design_is_told_and_never_crashes(content):
    with pytest.raises(DesignError):
        loads_design(content)


def test_64_components_are_accepted():
    parts = [PISTON | {"name": f"Cell {i}", "position": [0.01 * i - 0.3, 0.0, 0.0]} for i in range(63)]
    design = parse_design(document(*parts))
    assert len(design.vehicle.components) == 64
    assert len(assemble(design).cells) == 63


def test_two_components_of_one_name_are_refused():
    (problem,) = problems_of(document(PISTON, PISTON))
    assert problem.pointer == "/vehicle"
    assert "components 1 and 2 are both named 'Piston'" in problem.message


def test_no_component_is_refused():
    changed = document()
    changed["vehicle"]["components"] = []
    assert pointers_of(changed) == ["/vehicle/components"]


def test_the_largest_seed_has_an_identity_and_a_larger_one_is_refused():
    changed = load_preset("quad-bellows-heading").model_dump(mode="json")
    noise = changed["mission"]["control"]["controller"]["noise"]
    noise["seed"] = 2**53 - 1
    assert len(parse_design(changed).identity) == 64
    noise["seed"] = 2**53
    (problem,) = problems_of(changed)
    assert problem.pointer.endswith("/noise/seed") and problem.limit == 2**53 - 1


def test_a_table_without_rows_is_refused():
    changed = load_preset("canete-dual-bellows").model_dump(mode="json")
    table = changed["vehicle"]["hydrodynamics"]
    table |= {name: [] for name in table if name.startswith("row_")}
    (problem,) = problems_of(changed)
    assert problem.pointer == "/vehicle/hydrodynamics" and "the table has no rows" in problem.message


def test_times_of_a_schedule_must_rise():
    (problem,) = problems_of(document(control=schedule("Piston", (1.0, 0.001), (1.0, 0.002))))
    assert problem.pointer == "/mission/control/schedules/0"
    assert "times must rise: point 2 of 'Piston'" in problem.message


def test_every_problem_is_told_at_once():
    changed = document(duration=-1.0)
    changed["vehicle"]["components"][0]["mass"] = -1.0
    changed["name"] = ""
    assert set(pointers_of(changed)) == {"/mission/duration", "/vehicle/components/0/mass", "/name"}


def test_pointers_escape_their_tokens():
    assert escape("a/b~c") == "a~1b~0c"
    assert pointer_to("mission", "extensions", "a/b", 3) == "/mission/extensions/a~1b/3"
    changed = document(initial={"extensions": {"Tilde ~": "far"}})
    assert pointers_of(changed) == ["/mission/initial/extensions/Tilde ~0"]


def test_parsing_does_not_change_its_argument():
    changed = document()
    before = copy.deepcopy(changed)
    parse_design(changed)
    assert changed == before
