"""Warnings of a run that left its hydrodynamic data: the shares are those of its samples."""

from __future__ import annotations

import numpy as np

from models.data_range import outside_data
from models.presets import load_preset
from models.simulate import simulate


def test_the_paper_glide_is_slower_than_the_data():
    run = simulate(load_preset("canete-dual-bellows"))
    (told,) = outside_data(run)
    slow = (run.values["speed"] < 0.1) & (run.values["speed"] > 0.0)
    assert told.limit == 0.1
    assert told.message.startswith(f"{100 * slow.mean():.0f} % of the run is slower than")


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
