"""Root loci: branches followed, the crossing of a pendulum, values without a trim, and what is refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from models.design import parse_design
from models.limits import Limits
from models.linearize import linearize
from models.operating_point import OperatingPoint, point_of
from models.presets import load_preset
from models.problems import DesignError, Problem
from models.root_locus import root_locus, with_value
from models.simulate import simulate
from models.stability import stability_over
from models.targeted_trim import trim_for
from models.trim import find_trims
from tests.models.linear_support import GRAVITY, INERTIA, MASS, REST, resting_design

BELOW = "/vehicle/components/0/center_of_mass/2"


def at_rest(design, extensions, last):
    return REST


def test_a_pendulum_that_is_turned_over_is_known_at_once():
    """p' = -(d p + m g h phi) / I: stable until the centre of mass is above that of buoyancy, h = 0."""
    damping = 0.02
    design = resting_design(damping={"roll": damping, "pitch": 0.5})
    heights = np.linspace(0.0041, -0.0039, 21)
    locus = root_locus(design, BELOW, heights, trim_at=at_rest)
    assert locus.failures == () and locus.eigenvalues.shape == (21, 10)
    k = locus.names.index("roll oscillation")
    for h, root in zip(heights, locus.eigenvalues[:, k], strict=True):
        wanted = np.roots([INERTIA["xx"], damping, MASS * GRAVITY * h])
        assert np.abs(wanted - root).min() == pytest.approx(0.0, abs=2e-5)
    rolls = [c for c in locus.crossings if c.name == "roll oscillation"]
    assert len(rolls) == 1 and not rolls[0].becomes_stable
    # the root that crosses is nearly linear in h there: linear between two values 0.4 mm apart
    assert rolls[0].value == pytest.approx(0.0, abs=2e-5)
    assert rolls[0].frequency == pytest.approx(0.0, abs=1e-6)


def test_the_way_back_is_told_as_stable():
    design = resting_design(damping={"roll": 0.02, "pitch": 0.5})
    locus = root_locus(design, BELOW, np.linspace(-0.0039, 0.0041, 21), trim_at=at_rest)
    assert {crossing.becomes_stable for crossing in locus.crossings} == {True}


def test_branches_go_on_smoothly():
    """Two oscillations whose frequencies cross keep their names: roll by its inertia, pitch unchanged."""
    design = resting_design(added={3: 0.004}, damping={"roll": 1e-3, "pitch": 1e-3})
    values = np.linspace(0.005, 0.04, 36)
    locus = root_locus(design, "/vehicle/components/0/inertia/xx", values, trim_at=at_rest)
    roll, pitch = (locus.names.index(f"{axis} oscillation") for axis in ("roll", "pitch"))
    size = np.abs(locus.eigenvalues)
    np.testing.assert_allclose(size[:, roll], np.sqrt(MASS * GRAVITY * 0.004 / (values + 0.004)), rtol=1e-5)
    np.testing.assert_allclose(size[:, pitch], math.sqrt(MASS * GRAVITY * 0.004 / INERTIA["yy"]), rtol=1e-5)
    assert locus.crossings == ()


def test_values_without_a_trim_are_told_and_left_out():
    def picky(design, extensions, last):
        if design.vehicle.components[0].center_of_mass[2] > 0.0045:
            raise DesignError([Problem("", "too low for my taste")])
        return REST

    locus = root_locus(resting_design(), BELOW, [0.003, 0.004, 0.005, 0.0042], trim_at=picky)
    assert [value for value, _ in locus.failures] == [0.005]
    assert "too low" in locus.failures[0][1]
    assert np.isnan(locus.eigenvalues[2]).all() and np.isfinite(locus.eigenvalues[[0, 1, 3]]).all()
    assert locus.points[2] is None
    sent = json.loads(json.dumps(locus.as_dict(), allow_nan=False))
    assert sent["eigenvalues"][2] is None and len(sent["eigenvalues"][0]) == len(locus.names)


