"""The analysis of mass: the library's numbers, at the extensions asked for."""

from __future__ import annotations

import numpy as np
import pytest

from models.mass_properties import initial_extensions, mass_balance
from models.presets import load_preset
from tests.server.support import MASS, TRIM, ask, assert_problem, preset, read_json

DESIGN = load_preset("three-cell-glider")
AT = {"Front bellows": 0.012, "Battery slide": 0.01}


@pytest.mark.parametrize("at", [{}, AT])
def test_whole_and_parts(at):
    answer = read_json(ask("POST", MASS, {"design": preset(), "options": {"extensions": at}}))
    extensions = initial_extensions(DESIGN) | at
    balance = mass_balance(DESIGN.vehicle, extensions)
    assert answer["mass"] == balance.mass and answer["volume"] == balance.volume
    for name in ("center_of_mass", "inertia", "center_of_buoyancy"):
        assert answer[name] == getattr(balance, name).tolist()
    parts = answer["components"]
    assert [part["name"] for part in parts] == [c.name for c in DESIGN.vehicle.components]
    assert {part["name"]: part["extension"] for part in parts if part["extension"] is not None} == extensions
    # the whole is the sum of its parts; rounding only
    for total, weight, point in (("mass", "mass", "center_of_mass"), ("volume", "volume", "center_of_buoyancy")):
        assert sum(part[weight] for part in parts) == pytest.approx(answer[total], rel=1e-12)
        moment = sum(part[weight] * np.array(part[point]) for part in parts)
        assert moment / answer[total] == pytest.approx(answer[point], abs=1e-15)
    water, g = DESIGN.mission.environment.water, DESIGN.mission.environment.gravity
    assert answer["net_buoyancy"] == pytest.approx(g * (water.density * answer["volume"] - answer["mass"]), abs=1e-12)


def test_the_document_itself_is_weighed_at_its_start():
    assert ask("POST", MASS, preset()).json() == ask("POST", MASS, {"design": preset()}).json()


@pytest.mark.parametrize(
    ("at", "pointer", "says"),
    [
        ({"Tail": 0.0}, "/options/extensions/Tail", "'Front bellows'"),
        ({"a/b~c": 0.0}, "/options/extensions/a~1b~0c", "no component"),
        ({"Fuselage": 0.0}, "/options/extensions/Fuselage", "no component that moves"),
        ({"Front bellows": 5.0}, "/options/extensions/Front bellows", "outside its stops"),
        ({"Front bellows": "5"}, "/options/extensions/Front bellows", "valid number"),
        ([], "/options/extensions", "dictionary"),
    ],
)
def test_wrong_extensions_are_pointed_at(at, pointer, says):
    sent = {"design": preset(), "options": {"extensions": at}}
    assert_problem(ask("POST", MASS, sent), 422, pointer=pointer, says=says)


def test_wrong_initial_extensions_are_pointed_at_in_the_design():
    design = preset()
    design["mission"]["initial"]["extensions"] = {"Front bellows": 9.0}
    assert_problem(ask("POST", MASS, design), 422, pointer="/mission/initial/extensions/Front bellows")
    pointer = "/design/mission/initial/extensions/Front bellows"
    assert_problem(ask("POST", MASS, {"design": design}), 422, pointer=pointer)
    answer = ask("POST", MASS, {"design": design, "options": {"extensions": {"Front bellows": 0.016}}})
    assert answer.status_code == 200


def test_trimmed_ballast_floats_neutrally():
    design = preset()
    design["vehicle"]["components"][0]["mass"] += 0.05
    answer = read_json(ask("POST", TRIM, design))
    balance = mass_balance(load_preset("three-cell-glider").vehicle)
    density = DESIGN.mission.environment.water.density
    change = answer["change"]
    assert change["component"] == "Fuselage" and change["pointer"] == "/vehicle/components/0/volume"
    assert answer["design"]["vehicle"]["components"][0]["volume"] == change["after"] != change["before"]
    weighed = answer["mass_properties"]
    # every cell starts at neutral in this preset, so neutral is neutral at the start; rounding of 1 kg
    assert weighed["mass"] == pytest.approx(balance.mass + 0.05, rel=1e-12)
    assert density * weighed["volume"] == pytest.approx(weighed["mass"], rel=1e-12)


def test_ballast_can_be_taken_from_a_named_part():
    answer = read_json(ask("POST", TRIM, {"design": preset(), "component": "Keel ballast"}))
    assert answer["change"]["component"] == "Keel ballast"
    assert_problem(ask("POST", TRIM, {"design": preset(), "component": "Anchor"}), 422, says="'Anchor'")


def test_a_trim_beyond_the_limits_is_refused():
    design = preset()
    design["mission"]["environment"]["water"]["density"] = 1e-3
    design["vehicle"]["components"][0]["mass"] = 1e3  # neutral at 1e6 m3, above what a component may displace
    assert_problem(ask("POST", TRIM, design), 422, pointer="/vehicle/components/0/volume")
