"""docs/paper.md and its figures are what `python -m docs.make_paper` writes."""

from __future__ import annotations

import re

import pytest

from docs.figures import write_figures
from docs.formatting import bound, num, order_of, signed
from docs.make_paper import DOCS, make
from tests.docs.pages import assert_same_page

REFERENCE = re.compile(r"!\[[^\]]+\]\(img/([\w-]+\.svg)\)")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs")
    return folder, make(folder)


def test_paper_is_what_its_generator_writes(made):
    folder, _ = made
    pages = [(path / "paper.md").read_text(encoding="utf-8") for path in (folder, DOCS)]
    assert_same_page(*pages, "python -m docs.make_paper")


def test_every_figure_exists_and_is_shown_once(made):
    folder, names = made
    shown = REFERENCE.findall((DOCS / "paper.md").read_text(encoding="utf-8"))
    assert sorted(shown) == sorted(names)
    assert sorted(names) == sorted(path.name for path in (DOCS / "img").glob("paper-*.svg"))
    for name in names:
        new, committed = ((path / "img" / name).read_text(encoding="utf-8") for path in (folder, DOCS))
        assert new.rstrip().endswith("</svg>")
        assert committed.rstrip().endswith("</svg>")
        assert "<dc:date>" not in committed


def test_figures_are_the_same_in_two_runs(made, tmp_path):
    folder, _ = made
    for name in write_figures(tmp_path, ()):
        assert (folder / "img" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_numbers_are_printed_plainly():
    assert (num(-0.004), num(-1.0, 0), signed(0.02), signed(-0.02)) == ("0.00", "−1", "+0.02", "−0.02")
    assert (order_of(3.8e-9), order_of(0.0), bound(3e-9), bound(0.0)) == ("4 × 10⁻⁹", "0", "10⁻⁸", "10⁻¹²")
