"""Every kind of water, current and force data has its panel, its state and its picture of the forces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from models.design import Design, parse_design
from models.hydrodynamics_angles import AngleTable
from models.presets import load_preset, preset_ids
from models.water import gravity_of, surface_density
from studio.panel.component_rows import component_rows
from studio.panel.force_rows import damping_rows, hydrodynamics_rows
from studio.panel.mass_rows import mass_rows
from studio.panel.mission_rows import mission_rows, solver_rows, water_rows
from studio.panel.rows import Row
from studio.panel.schedule_rows import schedule_rows
from studio.polar import polar_document
from studio.session import Session
from studio.state import state_of
from studio.view import View
from tests.studio.conftest import Studio, wait_until
from tests.studio.sources import angle_table, documents
from tests.studio.spiral import spiral

SECTIONS: tuple[Callable[[Design], list[Row]], ...] = (
    mass_rows, hydrodynamics_rows, damping_rows, water_rows, mission_rows, solver_rows,
)  # fmt: skip


def rows_of(design: Design) -> list[Row]:
    parts = range(len(design.vehicle.components))
    return [
        *(row for section in SECTIONS for row in section(design)),
        *(row for i in parts for row in (*component_rows(design, i), *schedule_rows(design, i))),
    ]


def row(design: Design, label: str) -> Row:
    return next(row for row in rows_of(design) if row.label == label)


DESIGNS = {name: parse_design(document) for name, document in documents().items()}
DESIGNS |= {name: load_preset(name) for name in preset_ids()}


@pytest.mark.parametrize("name", DESIGNS)
def test_no_section_is_empty_and_every_row_shows_and_writes_back_what_it_shows(name: str) -> None:
    design = DESIGNS[name]
    for section in SECTIONS:
        rows = section(design)
        assert rows
    for row in rows_of(design):
        shown = row.show(design)
        if row.widget in ("note", "text"):
            assert str(shown).strip()
        if row.widget in ("slider", "number", "readout"):
            assert math.isfinite(shown)
            assert row.unit.symbol or row.label.startswith("Pleats")


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


def test_lateral_rows_are_there_in_three_dimensions_only() -> None:
    spatial = {row.label for row in rows_of(spiral())}
    planar = {row.label for row in rows_of(load_preset("canete-dual-bellows"))}
    extra = {
        "Position y", "Initial roll", "Initial yaw", "Surface", "Bed contact", "Current", "Hotel load",
        "Inertia in roll", "Inertia in yaw", "CoM y", "Sway damping", "Efficiency",
    }  # fmt: skip
    assert extra <= spatial
    assert not extra & planar


def test_angles_of_what_rolls_are_in_degrees() -> None:
    design = spiral()
    assert row(design, "Angle 1").show(design) == pytest.approx(45.0)
    assert row(design, "Angle 1").unit.symbol == "°"
    (patch,) = row(design, "Angle to").patch(design, 90.0)
    assert patch["value"] == pytest.approx(math.pi / 2.0, abs=1e-9)


def test_the_model_is_a_choice_and_the_current_two_numbers(open_session: Callable[[Design], Session]) -> None:
    session = open_session(spiral(duration=5.0))
    session.edit(row(session.design, "Current").patch(session.design, "uniform"))
    session.edit(row(session.design, "Current east").patch(session.design, 12.0))
    current = session.design.mission.environment.current
    assert current is not None and current.kind == "uniform"
    assert current.velocity == (0.0, 0.12)
    assert row(session.design, "Current").patch(session.design, "uniform") == []
    session.edit(row(session.design, "Current").patch(session.design, "none"))
    assert session.design.mission.environment.current is None
    assert row(session.design, "Model").show(session.design) == "spatial"
