"""A user's own table of forces: read from CSV, refused with file, line and column where it is not one."""

from __future__ import annotations

from importlib.resources import files

import pytest

from models.hydrodynamics import Provenance
from models.polar_csv import read_polar_csv
from models.presets import load_preset
from models.problems import DesignError

PROVENANCE = Provenance(title="Test", source="made up for this test")
ROWS = ["speed,alpha_deg,lift,drag,moment"] + [
    f"0.2,{a},{0.01 * a * (90 - a)},{1 + a},{-0.01 * a}" for a in (0, 30, 60, 90)
]


def read(tmp_path, rows, **fields):
    path = tmp_path / "forces.csv"
    path.write_text("\n".join(rows))
    return read_polar_csv(path, provenance=PROVENANCE, **fields)


def test_the_stand_ins_table_is_that_of_its_file():
    path = files("models").joinpath("data/standin_kepsilon.csv")
    preset = load_preset("canete-dual-bellows").vehicle.hydrodynamics
    assert read_polar_csv(path, provenance=preset.provenance) == preset


def test_columns_and_fields_are_read(tmp_path):
    table = read(tmp_path, ROWS, reference_density=1025.0, includes_munk_moment=False)
    assert table.row_alpha_deg == (0.0, 30.0, 60.0, 90.0)
    assert table.row_drag == (1.0, 31.0, 61.0, 91.0)
    assert table.reference_density == 1025.0 and not table.includes_munk_moment


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda rows: [rows[0].replace("drag", "resistance"), *rows[1:]], "lacks the columns drag"),
        (lambda rows: [*rows[:2], rows[2].replace("0.2", "fast"), *rows[3:]], "line 3, column speed: 'fast'"),
        (lambda rows: rows[:-1], "run from 0 to 90 deg"),
        (lambda rows: [*rows[:-1], "0.2,90,0,nan,0"], "finite"),
        (lambda rows: [], "lacks the columns"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, spoil, says):
    with pytest.raises(DesignError, match=says):
        read(tmp_path, spoil(ROWS))
