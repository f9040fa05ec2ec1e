"""What the 3D scene draws: colours of the path, cells that breathe, currents, ghosts, and parts that are hidden."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from models.components import Bladder, Piston
from models.design import Design
from models.environment import ShearedCurrent, TabulatedCurrent, UniformCurrent
from models.presets import load_preset
from models.problems import DesignError
from models.run import Run
from models.simulate import simulate
from studio import palette
from studio.bodies import SMALLEST_STRETCH, bodies, breath, drawn_length, pleat
from studio.curves import MAX_POINTS, curve_samples
from studio.path_colors import Scale, colors_of, linear, quantities_of, scale_of
from studio.scene import vehicle_length
from studio.scene_current import LONGEST, current_arrows, current_at
from studio.scene_display import Display, changed
from studio.scene_ghost import LARGER, silhouette
from studio.scene_markers import MOMENTS
from studio.session import Session
from studio.view import CAMERAS, FAR, FOG, View
from studio.water import points_at, segment_colors
from tests.studio.conftest import Studio, wait_until
from tests.studio.raw_client import RawClient
from tests.studio.test_wire import browse


@pytest.fixture(scope="module")
def run(kernel: None) -> Run:
    return simulate(load_preset("canete-dual-bellows"))


@pytest.fixture
def view(session: Session) -> Iterator[View]:
    made = View(session)
    yield made
    made.close()


def luminance(color: str) -> float:
    """Return the relative luminance of #rrggbb (WCAG 2.1)."""
    share = np.array(palette.rgb(color)) / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return float(light @ (0.2126, 0.7152, 0.0722))


def test_the_scale_rises_in_lightness_and_stands_out_from_the_water() -> None:
    light = [luminance(color) for color in palette.PATH_SCALE]
    assert light == sorted(light), "order must be seen without colours"
    assert (light[0] + 0.05) / (luminance(palette.WATER_BOTTOM) + 0.05) > 3.0


def test_a_value_has_the_colour_of_its_place_on_the_scale() -> None:
    scale = Scale("speed", "m/s", 1.0, 3.0, below=True, above=False)
    shown = colors_of(np.array([0.0, 1.0, 2.0, 3.0, np.nan]), scale)
    first, last = (palette.rgb(palette.PATH_SCALE[k]) for k in (0, -1))
    assert shown[0].tolist() == shown[1].tolist() == list(first)
    assert shown[3].tolist() == list(last)
    middle = np.mean([palette.rgb(palette.PATH_SCALE[k]) for k in (2, 3)], axis=0)
    assert shown[2] == pytest.approx(middle, abs=0.5)
    assert shown[4].tolist() == shown[2].tolist(), "what is not a number stands in the middle"


def test_the_client_gets_light_and_not_channels() -> None:
    # the ends are fixed; 188 of 255 is half the light
    assert linear(np.array([0, 255, 188])).tolist() == [0, 255, 128]


def test_a_rare_value_does_not_take_the_colours_from_the_glide(run: Run) -> None:
    speed = scale_of(run, "speed")
    assert speed is not None
    assert (speed.low, speed.high) == (run.values["speed"].min(), run.values["speed"].max())
    attack = scale_of(run, "alpha")
    assert attack is not None
    # it starts at right angles to the flow, and for most of the glide moves along it
    assert run.values["alpha"].max() == pytest.approx(math.pi / 2.0, abs=0.01)
    assert attack.unit == "rad"
    assert scale_of(run, "phi") is None and scale_of(run, None) is None
    assert [q["name"] for q in quantities_of(run)] == ["z", "speed", "alpha", "theta", "net_buoyancy"]


