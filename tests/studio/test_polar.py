from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from models.design import Design
from models.hydrodynamic_law import QUANTITIES, build_law, coefficients_by_speed, select_data
from models.hydrodynamics import PolarTable
from models.hydrodynamics_coefficients import CoefficientForm
from studio.polar import polar_document
from tests.studio.conftest import Studio
from tests.studio.spiral import spiral


@pytest.fixture(params=["pchip", "polynomial"])
def table(request: pytest.FixtureRequest, dual_bellows: Design) -> PolarTable:
    return dual_bellows.vehicle.hydrodynamics.model_copy(update={"law": request.param})


def test_the_line_is_the_law_that_the_physics_uses(table: PolarTable) -> None:
    line = polar_document(table)["law"]
    assert line["alpha_deg"][0] == -180.0 and line["alpha_deg"][-1] == 180.0
    values = build_law(table)(np.deg2rad(line["alpha_deg"]))
    for name, expected in zip(QUANTITIES, values, strict=True):
        assert line[name] == expected.tolist()


def test_every_row_of_the_data_is_drawn_per_squared_speed(table: PolarTable) -> None:
    document = polar_document(table)
    assert [series["speed"] for series in document["data"]] == list(table.speeds)
    assert sum(len(series["alpha_deg"]) for series in document["data"]) == len(table.row_speed)
    for series in document["data"]:
        alpha, forces = coefficients_by_speed(table)[series["speed"]]
        # degrees to radians and back rounds twice
        assert series["alpha_deg"] == pytest.approx(np.rad2deg(alpha).tolist(), rel=1e-15)
        assert [series[name] for name in QUANTITIES] == forces.tolist()


def test_the_chosen_data_are_the_mean_or_one_speed(table: PolarTable) -> None:
    chosen = polar_document(table)["chosen"]
    assert chosen["what"] == "mean of 3 speeds"
    assert [chosen[name] for name in QUANTITIES] == select_data(table)[1].tolist()
    speed = table.speeds[1]
    one = polar_document(table.model_copy(update={"speed": speed}))
    assert one["chosen"]["what"] == f"{speed:g} m/s"
    assert one["chosen"]["drag"] == one["data"][1]["drag"]


def test_the_errors_and_the_provenance_are_told_unchanged(table: PolarTable) -> None:
    document = polar_document(table)
    for told, error in zip(document["errors"], build_law(table).errors, strict=True):
        assert told["quantity"] == error.quantity
        assert (told["rms"], told["largest"], told["largest_at_deg"]) == (
            error.rms, error.largest, error.largest_at_deg,
        )  # fmt: skip
        assert told["relative"] == error.largest / error.range
    assert document["provenance"] == table.provenance.model_dump()
    assert "stand-in" in document["provenance"]["limits"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {},
            "no side force, roll or yaw moment: they are all zero in the coefficients; nothing holds against sideslip",
        ),
        ({"side_sideslip": -20.0, "yaw_rate": -1.0}, "the coefficients give side force and yaw moment; no roll moment"),
        (
            {"side_sideslip": -20.0, "roll_sideslip": -1.0, "yaw_sideslip": 5.0},
            "the coefficients give side force, roll moment and yaw moment",
        ),
    ],
)
def test_lateral_forces_are_told_by_their_values(given: dict[str, float], told: str) -> None:
    source = spiral().vehicle.hydrodynamics
    assert isinstance(source, CoefficientForm)
    zero = dict.fromkeys(("side_sideslip", "roll_sideslip", "roll_rate", "yaw_sideslip", "yaw_rate"), 0.0)
    assert polar_document(source.model_copy(update=zero | given))["sideways"] == told


def test_a_session_answers_its_own_design_to_its_own_browser(studio: Studio, dual_bellows: Design) -> None:
    client, session_id = studio.open()
    with closing(client):
        told = client.get("polar")
        assert told.status_code == 200
        assert told.headers["cache-control"] == "no-store"
        # JSON has no tuples, and keeps every digit of a float
        expected = polar_document(dual_bellows.vehicle.hydrodynamics)
        assert told.json() == expected | {"reference_point": list(expected["reference_point"])}
        patch = [{"op": "replace", "path": "/vehicle/hydrodynamics/law", "value": "polynomial"}]
        assert client.post("edit", json={"patch": patch}).status_code == 200
        assert client.get("polar").json()["law"]["name"] == "polynomial"
    with studio.client as stranger:
        assert stranger.get(f"/s/{session_id}/polar").status_code == 403
