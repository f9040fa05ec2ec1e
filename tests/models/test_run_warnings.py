"""Warnings of a run that left its hydrodynamic data: the shares are those of its samples."""

from __future__ import annotations

import numpy as np
import pytest

from models.presets import load_preset
from models.run_warnings import inaccurate, outside_data
from models.simulate import simulate


def test_the_paper_glide_is_slower_than_the_data():
    run = simulate(load_preset("canete-dual-bellows"))
    (told,) = outside_data(run)
    slow = (run.values["speed"] < 0.1) & (run.values["speed"] > 0.0)
    assert told.limit == 0.1
    assert told.message.startswith(f"{100 * slow.mean():.0f} % of the run is slower than")


def test_a_coarse_fixed_step_is_told_as_inaccurate():
    design = load_preset("canete-dual-bellows")
    assert list(inaccurate(simulate(design))) == []
    solver = design.mission.solver.model_copy(update={"method": "rk4", "step": 0.4})
    run = simulate(design.model_copy(update={"mission": design.mission.model_copy(update={"solver": solver})}))
    assert run.relative_residual > 0.1
    (told,) = inaccurate(run)
    assert told.pointer == "/mission/solver/step"
    assert f"{100 * run.relative_residual:.2g} %" in told.message


def test_the_residual_does_not_depend_on_where_depth_counts_from():
    design = load_preset("canete-dual-bellows")
    shares = []
    for depth in (0.5, 1000.0):
        initial = design.mission.initial.model_copy(update={"position": (0.0, 0.0, depth)})
        run = simulate(design.model_copy(update={"mission": design.mission.model_copy(update={"initial": initial})}))
        shares.append(run.energy_exchanged)
    # the actuators' work is a difference of energies of 1e4 J at that depth, rounded at 1e-12 J
    assert shares[0] == pytest.approx(shares[1], abs=1e-9)


def test_a_glide_within_the_data_is_not_warned_of():
    steady = simulate(load_preset("three-cell-glider"))
    quick = steady.select(np.flatnonzero(steady.values["speed"] >= 0.1))
    assert len(quick.times) > 100
    assert list(outside_data(quick)) == []


def test_backward_motion_is_told_with_its_largest_angle():
    design = load_preset("canete-dual-bellows")
    initial = design.mission.initial.model_copy(update={"velocity": (-0.2, 0.0, 0.0), "position": (0.0, 0.0, 5.0)})
    run = simulate(design.model_copy(update={"mission": design.mission.model_copy(update={"initial": initial})}))
    past = [problem for problem in outside_data(run) if problem.limit == 90.0]
    assert len(past) == 1
    assert f"up to {np.rad2deg(np.abs(run.values['alpha']).max()):.0f} deg" in past[0].message
