from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import closing

import httpx
import pytest
import websockets

from models.design import Design
from studio.guard import HEADER, KEY
from tests.studio.conftest import Studio, wait_until
from tests.studio.raw_client import RawClient


@pytest.fixture(scope="module")
def opened(studio: Studio) -> Iterator[tuple[httpx.Client, str]]:
    client, session_id = studio.open()
    wait_until(lambda: client.get("state").json()["run"] is not None)
    yield client, session_id
    client.close()


def cookie_of(client: httpx.Client, session_id: str) -> str:
    name = f"gs_{session_id}"
    return f"{name}={client.cookies[name]}"


def socket_url(studio: Studio, session_id: str) -> str:
    return studio.url.replace("http", "ws") + f"/s/{session_id}/view"


def test_the_cookie_is_bound_to_the_session_and_hidden_from_scripts(studio: Studio) -> None:
    with studio.client as client:
        answer = client.post("/sessions", data={"preset": "three-cell-glider"}, headers={"Origin": studio.url})
    assert answer.status_code == 303
    cookie = answer.headers["set-cookie"]
    assert f"Path={answer.headers['location']}" in cookie
    assert "HttpOnly" in cookie
    assert "SameSite=lax" in cookie


@pytest.mark.parametrize(
    "path", ["", "view/", "state", "events", "design.json", "run.csv", "run.nc"], ids=lambda path: path or "page"
)
def test_without_its_cookie_nothing_of_a_session_is_told(
    studio: Studio, opened: tuple[httpx.Client, str], path: str
) -> None:
    with studio.client as stranger:
        assert stranger.get(f"/s/{opened[1]}/{path}").status_code == 403
        assert stranger.get(f"/s/not-a-session/{path}").status_code == 403
        stranger.cookies.set(f"gs_{opened[1]}", "guess")
        assert stranger.get(f"/s/{opened[1]}/{path}").status_code == 403


