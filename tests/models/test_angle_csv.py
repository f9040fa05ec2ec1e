"""A user's own table over angle of attack and sideslip: read from CSV, refused by place and angle otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from models.angle_csv import holds_sideslip, read_angle_table_csv
from models.hydrodynamics import Provenance
from models.hydrodynamics_angles import QUANTITIES
from models.problems import DesignError

PROVENANCE = Provenance(title="Test", source="made up for this test")
ALPHA = (-10.0, 0.0, 10.0, 20.0)
BETA = (0.0, 5.0, 15.0)
HEADER = "speed,alpha_deg,beta_deg,X,Y,Z,K,M,N"


def forces(alpha, beta):
    """Per squared speed; odd in the sideslip where the vehicle's symmetry asks for it."""
    return (-3.0 - 0.01 * alpha, -0.2 * beta, -0.5 * alpha, 0.01 * beta, 0.03 * alpha - 0.001 * beta, -0.02 * beta)


def rows(*speeds, scale=lambda speed: 1.0):
    lines = [HEADER]
    for speed in speeds:
        for alpha in ALPHA:
            for beta in BETA:
                values = [speed, alpha, beta, *(f * speed**2 * scale(speed) for f in forces(alpha, beta))]
                lines.append(",".join(map(repr, values)))
    return lines


def read(tmp_path, lines, **fields):
    path = tmp_path / "tank.csv"
    path.write_text("\n".join(lines))
    return read_angle_table_csv(path, provenance=PROVENANCE, **fields)


def grids(table):
    return np.array([getattr(table, name) for name in QUANTITIES])


EXPECTED = np.array([[forces(a, b) for b in BETA] for a in ALPHA]).transpose(2, 0, 1)


def test_forces_are_per_squared_speed_in_any_order_of_rows(tmp_path):
    lines = rows(0.4)
    np.random.default_rng(3).shuffle(body := lines[1:])
    table = read(tmp_path, [lines[0], *body], reference_density=1025.0, includes_munk_moment=False)
    assert (table.alpha_deg, table.beta_deg) == (ALPHA, BETA)
    assert grids(table) == pytest.approx(EXPECTED, rel=1e-14, abs=1e-15)
    assert (table.reference_density, table.includes_munk_moment, table.provenance) == (1025.0, False, PROVENANCE)


def test_a_header_with_units_is_read_and_a_sideslip_is_seen_in_it(tmp_path):
    header = "speed (m/s),alpha_deg (deg), beta_deg [deg],X (N),Y [N],Z,K (N m),M [Nm],N"
    assert grids(read(tmp_path, [header, *rows(0.4)[1:]])) == pytest.approx(EXPECTED, rel=1e-14, abs=1e-15)
    assert holds_sideslip(tmp_path / "tank.csv")
    (tmp_path / "tank.csv").write_text("speed,alpha_deg,lift,drag,moment")
    assert not holds_sideslip(tmp_path / "tank.csv")


def test_of_several_speeds_one_is_chosen_or_the_mean_taken(tmp_path):
    lines = rows(0.2, 0.5, scale=lambda speed: {0.2: 1.3, 0.5: 1.0}[speed])
    assert grids(read(tmp_path, lines, speed=0.5)) == pytest.approx(EXPECTED, rel=1e-14, abs=1e-15)
    assert grids(read(tmp_path, lines, speed=0.2)) == pytest.approx(1.3 * EXPECTED, rel=1e-14, abs=1e-15)
    assert grids(read(tmp_path, lines, speed="mean")) == pytest.approx(1.15 * EXPECTED, rel=1e-14, abs=1e-15)
    with pytest.raises(DesignError, match=r'2 speeds \(0.2, 0.5 m/s\) \(pick one by speed=, or speed="mean"\)'):
        read(tmp_path, lines)
    with pytest.raises(DesignError, match=r"no row at 0.3 m/s \(its speeds are 0.2, 0.5 m/s\)"):
        read(tmp_path, lines, speed=0.3)


def test_a_speed_with_holes_hinders_only_the_mean(tmp_path):
    lines = rows(0.2, 0.5)
    del lines[2]
    assert grids(read(tmp_path, lines, speed=0.5)) == pytest.approx(EXPECTED, rel=1e-14, abs=1e-15)
    with pytest.raises(DesignError, match=r"missing: speed 0.2, alpha_deg -10, beta_deg 5 \(1 in all\)"):
        read(tmp_path, lines, speed="mean")


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda lines: lines[:2] + lines[3:], r"missing: speed 0.4, alpha_deg -10, beta_deg 5 \(1 in all\)"),
        (
            lambda lines: [*lines, "0.4,90,0,0,0,0,0,0,0", "0.4,80,1,0,0,0,0,0,0", "0.4,70,2,0,0,0,0,0,0"],
            r"alpha_deg 0, beta_deg 2; speed 0.4, alpha_deg 10, beta_deg 1; \.\.\. \(20 in all\)",
        ),
        (
            lambda lines: [*lines, lines[3]],
            r"more than once: speed 0.4, alpha_deg -10, beta_deg 15 \(line 4 and line 14\) \(1 in all\)",
        ),
        (
            lambda lines: [lines[0].replace("K", "Q"), *lines[1:]],
            "tank.csv lacks the columns K .wanted are speed, alpha_deg, beta_deg, X, Y, Z, K, M, N; its header has",
        ),
        (lambda lines: [lines[0].replace("K", "K (lbf ft)"), *lines[1:]], "column K is in 'lbf ft', wanted is N m"),
        (lambda lines: [lines[0] + ",X", *(f"{line},1" for line in lines[1:])], "columns X more than once"),
        (lambda lines: [*lines[:2], "0.4,-10,5,big,0,0,0,0,0", *lines[3:]], "line 3, column X: 'big' is not a number"),
        (lambda lines: [*lines[:2], "0.4,-10,5,,0,0,0,0,0", *lines[3:]], "line 3, column X: no number"),
        (lambda lines: [*lines, "0,30,0,0,0,0,0,0,0"], "line 14, column speed: 0 m/s .speeds must be above 0"),
        (lambda lines: [], "tank.csv is empty"),
        (lambda lines: [lines[0]], "no row has a number"),
        (
            lambda lines: [*lines[:1], "0.4,-10,0,1,9,1,0,0,0", *lines[2:]],
            "tank.csv: sway at alpha = -10.0 deg, beta = 0",
        ),
        (lambda lines: lines[:4], "tank.csv: .*at least 2 items"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, spoil, says):
    with pytest.raises(DesignError, match=says):
        read(tmp_path, spoil(rows(0.4)))
