"""Parts that are dragged in the scene: along an axis, in whole millimetres, with their mirror image, unless locked."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from models.presets import load_preset
from studio.attitude import attitude_of, rotate
from studio.scene_drag import PartMoves, along, snapped
from studio.session import Session
from tests.studio.conftest import Studio, wait_until
from tests.studio.raw_client import RawClient
from tests.studio.test_wire import browse, is_path

SIDE = SimpleNamespace(position=(0.0, 3.0, 0.0), look_at=(0.0, 0.0, 0.0))  # from starboard
TOP = SimpleNamespace(position=(0.0, 0.0, -3.0), look_at=(0.0, 0.0, 0.0))
LEVEL = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def quad(kernel: None) -> Iterator[Session]:
    made = Session("a-quad", load_preset("quad-bellows-glide"))
    wait_until(lambda: not made.simulating, timeout=60.0)
    yield made
    made.close()


def drag(moves: PartMoves, index: int, *ways: Any, modifier: str | None = None, camera: Any = SIDE) -> None:
    """Take a part at some place in the scene, move the pointer by each way, and let go."""

    def event(phase: str, way: Any) -> Any:
        begin = np.array((0.1, 0.2, 0.3))
        return SimpleNamespace(
            phase=phase, modifier=modifier, start_position=tuple(begin), end_position=tuple(begin + way),
            client=SimpleNamespace(camera=camera),
        )  # fmt: skip

    moves.drag(index, event("start", np.zeros(3)))
    for way in ways:
        moves.drag(index, event("update", np.array(way)))
    moves.drag(index, event("end", np.array(ways[-1])))


def position(session: Session, index: int) -> tuple[float, float, float]:
    return session.design.vehicle.components[index].position


def test_a_cell_goes_along_the_hull_in_whole_millimetres(session: Session) -> None:
    before = position(session, 1)
    moves = PartMoves(session, lambda: LEVEL)
    drag(moves, 1, (-0.0123, 0.0, 0.4))
    assert position(session, 1) == pytest.approx((before[0] - 0.012, before[1], before[2]), abs=1e-12)
    assert session.selected == 1
    assert moves.label is None, "what is let go tells its place no longer"
    session.undo()


def test_one_drag_is_one_step_of_undo_and_two_are_two(session: Session) -> None:
    before = session.design
    moves = PartMoves(session, lambda: LEVEL)
    drag(moves, 1, (-0.01, 0, 0), (-0.02, 0, 0), (-0.03, 0, 0))
    between = session.design
    drag(moves, 1, (0.005, 0, 0))
    assert session.undo() and session.design == between
    assert session.undo() and session.design == before


def test_the_label_tells_axis_and_place(session: Session) -> None:
    moves = PartMoves(session, lambda: LEVEL)
    told = []
    session.subscribe(lambda _: told.append(moves.label))
    drag(moves, 1, (-0.03, 0, 0))
    assert session.design.vehicle.components[1].position[0] == pytest.approx(0.15)
    wait_until(lambda: moves.label is None)
    session.undo()


@pytest.mark.parametrize(
    ("modifier", "camera", "way", "expected"),
    [
        (None, SIDE, (0.0123, 0.0, 0.01), (0.012, 0.0, 0.0)),
        ("alt", SIDE, (0.01234, 0.0, 0.01), (0.01234, 0.0, 0.0)),
        ("shift", TOP, (0.5, 0.0078, 0.0), (0.0, 0.008, 0.0)),
        ("alt+shift", TOP, (0.5, 0.00781, 0.0), (0.0, 0.00781, 0.0)),
        ("cmd/ctrl", SIDE, (0.5, 0.0, 0.0078), (0.0, 0.0, 0.008)),
    ],
)
def test_the_mirror_image_follows(quad: Session, modifier: str | None, camera: Any, way: Any, expected: Any) -> None:
    port, starboard = position(quad, 4), position(quad, 5)
    assert (port[0], port[1], port[2]) == (starboard[0], -starboard[1], starboard[2])
    drag(PartMoves(quad, lambda: LEVEL), 4, way, modifier=modifier, camera=camera)
    assert np.subtract(position(quad, 4), port) == pytest.approx(expected, abs=1e-9)
    x, y, z = position(quad, 4)
    assert position(quad, 5) == (x, -y, z)
    assert quad.undo()
    assert (position(quad, 4), position(quad, 5)) == (port, starboard), "both in one step"


def test_a_locked_part_stays_and_says_why(quad: Session) -> None:
    before = quad.design
    quad.mark(4, locked=True)
    drag(PartMoves(quad, lambda: LEVEL), 4, (0.05, 0, 0))
    assert quad.design is before
    assert "locked" in quad.problem[0].message and quad.problem[0].pointer == "/vehicle/components/4/position"
    # its image can be moved, and goes alone
    drag(PartMoves(quad, lambda: LEVEL), 5, (0.05, 0, 0))
    assert position(quad, 4) == before.vehicle.components[4].position
    assert position(quad, 5)[0] == pytest.approx(before.vehicle.components[5].position[0] + 0.05)
    quad.undo()
    quad.mark(4, locked=False)


def test_a_planar_glider_keeps_its_parts_in_the_plane(session: Session) -> None:
    before = session.design
    drag(PartMoves(session, lambda: LEVEL), 1, (0.0, 0.05, 0.0), modifier="shift", camera=TOP)
    assert session.design is before


def test_a_part_stays_under_the_pointer_of_a_glider_that_dives(session: Session) -> None:
    pitch = attitude_of(0.0, -0.6, 0.0)
    hull = rotate(np.array([[1.0, 0.0, 0.0]]), pitch)[0]
    before = position(session, 1)
    drag(PartMoves(session, lambda: pitch), 1, -0.02 * hull)
    assert position(session, 1)[0] == pytest.approx(before[0] - 0.02, abs=1e-12)
    session.undo()


def test_seen_at_an_angle_the_way_is_longer_than_it_looks() -> None:
    sight = np.array([math.sqrt(0.5), math.sqrt(0.5), 0.0])
    axis = np.array([1.0, 0.0, 0.0])
    way = 0.1 * (axis - (axis @ sight) * sight)  # what a tenth of a metre looks like in the plane of the picture
    assert along(way, axis, sight) == pytest.approx(0.1)
    # along the line of sight nothing is seen to move, and nothing leaps
    assert abs(along(np.array([0.0, 0.01, 0.0]), axis, axis)) < 1e-9


def test_places_snap_to_millimetres_or_hundredths() -> None:
    assert snapped(0.17649, free=False) == 0.176
    assert snapped(0.176494, free=True) == 0.17649


def test_a_part_that_is_gone_ends_its_drag(session: Session) -> None:
    moves = PartMoves(session, lambda: LEVEL)
    grip = moves.take(2)
    assert grip is not None
    session.remove_component("Rear bellows")
    after = session.design
    moves.put(grip, (0.0, 0.0, 0.0))
    assert session.design is after
    session.undo()


def test_a_drag_on_the_wire_moves_the_path(studio: Studio) -> None:
    async def pull(browser: RawClient) -> str:
        await browser.wait_for(is_path)
        name = "/glider/cell1/stack"
        bound = await browser.wait_for(lambda m: m["type"] == "SetSceneNodeDragBindingsMessage" and m["name"] == name)
        heard = len(browser.messages)
        message = {
            "type": "SceneNodeDragMessage", "name": name, "instance_index": None, "start_screen_pos": (0.5, 0.5),
            "end_screen_pos": (0.4, 0.5), "button": "left", "modifier": None, "owner": "",
            "start_position": (0.18, 0.02, 0.0),
        }  # fmt: skip
        await browser.send(**message, phase="start", end_position=(0.18, 0.02, 0.0))
        await browser.send(**message, phase="update", end_position=(0.15, 0.02, 0.0))
        await browser.wait_for(is_path, after=heard)
        label = await browser.wait_for(lambda m: m.get("name") == "/glider/told", after=heard)
        await browser.send(**message, phase="end", end_position=(0.15, 0.02, 0.0))
        await browser.wait_for(lambda m: m["type"] == "RemoveSceneNodeMessage", after=heard)
        assert bound["bindings"]
        return str(label["props"]["text"])

    def scenario(browser: RawClient) -> Any:
        return asyncio.wait_for(pull(browser), 60.0)

    told, session_id = browse(studio, scenario)
    session = studio.sessions.get(session_id)
    assert session is not None
    x = session.design.vehicle.components[1].position[0]
    assert x < 0.18 and round(x * 1e3, 6) == round(x * 1e3)
    assert told.startswith("x ") and told.endswith(" mm")
