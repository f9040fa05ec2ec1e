"""Volume laws of the cells: Eqs. 9 and 10, pistons, bladders, and what a cell refuses."""

import math

import numpy as np
import pytest
from hypothesis import given
from pydantic import ValidationError
from scipy.interpolate import PchipInterpolator

from models.assemble import assemble
from models.components import Bellows, Bladder, MovableMass, Piston, Rigid
from models.design import parse_design
from models.kernel.actuators import volume_and_slope
from models.mass_properties import component_center_of_buoyancy
from models.volumes import core_volume, unit_axis, volume
from tests.models.support import document
from tests.strategies import bladder_tables, components

BELLOWS = {
    "kind": "bellows", "name": "Cell", "mass": 0.03, "position": [0.18, 0.0, 0.0], "axis": [2.0, 0.0, 0.0], "pleats": 8,
    "inner_radius": 0.016, "outer_radius": 0.024, "fixed_volume": 1e-4, "pleat_volume": 1e-7, "gap_volume": 2e-7,
    "extension_range": [0.0, 0.032], "neutral_extension": 0.016,
}  # fmt: skip


def frustum(height, r, R):
    """Volume of a truncated cone by quadrature of its sections."""
    h = np.linspace(0.0, 1.0, 3)
    sections = math.pi * (r + (R - r) * h) ** 2
    return height * (sections[0] + 4 * sections[1] + sections[2]) / 6.0  # Simpson's rule is exact for a quadratic


@pytest.mark.parametrize("e", [0.0, 0.01, 0.016, 0.032])
def test_bellows_are_frustums_that_grow_by_the_stroke(e):
    """Eq. 9 with l_d = e / (2 m_p): 16 frustums of that height."""
    cell = Bellows.model_validate(BELLOWS)
    expected = 1e-4 + 8 * (1e-7 + 2e-7) + 16 * frustum(e / 16, 0.016, 0.024)
    assert volume(cell, e) == pytest.approx(expected, rel=1e-14)
    assert 16 * (e / 16) == pytest.approx(e)  # the heights add up to the stroke


def test_the_printed_frustum_height_doubles_the_change():
    cell, printed = Bellows.model_validate(BELLOWS), Bellows.model_validate(BELLOWS | {"as_printed": True})
    change = volume(cell, 0.03) - volume(cell, 0.01)
    assert volume(printed, 0.03) - volume(printed, 0.01) == pytest.approx(2.0 * change, rel=1e-12)
    assert volume(printed, 0.0) == volume(cell, 0.0)
    expected = printed.core_volume + 16 * frustum(0.03 / 8, 0.016, 0.024)  # Eq. 10 as it stands: l_d = L / m_p
    assert volume(printed, 0.03) == pytest.approx(expected, rel=1e-14)


def test_a_cylinder_is_a_bellows_of_one_radius():
    cell = Bellows.model_validate(BELLOWS | {"inner_radius": 0.02, "outer_radius": 0.02})
    assert cell.section == pytest.approx(math.pi * 0.02**2, rel=1e-15)


def test_bellows_move_their_centre_by_half_the_growth_of_the_stack():
    """The core stays at the position; the stack's centroid moves along the axis by half its growth."""
    cell = Bellows.model_validate(BELLOWS)
    e = 0.03
    stack = volume(cell, e) - core_volume(cell)
    moved = stack * 0.5 * (e - 0.016) / volume(cell, e)
    np.testing.assert_allclose(component_center_of_buoyancy(cell, e), [0.18 + moved, 0.0, 0.0], rtol=1e-14)
    np.testing.assert_array_equal(component_center_of_buoyancy(cell, 0.016), [0.18, 0.0, 0.0])
    np.testing.assert_array_equal(unit_axis(cell), [1.0, 0.0, 0.0])


def test_a_piston_is_linear_and_its_stops_follow_from_its_volumes():
    piston = Piston.model_validate({
        "kind": "piston", "name": "P", "mass": 0.1, "position": [0.0, 0.0, 0.0], "volume": 5e-5,
        "volume_range": [3e-5, 8e-5], "area": 2e-3,
    })  # fmt: skip
    low, high = piston.stroke
    assert (low, high) == pytest.approx((-0.01, 0.015), rel=1e-14)
    assert volume(piston, low) == pytest.approx(3e-5, rel=1e-14)
    assert volume(piston, 0.0) == 5e-5
    assert volume(piston, high) == pytest.approx(8e-5, rel=1e-14)


