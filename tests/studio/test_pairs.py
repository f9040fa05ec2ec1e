"""Edits by hand go to both parts of a pair, mirrored: by fields as by drags, unless one is to stay."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import pytest

from models.design import Design
from models.mass_properties import initial_extensions
from models.presets import load_preset
from server.editing import apply_patch
from studio.pairs import followed
from studio.part_symmetry import partners
from studio.scene_drag import PartMoves
from studio.session import Session
from tests.studio.conftest import Studio
from tests.studio.test_drag import LEVEL, TOP, drag

PORT, STARBOARD = 4, 5
NAMES = ("Front port cell", "Front starboard cell")


def edited(design: Design, path: str, value: Any, *, op: str = "replace", staying: tuple[str, ...] = ()) -> Design:
    after = apply_patch(design, [{"op": op, "path": path, "value": value}])
    return apply_patch(after, followed(design, after, staying=staying))


@pytest.fixture(scope="module")
def quad() -> Design:
    return load_preset("quad-bellows-glide")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("position/0", 0.55),
        ("position/1", -0.25),
        ("mass", 0.95),
        ("pleats", 9),
        ("center_of_mass", [0.6, -0.19, 0.01]),
    ],
)
@pytest.mark.parametrize("index", [PORT, STARBOARD])
def test_a_pair_stays_a_pair_whichever_is_edited(quad: Design, index: int, field: str, value: Any) -> None:
    after = edited(quad, f"/vehicle/components/{index}/{field}", value)
    assert after != quad
    assert partners(after.vehicle.components) == partners(quad.vehicle.components)
    assert [c.name for c in after.vehicle.components] == [c.name for c in quad.vehicle.components]


def test_what_is_not_seen_stays_each_ones_own(quad: Design) -> None:
    after = edited(quad, f"/vehicle/components/{PORT}/notes", "leaks")
    assert after.vehicle.components[STARBOARD] == quad.vehicle.components[STARBOARD]
    after = edited(after, f"/vehicle/components/{STARBOARD}/mass", 0.95)
    assert after.vehicle.components[PORT].mass == 0.95 and after.vehicle.components[PORT].notes == "leaks"


def test_extensions_at_start_go_along_where_they_were_alike(quad: Design) -> None:
    folder = "/mission/initial/extensions"
    after = edited(quad, f"{folder}/{NAMES[0]}", 0.03, op="add")
    assert [initial_extensions(after)[name] for name in NAMES] == [0.03, 0.03]
    apart = apply_patch(quad, [{"op": "add", "path": f"{folder}/{NAMES[0]}", "value": 0.02}])
    after = edited(apart, f"{folder}/{NAMES[0]}", 0.04)
    assert initial_extensions(after) == initial_extensions(apart) | {NAMES[0]: 0.04}


def test_those_that_stay_and_other_lists_of_parts_are_left_alone(quad: Design) -> None:
    path = f"/vehicle/components/{PORT}"
    assert edited(quad, f"{path}/mass", 0.95, staying=(NAMES[1],)).vehicle.components[STARBOARD].mass == 0.9
    renamed = apply_patch(quad, [{"op": "replace", "path": "/vehicle/components/0/name", "value": "Tube"}])
    assert followed(quad, renamed, staying=()) == []
    assert followed(quad, apply_patch(quad, [{"op": "remove", "path": "/vehicle/components/0"}]), staying=()) == []


def test_a_session_links_fields_and_drags_alike(kernel: None, quad: Design) -> None:
    with closing(Session("pairs", quad)) as session:
        moves = PartMoves(session, lambda: LEVEL)
        patch = [{"op": "replace", "path": f"/vehicle/components/{PORT}/position/0", "value": 0.55}]
        for linked in (True, False):
            session.link(linked)
            session.edit(patch, paired=True)
            assert places(session) == [0.55, 0.55 if linked else 0.6]
            session.undo()
            drag(moves, PORT, (-0.02, 0.0, 0.0), camera=TOP)
            assert places(session) == pytest.approx([0.58, 0.58 if linked else 0.6])
            session.undo()
            assert session.design == quad
        session.link(True)
        session.edit(patch)  # as scripts do
        assert places(session) == [0.55, 0.6]


def places(session: Session) -> list[float]:
    return [session.design.vehicle.components[i].position[0] for i in (PORT, STARBOARD)]


def test_the_page_asks_for_it_by_the_edit_and_turns_it_off(studio: Studio) -> None:
    client, _ = studio.open("quad-bellows-glide")
    with closing(client):
        client.headers["Origin"] = studio.url
        patch = [{"op": "replace", "path": f"/vehicle/components/{PORT}/mass", "value": 0.95}]
        assert client.get("state").json()["linked"] is True
        assert client.post("edit", json={"patch": patch, "paired": True}).status_code == 200
        assert client.get("design.json").json()["vehicle"]["components"][STARBOARD]["mass"] == 0.95
        assert client.post("pairs", json={"linked": False}).status_code == 200
        assert client.get("state").json()["linked"] is False
        for address, body, pointer in (("edit", {"patch": patch, "paired": 1}, "/paired"), ("pairs", {}, "/linked")):
            answer = client.post(address, json=body)
            assert answer.status_code == 422 and answer.json()["errors"][0]["pointer"] == pointer
