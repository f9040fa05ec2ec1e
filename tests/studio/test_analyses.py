"""A session's slower analyses: what modes move, how large the run's error is, polars, and trims that are wanted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing

import httpx
import numpy as np
import pytest

from models.assemble import assemble
from models.attitude import quaternion_from_rpy_radians, rotation_of
from models.design import Design, parse_design
from models.glide_polar import glide_polar
from models.limits import DEFAULT_LIMITS
from models.linearize import linearize
from models.modes import modes_of
from models.operating_point import point_of
from models.presets import load_preset
from models.problems import DesignError
from models.simulate import Control, simulate
from models.trim import Trim, find_trims
from studio.error_estimate import differences, error_estimate, tightened
from studio.glide_polar_document import glide_polar_document
from studio.mode_motion import HELD, modes_document, motion_of_mode
from tests.studio.conftest import Studio, wait_until

STEP = 1e-6


def turning() -> tuple[Design, Trim]:
    """Return a design and a trim of it that turns, so that every amplitude of a mode counts."""
    design = load_preset("quad-bellows-spiral")
    last = {s.cell: s.points[-1].extension for s in design.mission.control.schedules}
    trim = find_trims(design, extensions=last).stable[0]
    assert trim.turn_radius is not None
    return design, trim


@pytest.mark.usefixtures("kernel")
class TestModes:
    def test_the_leading_one_grows_as_the_trim_says(self) -> None:
        design, trim = turning()
        told = modes_document(assemble(design), point_of(trim))
        leading = next(mode for mode in told["modes"] if mode["name"] == told["leading"])
        # lags of the actuators are states here, and all faster
        assert leading["real"] == pytest.approx(trim.growth, rel=1e-5)
        assert told["stable"] and told["equilibrium"]
        for mode in told["modes"]:
            assert sum(mode["shares"]) == pytest.approx(1.0)
            assert mode["participation"]

    def test_the_place_follows_from_the_velocity_over_ground(self) -> None:
        """p' = R v: with p and R v disturbed by a mode, (lambda + Omega x) p = d(R v), by differences of R v itself."""
        design, trim = turning()
        model = linearize(assemble(design), point_of(trim))
        kept = model.without(*HELD)
        omega = np.array([[0.0, -trim.turn_rate], [trim.turn_rate, 0.0]])
        for mode in modes_of(kept.A, kept.state_names).modes:
            motion = motion_of_mode(model, mode)
            assert motion is not None
            vector = dict(zip(kept.state_names, mode.eigenvector, strict=True))
            angles = np.array([motion["roll"], motion["pitch"], motion["yaw"]])
            moved = np.array([vector["u"], vector["v"], vector["w"]])
            velocity = sum(
                unit * (over_ground(trim, part(angles), part(moved)) - over_ground(trim, -part(angles), -part(moved)))
                for unit, part in ((1.0, np.real), (1j, np.imag))
            ) / (2.0 * STEP)
            place = np.array([motion["ahead"], motion["right"]])
            np.testing.assert_allclose(mode.eigenvalue * place + omega @ place, velocity[:2], atol=1e-6)
            assert mode.eigenvalue * motion["down"] == pytest.approx(velocity[2], abs=1e-6)

    def test_the_largest_motion_is_one(self) -> None:
        design, trim = turning()
        for mode in modes_document(assemble(design), point_of(trim))["modes"]:
            sizes = {name: math.hypot(*pair) for name, pair in mode["motion"].items()}
            angles = [sizes[name] for name in ("roll", "pitch", "yaw")]
            lengths = [sizes[name] / 2.0 for name in ("ahead", "right", "down")]  # the glider is 2 m long
            assert max(*angles, *lengths) == pytest.approx(1.0)


def over_ground(trim: Trim, angles: np.ndarray, moved: np.ndarray) -> np.ndarray:
    roll, pitch, yaw = STEP * angles + [trim.roll, trim.pitch, 0.0]
    velocity: np.ndarray = rotation_of(quaternion_from_rpy_radians(roll, pitch, yaw)) @ (trim.velocity + STEP * moved)
    return velocity


def with_solver(design: Design, **solver: object) -> Design:
    mission = design.mission.model_copy(update={"solver": design.mission.solver.model_copy(update=solver)})
    return parse_design(design.model_copy(update={"mission": mission}).model_dump(mode="json"))


