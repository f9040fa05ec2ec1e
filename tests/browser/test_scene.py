"""A designer's journeys in the 3D view: what is drawn where, what it is called, and parts moved by hand."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Frame, Page, expect

from models.design import loads_design
from models.presets import load_preset
from models.simulate import simulate
from studio.attitude import attitude_at, rotate
from studio.bodies import breath
from studio.path_colors import scale_of
from studio.scene import vehicle_length
from studio.view import FOG
from tests.browser.studio_page import StudioPage, document_of

pytestmark = pytest.mark.browser

SIGHT = """(points) => {
  const m = window.__viserMutable;
  const [w, h] = [m.canvas.clientWidth, m.canvas.clientHeight];
  return points.map(([name, place]) => {
    const at = m.nodeRefFromName[name].localToWorld(m.camera.position.clone().set(...place)).project(m.camera);
    return [((at.x + 1) / 2) * w, ((1 - at.y) / 2) * h];
  });
}"""
"""Where points of nodes, in the nodes' own axes, are on the client's canvas, px from its top left corner."""


def view_of(page: Page) -> Frame:
    return next(f for f in page.frames if "/view/" in f.url)


def on_canvas(studio: StudioPage, *points: tuple[str, tuple[float, float, float]]) -> np.ndarray:
    """Return where points of nodes are seen, (n, 2) px to the right and down."""
    return np.array(view_of(studio.page).evaluate(SIGHT, [[name, list(place)] for name, place in points]))


def node(studio: StudioPage, name: str, what: str) -> Any:
    """Return a member of a node as the client's tree has it, such as visibility, or a property of its message."""
    tree = "window.__viserSceneTree.getState()"
    return view_of(studio.page).evaluate(f"() => {tree}['{name}']?.{what}")


def design_of(studio: StudioPage) -> Any:
    answer = studio.page.request.get(studio.url.split("?")[0] + "design.json")
    return loads_design(answer.text())


@pytest.fixture
def quad(reopened) -> StudioPage:
    document = document_of("quad-bellows-glide")
    document["mission"]["duration"] = 60.0
    return reopened(document)


def test_pleats_breathe_as_the_server_would_draw_them(studio):
    design = design_of(studio)
    run, part = simulate(design), design.vehicle.components[1]
    k = run.cells.index(part.name)
    for t, times in ((6.0, 10.0), (18.0, 20.0)):
        studio.page.get_by_test_id("display").click()
        studio.page.get_by_test_id("exaggeration").select_option(f"{times:g}")
        studio.page.keyboard.press("Escape")
        studio.seek(t)
        extension = float(np.interp(t, run.times, run.cell_values["extension"][:, k]))
        expected = breath(part, times * (extension - part.neutral))
        assert expected[1] != 1.0, "the pleats are not at rest"
        studio.wait_until(
            lambda wanted=expected: (
                node(studio, "/glider/cell1/stack", "message.props.scale") == pytest.approx(wanted, abs=1e-4)
            )
        )


def test_the_path_has_the_colours_of_its_legend(studio):
    page = studio.page
    run = simulate(design_of(studio))
    for name, words in (("z", "m"), ("theta", "°")):
        before = node(studio, "/world/path", "message.props.colors")
        page.get_by_test_id("color-by").select_option(name)
        studio.wait_until(lambda was=before: node(studio, "/world/path", "message.props.colors") != was)
        scale = scale_of(run, name)
        assert scale is not None
        expect(page.get_by_test_id("path-unit")).to_have_text(words)
        shown = page.evaluate("() => window.__studio.state.scene.path")
        assert (shown["low"], shown["high"]) == pytest.approx((scale.low, scale.high))
        low = page.get_by_test_id("path-low").inner_text().replace("\N{MINUS SIGN}", "-").lstrip("≤ ")
        factor = 1.0 if words == "m" else math.degrees(1.0)
        assert float(low) == pytest.approx(factor * scale.low, abs=0.06 * abs(factor * (scale.high - scale.low)))
    page.get_by_test_id("color-by").select_option("none")
    expect(page.locator("#path-scale")).to_be_hidden()