@given(bladder_tables())
def test_a_bladder_is_monotone_and_passes_its_table(table):
    bladder = Bladder.model_validate({"kind": "bladder", "name": "B", "mass": 0.0, "position": [0.1, 0.0, 0.0]} | table)
    grid = np.linspace(*bladder.stroke, 301)
    V = [volume(bladder, float(e)) for e in grid]
    assert np.diff(V).min() >= -1e-18
    for e, expected in zip(bladder.extensions, bladder.volumes, strict=True):
        assert volume(bladder, e) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(V, PchipInterpolator(bladder.extensions, bladder.volumes)(grid), rtol=1e-12)
    np.testing.assert_array_equal(component_center_of_buoyancy(bladder, grid[17]), [0.1, 0.0, 0.0])


def test_other_parts_do_not_change_their_volume():
    slide = MovableMass.model_validate({
        "kind": "movable_mass", "name": "S", "mass": 0.1, "position": [0.0, 0.0, 0.0],
        "extension_range": [-0.1, 0.1], "neutral_extension": 0.0,
    })  # fmt: skip
    rigid = Rigid.model_validate({"kind": "rigid", "name": "R", "mass": 1.0, "position": [0, 0, 0], "volume": 0.5})
    assert volume(slide, 0.07) == 0.0
    assert volume(rigid, 123.0) == 0.5


@given(components("Cell"))
def test_the_kernels_volume_and_slope_are_those_of_the_law(part):
    assembly = assemble(parse_design(document(part)))
    if part["kind"] == "rigid":
        assert len(assembly.params.parts) == 0
        return
    (_, cell), *_ = assembly.design.vehicle.actuated
    low, high = cell.stroke
    h = 1e-4 * (high - low)
    for e in np.linspace(low + h, high - h, 29):
        V, slope = volume_and_slope(assembly.params.parts[0], float(e), assembly.params)
        assert V == pytest.approx(volume(cell, float(e)), rel=1e-14, abs=1e-20)
        difference = (volume(cell, e + h) - volume(cell, e - h)) / (2 * h)
        # a central difference over a knot of a PCHIP law is off by its jump in curvature
        assert slope == pytest.approx(difference, rel=2e-3, abs=1e-9)


@pytest.mark.parametrize(("changes", "words"), [
    ({"inner_radius": 0.03}, "exceeds outer_radius"),
    ({"extension_range": [-0.01, 0.03]}, "cannot extend below 0"),
    ({"extension_range": [0.03, 0.03], "neutral_extension": 0.03}, "is empty"),
    ({"neutral_extension": 0.04}, "outside the stops"),
    ({"axis": [0.0, 0.0, 0.0]}, "no direction"),
    ({"pleats": 0}, "greater than or equal to 1"),
    ({"pleats": 2.0}, "valid integer"),
    ({"mass": -1.0}, "greater than or equal to 0"),
    ({"mass": "1"}, "valid number"),
    ({"mass": True}, "valid number"),
    ({"rate_limit": 0.0}, "greater than 0"),
    ({"lag": -1.0}, "greater than or equal to 0"),
])  # fmt: skip
def test_a_cell_says_what_is_wrong_with_it(changes, words):
    with pytest.raises(ValidationError, match=words):
        Bellows.model_validate(BELLOWS | changes)


@pytest.mark.parametrize(("changes", "words"), [
    ({"extensions": [0.0, 0.02, 0.01]}, "must rise: entry 2"),
    ({"volumes": [1e-5, 1e-5, 3e-5]}, "must rise: entry 1"),
    ({"volumes": [1e-5, 2e-5]}, "has 3 entries, volumes has 2"),
    ({"neutral_extension": 0.03}, "outside the table"),
])  # fmt: skip
def test_a_bladder_says_what_is_wrong_with_it(changes, words):
    table = {
        "kind": "bladder", "name": "B", "mass": 0.1, "position": [0, 0, 0], "extensions": [0.0, 0.01, 0.02],
        "volumes": [1e-5, 2e-5, 3e-5], "neutral_extension": 0.01,
    }  # fmt: skip
    Bladder.model_validate(table)
    with pytest.raises(ValidationError, match=words):
        Bladder.model_validate(table | changes)
