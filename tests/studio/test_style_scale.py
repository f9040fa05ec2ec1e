"""All pages set type and room between things from one scale of each, kept in static/tokens.css."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import studio

STATIC = Path(studio.__file__).parents[1] / "static"
SHEETS = sorted(path.name for path in STATIC.glob("*.css"))
TOKENS = (STATIC / "tokens.css").read_text(encoding="utf-8")
TEXT = {name: float(size) for name, size in re.findall(r"--(text-\w+): ([\d.]+)px;", TOKENS)}
ROOM = {name: float(size) for name, size in re.findall(r"--(s\d): ([\d.]+)px;", TOKENS)}
HAIR, SECTION = 3.0, 16.0
"""Px: smaller than any room, and what parts whole sections from each other is larger than all."""


def declared(sheet: str, properties: str) -> list[str]:
    """Return the values that a sheet gives to properties, by a pattern of their names."""
    text = re.sub(r"/\*.*?\*/", "", (STATIC / sheet).read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.findall(rf"[\s{{;](?:{properties}): ?([^;}}]+)", text)


def test_the_scales_are_short_and_rise():
    for scale, most in ((TEXT, 6), (ROOM, 5)):
        assert 1 < len(scale) <= most
        assert list(scale.values()) == sorted(set(scale.values()))
    assert min(TEXT.values()) >= 10.0


@pytest.mark.parametrize("sheet", SHEETS)
def test_type_is_of_the_scale(sheet):
    known = {"inherit"} | {f"var(--{name})" for name in TEXT}
    assert set(declared(sheet, "font-size")) <= known
    assert set(declared(sheet, "font")) <= {"inherit"}  # the short form could hide a size


@pytest.mark.parametrize("sheet", SHEETS)
def test_room_is_of_the_scale(sheet):
    for value in declared(sheet, "(?:row-|column-)?gap"):
        for size in re.findall(r"([\d.]+)px", value):
            assert float(size) <= HAIR or float(size) > SECTION, f"gap: {value}"
    for value in declared(sheet, "(?:padding|margin)(?:-[a-z]+)*"):
        plain = {float(size) for size in re.findall(r"(?<![-\d.])([\d.]+)px", value)}
        assert not plain & set(ROOM.values()), f"{value}: a size of the scale, by its number"


@pytest.mark.parametrize("sheet", SHEETS)
def test_every_variable_of_the_scales_is_there(sheet):
    text = (STATIC / sheet).read_text(encoding="utf-8")
    named = set(re.findall(r"var\(--(text-\w+|s\d)\)", text))
    assert named <= TEXT.keys() | ROOM.keys()