def test_the_offset_of_the_centres_is_drawn_to_scale_and_told_in_millimetres(studio):
    page = studio.page
    studio.seek(6.0)
    run = simulate(design_of(studio))
    center = {
        name: np.array([np.interp(6.0, run.times, run.values[f"{name}_{axis}"]) for axis in "xz"])
        for name in ("com", "cob")
    }
    offset = center["com"] - center["cob"]
    page.get_by_test_id("display").click()
    for times in (1, 100):
        page.get_by_test_id("offset-scale").select_option(str(times))
        expected = center["cob"] + times * offset
        studio.wait_until(
            lambda wanted=expected: (
                np.array(studio.pose("/glider/com")["position"])[[0, 2]] == pytest.approx(wanted, abs=1e-5)
            )
        )
        length = node(studio, "/glider/cob/offset_starboard", "message.props.scale")[0]
        assert length == pytest.approx(times * np.linalg.norm(offset), rel=1e-3)
    shown = float(page.get_by_test_id("center-offset").inner_text().removesuffix(" mm"))
    assert shown == pytest.approx(1e3 * np.linalg.norm(offset), abs=0.006)
    expect(page.get_by_test_id("center-scale")).to_have_text("drawn ×100")


def test_moments_are_shown_when_asked_for_and_named_with_their_unit(turning):
    page = turning.page
    turning.seek(250.0)
    assert node(turning, "/glider/moment_roll", "visibility") is False
    page.get_by_test_id("toggle-moments").click()
    for name, column in (("roll", "hydro_K"), ("pitch", "moment"), ("yaw", "hydro_N")):
        turning.wait_until(lambda of=name: node(turning, f"/glider/moment_{of}", "visibility") is True)
        expect(page.get_by_test_id(f"moment-{name}")).to_contain_text("N m")
        value = page.evaluate(
            f"() => (({{ t, {column}: v }}, i) => v[i])"
            "(window.__studio.state.run.columns, window.__studio.state.run.columns.t.findIndex((t) => t >= 250))"
        )
        shown = page.get_by_test_id(f"moment-{name}").inner_text().removesuffix(" N m").replace("\N{MINUS SIGN}", "-")
        assert float(shown) == pytest.approx(value, rel=0.05, abs=0.02)
        # the arrow turns about its axis, the way that the sign says
        axis = rotate(np.array([[1.0, 0.0, 0.0]]), tuple(turning.pose(f"/glider/moment_{name}")["wxyz"]))[0]
        expected = np.eye(3)[("roll", "pitch", "yaw").index(name)] * np.sign(value)
        assert axis == pytest.approx(expected, abs=1e-6)


def test_positive_roll_lowers_the_starboard_wing_on_screen(turning):
    page = turning.page
    # the other way round than the published spiral: its mass swings to starboard
    turning.edit({"op": "replace", "path": "/mission/control/schedules/0/points/0/extension", "value": -0.7})
    turning.wait_until(lambda: turning.readout("end-roll") > math.radians(5.0))
    page.get_by_test_id("camera-chase").click()
    turning.seek(250.0)
    turning.wait_until(lambda: turning.readout("roll") > math.radians(5.0))
    tips = [("/glider", (0.0, side, 0.0)) for side in (-0.6, 0.6)]

    def banked() -> bool:
        port, starboard = on_canvas(turning, *tips)
        # seen from behind: starboard is to the right, and lower
        return starboard[0] > port[0] + 20.0 and starboard[1] > port[1] + 2.0

    turning.wait_until(banked)
    port, starboard = on_canvas(turning, *tips)
    bank = math.atan2(starboard[1] - port[1], starboard[0] - port[0])
    # the camera stands above: perspective leaves the bank about as steep as it is
    assert bank == pytest.approx(turning.readout("roll"), rel=0.35)