def test_outliers_are_told_to_lie_beyond() -> None:
    design = load_preset("canete-dual-bellows")
    values = np.concatenate([np.linspace(1.0, 2.0, 1000), [50.0]])
    made = simulate(design)
    changed_run = Run(
        design, np.arange(1001.0), {**made.values, "speed": values}, made.cells, made.cell_values, made.status,
        made.events, made.statistics, made.kernel,
    )  # fmt: skip
    scale = scale_of(changed_run, "speed")
    assert scale is not None and scale.above and scale.below
    assert 1.0 < scale.low < scale.high < 2.1


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [
        ((1.4e-16, 0.5, 2.0), 0.0, 2.0),  # what sums leave over
        ((-2.0, -0.5, -1.4e-16), -2.0, 0.0),
        ((-3e-17, 0.0, 1.4e-16), 0.0, 0.0),
        ((5.0, 5.0 + 1e-10, 5.0 - 1e-10), 5.0 - 1e-10, 5.0 - 1e-10),
        ((1e-6, 2e-6, 3e-6), 1e-6, 3e-6),  # little, yet there
    ],
)
def test_rounding_errors_are_no_end_of_a_scale_and_no_colours(
    run: Run, values: tuple[float, ...], low: float, high: float
) -> None:
    drawn = np.resize(values, len(run.times))
    changed_run = replace(run, values={**run.values, "net_buoyancy": drawn})
    scale = scale_of(changed_run, "net_buoyancy")
    assert scale is not None and (scale.low, scale.high) == (low, high)
    assert len(np.unique(colors_of(drawn, scale), axis=0)) == (1 if low == high else len(values))


def test_each_segment_of_the_path_has_the_colours_of_its_ends(run: Run) -> None:
    chosen = curve_samples(run, MAX_POINTS["planar"])
    scale = scale_of(run, "z")
    shown = segment_colors(run, chosen, scale)
    assert shown.shape == (len(points_at(run, chosen)) - 1, 2, 3)
    assert (shown[:-1, 1] == shown[1:, 0]).all(), "one segment ends as the next begins"
    plain = segment_colors(run, chosen, None)
    assert plain.shape == shown.shape and len(np.unique(plain.reshape(-1, 3), axis=0)) == 1


def test_a_bellows_pleats_flatten_as_it_stretches(dual_bellows: Design) -> None:
    part = dual_bellows.vehicle.components[1]
    sizes, length = pleat(part), drawn_length(part)
    assert sizes is not None and length is not None
    half, depth, radius = sizes
    assert breath(part, 0.0) == pytest.approx((1.0, 1.0, 1.0))
    for growth in (-0.002, 0.001, 0.002):
        along, across, same = breath(part, growth)
        assert across == same
        assert along == pytest.approx(1.0 + growth / length)
        # each side of a pleat keeps its length
        left = across * radius - (radius - depth)
        assert math.hypot(along * half, left) == pytest.approx(math.hypot(half, depth), rel=1e-9)
    assert breath(part, -10.0)[0] == SMALLEST_STRETCH


def test_a_bladder_swells_all_round_and_a_piston_only_gets_longer() -> None:
    three = {type(c): c for c in load_preset("three-cell-glider").vehicle.components}
    along, across, _ = breath(three[Piston], 0.01)
    assert (along > 1.0, across) == (True, 1.0)
    bladder = Bladder(
        kind="bladder", name="Bladder", mass=0.05, position=(0.0, 0.0, 0.0), extensions=(0.0, 0.01, 0.02),
        volumes=(1e-5, 2e-5, 3e-5), neutral_extension=0.01, rate_limit=0.002,
    )  # fmt: skip
    length = drawn_length(bladder)
    assert length is not None
    x, y, z = breath(bladder, 0.5 * length)
    assert x == y == z
    assert x**3 == pytest.approx(1.5), "its volume grows as the length of anything else would"


def test_the_current_is_that_of_the_table() -> None:
    depths = np.array([0.0, 10.0, 40.0])
    uniform = UniformCurrent(kind="uniform", velocity=(0.1, -0.2))
    assert current_at(uniform, depths) == pytest.approx(np.tile([0.1, -0.2], (3, 1)))
    sheared = ShearedCurrent(kind="sheared", surface_velocity=(0.1, 0.0), shear=(0.0, 0.01))
    assert current_at(sheared, depths) == pytest.approx(np.array([(0.1, 0.0), (0.1, 0.1), (0.1, 0.4)]))
    table = TabulatedCurrent(
        kind="tabulated", depths=(0.0, 10.0, 20.0), times=(0.0, 100.0),
        north=((0.1, 0.2, 0.3), (9.0, 9.0, 9.0)), east=((0.0, 0.0, -0.1), (9.0, 9.0, 9.0)),
    )  # fmt: skip
    # at the start of the mission; held below the last level
    assert current_at(table, depths) == pytest.approx(np.array([(0.1, 0.0), (0.2, 0.0), (0.3, -0.1)]))


