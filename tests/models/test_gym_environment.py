"""Gliders as Gymnasium environments: interface, seeds, ends of episodes, and the motion against the adaptive kernel."""

from __future__ import annotations

import math
import re
import runpy
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from models.design import Design, parse_design
from models.glide_tasks import HoldHeading, Motion, ReachWaypoint, StayInBand, wrapped
from models.gym_environment import ID, STEP_TIME, GliderEnv, GliderVectorEnv
from models.kernel.control_layout import DEPTH, EAST, NORTH, PITCH, ROLL, YAW
from models.own_controller import Measurement, simulate_with
from models.presets import load_preset

RANGES = {"depth": (5.0, 20.0), "heading": (-math.pi, math.pi), "pitch": (-0.3, 0.3), "roll": (-0.2, 0.2)}
PLANAR = "three-cell-glider"


def changed(preset: str, **environment: Any) -> Design:
    """Return a preset in another environment."""
    document = load_preset(preset).model_dump(mode="json")
    document["mission"]["environment"] |= environment
    return parse_design(document)


def actions_for(env: Any, count: int, *, seed: int = 0) -> np.ndarray:
    """Return random actions (count, ...), some of them beyond -1 and 1."""
    return np.random.default_rng(seed).uniform(-1.2, 1.2, (count, *env.action_space.shape)).astype(np.float32)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"task": "waypoint", "action": "forces", "initial": RANGES},
        {"task": "depth_band", "design": PLANAR, "duration": 5.0},
        {"task": "heading", "design": PLANAR, "action": "forces", "duration": 5.0},
    ],
)
def test_the_interface_is_gymnasiums(arguments):
    env = gymnasium.make(f"models.gym_environment:{ID}", **arguments)  # warnings are errors
    check_env(env.unwrapped)
    assert len(env.unwrapped.entries) == env.observation_space.shape[0]


def test_make_vec_gives_the_vector_environment():
    envs = gymnasium.make_vec(ID, num_envs=3, vectorization_mode="vector_entry_point", task="waypoint")
    assert isinstance(envs.unwrapped, GliderVectorEnv)
    observed, _ = envs.reset(seed=0)
    assert observed in envs.observation_space
    observed, rewards, terminated, truncated, _ = envs.step(envs.action_space.sample())
    assert observed in envs.observation_space
    assert rewards.shape == terminated.shape == truncated.shape == (3,)
    envs.close()


@pytest.mark.parametrize("task", ["heading", "depth_band", "waypoint"])
@pytest.mark.parametrize(("action", "threads"), [("cells", 1), ("forces", 2)])
def test_a_row_of_many_is_the_single_environment_bit_for_bit(task, action, threads):
    """Through ends of episodes and new beginnings; a bed near below ends some early."""
    shallow = changed("quad-bellows-glide", bed_depth=21.0, surface="end")
    start = RANGES | {"depth": (15.0, 20.95)}
    common: dict[str, Any] = {"task": task, "action": action, "initial": start, "duration": 30.0}
    envs = GliderVectorEnv(17, shallow, threads=threads, **common)
    together = [envs.reset(seed=40)[0]]
    actions = np.repeat(0.5 * actions_for(envs, 15) - 0.7, 25, axis=0)
    earned, ends = [], []
    for a in actions:
        observed, rewards, terminated, truncated, _ = envs.step(a)
        together.append(observed)
        earned.append(rewards)
        ends.append(terminated.astype(int) + 2 * truncated)
    assert {0, 1, 2} <= set(np.unique(ends))
    for row in (0, 8, 16):
        env, fresh = GliderEnv(shallow, **common), False
        np.testing.assert_array_equal(env.reset(seed=40 + row)[0], together[0][row])
        for k, a in enumerate(actions):
            if fresh:
                observed, reward, terminated, truncated = env.reset()[0], 0.0, False, False
            else:
                observed, reward, terminated, truncated, _ = env.step(a[row])
            np.testing.assert_array_equal(observed, together[k + 1][row])
            assert (reward, terminated + 2 * truncated) == (earned[k][row], ends[k][row])
            fresh = terminated or truncated
    envs.close()


def test_the_vector_environment_is_what_gymnasium_makes_of_single_ones():
    common: dict[str, Any] = {"initial": RANGES, "duration": 5.0}
    ours = GliderVectorEnv(4, **common)
    theirs = gymnasium.vector.SyncVectorEnv([lambda: GliderEnv(**common)] * 4)
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    np.testing.assert_array_equal(ours.reset(seed=[3, 1, 4, 1])[0], theirs.reset(seed=[3, 1, 4, 1])[0])
    for a in actions_for(ours, 50):
        for mine, other in zip(ours.step(a)[:4], theirs.step(a)[:4], strict=True):
            np.testing.assert_array_equal(mine, other)


