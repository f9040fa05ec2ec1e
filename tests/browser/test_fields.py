"""The fields of the left panel: units, drafts, drags, help, and every kind of document in every section."""

from __future__ import annotations

import math
from typing import Any

import pytest
from playwright.sync_api import expect

from models.design import parse_design
from models.presets import load_preset
from tests.studio.sources import documents

pytestmark = pytest.mark.browser

PRESETS = ("three-cell-glider", "quad-bellows-waypoints", "movable-mass-twin", "slocum-glide")
"""Between them they have every kind of component, of control, and of force data that presets have."""


def _short(name: str) -> dict[str, Any]:
    document = load_preset(name).model_dump(mode="json")
    document["mission"]["duration"] = 20.0
    return document


DOCUMENTS = documents() | {name: _short(name) for name in PRESETS}


def test_another_unit_changes_what_is_shown_and_nothing_else(panel):
    saved = panel.document()
    unit = panel.row("Position x").get_by_role("combobox", name="Unit of Position x")
    unit.select_option(label="cm")
    expect(panel.box("Position x")).to_have_value("18.00")
    expect(panel.box("Inner radius")).to_have_value("1.60")
    assert panel.document() == saved
    panel.type_number("Position x", "17.5")
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "position", 0) == pytest.approx(0.175))
    panel.type_number("Position x", "0.16 m")
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "position", 0) == pytest.approx(0.16))
    panel.page.reload()
    panel.wait_for_glide()
    expect(panel.box("Position x")).to_have_value("16.00")


def test_units_of_mass_volume_angle_and_pressure_reach_the_document_in_si(panel):
    part = ("vehicle", "components", 1)
    panel.edit(  # the planar model knows no compression
        {"op": "replace", "path": "/mission/solver/model", "value": "spatial"},
        {"op": "replace", "path": "/vehicle/components/1/bulk_modulus", "value": 2.5e9},
    )
    panel.open_section("start")
    panel.page.get_by_test_id("group-Volume in detail").locator("summary").first.click()
    for label, first, typed, si, other, shown, suffixed, converted, path in (
        ("Mass", "g", "31.5", 0.0315, "kg", "0.0315", "32 g", 0.032, (*part, "mass")),
        ("Fixed volume", "cm³", "125.5", 1.255e-4, "dm³", "0.1255", "130 cm3", 1.3e-4, (*part, "fixed_volume")),
        ("Pitch", "°", "12", math.radians(12.0), "rad", "0.2094395", "9 deg", math.radians(9.0),
         ("mission", "initial", "pitch")),
        ("Bulk modulus", "kPa", "2000000", 2e9, "MPa", "2000.0000", "3e6 kPa", 3e9, (*part, "bulk_modulus")),
    ):  # fmt: skip
        unit = panel.row(label).get_by_role("combobox", name=f"Unit of {label}")
        assert unit.locator("option:checked").inner_text() == first, label
        panel.type_number(label, typed)
        panel.wait_until(lambda path=path, si=si: panel.at(*path) == pytest.approx(si, rel=1e-9))
        unit.select_option(label=other)
        expect(panel.box(label)).to_have_value(shown)
        assert panel.at(*path) == pytest.approx(si, rel=1e-9), "another unit is another view of it"
        panel.type_number(label, suffixed)
        panel.wait_until(lambda path=path, si=converted: panel.at(*path) == pytest.approx(si, rel=1e-9))


def test_leaving_a_box_untouched_changes_nothing(panel):
    exact = 0.123456789012
    panel.edit({"op": "replace", "path": "/vehicle/components/1/position/0", "value": exact})
    expect(panel.box("Position x")).to_have_value("123.4568")
    panel.box("Position x").click()
    panel.key("Enter", "Tab")
    panel.type_number("Mass", 31)
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "mass") == pytest.approx(0.031))
    assert panel.at("vehicle", "components", 1, "position", 0) == exact


def test_a_refused_number_stays_as_a_draft_beside_its_message(panel):
    before, saved = panel.readout("end-depth"), panel.document()
    panel.type_number("Inner radius", 30)
    row = panel.row("Inner radius")
    expect(row.get_by_role("alert")).to_contain_text("exceeds outer_radius")
    expect(panel.box("Inner radius")).to_have_value("30.0")
    expect(panel.box("Inner radius")).to_have_attribute("aria-invalid", "true")
    assert panel.document() == saved and panel.readout("end-depth") == before
    panel.type_number("Outer radius", 32)
    panel.wait_until(lambda: panel.document()["vehicle"]["components"][1]["outer_radius"] == pytest.approx(0.032))
    expect(row.get_by_role("alert")).to_be_hidden()
    expect(panel.box("Inner radius")).to_have_value("16.0")