def test_arrows_of_the_current_point_its_way_at_the_depths_they_name() -> None:
    path = np.column_stack([np.linspace(0.0, 50.0, 100), np.zeros(100), np.linspace(1.0, 40.0, 100)])
    sheared = ShearedCurrent(kind="sheared", surface_velocity=(0.0, 0.2), shear=(0.0, -0.005))
    drawn = current_arrows(sheared, path, 2.0)
    ways = drawn.arrows[:, 1] - drawn.arrows[:, 0]
    assert ways[0] == pytest.approx((0.0, 2.0 * LONGEST, 0.0), abs=1e-6), "the strongest is as long as it gets"
    fastest = 0.2 - 0.005 * drawn.arrows[0, 0, 2]
    for tail, way, (text, place) in zip(drawn.arrows[:, 0], ways, drawn.labels, strict=True):
        speed = 0.2 - 0.005 * tail[2]
        assert way == pytest.approx((0.0, 2.0 * LONGEST * speed / fastest, 0.0), abs=1e-5)
        assert float(text.removesuffix(" m/s")) == pytest.approx(speed, rel=0.06), "two digits"
        assert place == pytest.approx(tail, abs=1e-5)
    assert len(current_arrows(None, path, 2.0).arrows) == 0
    assert len(current_arrows(UniformCurrent(kind="uniform", velocity=(0.0, 0.0)), path, 2.0).arrows) == 0


def test_the_silhouette_is_the_vehicle(dual_bellows: Design) -> None:
    parts = dual_bellows.vehicle.components
    whole = silhouette(parts)
    assert len(whole.faces) == sum(len(body.mesh.faces) for part in parts for body in bodies(part))
    assert whole.faces.max() == len(whole.vertices) - 1
    assert LARGER > 1.0
    assert silhouette(()).vertices.shape == (0, 3)


def test_a_kept_run_flies_along_as_a_ghost(session: Session, view: View) -> None:
    kept = session.keep_run("Before")
    session.show(Display("z", kept.id))
    wait_until(lambda: len(view.ghost._nodes) == 2)
    frame, path = view.ghost._nodes
    assert path.colors.tolist() == list(palette.rgb(palette.KEPT[kept.place]))
    session.set_field("/vehicle/components/1/position/0", 0.15)
    wait_until(lambda: not session.simulating)
    view.set_clock(12.0)
    run = session.run
    assert run is not None
    here = [np.interp(12.0, kept.run.times, kept.run.values[name]) for name in ("x", "z")]
    glider = [np.interp(12.0, run.times, run.values[name]) for name in ("x", "z")]
    assert np.array(frame.position)[[0, 2]] == pytest.approx(np.subtract(here, glider), abs=1e-9)
    session.forget_run(kept.id)
    wait_until(lambda: view.ghost._nodes == [])


def test_a_hidden_part_is_not_drawn(session: Session, view: View) -> None:
    session.mark(2, hidden=True)
    wait_until(lambda: not view.glider._parts[2]._frame.visible)
    assert view.glider._parts[1]._frame.visible
    session.mark(2, hidden=False)
    wait_until(lambda: view.glider._parts[2]._frame.visible)


def test_the_colours_of_the_path_follow_the_choice(session: Session, view: View) -> None:
    before = np.array(view.water._path.colors)
    session.show(Display(None, None))
    wait_until(lambda: not np.array_equal(view.water._path.colors, before))
    assert len(np.unique(np.array(view.water._path.colors).reshape(-1, 3), axis=0)) == 1


def test_moments_are_about_the_axes_they_are_positive_about(view: View) -> None:
    assert list(MOMENTS) == ["roll", "pitch", "yaw"]
    assert np.array(list(MOMENTS.values())) == pytest.approx(np.eye(3))
    assert not any(node.visible for node in view.markers._moments.values()), "pages show them as they are asked to"


@pytest.mark.parametrize(
    ("document", "pointer"),
    [
        ({}, ""),
        ({"color": 1}, ""),
        ({"color_by": "mood"}, "/color_by"),
        ({"ghost": 3}, "/ghost"),
        ({"ghost": "x" * 41}, "/ghost"),
        ([], ""),
    ],
)
def test_a_display_that_makes_no_sense_is_refused(document: object, pointer: str) -> None:
    with pytest.raises(DesignError) as refused:
        changed(Display(), document)
    assert refused.value.problems[0].pointer == pointer
    assert refused.value.problems[0].hint


