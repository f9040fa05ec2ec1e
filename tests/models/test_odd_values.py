"""Values that are numbers, yet mean nothing: refused at the door with the way out, never a failure later."""

from __future__ import annotations

import copy

import pytest

from models.design import parse_design
from models.presets import load_preset
from models.problems import DesignError

CELL = "/vehicle/components/1"
BLADDER = {"kind": "bladder", "name": "B", "mass": 0.1, "position": [0, 0, 0], "neutral_extension": 0.0}


def document():
    return copy.deepcopy(load_preset("canete-dual-bellows").model_dump(mode="json"))


def refusal(spoiled):
    with pytest.raises(DesignError) as caught:
        parse_design(spoiled)
    return caught.value.problems[0]


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("extension_range", [0.0, 5e-324], "by 1e-09 m at least"),
        ("lag", 1e-300, "give 0 for none"),
        ("axis", [0.0, 0.0, 0.0], "no direction"),
        ("name", "\x00", "match"),
        ("name", " ", "match"),
    ],
)
def test_of_a_cell(field, value, says):
    spoiled = document()
    spoiled["vehicle"]["components"][1][field] = value
    problem = refusal(spoiled)
    assert problem.pointer.startswith(CELL)
    assert says in problem.message


def test_of_a_bladders_table():
    spoiled = document()
    cell = BLADDER | {"extensions": [0.0, 5e-324, 1.0], "volumes": [1e-5, 2e-5, 3e-5]}
    spoiled["vehicle"]["components"].append(cell)
    assert "must rise" in refusal(spoiled).message


def test_of_a_drawn_cylinder():
    spoiled = document()
    shape = {"kind": "cylinder", "length": 0.1, "radius": 0.01, "axis": [1e-200, 0.0, 0.0]}
    spoiled["vehicle"]["components"][0]["shapes"] = [shape]
    problem = refusal(spoiled)
    assert problem.pointer == "/vehicle/components/0/shapes/0"
    assert "no direction" in problem.message


def test_of_a_designs_name():
    spoiled = document()
    spoiled["name"] = "a\x00b"
    assert refusal(spoiled).pointer == "/name"


def test_a_missing_entry_and_a_missing_kind_are_pointed_at():
    spoiled = document()
    spoiled["vehicle"]["components"][1]["extension_range"] = [0.0]
    assert refusal(spoiled).pointer == f"{CELL}/extension_range/1"
    spoiled = document()
    del spoiled["vehicle"]["components"][1]["kind"]
    problem = refusal(spoiled)
    assert (problem.pointer, problem.message) == (f"{CELL}/kind", "the kind is missing")
    spoiled["vehicle"]["components"][1]["kind"] = "balloon"
    assert "'balloon'" in refusal(spoiled).message


def test_a_version_that_is_true_is_not_one():
    assert refusal(document() | {"version": True}).pointer == "/version"
