"""Allocation: the dual method against SciPy's bounded least squares, effectiveness against mass properties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from models.allocation import allocate, authority, effectiveness
from models.design import parse_design
from models.kernel import allocate as kernel
from models.mass_properties import mass_balance
from models.presets import load_preset
from models.problems import DesignError
from models.water import gravity_of, surface_density


@given(st.integers(1, 12), st.integers(0, 10_000), st.booleans())
def test_no_extensions_come_nearer_to_the_wish(count, seed, alike):
    rng = np.random.default_rng(seed)
    rows = np.zeros((count, kernel.COLUMNS))
    rows[:, : kernel.AXES] = rng.normal(size=(count, 3))
    if alike:
        rows[:, : kernel.AXES] = rows[0, : kernel.AXES]
    rows[:, kernel.PREFERRED] = rng.uniform(-0.3, 0.3, count)
    rows[:, kernel.LOW], rows[:, kernel.HIGH] = -1.0, 1.0
    effort = rows[:, kernel.EFFORT] = 10.0 ** rng.uniform(-6, -1, count)
    wish, x = rng.normal(size=3) * 10.0 ** rng.uniform(-1, 1), np.zeros(count)
    missing = kernel.allocate(rows, *wish, x)
    matrix = np.vstack([rows[:, : kernel.AXES].T, np.diag(np.sqrt(effort))])
    right = np.concatenate([wish, np.sqrt(effort) * rows[:, kernel.PREFERRED]])
    best = lsq_linear(matrix, right, (-1.0, 1.0), method="bvls", tol=1e-14).x
    cost, least = (float(np.sum((matrix @ v - right) ** 2)) for v in (x, best))
    assert np.all(np.abs(x) <= 1.0)
    assert cost <= least * (1.0 + 1e-9) + 1e-12
    np.testing.assert_allclose(missing, wish - rows[:, : kernel.AXES].T @ x, atol=1e-12)


@pytest.mark.parametrize("preset", ["quad-bellows-glide", "movable-mass-twin", "three-cell-glider"])
def test_effectiveness_is_the_change_of_weight_and_buoyancy(preset):
    design = load_preset(preset)
    cells = effectiveness(design)
    density, gravity = surface_density(design.mission.environment.water), gravity_of(design.mission.environment)
    for name, column, neutral, span in zip(cells.cells, cells.matrix.T, cells.neutral, cells.span, strict=True):
        sides = []
        for e in (neutral - 1e-5 * span, neutral + 1e-5 * span):
            b = mass_balance(design.vehicle, {name: float(e)})
            arm = b.mass * b.center_of_mass - density * b.volume * b.center_of_buoyancy
            sides.append(gravity * np.array([density * b.volume - b.mass, -arm[0], arm[1]]))
        np.testing.assert_allclose((sides[1] - sides[0]) / (2e-5 * span), column, rtol=1e-6, atol=1e-6)


def test_a_reachable_wish_is_reached_with_cells_near_neutral():
    cells = effectiveness(load_preset("quad-bellows-glide"))
    wish = np.array([0.3, 0.2, 0.1]) * cells.scale
    found = allocate(cells, wish)
    np.testing.assert_allclose(found.reached, wish, atol=1e-5 * cells.scale.max())
    assert found.short == () and found.at_stop == ()
    exact = cells.neutral + np.linalg.pinv(cells.matrix) @ wish  # equal strokes: the nearest to neutral
    np.testing.assert_allclose(list(found.extensions.values()), exact, atol=1e-6)


def test_what_cannot_be_reached_is_told_with_the_cells_at_their_stops():
    cells = effectiveness(load_preset("quad-bellows-glide"))
    found = allocate(cells, [2.0 * cells.scale[0], 0.0, 0.0])
    assert found.short == ("heave",)
    assert found.missing[0] == pytest.approx(cells.scale[0], rel=1e-6)
    assert set(found.at_stop) == set(cells.cells)
    assert "heave is short by" in str(found)


def test_weights_decide_which_axis_gives_way():
    cells = effectiveness(load_preset("quad-bellows-glide"))
    wish = cells.scale * np.array([0.9, 0.9, 0.0])  # each possible alone, not both
    heave_first = allocate(cells, wish, (100.0, 1.0, 1.0))
    pitch_first = allocate(cells, wish, (1.0, 100.0, 1.0))
    assert abs(heave_first.missing[0]) < 1e-3 * cells.scale[0] < abs(pitch_first.missing[0])
    assert abs(pitch_first.missing[1]) < 1e-3 * cells.scale[1] < abs(heave_first.missing[1])


def test_two_cells_in_a_row_cannot_hold_roll():
    two, four = (authority(effectiveness(load_preset(p))) for p in ("canete-dual-bellows", "quad-bellows-glide"))
    assert two.rank == 2 and two.holds == ("heave", "pitch")
    assert four.rank == 3 and four.holds == ("heave", "pitch", "roll")
    # four equal cells in a rectangle act on the three axes apart: equal singular values, and all of a stroke for each
    np.testing.assert_allclose(four.singular_values, 0.5, rtol=1e-9)


def test_unknown_cells_are_refused_by_place():
    with pytest.raises(DesignError, match="no component that moves is named 'Tail'") as error:
        effectiveness(load_preset("quad-bellows-glide"), ["Front port cell", "Tail"])
    assert error.value.problems[0].pointer == "/options/cells/1"


def test_frozen_masses_do_nothing():
    document = load_preset("three-cell-glider").model_dump(mode="json")
    document["vehicle"]["mass_properties"] = {
        "kind": "declared", "mass": 0.8, "center_of_mass": [0.0, 0.0, 0.002], "inertia": {"yy": 0.03},
    }  # fmt: skip
    cells = effectiveness(parse_design(document))
    assert np.all(cells.matrix[:, cells.cells.index("Battery slide")] == 0.0)