def test_other_sites_cannot_open_or_change_sessions(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    client, _ = opened
    foreign = {"Origin": "http://evil.example"}
    with studio.client as stranger:
        assert stranger.post("/sessions", data={"preset": "canete-dual-bellows"}, headers=foreign).status_code == 403
        cross = {"Sec-Fetch-Site": "cross-site"}
        assert stranger.post("/sessions", data={"preset": "canete-dual-bellows"}, headers=cross).status_code == 403
        rebound = {"Origin": "http://evil.example:80", "Host": "evil.example:80"}
        assert stranger.post("/sessions", data={"preset": "canete-dual-bellows"}, headers=rebound).status_code == 403
    assert client.post("undo", headers=foreign).status_code == 403
    assert client.post("edit", json={"patch": []}, headers={"Origin": "null"}).status_code == 403


def test_pages_allow_no_foreign_script_and_no_foreign_frame(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    client, _ = opened
    for answer in (client.get(studio.url + "/"), client.get("")):
        policy = answer.headers["content-security-policy"]
        assert answer.status_code == 200
        assert "script-src 'self';" in policy
        assert "frame-ancestors 'none'" in policy
    viewer = client.get("view/")
    policy = viewer.headers["content-security-policy"]
    assert viewer.status_code == 200
    assert "frame-ancestors 'self'" in policy
    assert "'unsafe-eval'" not in policy
    assert viewer.headers["cache-control"] == "no-cache"


@pytest.mark.parametrize("query", ["websocket=ws://evil.example", "playbackPath=http://evil.example/x.viser"])
def test_the_viewer_never_talks_to_another_server(opened: tuple[httpx.Client, str], query: str) -> None:
    assert opened[0].get(f"view/?{query}").status_code == 400


@pytest.mark.parametrize("name", ["__init__.py", "..%2fpyproject.toml", "nothing.js", "%2e%2e%2fserver"])
def test_only_the_pages_own_files_are_served(studio: Studio, name: str) -> None:
    with studio.client as client:
        assert client.get(f"/static/{name}").status_code == 404
        assert client.get("/static/main.js").status_code == 200


def test_the_page_of_somebody_elses_session_says_how_to_go_on(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    with studio.client as stranger:
        answer = stranger.get(f"/s/{opened[1]}/")
    assert answer.status_code == 403 and answer.headers["content-type"].startswith("text/html")
    assert "This session is not yours, or it is over" in answer.text and "Presets and stored designs" in answer.text


def test_presets_have_pictures(studio: Studio) -> None:
    with studio.client as client:
        answer = client.get("/presets/canete-dual-bellows.svg")
        assert answer.headers["content-type"] == "image/svg+xml"
        assert answer.text.startswith("<svg")
        assert "<polyline" in answer.text
        assert client.get("/presets/nothing.svg").status_code == 404


def test_a_document_opens_a_session_and_a_wrong_one_is_told_why(studio: Studio, dual_bellows: Design) -> None:
    document = dual_bellows.model_dump(mode="json")
    with studio.client as client:
        answer = client.post("/sessions", json=document)
        assert answer.status_code == 201
        assert answer.json()["url"].startswith("/s/")
        document["mission"]["duration"] = -1.0
        wrong = client.post("/sessions", json=document)
        assert wrong.status_code == 422
        assert wrong.headers["content-type"] == "application/problem+json"
        assert wrong.json()["errors"][0]["pointer"] == "/mission/duration"
        assert client.post("/sessions", data={"preset": "none"}).status_code == 404
        assert client.post("/sessions", content=b"x", headers={"content-type": "text/plain"}).status_code == 415


def test_edits_undo_files_and_state_agree(studio: Studio) -> None:
    client, session_id = studio.open()
    with closing(client):
        patch = [{"op": "replace", "path": "/vehicle/components/1/position/0", "value": 0.17}]
        revision = client.post("edit", json={"patch": patch}).json()["revision"]
        wait_until(lambda: (s := client.get("state").json())["run"] is not None and not s["simulating"])
        state = client.get("state").json()
        assert state["revision"] == revision
        assert state["can_undo"] and not state["can_redo"]
        assert {len(column) for column in state["run"]["columns"].values()} == {len(state["run"]["columns"]["t"])}
        assert len(state["run"]["columns"]["t"]) <= 800
        assert client.get("design.json").json()["vehicle"]["components"][1]["position"][0] == 0.17
        assert client.get("run.csv").text.startswith("t [s],x [m],")
        assert client.get("run.nc").content[:8] == b"\x89HDF\r\n\x1a\n"
        assert client.post("undo").status_code == 200
        assert client.post("undo").status_code == 409
        assert client.post("redo").status_code == 200
        found = studio.sessions.get(session_id)
        assert found is not None
        assert found.design.vehicle.components[1].position[0] == 0.17


def test_edits_of_one_gesture_are_one_step_of_undo_however_slow(studio: Studio) -> None:
    client, _ = studio.open()
    with closing(client):
        before = client.get("design.json").text
        for length in (15.0, 16.0, 17.0):
            patch = [{"op": "replace", "path": "/mission/duration", "value": length}]
            assert client.post("edit", json={"patch": patch, "gesture": "a drag"}).status_code == 200
            patch[0] |= {"path": "/name", "value": f"Dragged to {length:g}"}  # other fields: no merging by those
            assert client.post("edit", json={"patch": patch, "gesture": "a drag"}).status_code == 200
        client.post("undo")
        assert client.get("design.json").text == before
        refused = client.post("edit", json={"patch": [], "gesture": 3})
        assert refused.status_code == 422 and refused.json()["errors"][0]["pointer"] == "/gesture"


def test_a_refused_edit_is_told_and_the_last_good_glide_stays(studio: Studio) -> None:
    client, _ = studio.open()
    with closing(client):
        wait_until(lambda: client.get("state").json()["run"] is not None)
        wrong = client.post("edit", json={"patch": [{"op": "replace", "path": "/mission/duration", "value": 0}]})
        assert wrong.status_code == 422
        state = client.get("state").json()
        assert state["problem"]["errors"][0]["pointer"] == "/mission/duration"
        assert state["run"]["status"] == "completed"
        document = client.get("design.json").json() | {"version": 99}
        assert client.put("design", json=document).status_code == 422
        assert client.get("state").json()["problem"]["errors"][0]["pointer"] == "/version"
        assert client.post("edit", content=b"{", headers={"content-type": "application/json"}).status_code == 400
        for view in ("inside", [], {}, 3, None):
            assert client.post("camera", json={"view": view}).status_code == 422
        for covered in (-0.1, 0.9, True, "half", None):
            assert client.post("camera", json={"view": "overview", "covered": covered}).status_code == 422
        assert client.post("select", json={"component": 99}).status_code == 422


def test_the_stream_tells_of_each_change(opened: tuple[httpx.Client, str]) -> None:
    client, _ = opened
    with client.stream("GET", "events") as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        lines = answer.iter_lines()
        assert next(lines) == "event: state"
        first = json.loads(next(lines).removeprefix("data: "))
        assert first["selected"] != 2
        editor = threading.Thread(target=lambda: client.post("select", json={"component": 2}))
        editor.start()
        data = (json.loads(line[6:]) for line in lines if line.startswith("data: "))
        second = next(sent for sent in data if sent.get("selected") == 2)
        editor.join()
    asked = client.get("state").json()
    assert second["run"]["number"] == asked["run"]["number"] and set(second) == set(asked)


async def handshake(url: str, **options: object) -> int:
    try:
        async with websockets.connect(url, proxy=None, **options):  # type: ignore[arg-type]
            return 101
    except websockets.InvalidStatus as error:
        return error.response.status_code


def test_the_websocket_demands_cookie_and_own_origin(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    client, session_id = opened
    url, cookie = socket_url(studio, session_id), {"Cookie": cookie_of(client, session_id)}

    async def answers() -> list[int]:
        return [
            await handshake(url),
            await handshake(url, additional_headers=cookie),
            await handshake(url, origin="http://evil.example", additional_headers=cookie),
            await handshake(url, origin=studio.url),
            await handshake(url, origin=studio.url, additional_headers=cookie),
        ]

    assert asyncio.run(answers()) == [403, 403, 403, 403, 101]


def test_the_raw_port_answers_only_the_proxy(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    found = studio.sessions.find(opened[1])
    assert found is not None
    server = found.view().server
    port = server.get_port()
    assert server.get_host() == "127.0.0.1"
    assert server.request_share_url() is None

    async def answers() -> list[int]:
        url = f"ws://127.0.0.1:{port}/"
        return [
            await handshake(url),
            await handshake(url, origin=studio.url, additional_headers={HEADER: "guess"}),
            await handshake(url, additional_headers={HEADER: KEY}),
        ]

    assert asyncio.run(answers()) == [403, 403, 101]
    # the client's page, too: a plain GET of the raw port has no key
    assert httpx.get(f"http://127.0.0.1:{port}/", trust_env=False).status_code == 403


def test_a_client_that_asks_for_a_tunnel_gets_none(studio: Studio, opened: tuple[httpx.Client, str]) -> None:
    client, session_id = opened

    async def ask() -> None:
        url, cookie = socket_url(studio, session_id), cookie_of(client, session_id)
        async with RawClient(url, cookie=cookie, origin=studio.url) as browser:
            await browser.send(type="ShareUrlRequest")
            await asyncio.sleep(0.3)
            assert all(m.get("share_url") is None for m in browser.messages if m["type"] == "ShareUrlUpdated")

    asyncio.run(ask())
    found = studio.sessions.find(session_id)
    assert found is not None
    assert found.view().server._share_tunnel is None
