"""The list of parts: added, mirrored, named, put in order, locked and hidden, by mouse and by keys."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from models.presets import load_preset
from studio.part_kinds import NAMES
from tests.browser.panel_page import PanelPage

pytestmark = pytest.mark.browser

PALETTE = {**NAMES, "rigid": "Rigid part"}


def test_each_kind_of_the_palette_is_added_and_selected(spatial):
    for kind, name in NAMES.items():
        before = spatial.names()
        spatial.add_part(PALETTE[kind])
        spatial.wait_until(lambda before=before: len(spatial.names()) == len(before) + 1)
        added = spatial.names()[-1]
        assert added.startswith(name)
        expect(spatial.page.get_by_test_id("form-title")).to_contain_text(added)
        expect(spatial.part(added)).to_have_attribute("aria-selected", "true")
    parts = spatial.document()["vehicle"]["components"][-len(NAMES) :]
    assert {part["kind"] for part in parts} >= {"rigid", "bellows", "piston", "bladder", "movable_mass", "rolling_mass"}
    assert all(part["mass"] > 0.0 for part in parts)
    shapes = [shape["kind"] for part in parts for shape in part["shapes"]]
    assert "wing" in shapes and "fin" in shapes


def test_what_rolls_cannot_be_added_in_the_plane_and_the_palette_says_why(panel):
    panel.page.get_by_test_id("parts-add").click()
    item = panel.page.get_by_role("menuitem", name="Rolling mass")
    expect(item).to_be_disabled()
    expect(item).to_contain_text("spatial model")
    panel.key("Escape")
    expect(panel.page.get_by_test_id("parts-menu")).to_have_count(0)
    expect(panel.page.get_by_test_id("parts-add")).to_be_focused()


def test_nothing_on_the_axis_is_mirrored_in_the_plane_and_the_button_says_why(panel):
    button = panel.page.get_by_test_id("parts-mirror")
    expect(button).to_be_disabled()
    expect(button).to_have_attribute("title", re.compile("choose the spatial model first"))
    panel.page.get_by_test_id("parts-more").click()
    for name in ("Mirror port and starboard", "Mirror with its schedule"):
        expect(panel.page.get_by_role("menuitem", name=name)).to_be_disabled()
    panel.key("Escape")
    panel.focus_tree()
    panel.key("m")
    problem = panel.page.get_by_test_id("problem")
    expect(problem).to_contain_text("choose the spatial model first")
    problem.get_by_role("button", name="Show model").click()
    expect(panel.page.locator(".part-field[data-pointer='/mission/solver/model'] select")).to_be_focused()


def test_a_part_is_mirrored_and_both_are_told_as_partners(spatial):
    spatial.add_part("Piston")
    spatial.wait_until(lambda: "Piston" in spatial.names())
    spatial.page.get_by_test_id("parts-mirror").click()
    problem = spatial.page.get_by_test_id("problem")
    expect(problem).to_contain_text("stands in the plane of symmetry")
    spatial.type_number("Position y", "60")
    spatial.wait_until(lambda: spatial.document()["vehicle"]["components"][3]["position"][1] == pytest.approx(0.06))
    spatial.page.get_by_test_id("parts-mirror").click()
    spatial.wait_until(lambda: spatial.names()[-2:] == ["Piston starboard", "Piston port"])
    assert spatial.state("s.components.slice(-2).map(c => c.partner)") == [4, 3]
    image = spatial.document()["vehicle"]["components"][4]
    assert image["position"][1] == pytest.approx(-0.06)
    expect(spatial.part("Piston port")).to_have_attribute("aria-label", re.compile("mirrors Piston starboard"))


def test_a_mirrored_part_takes_the_opposite_schedule_along(spatial):
    spatial.edit({"op": "replace", "path": "/vehicle/components/2/position/1", "value": 0.05})
    spatial.wait_until(lambda: spatial.state("s.components[2].position[1]") == 0.05)
    spatial.part("Engine").click(button="right")
    spatial.page.get_by_role("menuitem", name="Mirror with the opposite schedule").click()
    spatial.wait_until(lambda: len(spatial.names()) == 4)
    schedules = {s["cell"]: s["points"] for s in spatial.document()["mission"]["control"]["schedules"]}
    own, other = schedules["Engine starboard"][0], schedules["Engine port"][0]
    assert other["extension"] == pytest.approx(-own["extension"])


def test_a_part_is_renamed_in_place_with_what_names_it(panel):
    panel.part("Front bellows").dblclick()
    box = panel.page.get_by_test_id("part-rename")
    box.fill("Rear bellows")
    box.press("Enter")
    expect(panel.page.get_by_test_id("problem")).to_contain_text("both named")
    expect(box).to_have_attribute("aria-invalid", "true")
    box.fill("Nose <img src=x>")
    box.press("Enter")
    panel.wait_until(lambda: panel.names()[1] == "Nose <img src=x>")
    assert panel.document()["mission"]["control"]["schedules"][0]["cell"] == "Nose <img src=x>"
    assert panel.panel.locator("img").count() == 0
    panel.key("F2")
    box.fill("Another")
    box.press("Escape")
    assert panel.names()[1] == "Nose <img src=x>"


def test_parts_are_put_in_order_by_mouse_and_by_keys(panel):
    panel.part("Rear bellows").drag_to(panel.part("Body"), target_position={"x": 60, "y": 3})
    panel.wait_until(lambda: panel.names() == ["Rear bellows", "Body", "Front bellows"])
    colors = panel.state("s.components.map(c => c.color)")
    assert panel.state("s.selected") == 0
    panel.focus_tree()
    panel.key("Alt+ArrowDown")
    panel.wait_until(lambda: panel.names() == ["Body", "Rear bellows", "Front bellows"])
    assert panel.state("s.components.map(c => c.color)") == [colors[1], colors[0], colors[2]]
    assert panel.state("s.selected") == 1


def test_a_locked_part_is_refused_everywhere_until_it_is_unlocked(panel):
    page, design = panel.page, panel.document()
    panel.part("Front bellows").hover()
    page.get_by_role("button", name="Lock Front bellows").click()
    panel.wait_until(lambda: panel.state("s.components[1].locked") is True)
    expect(panel.box("Mass")).to_be_disabled()
    address = panel.url.split("?")[0]
    origin = "/".join(address.split("/")[:3])
    patch = [{"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": 0.0168}]
    answer = page.request.post(f"{address}edit", data={"patch": patch}, headers={"Origin": origin})
    assert answer.status == 422
    (error,) = answer.json()["errors"]
    assert "'Front bellows' is locked" in error["message"] and "unlock" in error["hint"]
    panel.focus_tree()
    with page.expect_response(lambda answer: answer.status == 422):
        panel.key("Delete")
    problem = page.get_by_test_id("problem")
    expect(problem).to_contain_text("'Front bellows' is locked")
    assert problem.inner_text().count("is locked") == 1 and "/vehicle" not in problem.inner_text()
    expect(problem.locator("strong")).to_have_text("The change was refused")
    panel.key("F2")
    expect(page.get_by_test_id("part-rename")).to_have_count(0)
    expect(problem).to_contain_text("Its name stays as it is until it is unlocked")
    assert panel.document() == design
    page.get_by_test_id("locked").get_by_role("button").click()
    expect(panel.box("Mass")).to_be_enabled()
    panel.type_number("Mass", 31)
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "mass") == pytest.approx(0.031))


def test_a_hidden_part_stays_in_the_physics_and_is_hidden_after_a_reload(panel):
    page, before = panel.page, panel.readout("end-depth")
    panel.focus_tree()
    panel.key("h")
    panel.wait_until(lambda: panel.state("s.components[1].hidden") is True)
    assert panel.readout("end-depth") == before
    page.reload()
    panel.wait_for_glide()
    assert panel.state("s.components.map(c => c.hidden)") == [False, True, False]
    expect(panel.part("Front bellows")).to_have_attribute("aria-label", re.compile("hidden"))


def test_everything_goes_by_keyboard_alone(panel):
    page = panel.page
    panel.focus_tree()
    panel.key("ArrowDown")
    panel.wait_until(lambda: panel.state("s.selected") == 2)
    expect(panel.part("Rear bellows")).to_be_focused()
    panel.key("a")
    panel.key("p", "Enter")
    panel.wait_until(lambda: panel.names()[-1] == "Piston")
    panel.focus_tree()
    panel.key("Control+d")
    panel.wait_until(lambda: panel.names()[-1] == "Piston 2")
    panel.focus_tree()
    panel.key("F2")
    page.keyboard.type("Spare")
    panel.key("Enter")
    panel.wait_until(lambda: panel.names()[-1] == "Spare")
    before = panel.state("s.components.at(-1).position[0]")
    panel.focus_tree()
    panel.key("Enter")
    expect(panel.box("Position x")).to_be_focused()
    panel.key("ArrowUp", "ArrowUp", "Shift+ArrowUp")
    panel.wait_until(lambda: panel.state("s.components.at(-1).position[0]") == pytest.approx(before + 0.012))
    panel.focus_tree()
    panel.key("Delete")
    panel.wait_until(lambda: panel.names()[-1] == "Piston")


def test_a_pointer_leads_to_its_field(panel):
    for pointer, label in {
        "/vehicle/components/2/mass": "Mass",
        "/vehicle/components/0/inertia/yy": "Pitch yy",
        "/vehicle/damping/pitch": "Pitch C33",
        "/mission/solver/tolerance": "Tolerance",
        "/mission/environment/water/density": "Density",
        "/mission/initial/pitch": "Pitch",
    }.items():
        panel.page.evaluate("async pointer => (await import('/static/parts.js')).focusField(pointer)", pointer)
        expect(panel.page.locator(f"[data-pointer='{pointer}'] input:focus")).to_be_visible()
        expect(panel.page.locator(f".part-field[data-pointer='{pointer}'] .field-label")).to_have_text(label)
        index = re.match(r"/vehicle/components/(\d)", pointer)
        assert panel.state("s.selected") == (int(index[1]) if index else 0)


LINK = """async ([pointer, there]) => {
  const { pointerLink } = await import('/static/notices.js');
  const link = pointerLink(window.__studio.state, { showForces() {} })(pointer);
  link?.click();
  const flashes = () => Boolean(there && document.querySelector(`${there}.flash`));
  for (let k = 0; there && k < 300 && !flashes(); k += 1) await new Promise(requestAnimationFrame);
  return [link?.textContent ?? null, flashes()];
}"""


def test_every_link_has_words_and_leads_somewhere(panel):
    for pointer, words, there in (
        ("/vehicle/components", "Show the list of parts", "[data-testid=parts-tree]"),
        ("/vehicle/components/9/mass", "Show the list of parts", "[data-testid=parts-tree]"),
        ("/vehicle/components/1/position/1", "Show Front bellows: position y", "[data-testid=part-fields]"),
        ("/vehicle/components/2/extension_range/1", "Show Rear bellows: stroke to", "[data-pointer$=extension_range]"),
        ("/mission/control/schedules/0/points/0/time", "Show Front bellows, point 1", "[data-testid^=lane-Front]"),
        ("/mission/control/schedules/0", "Show Front bellows, schedule", "[data-testid^=lane-Front]"),
        ("/mission/control/schedules/9/points", "Show the schedules", "#lanes"),
        ("/mission/initial/extensions/Front bellows", "Show Front bellows at start", ".part-field"),
        ("/vehicle", "Show vehicle", "[data-testid=section-vehicle]"),
    ):
        assert panel.page.evaluate(LINK, [pointer, there]) == [words, True]
    assert panel.page.evaluate(LINK, ["/kind", ""]) == [None, False]
    panel.part("Rear bellows").click()
    panel.wait_until(lambda: panel.state("s.selected") == 2)
    panel.page.evaluate(LINK, ["/mission/control/schedules/0/points/1/extension", ""])
    expect(panel.page.get_by_test_id("point-Front bellows-1")).to_be_focused()
    panel.wait_until(lambda: panel.state("s.selected") == 1)


def test_choosing_a_part_brings_its_fields_into_view(panel):
    for section in ("vehicle", "water", "design"):
        panel.open_section(section)
    panel.page.get_by_test_id("section-design").locator("textarea").scroll_into_view_if_needed()
    expect(panel.page.get_by_test_id("form-title")).not_to_be_in_viewport()
    panel.part("Rear bellows").click()
    expect(panel.page.get_by_test_id("form-title")).to_contain_text("Rear bellows")
    expect(panel.page.get_by_test_id("form-title")).to_be_in_viewport()


def test_fields_change_both_parts_of_a_pair_unless_it_is_unlinked(program, page):
    document = load_preset("quad-bellows-glide").model_dump(mode="json")
    panel = PanelPage.open_document(page, program.url, document)
    panel.part("Front port cell").click()
    linked = page.get_by_test_id("pair-linked")
    expect(page.get_by_text("Also Front starboard cell, mirrored")).to_be_visible()

    def places() -> list[float]:
        return [panel.at("vehicle", "components", i, "position", 1) for i in (4, 5)]

    panel.type_number("Position y", -210)
    panel.wait_until(lambda: places() == [-0.21, 0.21])
    page.get_by_test_id("undo").click()
    panel.wait_until(lambda: places() == [-0.2, 0.2])
    linked.uncheck()
    panel.wait_until(lambda: panel.state("s.linked") is False)
    panel.type_number("Position y", -210)
    panel.wait_until(lambda: places() == [-0.21, 0.2])
    expect(linked).to_be_hidden()  # they are no pair any more
