"""Suggested loops hold what they are asked to, within the time they state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from models.assemble import assemble
from models.controller_design import design_controller
from models.controller_options import ControllerOptions
from models.controllers import Cascade, DepthBand
from models.design import Design, parse_design
from models.loop_response import mission_from
from models.loop_suggestion import suggest_loops
from models.mass_properties import mass_balance
from models.operating_point import point_of
from models.problems import DesignError
from models.simulate import simulate
from models.trim import find_trims
from tests.models.design_support import level_cells, uniform


@pytest.fixture(scope="module")
def quad() -> Design:
    return uniform()


@pytest.mark.parametrize("angle", [-0.5, 0.5])
def test_suggested_loops_hold_pitch_and_heading(quad: Design, angle: float):
    """A turn of 0.5 rad and a pitch 0.05 rad off: within the stated time both are there and stay, without swinging."""
    depth = 110.0 if angle > 0 else 20.0
    options = ControllerOptions(trim={"targets": {"glide_angle": angle, "speed": 0.2}, "depth": depth})
    point = design_controller(quad, options).problem.point
    suggested = suggest_loops(quad, point, heading=0.5)
    assert suggested.growth < 0.0 and suggested.settling_time < 600.0
    off = replace(point, pitch=point.pitch + 0.05)
    end = suggested.settling_time + 100.0
    run = simulate(mission_from(quad, off, suggested.cascade, duration=end, interval=1.0))
    late = run.times > suggested.settling_time
    assert np.abs(run.values["theta"][late] - point.pitch).max() < 2e-3
    assert np.abs(run.values["psi"][late] - 0.5).max() < 0.03
    assert np.ptp(run.values["theta"][late]) < 1e-3 and np.ptp(run.values["phi"][late]) < 0.02


@pytest.mark.parametrize("angle", [-0.5, 0.5])
def test_suggested_loops_serve_dives_and_climbs(quad: Design, angle: float):
    """From one phase for both: a bank to the same side turns to the other side on climbs, which the loops know.

    In a yo-yo each phase settles on its pitch and the heading, and the gain of the heading is one for both.
    """
    trim = {"targets": {"glide_angle": angle, "speed": 0.2}, "depth": 65.0}
    point = design_controller(quad, ControllerOptions(trim=trim)).problem.point
    cascade = suggest_loops(quad, point, heading=0.5).cascade
    assert cascade.lateral.heading_loop.proportional > 0.0 and cascade.lateral.climb_bank == "opposite"
    assert cascade.pitch.dive < 0.0 < cascade.pitch.climb
    again = Cascade.model_validate_json(cascade.model_dump_json())
    heave = abs(cascade.vertical.heave)
    band = DepthBand(
        kind="depth_band", top=30.0, bottom=100.0, dive_heave=-heave, climb_heave=heave,
        first="climb" if angle > 0.0 else "dive",
    )  # fmt: skip
    controller = again.model_copy(update={"vertical": band})
    run = simulate(mission_from(quad, point, controller, duration=1800.0, interval=1.0))
    turns = [event.time for event in run.events if event.kind in ("dive", "climb")]
    assert len(turns) >= 2
    ends = [*turns, run.times[-1]]
    for k, end in enumerate(ends):
        # the heading is reached in the first phase, and held through every turn since
        at = np.abs(run.times - (end - 5.0)).argmin()
        climbs = (angle > 0.0) == (k % 2 == 0)
        assert run.values["theta"][at] == pytest.approx(cascade.pitch.climb if climbs else cascade.pitch.dive, abs=2e-3)
        assert run.values["psi"][at] == pytest.approx(0.5, abs=0.03)


def test_loops_need_moments():
    design = level_cells()
    trim = find_trims(design, extensions={"Front port cell": 0.03, "Rear port cell": 0.045}, depth=50.0).stable[0]
    with pytest.raises(DesignError, match="cannot make roll moments"):
        suggest_loops(design, point_of(trim))


def test_a_turn_has_no_heading_to_hold(quad: Design):
    document = quad.model_dump(mode="json")
    document["vehicle"]["components"][5]["position"][1] *= 1.01
    trim = find_trims(design := parse_design(document), depth=50.0).stable[0]
    assert trim.turn_rate != 0.0
    with pytest.raises(DesignError, match=f"turns at {abs(trim.turn_rate):.3g} rad/s") as refused:
        suggest_loops(design, trim)
    assert refused.value.problems[0].pointer == "/options/trim"


def test_gains_beyond_all_limits_are_told(quad: Design):
    document = quad.model_dump(mode="json")
    document["vehicle"]["added_mass"]["matrix"][4][4] = 1e9
    design = parse_design(document)
    with pytest.raises(DesignError, match="beyond their limits: derivative"):
        suggest_loops(design, find_trims(design, depth=50.0).solutions[0], sample_time=0.01)


def test_a_planar_glider_gets_a_loop_of_pitch_alone():
    """By one mass without lag: four time constants leave less than 2 % of a departure of 0.05 rad."""
    design = uniform("slocum-glide")
    trim = find_trims(design, depth=20.0).stable[0]
    suggested = suggest_loops(design, trim, sample_time=0.5)
    assert suggested.cascade.lateral is None and suggested.growth < 0.0
    point = point_of(trim)
    off = replace(point, pitch=point.pitch + 0.05)
    run = simulate(mission_from(design, off, suggested.cascade, duration=suggested.settling_time, interval=0.5))
    assert abs(run.values["theta"][-1] - point.pitch) < 1e-3


def test_an_axis_is_what_the_vehicle_weighs_and_floats():
    """Of pitch: the inertia with added mass, as moments of weight and buoyancy shrink with the cosine of pitch."""
    design = uniform("quad-bellows-glide")
    extensions = {"Front port cell": 0.045, "Front starboard cell": 0.045}
    trim = find_trims(design, extensions=extensions, depth=50.0).stable[0]
    pitch = suggest_loops(design, trim).axes[0]
    balance = mass_balance(design.vehicle)
    whole = assemble(design).params.added[4, 4] + balance.inertia_about_origin[1, 1]
    # couplings of added mass with surge and heave, and bellows that fill: some percent
    assert pitch.inertia * np.cos(trim.pitch) == pytest.approx(whole, rel=0.05)
