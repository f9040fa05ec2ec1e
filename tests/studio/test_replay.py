"""Replays as one file: all that they need is inside, small enough, and no text of a design escapes its place."""

from __future__ import annotations

import base64
import json
import re
import threading

import pytest

from models.presets import load_preset
from models.problems import DesignError
from studio import replay
from studio.replay import MOST_BYTES, replay_html
from studio.session import Change, Session
from studio.source_range import range_in_short


@pytest.fixture(scope="module")
def flown(kernel):
    """A session on a spatial preset with a hostile name, whose glide is there."""
    design = load_preset("quad-bellows-spiral").model_copy(update={"name": "</script><script>alert(1)</script>"})
    session, done = Session("replay", design), threading.Event()
    session.subscribe(lambda change: done.set() if change is Change.run else None)
    assert session.run is not None or done.wait(120)
    yield session
    session.close()


def modules_of(page: str) -> dict[str, str]:
    found = re.search(r'<script type="importmap">(.*?)</script>', page)
    assert found
    imports = json.loads(found[1])["imports"]
    return {name: base64.b64decode(address.split(",", 1)[1]).decode() for name, address in imports.items()}


def test_a_replay_is_one_small_file_with_all_modules_inside(flown):
    page = replay_html(flown)
    assert len(page.encode()) <= MOST_BYTES
    modules = modules_of(page)
    for text in modules.values():
        imported = re.findall(r'from "([^"]+)"', text)
        assert set(imported) <= set(modules)
    assert "studio/replay.js" in modules and "studio/scene.js" in modules
    assert "__VISER_EMBED_DATA__" in page


def test_the_name_of_a_design_stays_text(flown):
    page = replay_html(flown)
    assert "<script>alert" not in page
    data = re.search(r'<script type="application/json" id="replay-data">(.*?)</script>', page)
    assert data and json.loads(data[1])["name"] == flown.design.name


def test_a_replay_knows_the_colours_of_its_path(flown):
    data = re.search(r'<script type="application/json" id="replay-data">(.*?)</script>', replay_html(flown))
    assert data
    scene = json.loads(data[1])["scene"]
    assert set(scene) == {"path", "path_colors"}
    assert scene["path"]["unit"] == "m/s" and scene["path"]["low"] < scene["path"]["high"]
    assert "studio/pathlegend.js" in modules_of(replay_html(flown))


def test_a_replay_tells_nothing_of_the_session(flown):
    assert "origin" not in replay.SHOWN and "id" not in replay.SHOWN
    assert '"origin"' not in replay_html(flown)


def test_a_file_that_would_be_too_large_is_refused(flown, monkeypatch):
    monkeypatch.setattr(replay, "MOST_BYTES", 1000)
    with pytest.raises(DesignError, match="the replay would have"):
        replay_html(flown)


def test_each_kind_of_source_says_its_range():
    said = {
        p: range_in_short(load_preset(p).vehicle.hydrodynamics) for p in ("canete-dual-bellows", "quad-bellows-spiral")
    }
    assert said["canete-dual-bellows"] == "α ±90°, 0.1–0.5 m/s"
    assert all("°" in text for text in said.values())