def test_the_same_seed_gives_the_same_episodes_and_another_others():
    env = GliderEnv(task="waypoint", initial=RANGES)

    def episode(seed: int) -> np.ndarray:
        return np.array([env.reset(seed=seed)[0]] + [env.step(a)[0] for a in actions_for(env, 40)])

    np.testing.assert_array_equal(episode(1), episode(1))
    assert np.abs(episode(1) - episode(2)).max() > 0.1


def test_the_motion_is_that_of_the_adaptive_kernel():
    """Within a millimetre and a tenth of a milliradian over 100 s of random commands, at the step that it chose."""
    env = GliderEnv(duration=100.0)
    assert env.step_size == STEP_TIME
    env.reset(seed=0)
    actions = np.repeat(0.4 * actions_for(env, 20), 20, axis=0)
    seen = []
    for a in actions:
        env.step(a)
        seen.append(env.episodes.fleet.seen[0].copy())
    fleet = env.episodes.fleet
    told = fleet.low + 0.5 * (actions.astype(float) + 1.0) * (fleet.high - fleet.low)

    def replay(now: Measurement) -> dict[str, float]:
        return dict(zip(fleet.cells, told[round(now.time / STEP_TIME)], strict=True))

    document = load_preset("quad-bellows-glide").model_dump(mode="json")
    document["mission"] |= {"control": {}, "duration": 100.0}
    document["mission"]["solver"] |= {"output_interval": STEP_TIME, "tolerance": 1e-10}
    run = simulate_with(parse_design(document), replay, sample_time=STEP_TIME)
    assert np.ptp(run.values["theta"]) > 0.3 and np.ptp(run.values["phi"]) > 0.1
    for k, name in ((DEPTH, "z"), (NORTH, "x"), (EAST, "y")):
        np.testing.assert_allclose(np.array(seen)[:, k], run.values[name][1:], atol=1e-3)
    for k, name in ((ROLL, "phi"), (PITCH, "theta"), (YAW, "psi")):
        assert np.abs(wrapped(np.array(seen)[:, k] - run.values[name][1:])).max() < 1e-4


def test_observations_are_told_in_their_units():
    env = GliderEnv(initial={"depth": 12.0, "heading": 0.5, "roll": 0.1, "pitch": -0.2}, task=HoldHeading(heading=0.8))
    observed, _ = env.reset(seed=0)
    told = dict(zip(env.entries, observed.tolist(), strict=True))
    wanted = {"depth, m": 12.0, "roll, rad": 0.1, "pitch, rad": -0.2, "yaw, rad": 0.5, "heading error, rad": 0.3}
    assert {name: told[name] for name in wanted} == pytest.approx(wanted, abs=1e-6)
    for _ in range(400):  # 100 s, within which 0.05 m at 1 mm/s are done
        observed = env.step(np.array([1.0, -1.0, 0.5, 0.0]))[0]
    np.testing.assert_allclose(observed[10:14], [1.0, -1.0, 0.5, 0.0], atol=1e-5)


def test_a_current_carries_the_glider_that_begins_at_rest_in_the_water():
    current = {"kind": "uniform", "velocity": [0.2, 0.1]}
    env = GliderEnv(changed("quad-bellows-glide", current=current), initial={"depth": 10.0, "heading": 1.0})
    observed, _ = env.reset(seed=0)
    np.testing.assert_allclose(observed[4:7], 0.0, atol=1e-7)
    env.step(np.zeros(4))
    np.testing.assert_allclose(env.episodes.fleet.seen[0, 10:12], [0.05, 0.025], rtol=0.02)


def test_forces_are_allocated():
    env = GliderEnv(action="forces")
    assert env.episodes.actions.names == ("heave", "pitch", "roll")
    env.reset(seed=0)
    for action, signs in (([1, 0, 0], [1, 1, 1, 1]), ([0, 0.5, 0], [1, 1, -1, -1]), ([0, 0, 0.5], [1, -1, 1, -1])):
        env.step(np.array(action, dtype=np.float32))
        departure = env.episodes.fleet.told[0] - 0.05
        np.testing.assert_array_equal(np.sign(departure), signs)