def test_the_compass_and_the_bar_follow_the_camera(turning):
    page = turning.page
    page.get_by_test_id("camera-chase").click()
    turning.seek(250.0)
    turning.wait_until(lambda: abs(turning.readout("heading")) > 0.2)
    heading = round(math.degrees(turning.readout("heading"))) % 360
    compass = page.get_by_test_id("compass")

    def looks_ahead() -> bool:
        shown = int((compass.get_attribute("aria-label") or "Looking -1").split(" ")[1].rstrip("°"))
        return abs((shown - heading + 180) % 360 - 180) <= 2

    turning.wait_until(looks_ahead)
    page.keyboard.press("1")
    expect(page.get_by_test_id("camera-side")).to_have_attribute("aria-pressed", "true")
    # from starboard, across the way
    turning.wait_until(lambda: page.evaluate("() => window.__studio.view.camera") == "side")

    def bar_is_true() -> bool:
        number, unit = page.get_by_test_id("scale-length").inner_text().split(" ")
        length = float(number) * {"mm": 1e-3, "m": 1.0, "km": 1e3}[unit]
        width = page.locator("#scale-bar").bounding_box()["width"]
        return width == pytest.approx(view_of(page).evaluate(ACROSS, length), rel=0.05)

    turning.wait_until(bar_is_true)


def labels_in_sight(studio: StudioPage) -> list[str]:
    """Return the labels in the water that are shown."""
    tree = "Object.entries(window.__viserSceneTree.getState())"
    test = "/^\\/world\\/(rungs|grid|room)\\/label/.test(name) && (node.visibility ?? true)"
    found: list[str] = view_of(studio.page).evaluate(f"() => {tree}.filter(([name, node]) => {test}).map(([n]) => n)")
    return found


def test_depths_in_the_water_never_lie_over_each_other(turning):
    turning.seek(100.0)
    for camera in ("chase", "top", "side"):
        turning.page.get_by_test_id(f"camera-{camera}").click()

        def apart() -> bool:
            shown = labels_in_sight(turning)
            world = {name: turning.pose(name)["position"] for name in shown}
            at = (
                on_canvas(turning, *(("/world", tuple(place)) for place in world.values()))
                if shown
                else np.empty((0, 2))
            )
            gaps = np.abs(at[:, None] - at[None])[np.triu_indices(len(at), 1)]
            return 0 < len(shown) <= 12 and bool(((gaps[:, 0] > 40.0) | (gaps[:, 1] > 14.0)).all())

        turning.wait_until(apart)
    turning.page.get_by_test_id("camera-overview").click()
    turning.wait_until(lambda: sum(name.startswith("/world/room") for name in labels_in_sight(turning)) > 4)


OUTLINES = """() => {
  const found = new Set();
  window.__viserMutable.scene.traverse(({ material }) => {
    for (const one of [material].flat()) if (one?.uniforms?.screenspace) found.add(one.fog === false);
  });
  return [...found];
}"""
"""Whether the outlines, which are told by a uniform of theirs, do without fog."""
ACROSS = """length => {
  const { nodeRefFromName, camera, canvas } = window.__viserMutable;
  const place = nodeRefFromName["/glider"].getWorldPosition(camera.position.clone());
  const above = place.clone().addScaledVector(camera.up.clone().setFromMatrixColumn(camera.matrixWorld, 1), length);
  const [low, high] = [place, above].map((point) => point.project(camera).y);
  return ((high - low) / 2) * canvas.clientHeight;
}"""
"""How long something at the glider, across the line of sight, is in the picture, px."""
PANEL = re.compile("connected|connecting|ws://|save canvas|reset view|dev settings|scene tree", re.IGNORECASE)
"""What stands on the control panel of Viser's client."""


