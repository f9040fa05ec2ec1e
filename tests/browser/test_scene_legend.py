"""The legends over the scene, without the scene."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.browser

LEGEND = """async ([low, high, below, above]) => {
  const { pathLegend } = await import("/static/pathlegend.js");
  const path = { label: "Speed", unit: "m/s", low, high, below, above };
  const legend = pathLegend({ path, path_colors: [] });
  return [legend.low, legend.unit, legend.high];
}"""


def test_a_path_of_one_value_says_it_once(panel):
    def told(*path: object) -> Any:
        return panel.page.evaluate(LEGEND, list(path))

    assert told(0.3, 0.5, True, False) == ["≤ 0.300", "m/s", "0.500"]
    assert told(0.49017, 0.49017, False, False) == ["0.490 m/s", "", "all along"]
    steady = 0.49017, 0.49017 + 1e-9
    assert told(*steady, False, False) == ["0.490 m/s", "", "all along"]
    assert told(*steady, True, True) == ["0.490 m/s", "", "but for outliers"]


def test_a_low_scene_begins_with_its_legend_in_one_row(panel):
    page = panel.page
    fold, lift = page.get_by_test_id("legend-fold"), page.get_by_test_id("force-lift")
    expect(lift).to_be_visible()
    page.set_viewport_size({"width": 1280, "height": 600})
    expect(fold).to_have_attribute("aria-expanded", "false")
    expect(lift).to_be_hidden()
    assert page.get_by_test_id("forces").bounding_box()["height"] < 30
    assert page.locator("#scene-bar").bounding_box()["height"] < 40
    fold.click()
    expect(lift).to_be_visible()
    page.reload()
    expect(lift).to_be_visible()