def test_dragging_a_label_changes_its_number_on_the_way(panel):
    page = panel.page
    label = panel.row("Mass").locator(".field-label").bounding_box()
    x, y = label["x"] + 10, label["y"] + label["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    seen = set()
    for k in range(1, 9):
        page.mouse.move(x + 8 * k, y)
        page.wait_for_timeout(120)
        seen.add(panel.state("s.components[1].mass"))
    page.mouse.up()
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "mass") == pytest.approx(0.046))
    assert len(seen) >= 3, "the mass should have changed while the mouse was down"
    page.get_by_test_id("undo").click()
    panel.wait_until(lambda: panel.at("vehicle", "components", 1, "mass") == pytest.approx(0.03))


def test_help_tells_the_sentence_symbol_limits_and_si_value(panel):
    panel.wait_for_consequences()  # after which nothing is drawn anew
    panel.box("Outer radius").focus()
    panel.key("Tab", "Shift+Tab")
    told = panel.page.get_by_test_id("field-help")
    assert told.count() == 0, "who passes by with Tab wants no help"
    panel.key("F1")
    for words in ("Radius at the crests of the pleats.", "above 0.0 mm up to 50000.0 mm", "0.024 m"):
        expect(told).to_contain_text(words)
    panel.page.keyboard.type("26.5")
    expect(told).to_contain_text("0.0265 m")
    card, scene = told.bounding_box(), panel.page.locator("main.scene").bounding_box()
    assert card["x"] >= scene["x"] and scene["y"] <= card["y"]
    assert card["y"] + card["height"] <= scene["y"] + scene["height"]
    panel.key("Escape")
    expect(told).to_be_hidden()


def test_a_bound_is_told_in_the_unit_of_the_box(panel):
    panel.type_number("Mass", -5)
    expect(panel.row("Mass").get_by_role("alert")).to_contain_text("\u22125 g: at least 0 g is wanted")
    expect(panel.page.get_by_test_id("problem")).to_contain_text("\u22125 g: at least 0 g is wanted")


def test_undo_in_a_box_is_the_documents_unless_it_holds_a_draft(panel):
    def mass() -> float:
        return round(panel.at("vehicle", "components", 1, "mass"), 6)

    panel.type_number("Mass", 31)
    panel.wait_until(lambda: mass() == 0.031 and panel.state("s.can_undo"))
    panel.box("Mass").focus()
    panel.key("Control+z")
    panel.wait_until(lambda: mass() == 0.03 and panel.state("s.can_redo"))
    expect(panel.box("Mass")).to_have_value("30.0")
    panel.key("Control+Shift+z")
    panel.wait_until(lambda: mass() == 0.031)
    expect(panel.box("Mass")).to_have_value("31.0")
    expect(panel.box("Mass")).to_be_focused()
    panel.page.keyboard.type("32")
    panel.key("Control+z")
    panel.page.wait_for_timeout(200)
    assert mass() == 0.031 and panel.state("s.can_redo") is False
    panel.key("Escape", "ArrowUp")
    panel.wait_until(lambda: mass() == 0.032)


def test_mass_is_declared_as_it_is_and_composed_again(panel):
    panel.edit({"op": "replace", "path": "/vehicle/mass_properties", "value": {"kind": "composite"}})
    panel.open_section("mass")
    total = panel.page.get_by_test_id("readout-mass")
    panel.choose("Properties", "declared")
    panel.wait_until(lambda: panel.document()["vehicle"]["mass_properties"]["kind"] == "declared")
    assert panel.document()["vehicle"]["mass_properties"]["mass"] == pytest.approx(0.787)
    expect(total).to_be_visible()
    section = panel.page.get_by_test_id("section-mass")
    expect(section.get_by_test_id("field-/vehicle/mass_properties/mass").locator("input")).to_have_value("787.0")
    panel.choose("Properties", "composed")
    panel.wait_until(lambda: panel.document()["vehicle"]["mass_properties"] == {"kind": "composite"})


def test_current_and_controller_are_chosen_and_their_fields_edited(spatial):
    spatial.open_section("water")
    spatial.choose("Current", "uniform")
    spatial.wait_until(lambda: spatial.document()["mission"]["environment"]["current"] is not None)
    box = spatial.page.get_by_role("textbox", name="Velocity east")
    box.fill("12 cm/s")
    box.press("Enter")
    velocity = [0.0, pytest.approx(0.12)]
    spatial.wait_until(lambda: spatial.document()["mission"]["environment"]["current"]["velocity"] == velocity)
    spatial.choose("Current", "none")
    spatial.wait_until(lambda: spatial.document()["mission"]["environment"]["current"] is None)
    spatial.open_section("control")
    spatial.edit({"op": "replace", "path": "/mission/control/schedules", "value": []})
    spatial.choose("Controller", "cascade")
    spatial.wait_until(lambda: (spatial.document()["mission"]["control"]["controller"] or {}).get("kind") == "cascade")
    spatial.choose("Vertical", "yo-yo")
    vertical = ("mission", "control", "controller", "vertical")
    spatial.wait_until(lambda: spatial.at(*vertical, "kind") == "depth_band")
    spatial.type_number("Bottom", 40)
    spatial.wait_until(lambda: spatial.at(*vertical, "bottom") == 40.0)


