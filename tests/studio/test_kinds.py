"""Every kind of water, current and force data has its fields, its state and its picture of the forces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from pydantic_core import to_json

from models.design import Design, parse_design
from models.hydrodynamics_angles import AngleTable
from models.presets import load_preset, preset_ids
from models.water import gravity_of, surface_density
from studio.part_fields import fields_of
from studio.polar import polar_document
from studio.session import Session
from studio.state import state_of
from studio.view import View
from tests.studio.conftest import Studio, wait_until
from tests.studio.sources import angle_table, documents
from tests.studio.spiral import spiral

DESIGNS = {name: parse_design(document) for name, document in documents().items()}
DESIGNS |= {name: load_preset(name) for name in preset_ids()}


def numbers_in(node: Any) -> Iterator[float]:
    if isinstance(node, dict):
        yield from (n for value in node.values() for n in numbers_in(value))
    elif isinstance(node, list | tuple):
        yield from (n for value in node for n in numbers_in(value))
    elif isinstance(node, float):
        yield node


@pytest.mark.parametrize("name", DESIGNS)
def test_the_fields_are_few_and_what_follows_from_them_is_finite(name: str) -> None:
    design = DESIGNS[name]
    fields = fields_of(design)
    facts = fields["facts"]
    assert all(math.isfinite(n) for n in numbers_in(facts))
    assert facts["forces"][0] == design.vehicle.hydrodynamics.provenance.title
    assert bool(facts["water"]) == (design.mission.environment.water.kind != "uniform")
    assert len(to_json(fields)) < 24_000, "a page fetches them after each edit"
    assert facts["start"].keys() == facts["stroke"].keys() == {part.name for _, part in design.vehicle.actuated}


@pytest.mark.parametrize("name", DESIGNS)
def test_the_forces_are_drawn_over_the_whole_circle(name: str) -> None:
    document = polar_document(DESIGNS[name].vehicle.hydrodynamics)
    law = document["law"]
    assert (law["alpha_deg"][0], law["alpha_deg"][-1]) == (-180.0, 180.0)
    for quantity in ("lift", "drag", "moment"):
        assert len(law[quantity]) == len(law["alpha_deg"])
        assert np.isfinite(law[quantity]).all()
    low, high = document["range_deg"]
    assert low < high
    assert document["beyond"] and document["sideways"]


def test_lateral_forces_of_a_table_are_told_by_its_values() -> None:
    table = parse_design(documents()["angle_table"]).vehicle.hydrodynamics
    assert isinstance(table, AngleTable)
    assert polar_document(table)["sideways"] == "the table gives side force and yaw moment; no roll moment"
    rates = table.rates.model_copy(update={"roll_roll": -1.0})
    damped = table.model_copy(update={"rates": rates})
    assert polar_document(damped)["sideways"] == "the table gives side force, roll moment and yaw moment"


def test_a_table_over_both_angles_gives_lift_and_drag_without_sideslip() -> None:
    design = parse_design(documents()["angle_table"])
    document = polar_document(design.vehicle.hydrodynamics)
    at = {angle: k for k, angle in enumerate(document["chosen"]["alpha_deg"])}
    for angle in (-20.0, 0.0, 10.0):
        k, law = at[angle], document["law"]["alpha_deg"].index(angle)
        twice = 2.0 * math.radians(angle)
        for quantity, expected in (("lift", 9.0 * math.sin(twice)), ("drag", 2.0), ("moment", -math.sin(twice))):
            assert document["chosen"][quantity][k] == pytest.approx(expected, abs=1e-12)
            assert document["law"][quantity][law] == pytest.approx(expected, abs=1e-12)  # a node of the table


def test_a_table_that_does_not_close_the_circle_says_its_range() -> None:
    whole = documents()["angle_table"]
    whole["vehicle"]["hydrodynamics"] = angle_table((-20.0, -10.0, 0.0, 10.0, 20.0))
    document = polar_document(parse_design(whole).vehicle.hydrodynamics)
    assert document["range_deg"] == [-20.0, 20.0]
    assert "held beyond" in document["beyond"]


def test_coefficients_say_for_which_angles_they_were_meant() -> None:
    document = polar_document(spiral().vehicle.hydrodynamics)
    assert document["range_deg"] == [-20.0, 20.0]
    assert document["data"] == [] and document["chosen"] is None and document["errors"] == []
    k = document["law"]["alpha_deg"].index(10.0)
    radians = math.radians(10.0)
    assert document["law"]["lift"][k] == pytest.approx(-0.36 + 440.99 * radians, rel=1e-12)
    assert document["law"]["drag"][k] == pytest.approx(7.19 + 386.29 * radians**2, rel=1e-12)


@pytest.fixture
def open_session(kernel: None) -> Iterator[Callable[[Design], Session]]:
    opened: list[Session] = []

    def make(design: Design) -> Session:
        opened.append(Session("a-session-id", design))
        wait_until(lambda: not opened[-1].simulating, timeout=60.0)
        return opened[-1]

    yield make
    for session in opened:
        session.close()


@pytest.mark.parametrize("name", documents())
def test_state_and_view_know_every_kind(open_session: Callable[[Design], Session], name: str) -> None:
    session = open_session(DESIGNS[name])
    state: dict[str, Any] = state_of(session, saved_at=None)
    environment = session.design.mission.environment
    balance = state["mass"]
    buoyancy = gravity_of(environment) * surface_density(environment.water) * balance["displaced_volume"]
    assert balance["net_buoyancy"] == pytest.approx(buoyancy - gravity_of(environment) * balance["mass"], abs=1e-9)
    assert state["hydrodynamics"]
    view = View(session)
    view.set_clock(10.0)
    view.close()


def test_a_polar_of_another_kind_reaches_the_browser(studio: Studio) -> None:
    with studio.client as client:
        url = client.post("/sessions", json=documents()["angle_table"]).json()["url"]
        assert client.get(f"{url}polar").json()["kind"] == "angle_table"
        assert client.get(f"{url}state").json()["model"] == "spatial"


def test_the_lateral_data_that_are_missing_are_told(studio: Studio) -> None:
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    document["mission"]["solver"]["model"] = "spatial"
    document["vehicle"]["mass_properties"]["inertia"] |= {"xx": 1e-3, "zz": 1e-2}
    with closing(studio.client) as client:
        url = client.post("/sessions", json=document).json()["url"]
        told = client.get(f"{url}state").json()["warnings"]
        assert any(w["pointer"] == "/vehicle/hydrodynamics/lateral" for w in told)
        assert "sideslip" in client.get(f"{url}polar").json()["sideways"]