def test_nothing_of_the_viewers_own_panel_lies_over_the_scene(studio):
    for width in (1400, 390):  # the panel of a narrow window is another element
        studio.page.set_viewport_size({"width": width, "height": 844})
        studio.scene(f"() => (innerWidth > 576) === {str(width > 576).lower()}")
        words = view_of(studio.page).get_by_text(PANEL)
        studio.wait_until(lambda found=words: found.count() >= 3)
        studio.wait_until(lambda found=words: all(found.nth(k).bounding_box() is None for k in range(found.count())))


def test_keys_choose_where_to_look_from(studio):
    page = studio.page
    for key, camera in (("2", "top"), ("5", "overview"), ("4", "free"), ("3", "chase"), ("1", "side")):
        page.keyboard.press(key)
        expect(page.get_by_test_id(f"camera-{camera}")).to_have_attribute("aria-pressed", "true")
        assert page.evaluate("() => window.__studio.view.camera") == camera


def test_a_kept_glide_flies_along_as_a_ghost(studio):
    page = studio.page
    studio.ask("post", "runs", {"name": "Before"})
    studio.wait_until(lambda: studio.state("s.kept.length") == 1)
    before = simulate(design_of(studio))
    studio.edit({"op": "replace", "path": "/vehicle/components/1/position/0", "value": 0.15})
    page.get_by_test_id("display").click()
    page.get_by_test_id("ghost").select_option(label="Before")
    page.keyboard.press("Escape")
    studio.scene("() => '/ghost/silhouette' in window.__viserSceneTree.getState()")
    studio.seek(12.0)
    expected = attitude_at(before, 12.0)
    # attitudes of thinned samples
    studio.wait_until(lambda: abs(np.dot(studio.pose("/ghost")["wxyz"], expected)) > 1.0 - 1e-5)
    assert abs(np.dot(studio.pose("/glider")["wxyz"], expected)) < 1.0 - 1e-5
    ghost, glider = (np.array(studio.pose(f"/{name}")["position"]) for name in ("ghost", "glider"))
    here = [np.interp(12.0, before.times, before.values[name]) for name in ("x", "z")]
    now = [studio.readout("distance"), studio.readout("depth")]
    assert (ghost - glider)[[0, 2]] == pytest.approx(np.subtract(here, now), abs=1e-4)
    away, deeper = np.hypot(*np.subtract(here, now)), here[1] - now[1]
    told = page.get_by_test_id("scene-ghost").inner_text()
    figures = [float(number) for number in re.findall(r"\d+\.\d+", told)]
    assert told.startswith("Ghost Before: ") and told.endswith("deeper" if deeper > 0 else "higher")
    assert figures == pytest.approx([away, abs(deeper)], abs=6e-4)
    page.get_by_test_id("display").click()
    page.get_by_test_id("ghost").select_option("")
    studio.scene("() => !('/ghost/silhouette' in window.__viserSceneTree.getState())")
    expect(page.get_by_test_id("scene-ghost")).to_be_hidden()


def test_the_keys_of_the_scene_are_listed_and_move_the_camera(studio):
    page = studio.page
    page.keyboard.press("?")
    keys = (
        page.get_by_test_id("keys").locator("section").filter(has=page.get_by_role("heading", name="Scene", exact=True))
    )
    for words in ("Shift + drag", "Ctrl + drag", "Alt + drag", "W / A / S / D / Q / E", "← / → / ↑ / ↓"):
        expect(keys.locator("dt", has_text=words)).to_have_count(1)
    page.get_by_test_id("keys-close").click()

    def place() -> list[float]:
        found: list[float] = view_of(page).evaluate("() => window.__viserMutable.camera.position.toArray()")
        return found

    view_of(page).locator("canvas").first.focus()
    view_of(page).evaluate("() => window.focus()")
    for key in ("w", "d", "e", "ArrowUp"):
        before = place()
        page.keyboard.down(key)
        studio.wait_until(lambda was=before: place() != pytest.approx(was, abs=1e-3))
        page.keyboard.up(key)