def test_the_page_chooses_and_is_told(studio: Studio) -> None:
    client, _ = studio.open()
    with closing(client):
        wait_until(lambda: client.get("state").json()["run"] is not None)
        headers = {"Origin": studio.url}
        assert client.post("display", json={"color_by": "z"}, headers=headers).status_code == 204
        scene = client.get("state").json()["scene"]
        assert scene["color_by"] == "z"
        assert scene["path"]["label"] == "Depth" and scene["path"]["unit"] == "m"
        assert scene["path"]["low"] < scene["path"]["high"]
        client.post("display", json={"color_by": "none"}, headers=headers)
        assert client.get("state").json()["scene"]["path"] is None
        refused = client.post("shown", json={"wxyz": [1, 1, 0, 0]}, headers=headers)
        assert refused.status_code == 422
        assert "length 1.41" in json.dumps(refused.json())
        assert client.post("shown", json={"wxyz": [1, 0, 0, 0]}, headers=headers).status_code == 204


def test_page_and_server_name_colours_alike() -> None:
    tokens = (Path(palette.__file__).parents[1] / "static" / "tokens.css").read_text()
    dark = tokens.split("@media")[0]
    for place, color in enumerate(palette.KEPT, start=1):
        series = dark.split(f"--kept-{place}: var(--")[1].split(")")[0]
        assert f"--{series}: {color};" in dark
    scene = (Path(palette.__file__).parents[1] / "static" / "scene.css").read_text()
    for color in (palette.MOMENT, palette.CENTER_OF_MASS, palette.CENTER_OF_BUOYANCY):
        assert color in scene


def test_the_water_hides_what_is_far_off_in_the_ordinary_view(studio: Studio) -> None:
    async def look(browser: RawClient) -> dict[str, Any]:
        return await browser.wait_for(lambda m: m["type"] == "FogMessage")

    fog, _ = browse(studio, look)
    assert fog["enabled"] is True
    assert tuple(fog["color"]) == palette.rgb(palette.FOG)
    length = vehicle_length(load_preset("canete-dual-bellows"))
    farthest = max(np.linalg.norm(place) for name, place in CAMERAS.items() if name != "free") + 0.5
    assert farthest * length < fog["near"] < fog["far"] < FAR, "the whole vehicle is clear, and no edge is seen"


def test_the_water_clears_for_the_overview(studio: Studio) -> None:
    async def look(browser: RawClient) -> list[dict[str, Any]]:
        await browser.wait_for(lambda m: m["type"] == "FogMessage")
        opened = studio.sessions.find(browser.session_id)
        assert opened is not None
        await asyncio.to_thread(wait_until, lambda: bool(opened.view().server.get_clients()))
        for view in ("overview", "side"):
            heard = len(browser.messages)
            await asyncio.to_thread(opened.view().camera, view)
            await browser.wait_for(lambda m: m["type"] == "FogMessage", after=heard)
        return [m for m in browser.messages if m["type"] == "FogMessage"]

    (near, far, again), _ = browse(studio, look)
    length = vehicle_length(load_preset("canete-dual-bellows"))
    assert (near["near"], near["far"]) == pytest.approx((FOG[0] * length, FOG[1] * length))
    assert far["near"] > near["near"] and far["far"] > near["far"]
    assert (again["near"], again["far"]) == (near["near"], near["far"])


def test_another_design_of_another_size_is_framed_anew(studio: Studio) -> None:
    larger = load_preset("quad-bellows-glide")

    async def look(browser: RawClient) -> list[dict[str, Any]]:
        await browser.wait_for(lambda m: m["type"] == "FogMessage")
        opened = studio.sessions.find(browser.session_id)
        assert opened is not None
        await asyncio.to_thread(wait_until, lambda: bool(opened.view().server.get_clients()))
        heard = len(browser.messages)
        await asyncio.to_thread(opened.session.replace, larger)
        for kind in ("FogMessage", "SetCameraPositionMessage"):
            await browser.wait_for(lambda m, kind=kind: m["type"] == kind, after=heard)
        return browser.messages[heard:]

    messages, _ = browse(studio, look)
    length = vehicle_length(larger)
    assert length > 2.0 * vehicle_length(load_preset("canete-dual-bellows"))
    fogs = [m for m in messages if m["type"] == "FogMessage"]
    assert (fogs[-1]["near"], fogs[-1]["far"]) == pytest.approx((FOG[0] * length, FOG[1] * length))
    (camera,) = (m for m in messages if m["type"] == "SetCameraPositionMessage")
    assert np.linalg.norm(camera["position"]) > length, "the whole of it is in the picture"