@pytest.mark.usefixtures("kernel")
class TestTheError:
    @pytest.mark.parametrize("solver", [{"tolerance": 1e-4}, {"method": "rk4", "step": 0.1}])
    def test_is_about_the_difference_to_a_nearly_exact_run(
        self, dual_bellows: Design, solver: dict[str, object]
    ) -> None:
        coarse = simulate(with_solver(dual_bellows, **solver))
        exact = simulate(with_solver(dual_bellows, method="adaptive", tolerance=1e-12))
        told = {one["name"]: one for one in error_estimate(coarse, DEFAULT_LIMITS, Control())["differences"]}
        for true in differences(coarse, exact):
            # of RK4 with half the step a sixteenth of the error is left
            assert told[true.name]["largest"] == pytest.approx(true.largest, rel=0.1)
            assert abs(true.largest) > 0.0

    def test_where_nothing_is_tighter_it_says_so(self, dual_bellows: Design) -> None:
        with pytest.raises(DesignError, match="nothing tighter") as caught:
            tightened(with_solver(dual_bellows, tolerance=1e-13))
        assert caught.value.problems[0].pointer == "/mission/solver/tolerance"

    def test_a_run_that_takes_too_long_is_refused_with_the_way_out(self, dual_bellows: Design) -> None:
        control = Control()
        control.cancel()
        with pytest.raises(DesignError, match="takes too long") as caught:
            error_estimate(simulate(dual_bellows), DEFAULT_LIMITS, control)
        assert caught.value.problems[0].hint


@pytest.mark.usefixtures("kernel")
def test_the_glide_polar_is_the_library_s(dual_bellows: Design) -> None:
    assembly = assemble(dual_bellows)
    told, polar = glide_polar_document(assembly), glide_polar(assembly, points=24)
    assert [len(curve["points"]) for curve in told["curves"]] == [len(c.points) for c in polar.curves if c.points]
    assert polar.best_range is not None
    best = {point["name"]: point for point in told["best"]}
    assert best["Best range"]["glide_angle"] == polar.best_range.glide_angle
    flattest = min(abs(math.atan2(p[1], p[0])) for curve in told["curves"] for p in curve["points"] if p[3])
    assert abs(best["Best range"]["glide_angle"]) == pytest.approx(flattest)


@pytest.fixture(scope="module")
def client(studio: Studio) -> Iterator[httpx.Client]:
    opened, _ = studio.open()
    opened.headers["Origin"] = studio.url
    opened.timeout = httpx.Timeout(30.0)
    with closing(opened):
        wait_until(lambda: (opened.get("state").json()["consequences"] or {}).get("analyses") == "ready")
        yield opened


class TestTheAnswers:
    def test_modes_of_a_hold_and_of_an_instant(self, client: httpx.Client) -> None:
        held = client.get("modes", params={"hold": 1})
        assert held.status_code == 200 and held.headers["cache-control"] == "no-store"
        trim = client.get("state").json()["consequences"]["holds"][1]["trim"]
        assert held.json()["point"]["pitch"] == trim["pitch"]
        moving = client.get("modes", params={"time": 3.0}).json()
        assert not moving["equilibrium"] and moving["point"]["time"] == 3.0

    @pytest.mark.parametrize(
        ("query", "told"),
        [({"hold": 9}, "hold 9 is none of the 2"), ({"time": -1}, "a number of at least 0 is wanted, not '-1'")],
    )
    def test_what_there_is_not_is_refused(self, client: httpx.Client, query: dict[str, int], told: str) -> None:
        answer = client.get("modes", params=query)
        assert answer.status_code == 422
        assert told in answer.text

    def test_error_and_glide_polar(self, client: httpx.Client) -> None:
        error = client.get("error-estimate").json()
        assert {one["name"] for one in error["differences"]} == {"x", "z", "theta", "speed"}
        assert 0.0 < error["finer_residual"] < error["residual"]
        assert {point["name"] for point in client.get("glide-polar").json()["best"]} >= {"Best range", "Slowest sink"}

    def test_a_kept_run_has_its_own_consequences(self, client: httpx.Client) -> None:
        kept = client.post("runs", json={}).json()["id"]
        before = client.get("state").json()["consequences"]
        told = client.get(f"runs/{kept}/consequences").json()
        assert told["holds"] == before["holds"]
        assert client.get("runs/run-99/consequences").status_code == 404

    def test_a_wanted_glide_or_why_there_is_none(self, client: httpx.Client) -> None:
        found = client.post("trim-for", json={"targets": {"glide_angle": -0.5}}).json()
        assert found["failure"] is None
        assert found["trims"][0]["glide_angle"] == pytest.approx(-0.5, abs=1e-9)
        missed = client.post("trim-for", json={"targets": {"speed": 3.0}}).json()
        assert missed["trims"] == []
        assert missed["failure"]["nearest"]["speed"] < 3.0
        assert missed["failure"]["message"]
        wrong = client.post("trim-for", json={"targets": {"glide": 1.0}})
        assert wrong.status_code == 422 and wrong.json()["errors"][0]["pointer"] == "/targets/glide"

    def test_strangers_get_nothing(self, studio: Studio, client: httpx.Client) -> None:
        path = client.base_url.path
        with studio.client as stranger:
            for name in ("modes", "glide-polar", "error-estimate"):
                assert stranger.get(f"{path}{name}").status_code == 403