def test_water_and_current_are_in_the_scene(reopened):
    document = document_of("quad-bellows-heading")
    document["mission"]["duration"] = 20.0
    studio = reopened(document)
    for name in ("surface", "surface_grid", "current"):
        studio.scene(f"() => window.__viserMutable.nodeRefFromName['/world/{name}']?.visible")
    length = vehicle_length(load_preset("quad-bellows-heading"))
    near, far = view_of(studio.page).evaluate("() => (({ near, far }) => [near, far])(window.__viserMutable.scene.fog)")
    assert (near, far) == pytest.approx((FOG[0] * length, FOG[1] * length))


def pull(studio: StudioPage, index: int, across: float, *, during: Callable[[], None] = lambda: None) -> None:
    """Take a cell by its mesh and pull it across the picture, px to the right."""
    page = studio.page
    place = on_canvas(studio, (f"/glider/cell{index}/stack", (0.02, 0.0, 0.0)))[0]
    frame = page.locator("iframe#view").bounding_box()
    x, y = frame["x"] + place[0], frame["y"] + place[1]
    page.mouse.move(x, y)
    page.wait_for_timeout(300)  # the client looks for what is under the pointer once a frame
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + across * k / 8, y)
        page.wait_for_timeout(120)
    during()
    page.mouse.up()


def test_a_cell_is_dragged_with_its_mirror_image(quad):
    page = quad.page
    place = "s.components[{}].position"
    port, starboard = (quad.state(place.format(i)) for i in (4, 5))

    def label_is_there() -> None:
        quad.scene("() => '/glider/told' in window.__viserSceneTree.getState()")
        assert str(node(quad, "/glider/told", "message.props.text")).endswith(" mm")

    pull(quad, 5, 40.0, during=label_is_there)  # from starboard the nose is to the right
    quad.wait_until(lambda: quad.state(place.format(5)) != starboard)
    quad.scene("() => !('/glider/told' in window.__viserSceneTree.getState())")
    moved, image = quad.state(place.format(5)), quad.state(place.format(4))
    assert moved[0] > starboard[0] and moved[1:] == starboard[1:], "along the hull, toward the nose"
    assert round(1e3 * moved[0], 6) == round(1e3 * moved[0]), "whole millimetres"
    assert image == [moved[0], -moved[1], moved[2]]
    assert quad.state("s.selected") == 5
    page.get_by_test_id("undo").click()
    quad.wait_until(lambda: quad.state(place.format(5)) == starboard)
    assert quad.state(place.format(4)) == port


def test_pointing_at_a_part_breaks_no_picture_off(quad):
    """The client's outline of what is pointed at lacks what fog needs: the picture would end where it is drawn."""
    page, broken = quad.page, []
    page.on("pageerror", lambda error: broken.append(str(error)))
    quad.wait_until(lambda: view_of(page).evaluate(OUTLINES) == [True])
    cell = quad.state("s.components.find(c => c.cell).index")
    (at,) = on_canvas(quad, (f"/glider/cell{cell}/stack", (0.0, 0.0, 0.0)))
    frame = page.locator("iframe#view").bounding_box()
    page.mouse.move(frame["x"] + at[0] - 30, frame["y"] + at[1])
    page.mouse.move(frame["x"] + at[0], frame["y"] + at[1], steps=4)
    page.wait_for_timeout(1500)
    assert broken == []


def test_a_locked_cell_cannot_be_dragged_and_a_hidden_one_is_not_seen(quad):
    quad.ask("post", "parts/5/marks", {"locked": True})
    before = quad.state("s.components[5].position")
    pull(quad, 5, 40.0)
    expect(quad.page.get_by_test_id("problem")).to_contain_text("locked")
    assert quad.state("s.components[5].position") == before
    quad.ask("post", "parts/4/marks", {"hidden": True})
    quad.wait_until(lambda: node(quad, "/glider/cell4", "visibility") is False)
    assert json.loads(design_of(quad).to_json())["vehicle"]["components"][4]["position"], "it is still in the design"
