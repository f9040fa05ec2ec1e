"""Tables of gains go from trim to trim, and say what is missing."""

from __future__ import annotations

import numpy as np
import pytest

from models.controller_options import ControllerOptions
from models.design import Design
from models.gain_table import GainTable, design_table
from models.problems import DesignError
from models.run import Run, Status
from models.simulate import simulate
from tests.models.design_support import uniform


@pytest.fixture(scope="module")
def quad() -> Design:
    return uniform()


@pytest.fixture(scope="module")
def table_flight(quad: Design) -> tuple[GainTable, Run]:
    """From one glide angle to another and back, over a table of five."""
    values = (-0.6, -0.55, -0.5, -0.45, -0.4)
    points = [(0.0, -0.6), (50.0, -0.6), (120.0, -0.4), (320.0, -0.4), (390.0, -0.5)]
    options = ControllerOptions(
        trim={"targets": {"speed": 0.2}, "depth": 20.0},
        table={"target": "glide_angle", "values": values, "set_points": [{"time": t, "value": v} for t, v in points]},
    )  # fmt: skip
    table = design_table(quad, options)
    return table, simulate(table.mission(duration=600.0, interval=1.0))


def test_a_table_of_gains_goes_from_glide_to_glide(table_flight: tuple[GainTable, Run]):
    table, run = table_flight
    assert run.status is Status.completed
    path = -np.arctan2(run.values["z_dot"], np.hypot(run.values["x_dot"], run.values["y_dot"]))
    for time, wanted in ((49.0, -0.6), (319.0, -0.4), (599.0, -0.5)):
        assert path[int(time)] == pytest.approx(wanted, abs=1e-3)
        assert run.values["speed"][int(time)] == pytest.approx(0.2, abs=1e-3)
    assert table.controller.scheduled_by == "glide angle, rad"
    assert not any("not stable" in warning or "stabilise" in warning for warning in table.warnings)


def test_a_table_says_which_trim_is_missing(quad: Design):
    options = ControllerOptions(
        trim={"targets": {"speed": 0.2}, "depth": 20.0}, table={"target": "glide_angle", "values": (-0.5, -0.01)}
    )
    with pytest.raises(DesignError, match=r"glide_angle -0\.01") as error:
        design_table(quad, options)
    assert error.value.problems[0].pointer == "/options/table/values/1"
