"""docs/paper.md and its figures are what `python -m docs.make_paper` writes."""

from __future__ import annotations

import re

import pytest

from docs.figures import write_figures
from docs.formatting import bound, num, order_of, signed
from docs.make_paper import DOCS, make

NUMBER = re.compile(r"[−-]?\d+(?:\.\d+)?")
REFERENCE = re.compile(r"!\[[^\]]+\]\(img/([\w-]+\.svg)\)")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs")
    return folder, make(folder)


def words(text: str) -> list[str]:
    """The text between the numbers; line breaks move with the width of a number, so they do not count."""
    return " ".join(NUMBER.sub("#", text).split()).split(" ")


def test_paper_is_what_its_generator_writes(made):
    """All words are equal, and every number to one unit of its last printed digit.

    Another processor rounds differently in the last bits (fused multiply-add, other sums in BLAS), which may carry a
    number over a rounding edge, but no further: numbers are printed with far fewer digits than the runs resolve.
    """
    folder, _ = made
    new, committed = ((path / "paper.md").read_text(encoding="utf-8") for path in (folder, DOCS))
    assert words(new) == words(committed), "docs/paper.md is stale: run `python -m docs.make_paper`"
    for a, b in zip(NUMBER.findall(new), NUMBER.findall(committed), strict=True):
        unit = 10.0 ** -max(len(x.partition(".")[2]) for x in (a, b))
        assert abs(float(a.replace("−", "-")) - float(b.replace("−", "-"))) <= 1.01 * unit, f"{a} is not {b}"


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