def test_where_nothing_can_be_trimmed_the_reason_is_given():
    def never(design, extensions, last):
        raise DesignError([Problem("", "nothing balances")])

    with pytest.raises(DesignError, match="nothing balances"):
        root_locus(resting_design(), BELOW, [0.003, 0.004], trim_at=never)


def test_a_value_that_is_no_design_is_one_failure():
    locus = root_locus(resting_design(), "/vehicle/components/0/mass", [1.0, -1.0], trim_at=at_rest)
    assert [value for value, _ in locus.failures] == [-1.0]


@pytest.fixture(scope="module")
def glider():
    design = load_preset("three-cell-glider")
    return design, {s.cell: s.points[-1].extension for s in design.mission.control.schedules}


def test_by_default_each_value_is_trimmed_anew(glider):
    design, ends = glider
    pointer, values = "/vehicle/components/2/position/2", [0.030, 0.032, 0.034]
    values = [design.vehicle.components[2].position[2] + step for step in (0.0, 0.002, 0.004)]
    locus = root_locus(design, pointer, values, extensions=ends)
    for value, point, row in zip(values, locus.points, locus.eigenvalues, strict=True):
        changed = with_value(design, pointer, value)
        trim = point_of(find_trims(changed, extensions=ends).stable[0])
        assert point.pitch == pytest.approx(trim.pitch, abs=1e-9)
        wanted = np.linalg.eigvals(linearize(changed, trim).A)
        assert max(np.abs(wanted - root).min() for root in row) == pytest.approx(0.0, abs=1e-7)
    pitches = [point.pitch for point in locus.points]
    assert np.all(np.diff(np.abs(pitches)) < 0.0)  # a lower ballast pitches less


def test_an_extension_can_be_the_parameter(glider):
    design, ends = glider
    values = ends["Front bellows"] + np.array([-5e-4, 0.0, 5e-4])
    locus = root_locus(design, "/extensions/Front bellows", values, extensions=ends)
    assert [point.extensions["Front bellows"] for point in locus.points] == pytest.approx(values.tolist())
    assert locus.failures == ()


def test_a_neutral_design_is_followed_at_rest():
    locus = root_locus(resting_design(damping={"roll": 0.02}), "/vehicle/components/0/inertia/xx", [0.01, 0.012])
    assert all(point.speed == 0.0 for point in locus.points)


def test_rest_is_at_the_depth_at_which_it_was_sought(glider):
    """A glider that starts at the surface is trimmed where all its parts are immersed."""
    made = resting_design(damping={"roll": 0.02}).model_dump(mode="json")
    made["mission"]["initial"]["position"][2] = 0.0
    made["mission"]["environment"]["surface"] = "float"
    made["vehicle"]["components"][0]["shapes"] = [
        {"kind": "hull", "length": 0.5, "radius": 0.05, "nose_length": 0.1, "tail_length": 0.1}
    ]
    design = parse_design(made)
    locus = root_locus(design, "/vehicle/components/0/inertia/xx", [0.01])
    assert locus.points[0].depth == find_trims(design).depth > 0.0
    assert root_locus(design, "/vehicle/components/0/inertia/xx", [0.01], depth=7.0).points[0].depth == 7.0


FREE = ("Middle piston", "Battery slide")
PATH = {"glide_angle": -0.5, "speed": 0.12}


def test_each_value_can_be_trimmed_to_the_same_motion(glider):
    design, ends = glider
    pointer = "/vehicle/components/2/position/2"
    values = [design.vehicle.components[2].position[2] + step for step in (0.0, 0.002, 0.004)]
    locus = root_locus(design, pointer, values, extensions=ends, targets=PATH, free=FREE)
    assert locus.failures == ()
    for value, point in zip(values, locus.points, strict=True):
        trim = trim_for(with_value(design, pointer, value), PATH, FREE, extensions=ends)
        assert point.speed == pytest.approx(0.12, abs=1e-9)
        assert point.extensions == pytest.approx(trim.extensions, abs=1e-9)
        assert point.extensions["Front bellows"] == ends["Front bellows"]
    assert len({point.extensions["Battery slide"] for point in locus.points}) == 3


