"""docs/data_files.md and `attach --help` name every column that is read, and the page's examples are read."""

from __future__ import annotations

import re

import pytest

from docs.make_paper import DOCS
from models import angle_csv, polar_csv, profile_files
from models.angle_csv import read_angle_table_csv
from models.hydrodynamics import Provenance
from models.polar_csv import read_polar_csv
from models.profile_files import read_current_profile, read_density_profile, read_water_profile
from studio.__main__ import COLUMNS

PAGE = (DOCS / "data_files.md").read_text(encoding="utf-8")
SECTIONS = {section.partition("\n")[0]: section for section in PAGE.split("\n## ")[1:]}
MADE_UP = Provenance(title="Test", source="the page's example")
FILES = {
    "Water: temperature and salinity": (profile_files.WATER_COLUMNS, lambda p: read_water_profile(p, latitude=46.5)),
    "Water: density": (profile_files.DENSITY_COLUMNS, read_density_profile),
    "Current": (profile_files.CURRENT_COLUMNS, read_current_profile),
    "Forces over the angle of attack": (polar_csv.COLUMNS, lambda p: read_polar_csv(p, provenance=MADE_UP)),
    "Forces over both angles": (
        (*angle_csv.AXES, *angle_csv.COLUMNS), lambda p: read_angle_table_csv(p, provenance=MADE_UP),
    ),
}  # fmt: skip


@pytest.mark.parametrize("title", FILES)
def test_the_page_names_the_columns_that_are_read_with_their_units(title):
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \|", SECTIONS[title], re.M)
    assert sorted(name for name, _ in rows) == sorted(FILES[title][0])
    for name, unit in rows:
        expected = "1, or g/kg" if name == "salinity" else profile_files.UNITS[name][0]
        assert unit == expected, name


@pytest.mark.parametrize("title", FILES)
def test_the_pages_examples_are_read(title, tmp_path):
    (example,) = re.findall(r"```csv\n(.*?)```", SECTIONS[title], re.S)
    path = tmp_path / "example.csv"
    path.write_text(example)
    FILES[title][1](path)


def test_the_page_names_every_standard_name():
    for name, standard in profile_files.STANDARD_NAMES.items():
        (row,) = re.findall(rf"^\| `{name}`.*", SECTIONS["NetCDF"], re.M)
        for word in standard:
            assert f"`{word}`" in row.partition("|")[2], word
    assert all(f"`{suffix}`" in SECTIONS["NetCDF"] for suffix in profile_files.NETCDF_SUFFIXES)


def test_the_help_names_every_column():
    for columns, _ in FILES.values():
        for name in columns:
            assert re.search(rf"\b{name}\b", COLUMNS), name