def test_angles_of_what_rolls_are_in_degrees(spatial):
    spatial.part("Battery").click()
    expect(spatial.box("Angle at start")).to_have_value("0.0")
    spatial.type_number("Angle at start", 30)
    start = ("mission", "initial", "extensions")
    spatial.wait_until(lambda: spatial.at(*start).get("Battery") == pytest.approx(math.radians(30.0)))
    spatial.page.get_by_test_id("group-Schedule").locator("summary").click()
    expect(spatial.page.get_by_role("textbox", name="Extension 1")).to_have_value("45.0")


def test_the_table_of_a_bladder_is_edited_point_by_point(panel):
    panel.add_part("Bladder")
    panel.wait_until(lambda: "Bladder" in panel.names())
    bladder = ("vehicle", "components", -1)
    cell = panel.page.get_by_role("textbox", name="Volumes 3")
    cell.fill("32")
    cell.press("Enter")
    panel.wait_until(lambda: panel.at(*bladder, "volumes", 2) == pytest.approx(3.2e-5))
    panel.row("Table").get_by_role("button", name="Add a row").click()
    panel.wait_until(lambda: panel.at(*bladder, "extensions") == pytest.approx([0.0, 0.01, 0.02, 0.03]))
    expect(panel.page.get_by_role("textbox", name="Volumes 4")).to_be_visible()
    cell.fill("5")
    cell.press("Enter")
    expect(panel.row("Table").get_by_role("alert")).to_contain_text("must rise")
    panel.row("Table").get_by_role("button", name="Remove row 4").click()
    panel.wait_until(lambda: len(panel.at(*bladder, "extensions")) == 3)


def test_shapes_are_added_and_removed(panel):
    panel.page.get_by_test_id("group-Looks and notes").locator("summary").first.click()
    panel.page.get_by_test_id("group-Shapes").locator("summary").first.click()

    def shapes() -> list[str]:
        return [shape["kind"] for shape in panel.at("vehicle", "components", 1, "shapes")]

    assert shapes() == ["bellows"]
    panel.choose("New", "Fin")
    panel.wait_until(lambda: shapes() == ["bellows", "fin"])
    panel.page.get_by_test_id("group-Fin").locator("summary").first.click()
    panel.page.get_by_test_id("group-Fin").get_by_role("button", name="Remove this shape").click()
    panel.wait_until(lambda: shapes() == ["bellows"])


def test_every_section_opens_for_every_kind_and_changes_nothing(panel):
    failures: list[str] = []
    panel.page.on("pageerror", lambda error: failures.append(str(error)))
    for section in ("vehicle", "mass", "water", "start", "mission", "control", "design"):
        panel.open_section(section)
    for name, document in DOCUMENTS.items():
        wanted = parse_design(document)
        panel.open_file(document)
        panel.wait_until(lambda wanted=wanted: panel.state("s.name") == wanted.name)
        panel.wait_until(lambda wanted=wanted: parse_design(panel.document()) == wanted)
        for _ in range(3):  # a group has its rows, and the groups among them, once it is open
            panel.page.evaluate("() => document.querySelectorAll('#parts details').forEach(d => (d.open = true))")
            panel.page.wait_for_timeout(60)
        boxes = panel.page.locator("#parts input.field-box")
        assert boxes.count() > 30, name
        panel.page.evaluate(
            "() => document.querySelectorAll('#parts input.field-box').forEach(box => {"
            " box.focus(); box.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true })); })"
        )
        assert parse_design(panel.document()) == wanted, name
    assert failures == []


def test_a_bound_in_the_message_is_not_said_again_without_its_unit(panel):
    for message, limit, said in (
        ("extension 200 mm of 'Front' lies outside its stops [0, 100] mm", 0.1, False),
        ("angle 100 deg of 'Battery' lies outside its stops [-90, 90] deg", -1.5707963267948966, False),
        ("Input should be greater than or equal to 0, not -5", 0.0, False),
        ("9e+06 samples of the result exceed the limit of 4e+06", 4_000_000, False),
        ("there are 3 too many", 0.1, True),
    ):
        shown = panel.page.evaluate(
            "async error => (await import('/static/problem.js')).problemNodes({ errors: [error] })"
            ".map(node => node.textContent).join(' ')",
            {"message": message, "limit": limit},
        )
        assert ("Limit: " in shown) is said