def test_values_at_which_targets_are_not_met_are_failures(glider):
    design, ends = glider
    pointer = "/extensions/Middle piston"
    locus = root_locus(
        design, pointer, [-0.012, 0.02], extensions=ends, targets={"glide_angle": -0.5}, free=["Battery slide"]
    )
    assert [value for value, _ in locus.failures] == [0.02]  # light: it can only climb
    assert "place of" in locus.failures[0][1]


@pytest.mark.parametrize(
    ("options", "pointer"),
    [
        ({"targets": PATH}, "/options/free"),
        ({"free": FREE}, "/options/targets"),
        ({"targets": PATH, "free": FREE, "trim_at": at_rest}, "/options/targets"),
        ({"targets": {"lift": 1.0}, "free": FREE[1:]}, "/options/targets/lift"),
        ({"targets": PATH, "free": ["Wing"]}, "/options/free/0"),
        ({"targets": PATH, "free": [FREE[1], FREE[0]]}, "/options/free/1"),
    ],
)
def test_targets_that_do_not_fit_are_told_at_once(glider, options, pointer):
    with pytest.raises(DesignError) as refused:
        root_locus(glider[0], "/extensions/Middle piston", [0.0], **options)
    assert [problem.pointer for problem in refused.value.problems] == [pointer]


def test_progress_is_told_before_each_value_and_can_stop_it():
    calls = []

    def until(done, total):
        calls.append((done, total))
        return done < 2

    with pytest.raises(DesignError, match="cancelled"):
        root_locus(resting_design(), BELOW, [0.003, 0.004, 0.005, 0.006], trim_at=at_rest, progress=until)
    assert calls == [(0, 4), (1, 4), (2, 4)]
    assert root_locus(resting_design(), BELOW, [0.003], trim_at=at_rest, progress=until).failures == ()


def test_limits_of_the_caller_hold():
    few = Limits(duration=0.5)
    with pytest.raises(DesignError, match=r"limit of 0\.5"):
        root_locus(resting_design(), BELOW, [0.003], trim_at=at_rest, limits=few)
    run = simulate(resting_design())
    with pytest.raises(DesignError, match=r"limit of 0\.5"):
        stability_over(run, limits=few)


@pytest.mark.parametrize(
    ("pointer", "told"),
    [
        ("/extensions/~x", "no JSON Pointer"),
        ("/extensions/Front bellows/b", "no component that moves is named 'Front bellows/b'"),
        ("/extensions/", "no component that moves"),
        ("/extensions/Wing", "no component that moves is named 'Wing'"),
    ],
)
def test_pointers_to_extensions_name_one_cell(glider, pointer, told):
    with pytest.raises(DesignError, match=told) as refused:
        root_locus(glider[0], pointer, [0.0])
    (problem,) = refused.value.problems
    assert problem.pointer == pointer and "'" not in problem.hint and "Front bellows" in problem.hint


@pytest.mark.parametrize(
    ("pointer", "values", "told"),
    [
        ("/vehicle/components/9/mass", [1.0], "no such field"),
        ("/vehicle/nothing", [1.0], "no such field"),
        ("/name", [1.0], "not a number"),
        ("/vehicle/components/0", [1.0], "not a number"),
        ("/vehicle/added_mass/enabled", [1.0], "not a number"),
        ("", [1.0], "not a number"),
        ("not a pointer", [1.0], "no such field"),
        (BELOW, [], "finite values"),
        (BELOW, [math.nan], "finite values"),
    ],
)
def test_pointers_and_values_are_checked(pointer, values, told):
    with pytest.raises(DesignError, match=told):
        root_locus(resting_design(), pointer, values, trim_at=at_rest)


def test_the_design_itself_is_left_alone():
    design = resting_design()
    changed = with_value(design, BELOW, 0.003)
    assert changed.vehicle.components[0].center_of_mass[2] == 0.003
    assert design.vehicle.components[0].center_of_mass[2] == 0.004


def test_points_are_plain(glider):
    assert isinstance(REST, OperatingPoint)
    assert json.dumps(REST.as_dict(), allow_nan=False)
