"""What reaches a browser through the proxy: the scene's truth, and the way from an edit to a new path."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from models.environment import UniformCurrent
from models.presets import load_preset
from models.simulate import simulate
from studio.attitude import attitude_of, rotate
from studio.grid import segments
from studio.water import path_points
from tests.studio.conftest import Studio, wait_until
from tests.studio.raw_client import RawClient

Scenario = Callable[[RawClient], Awaitable[Any]]


def browse(studio: Studio, scenario: Scenario, *, preset: str = "canete-dual-bellows") -> tuple[Any, str]:
    client, session_id = studio.open(preset)
    with closing(client):
        wait_until(lambda: (s := client.get("state").json())["run"] is not None and not s["simulating"])
        name = f"gs_{session_id}"
        cookie = f"{name}={client.cookies[name]}"

    async def run() -> Any:
        url = studio.url.replace("http", "ws") + f"/s/{session_id}/view"
        async with RawClient(url, cookie=cookie, origin=studio.url) as browser:
            return await scenario(browser)

    return asyncio.run(run()), session_id


def is_path(message: dict[str, Any]) -> bool:
    named = message.get("name") == "/world/path"
    return named and ("points" in message.get("updates", {}) or "points" in message.get("props", {}))


def points_of(message: dict[str, Any]) -> np.ndarray:
    placeholder = (message.get("updates") or message["props"])["points"]
    return np.frombuffer(message["arrays"][placeholder["__binary_index"]], dtype=np.float32).reshape(-1, 2, 3)


def test_the_path_is_the_run(studio: Studio) -> None:
    async def first(browser: RawClient) -> np.ndarray:
        return points_of(await browser.wait_for(is_path))

    shown, _ = browse(studio, first)
    expected = segments(path_points(simulate(load_preset("canete-dual-bellows"))))
    # single precision of metres
    assert shown == pytest.approx(expected, abs=1e-6)


def test_an_edit_moves_the_path(studio: Studio) -> None:
    async def edit(browser: RawClient) -> np.ndarray:
        await browser.wait_for(is_path)
        heard = len(browser.messages)
        live = studio.sessions.get(browser.session_id)
        assert live is not None
        await asyncio.to_thread(live.set_field, "/vehicle/components/1/position/0", 0.17)
        return points_of(await browser.wait_for(is_path, after=heard))

    shown, session_id = browse(studio, edit)
    session = studio.sessions.get(session_id)
    assert session is not None
    expected = segments(path_points(simulate(session.design)))
    assert shown == pytest.approx(expected, abs=1e-6)


def test_dragging_the_arrows_snaps_and_tells_as_dragging_the_part_does(studio: Studio) -> None:
    gizmo, told = "/glider/gizmo", "/glider/told"

    async def drag(browser: RawClient) -> tuple[str, dict[str, Any]]:
        await browser.wait_for(is_path)
        heard = len(browser.messages)
        live = studio.sessions.get(browser.session_id)
        assert live is not None
        await asyncio.to_thread(live.set_field, "/vehicle/components/1/position/2", 0.0004)
        at = await browser.wait_for(lambda m: m["type"] == "SetPositionMessage" and m["name"] == gizmo, after=heard)
        x, y, z = at["position"]
        heard = len(browser.messages)
        named = {"name": gizmo, "owner": ""}
        await browser.send(type="TransformControlsDragStartMessage", **named)
        await browser.send(
            type="TransformControlsUpdateMessage", wxyz=(0.0, 1.0, 0.0, 0.0), position=(x - 0.0504, y, z), **named
        )
        label = await browser.wait_for(lambda m: m.get("name") == told and "props" in m, after=heard)
        await browser.send(type="TransformControlsDragEndMessage", **named)
        await browser.wait_for(lambda m: m["type"] == "RemoveSceneNodeMessage" and m["name"] == told, after=heard)
        back = [m for m in browser.messages[heard:] if m["type"] == "SetPositionMessage" and m["name"] == gizmo]
        return str(label["props"]["text"]), back[-1] | {"from": (x, y, z)}

    (label, arrows), session_id = browse(studio, drag)
    session = studio.sessions.get(session_id)
    assert session is not None
    # whole millimetres along the arrow; across it the part stays where it was
    assert session.design.vehicle.components[1].position == pytest.approx((0.13, 0.0, 0.0004), abs=1e-9)
    assert label == "x 130 mm"
    assert arrows["position"] == pytest.approx(np.add(arrows["from"], (-0.05, 0.0, 0.0)), abs=1e-9), "with the part"


def test_nodes_have_the_physics_own_axes(studio: Studio) -> None:
    async def look(browser: RawClient) -> dict[str, dict[str, Any]]:
        found = studio.sessions.find(browser.session_id)
        assert found is not None
        heard = len(browser.messages)  # a pose is sent where it changed, and only then
        await asyncio.to_thread(found.session.set_field, "/mission/initial/pitch", 0.4)
        await asyncio.to_thread(wait_until, lambda: not found.session.simulating)
        await asyncio.to_thread(found.view().set_clock, 0.0)
        await browser.wait_for(lambda m: m["type"] == "SetOrientationMessage" and m["name"] == "/glider", after=heard)
        kinds = ("SetOrientationMessage", "SetPositionMessage")
        return {f"{m['type'][3:6]} {m['name']}": m for m in browser.messages if m["type"] in kinds}

    nodes, _ = browse(studio, look)
    attitude = nodes["Ori /glider"]["wxyz"]
    assert attitude == pytest.approx((math.cos(0.2), 0.0, math.sin(0.2), 0.0), abs=1e-12)
    assert nodes["Pos /world"]["position"] == pytest.approx((0.0, 0.0, -0.5), abs=1e-12)
    assert nodes["Pos /glider/cell1"]["position"] == pytest.approx((0.18, 0.0, 0.0), abs=1e-12)


def test_positive_pitch_raises_the_nose_and_positive_roll_lowers_starboard() -> None:
    nose, starboard = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    # z points down: above is negative
    pitch = attitude_of(0.0, 0.3, 0.0)
    assert rotate(nose, pitch)[0] == pytest.approx((math.cos(0.3), 0.0, -math.sin(0.3)), abs=1e-12)
    roll, yaw = (attitude_of(0.3, 0.0, 0.0), attitude_of(0.0, 0.0, 0.3))
    assert rotate(starboard, roll)[0] == pytest.approx((0.0, math.cos(0.3), math.sin(0.3)), abs=1e-12)
    assert rotate(nose, yaw)[0] == pytest.approx((math.cos(0.3), math.sin(0.3), 0.0), abs=1e-12)


def test_the_scene_has_the_nodes_that_the_page_moves(studio: Studio) -> None:
    async def names(browser: RawClient) -> set[str]:
        await browser.wait_for(is_path)
        return {m["name"] for m in browser.messages if "name" in m}

    found, _ = browse(studio, names, preset="three-cell-glider")
    arrows = {f"/glider/arrow_{name}" for name in ("buoyancy", "lift", "drag", "side")}
    cells = {f"/glider/cell{i}/stack" for i in (3, 4, 5)}
    parts = {f"/glider/part{i}" for i in (0, 1, 2, 6)}
    assert {"/world", "/world/path", "/glider", "/glider/com", "/glider/cob"} | arrows | cells | parts <= found


def test_the_scene_has_the_surface_and_the_current_of_the_design(studio: Studio) -> None:
    async def look(browser: RawClient) -> dict[str, dict[str, Any]]:
        await browser.wait_for(lambda m: m.get("name") == "/world/current/label0")
        return {m["name"]: m for m in browser.messages if "props" in m and "name" in m}

    nodes, _ = browse(studio, look, preset="quad-bellows-heading")
    current = load_preset("quad-bellows-heading").mission.environment.current
    assert isinstance(current, UniformCurrent)
    ways = np.diff(points_of(nodes["/world/current"]), axis=1)[:, 0]
    assert len(ways) > 1
    ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    # single precision
    assert ways == pytest.approx(
        np.tile(np.append(current.velocity, 0.0) / np.hypot(*current.velocity), (len(ways), 1)), abs=1e-4
    )
    speed = float(nodes["/world/current/label0"]["props"]["text"].removesuffix(" m/s"))
    assert speed == pytest.approx(np.hypot(*current.velocity), rel=0.06), "two digits"
    assert {"/world/surface", "/world/surface_grid", "/world/bed"} <= nodes.keys()
    assert 0.0 < nodes["/world/surface"]["props"]["opacity"] < 1.0


def test_the_server_can_move_the_glider_itself(studio: Studio) -> None:
    async def play(browser: RawClient) -> dict[str, dict[str, Any]]:
        await browser.wait_for(is_path)
        heard = len(browser.messages)
        found = studio.sessions.find(browser.session_id)
        assert found is not None
        await asyncio.to_thread(found.view().set_clock, 12.0)
        await browser.wait_for(lambda m: m["type"] == "SetPositionMessage" and m["name"] == "/world", after=heard)
        await browser.wait_for(lambda m: m.get("name") == "/glider/cell1/stack", after=heard)
        return {f"{m['type']} {m['name']}": m for m in browser.messages[heard:] if "name" in m}

    moved, _ = browse(studio, play)
    run = simulate(load_preset("canete-dual-bellows"))
    at = run.data.interp(time=12.0)
    position = moved["SetPositionMessage /world"]["position"]
    assert position == pytest.approx((-float(at["x"]), 0.0, -float(at["z"])), abs=1e-9)
    attitude = moved["SetOrientationMessage /glider"]["wxyz"]
    # between two samples the attitude is linear and made of length 1: second order in a twentieth of a second
    expected = attitude_of(0.0, float(at["theta"]), 0.0)
    assert attitude == pytest.approx(expected, abs=1e-6)
    assert moved["SceneNodeUpdateMessage /glider/cell1/stack"]["updates"]["scale"][0] != 1.0
