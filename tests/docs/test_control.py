"""docs/control.md and its figures are what `python -m docs.make_control` writes, and what it shows can be flown."""

from __future__ import annotations

import json
import re

import pytest

from docs.control_figures import write_figures
from docs.control_sections.writing import OTHERS
from docs.control_studies import flown, held, kept, legs, preset_run, without_integral
from docs.make_control import DOCS, SECTIONS, make
from models.variables import CONTROL_VARIABLES
from tests.docs.pages import assert_same_page

PAGE = (DOCS / "control.md").read_text(encoding="utf-8")
REFERENCE = re.compile(r"!\[[^\]]+\]\(img/([\w-]+\.svg)\)")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The page made anew; the runs behind it are kept for the other tests."""
    folder = tmp_path_factory.mktemp("docs")
    return folder, make(folder)


def test_the_page_is_what_its_generator_writes(made):
    assert_same_page((made[0] / "control.md").read_text(encoding="utf-8"), PAGE, "python -m docs.make_control")


def test_every_figure_exists_and_is_shown_once(made):
    folder, names = made
    assert sorted(REFERENCE.findall(PAGE)) == sorted(names)
    assert sorted(names) == sorted(path.name for path in (DOCS / "img").glob("control-*.svg"))
    for name in names:
        new, committed = ((path / "img" / name).read_text(encoding="utf-8") for path in (folder, DOCS))
        assert new.rstrip().endswith("</svg>") and committed.rstrip().endswith("</svg>")
        assert "<dc:date>" not in committed


def test_figures_are_the_same_in_two_runs(made, tmp_path):
    for name in write_figures(tmp_path):
        assert (made[0] / "img" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_every_section_that_is_there_has_its_place():
    files = {path.stem for path in (DOCS / "control_sections").glob("*.py")}
    assert files - {"__init__"} <= set(SECTIONS)


def test_the_controllers_shown_fly():
    (block,) = re.findall(r"```json\n(.*?)```", PAGE, re.S)
    shown = json.loads(block)
    assert flown(shown, 60.0).times[-1] == 60.0
    for other in OTHERS:
        flown(shown | {"lateral": shown["lateral"] | {"guidance": other}}, 20.0)


def test_every_variable_of_control_is_named():
    assert [name for name in CONTROL_VARIABLES if f"| `{name}` |" not in PAGE] == []


def test_what_the_page_says_holds():
    result = held()
    assert abs(result.track - result.expected) < 2e-3
    assert result.rms < 0.01
    settled, expected = without_integral()
    assert settled == pytest.approx(expected, rel=0.02)  # a yo-yo: the speed is a mean over dives and turns
    assert all(leg.late < 0.5 * leg.largest for leg in legs(preset_run("waypoints")))
    assert kept().radius < kept().largest < kept().bound
