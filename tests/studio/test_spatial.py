"""A run in three dimensions: what the page is told, and how the server itself shows it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator

import numpy as np
import pytest

from models.presets import load_preset
from models.run import Run
from models.simulate import simulate
from studio.attitude import attitude_at, attitude_of, attitudes, continuous, rotate
from studio.curves import MAX_POINTS, SHOWN, run_document
from studio.session import Session
from studio.state import state_json, state_of
from studio.view import View, moved_to
from studio.water import path_points
from tests.studio.conftest import wait_until
from tests.studio.spiral import ROLL_ANGLE, spiral


@pytest.fixture(scope="module")
def run(kernel: None) -> Run:
    return simulate(spiral())


@pytest.fixture(scope="module")
def turning(kernel: None) -> Iterator[Session]:
    made = Session("a-spiral", spiral())
    wait_until(lambda: not made.simulating, timeout=60.0)
    yield made
    made.close()


def test_it_tends_to_the_published_bank_and_turn(run: Run) -> None:
    # Zhang et al., 2013: -13.7 deg and 0.0039 rad/s (two digits); the piston's own mass shifts it a little
    assert math.degrees(run.final["phi"]) == pytest.approx(-13.7, abs=0.2)
    assert run.final["turn_rate"] == pytest.approx(0.0039, abs=2e-4)


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw"), [(0.3, 0.0, 0.0), (0.0, -0.5, 0.0), (0.0, 0.0, 2.5), (-0.4, 0.7, -1.2)]
)
def test_attitudes_are_yaw_then_pitch_then_roll(roll: float, pitch: float, yaw: float) -> None:
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    R = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]
    R = R @ [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    turned = rotate(np.eye(3), attitude_of(roll, pitch, yaw))
    assert turned == pytest.approx(R.T, abs=1e-12)  # a row for each body axis


def test_the_attitude_is_that_of_the_angles(run: Run) -> None:
    for k in (0, 500, -1):
        angles = (float(run.values[name][k]) for name in ("phi", "theta", "psi"))
        expected = np.array(attitude_of(*angles))
        shown = np.array(attitude_at(run, float(run.times[k])))
        assert abs(shown @ expected) == pytest.approx(1.0, abs=1e-9)  # q and -q are one attitude


def test_neighbouring_quaternions_have_one_sign() -> None:
    turn = np.linspace(0.0, 6.0 * np.pi, 200)
    q = np.column_stack([np.cos(turn / 2), 0 * turn, 0 * turn, np.sin(turn / 2)])
    flipped = q * np.where(np.arange(200) % 7 < 3, 1.0, -1.0)[:, None]
    smooth = continuous(flipped)
    assert (np.sum(smooth[1:] * smooth[:-1], axis=1) > 0.9).all()
    assert smooth == pytest.approx(q * np.sign(flipped[0, 0]), abs=1e-12)


def test_the_page_gets_the_columns_it_uses_and_no_more(run: Run) -> None:
    document = run_document(run, run.design)
    columns = document["columns"]
    made = {"t", "heading", "travelled", "q0", "q1", "q2", "q3"}
    assert set(columns) == made | set(SHOWN["spatial"])
    assert set(document["units"]) == set(columns)
    assert {len(column) for column in columns.values()} == {len(columns["t"])}
    assert len(columns["t"]) <= MAX_POINTS["spatial"]
    assert {cell["name"]: cell["unit"] for cell in document["cells"]} == {"Battery": "rad", "Engine": "m"}
    assert max(document["cells"][0]["extension"]) == pytest.approx(ROLL_ANGLE, abs=1e-6)
    # the way over ground is at least the straight line, and heading counts on past a half turn
    assert columns["travelled"][-1] > math.hypot(columns["x"][-1], columns["y"][-1])
    assert np.abs(np.diff(columns["heading"])).max() < 1.0
    q = np.column_stack([columns[f"q{i}"] for i in range(4)])
    assert np.linalg.norm(q, axis=1) == pytest.approx(1.0, abs=1e-6)  # seven digits


def test_what_is_not_a_number_is_null_in_the_state(turning: Session) -> None:
    state = json.loads(state_json(turning, saved_at=None), parse_constant=lambda token: pytest.fail(token))
    assert state["run"]["model"] == state["model"] == "spatial"
    # at rest in roll and yaw it goes straight: a circle of no radius
    assert state["run"]["columns"]["turn_radius"][0] is None
    assert state["run"]["columns"]["turn_radius"][-1] == pytest.approx(102.8, abs=1.0)


def test_a_rolling_mass_is_told_with_pivot_and_unit(turning: Session) -> None:
    battery = state_of(turning, saved_at=None)["components"][1]
    assert (battery["unit"], battery["pivot"], battery["cell"]) == ("rad", (0.4216, 0.0, 0.0), False)


def test_the_path_has_all_three_dimensions(run: Run) -> None:
    points = path_points(run)
    assert points[-1] == pytest.approx([run.final[name] for name in ("x", "y", "z")], abs=1e-12)
    # an even share of the samples keeps a circle round: no step is much longer than the mean
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() < 3.0 * steps.mean()


def test_the_server_shows_the_attitude_and_the_rolled_mass(turning: Session) -> None:
    view, run = View(turning), turning.run
    assert run is not None
    try:
        view.set_clock(300.0)
        shown = np.array(view.glider.frame.wxyz)
        k = int(np.searchsorted(run.times, 300.0))
        assert abs(shown @ attitudes(run)[k]) == pytest.approx(1.0, abs=1e-9)
        place = [-float(run.values[name][k]) for name in ("x", "y", "z")]
        assert np.array(view.water.frame.position) == pytest.approx(place, abs=1e-6)
        nose, starboard = rotate(np.eye(3)[:2], tuple(shown))
        assert nose[1] > 0.2, "it turned to starboard, east of north"
        assert starboard[2] < -0.1, "it banks to port: the starboard wing is up, and up is negative"
        battery = view.glider._parts[1]._frame
        # rolled by 45 deg about x, what hung below the pivot swings to port
        assert np.array(battery.position) == pytest.approx([0.4216, -0.014 * math.sqrt(0.5), 0.014 * math.sqrt(0.5)])
        assert np.array(view.markers.centers["com"].position)[1] < 0.0
    finally:
        view.close()


def test_a_rolling_mass_turns_about_its_pivot() -> None:
    battery = spiral().vehicle.components[1]
    (x, y, z), attitude = moved_to(battery, math.pi / 2.0)
    assert (x, y, z) == pytest.approx((0.4216, -0.014, 0.0), abs=1e-12)
    assert rotate(np.array([[0.0, 1.0, 0.0]]), attitude)[0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder", "movable_mass", "rolling_mass", "rigid"])
def test_each_kind_can_be_added_and_drawn_in_three_dimensions(kernel: None, kind: str) -> None:
    session = Session("a-spiral-two", spiral(duration=5.0))
    view = View(session)
    try:
        session.add_component(kind)
        session.duplicate_component(session.selected)
        wait_until(lambda: not session.simulating, timeout=60.0)
        assert session.problem == ()
        view.set_clock(2.0)
    finally:
        view.close()
        session.close()


def test_the_view_follows_from_space_into_the_plane_and_back(kernel: None, caplog: pytest.LogCaptureFixture) -> None:
    session = Session("a-spiral-three", spiral(duration=300.0))
    view = View(session)
    told = []
    session.subscribe(lambda change: told.append(view.water._frame))
    try:
        for duration in (60.0, 600.0, 30.0):  # more rungs, fewer, none
            session.set_field("/mission/duration", duration)
            wait_until(lambda: not session.simulating, timeout=60.0)
        session.replace(load_preset("canete-dual-bellows"))
        wait_until(lambda: not session.simulating and told[-1].kind == "plane")
        session.undo()
        session.set_field("/mission/duration", 400.0)
        wait_until(lambda: not session.simulating and told[-1].kind == "space", timeout=60.0)
        assert "failed" not in caplog.text
    finally:
        view.close()
        session.close()