def test_what_ends_an_episode_is_said():
    deep = {"initial": {"depth": 119.5}, "duration": 60.0}
    env = GliderEnv(**deep)
    env.reset(seed=0)
    for _ in range(240):
        *_, terminated, truncated, info = env.step(-np.ones(4))
        if terminated:
            break
    assert (truncated, info) == (False, {"status": "bed"})
    envs = GliderVectorEnv(2, duration=0.5)
    envs.reset(seed=0)
    envs.step(np.zeros((2, 4)))
    *_, truncated, info = envs.step(np.zeros((2, 4)))
    assert truncated.all() and info["status"].tolist() == ["completed"] * 2
    near = GliderEnv(task=ReachWaypoint(distance=(1.0, 1.0), radius=2.0))
    near.reset(seed=0)
    assert near.step(np.zeros(4))[2:] == (True, False, {"status": "reached"})


def test_a_glider_at_the_surface_does_not_hide_another_that_comes_to_it():
    """Rows are advanced one after another with one scratch: what one meets is not known to the next."""
    document = changed("quad-bellows-glide", surface="end")
    envs = GliderVectorEnv(3, document, duration=60.0)
    envs.reset(seed=0)
    for row, depth in enumerate((0.01, 0.011, 0.012)):
        envs.episodes.fleet.place(row, depth=depth, roll=0.0, pitch=0.0, heading=0.0)
    ended = np.full(3, -1)
    for k in range(240):
        terminated = envs.step(np.ones((3, 4)))[2]
        ended[terminated & (ended < 0)] = k
    alone = []
    for depth in (0.01, 0.011, 0.012):
        env, k = GliderEnv(document, duration=60.0, initial={"depth": depth}), 0
        env.reset(seed=0)
        while not env.step(np.ones(4))[2]:
            k += 1
        alone.append(k)
    assert ended.tolist() == alone


def test_the_example_learns(capsys):
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / "train_policy.py"))
    printed = capsys.readouterr().out
    by_mean = [float(number) for number in re.findall(r"(-?[\d.]+) by their mean", printed)]
    [at_last] = re.findall(r"the mean earns ([\d.]+)", printed)
    assert float(at_last) > by_mean[0] + 30.0


def test_rewards_are_what_the_tasks_say():
    seen, before = np.zeros((2, 12)), np.zeros((2, 12))
    seen[:, 3], seen[:, DEPTH], seen[:, 4], seen[:, 10] = [0.0, math.pi / 2], [5.0, 20.0], 0.3, [3.0, 0.0]

    def earned(task: Any, goal: list[float]) -> list[float]:
        motion = Motion(seen, before, seen, seen, np.tile(goal, (2, 1)), np.zeros((2, len(task.told))), 0.5)
        task.tell(motion, motion.entries)
        return task.reward(motion).tolist()

    assert earned(HoldHeading(), [0.0]) == pytest.approx([0.5, 0.0])
    assert earned(StayInBand(price=0.2), [10.0, 40.0]) == pytest.approx([0.5 * (0.3 - 1.0), 0.5 * 0.3])
    assert earned(ReachWaypoint(), [10.0, 0.0]) == pytest.approx([3.0, 0.0])


def test_a_reward_and_a_start_of_ones_own():
    env = GliderEnv(reward=lambda motion: -np.abs(motion.seen[:, PITCH] + 0.3), initial={"pitch": -0.3})
    env.reset(seed=0)
    assert -0.01 < env.step(np.zeros(4))[1] <= 0.0
    assert env.reset(options={"depth": 33.0})[0][0] == 33.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"task": "race"}, "no task 'race'"),
        ({"action": "thrust"}, "no actions 'thrust'"),
        ({"initial": {"speed": 1.0}}, "no initial 'speed'"),
        ({"initial": {"depth": (5.0, 200.0)}}, r"depth \(5.0, 200.0\) is not a rising range within 0 to 120"),
        ({"initial": {"heading": (1.0, 0.0)}}, "not a rising range"),
        ({"design": PLANAR, "initial": {"roll": 0.1}}, "no bank and no heading"),
        ({"step_time": 0.0}, "step_time 0 s"),
        ({"step": -1.0}, "step -1 s"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        GliderEnv(**arguments)


def test_actions_that_make_no_sense_are_refused():
    envs = GliderVectorEnv(2)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((2, 4)))
    envs.reset(seed=0)
    with pytest.raises(ValueError, match=r"the action for 'Rear port cell' of glider 1 is not a number, at 0 s"):
        envs.step(np.array([[0.0] * 4, [0.0, 0.0, math.nan, 0.0]]))
    with pytest.raises(ValueError, match=r"shape \(4,\), not \(2, 4\)"):
        envs.step(np.zeros(4))
