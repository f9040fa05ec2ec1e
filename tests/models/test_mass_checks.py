"""What lets thousands of cases pass without eigenvalues is a true bound: nothing passes that they would refuse."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from models.assemble import assemble
from models.mass_checks import least_moment, turning_inertia, turns_hard
from models.mass_properties import Masses, initial_extensions, mass_balance, masses
from models.presets import load_preset, preset_ids
from tests.strategies import designs, spatial_designs

ENTRY = st.floats(-10.0, 10.0)


@given(st.tuples(*[ENTRY] * 9), st.sampled_from([0.0, 1e-6, 1.0]))
def test_no_principal_moment_lies_below_the_bound(entries, shift):
    root = np.array(entries).reshape(3, 3)
    symmetric = 0.5 * (root + root.T)
    for inertia in (symmetric, root @ root.T + shift * np.eye(3)):
        smallest = float(np.linalg.eigvalsh(inertia)[0])
        assert 0.0 <= least_moment(inertia.tolist()) <= max(smallest, 0.0) * (1.0 + 1e-6) + 1e-12


def test_the_bound_is_of_use():
    """A body of three unlike moments is told from none, whichever way it lies."""
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    inertia = turn @ np.diag([1.0, 2.0, 3.0]) @ turn.T
    assert 0.5 < least_moment(inertia.tolist()) <= 1.0


@given(st.tuples(*[ENTRY] * 36), st.floats(1e-6, 1e6), st.tuples(ENTRY, ENTRY, ENTRY), st.floats(1e-9, 1e3))
def test_what_turns_hard_alone_does_so_with_whatever_added_mass(entries, size, center, moment):
    root = np.array(entries).reshape(6, 6)
    added, inertia = size * root @ root.T, moment * np.eye(3)
    heavy = Masses(7.0, center, tuple(map(tuple, inertia.tolist())))
    if not turns_hard(heavy, moment, largest_added=float(np.abs(added).max())):
        return
    balance = mass_balance(load_preset(preset_ids()[0]).vehicle)
    balance = type(balance)(7.0, np.array(center), inertia, balance.volume, balance.center_of_buoyancy)
    assert np.linalg.eigvalsh(turning_inertia(balance, added))[0] > 1e-12 * 7.0


@given(st.one_of(designs(), spatial_designs()))
def test_plain_numbers_are_those_of_the_balance(design):
    assemble(design)
    extensions = initial_extensions(design)
    found, balance = masses(design.vehicle, extensions), mass_balance(design.vehicle, extensions)
    assert found.mass == balance.mass
    np.testing.assert_array_equal(found.center, balance.center_of_mass)
    np.testing.assert_array_equal(found.inertia, balance.inertia)
    about, moment = balance.inertia_about_origin, balance.mass * balance.center_of_mass
    numbers = [*moment, about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2]]
    np.testing.assert_array_equal(found.moments, numbers)
