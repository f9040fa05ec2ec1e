"""JSON Patch on a design: what it does, and where its errors point."""

from __future__ import annotations

import copy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.design import Design
from models.presets import load_preset
from models.problems import DesignError
from server.editing import MAX_OPERATIONS, apply_patch
from server.examples.build import THIRD_CELL

DESIGN = load_preset("three-cell-glider")


def refusal(patch):
    with pytest.raises(DesignError) as caught:
        apply_patch(DESIGN, patch)
    return caught.value.problems


def test_a_cell_is_added_with_five_fields():
    edited = apply_patch(DESIGN, [{"op": "add", "path": "/vehicle/components/-", "value": THIRD_CELL}])
    assert edited.vehicle.components[:-1] == DESIGN.vehicle.components
    assert edited.vehicle.components[-1].name == THIRD_CELL["name"]


def test_every_operation_of_the_standard():
    patch = [
        {"op": "test", "path": "/name", "value": DESIGN.name},
        {"op": "replace", "path": "/name", "value": "Another"},
        {"op": "copy", "from": "/name", "path": "/notes"},
        {"op": "remove", "path": "/mission/control/schedules/0"},
        {"op": "move", "from": "/mission/control/schedules/0", "path": "/mission/control/schedules/-"},
    ]
    before = copy.deepcopy(patch)
    edited = apply_patch(DESIGN, patch)
    assert (edited.name, edited.notes) == ("Another", "Another")
    schedules = DESIGN.mission.control.schedules
    assert edited.mission.control.schedules == (*schedules[2:], schedules[1])
    assert patch == before


def test_an_empty_patch_changes_nothing():
    assert apply_patch(DESIGN, []) == DESIGN


@pytest.mark.parametrize(
    ("operation", "pointer", "says"),
    [
        (7, "/patch/1", "an operation is an object, not int"),
        ({"path": "/name"}, "/patch/1/op", "there is no operation null"),
        ({"op": "jump", "path": "/name"}, "/patch/1/op", "'jump'"),
        ({"op": ["add"], "path": "/name"}, "/patch/1/op", "an array of 1"),
        ({"op": "add", "path": "/name"}, "/patch/1/value", "needs 'value'"),
        ({"op": "remove"}, "/patch/1/path", "needs 'path'"),
        ({"op": "move", "path": "/name"}, "/patch/1/from", "needs 'from'"),
        ({"op": "remove", "path": 3}, "/patch/1/path", "JSON Pointer"),
        ({"op": "remove", "path": ""}, "/patch/1/path", "whole document"),
        ({"op": "remove", "path": "/nome"}, "/patch/1/path", "'/nome'"),
        ({"op": "replace", "path": "/vehicle/components/99", "value": 1}, "/patch/1/path", "outside of list"),
        ({"op": "replace", "path": "/vehicle/components/-", "value": 1}, "/patch/1/path", "'-'"),
        ({"op": "add", "path": "/vehicle/components/01", "value": 1}, "/patch/1/path", "not a valid sequence index"),
        ({"op": "add", "path": "name", "value": 1}, "/patch/1/path", "must start with /"),
        ({"op": "add", "path": "/name~2", "value": 1}, "/patch/1/path", "invalid escape"),
        ({"op": "add", "path": "/version/x", "value": 1}, "/patch/1/path", "does not support indexing"),
        ({"op": "move", "from": "/nome", "path": "/name"}, "/patch/1/from", "nothing at '/nome'"),
        ({"op": "copy", "from": "/vehicle/components/-", "path": "/name"}, "/patch/1/from", "past the end"),
        ({"op": "move", "from": "/vehicle", "path": "/vehicle/components/0"}, "/patch/1/path", "own children"),
        ({"op": "test", "path": "/version", "value": 2}, "/patch/1/value", "'/version' is 1, not 2"),
        ({"op": "test", "path": "/version", "value": True}, "/patch/1/value", "is 1, not true"),
        ({"op": "test", "path": "/nome", "value": 2}, "/patch/1/path", "nothing at '/nome'"),
    ],
)
def test_errors_point_into_the_patch(operation, pointer, says):
    (problem,) = refusal([{"op": "replace", "path": "/name", "value": "x"}, operation])
    assert problem.pointer == pointer
    assert says in problem.message
    # messages quote what was asked for, never the whole document
    assert len(problem.message) < 400


@pytest.mark.parametrize(
    ("operation", "pointer"),
    [
        ({"op": "replace", "path": "/vehicle/components/0/mass", "value": -1}, "/vehicle/components/0/mass"),
        ({"op": "replace", "path": "/mission/duration", "value": float("nan")}, "/mission/duration"),
        ({"op": "add", "path": "/mision", "value": 1}, "/mision"),
        ({"op": "replace", "path": "", "value": []}, ""),
        ({"op": "replace", "path": "/vehicle/components", "value": []}, "/vehicle/components"),
        ({"op": "remove", "path": "/format"}, "/format"),
    ],
)
def test_a_wrong_result_is_pointed_at_in_the_design(operation, pointer):
    assert pointer in [problem.pointer for problem in refusal([operation])]


@pytest.mark.parametrize("patch", [None, {}, "x", b"x", 1])
def test_a_patch_is_a_list(patch):
    assert refusal(patch)[0].pointer == "/patch"


def test_too_many_operations_and_copies_that_double_are_refused():
    (problem,) = refusal([{"op": "test", "path": "/version", "value": 1}] * (MAX_OPERATIONS + 1))
    assert (problem.pointer, problem.limit) == ("/patch", MAX_OPERATIONS)
    (problem,) = refusal([{"op": "copy", "from": "", "path": "/x"}] * MAX_OPERATIONS)
    assert "copies more than" in problem.message


def test_nesting_by_moves_ends_in_a_refusal():
    wrap = [
        {"op": "add", "path": "/y", "value": {}},
        {"op": "move", "from": "/notes", "path": "/y/n"},
        {"op": "move", "from": "/y", "path": "/notes"},
    ]
    assert refusal([*(wrap * 333)])
    assert refusal([*(wrap * 332), {"op": "copy", "from": "/notes", "path": "/name"}])


PATHS = st.lists(
    st.sampled_from(["vehicle", "mission", "components", "0", "2", "-", "99", "name", "control", "schedules", "", "x"]),
    max_size=4,
).map(lambda parts: "".join(f"/{part}" for part in parts))
OPERATIONS = st.fixed_dictionaries(
    {
        "op": st.sampled_from(["add", "remove", "replace", "move", "copy", "test"]),
        "path": PATHS | st.text("/~01a-", max_size=5),
        "from": PATHS,
        "value": st.none() | st.integers(-2, 2) | st.text("ab/", max_size=3) | st.just({}) | st.just([]),
    }
)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(st.lists(OPERATIONS, max_size=4))
def test_any_patch_gives_a_design_or_a_refusal(patch):
    try:
        assert isinstance(apply_patch(DESIGN, patch), Design)
    except DesignError as error:
        assert error.problems
