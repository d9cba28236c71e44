"""Environments of Gymnasium and PettingZoo."""

import gymnasium
import numpy as np
import pytest
import usarsim
import usarsim.gym
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

TASKS = [task for task in usarsim.tasks() if "Team" not in task]
SHORT = """
description = "Short"
map = "rough"
robot = "YouBot"
drive_model = "analytic"
time_step = 0.02
control_interval = 0.04
seconds = 0.2
[action]
twist = [0.8, 0.8, 1.0]
[start]
[reach]
distance = [0.1, 0.3]
tolerance = 0.1
"""


@pytest.fixture
def short(tmp_path):
    """A task whose episodes last five actions."""
    (tmp_path / "short.toml").write_text(SHORT)
    return str(tmp_path / "short.toml")


@pytest.mark.parametrize("task", TASKS)
def test_gymnasium_checks_every_task(task):
    environment = gymnasium.make(f"usarsim/{task}-v0", render_mode="rgb_array").unwrapped
    check_env(environment)


@pytest.mark.parametrize("task", TASKS)
def test_stable_baselines3_checks_every_task(task):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(f"usarsim/{task}-v0").unwrapped)


def test_a_vector_has_the_bits_of_environments_one_by_one():
    vector = gymnasium.make_vec("usarsim/YouBotReach-v0", num_envs=5, vectorization_mode="vector_entry_point")
    alone = [gymnasium.make("usarsim/YouBotReach-v0").unwrapped for _ in range(5)]
    seen, _ = vector.reset(seed=7)
    first = [one.reset(seed=7 + number)[0] for number, one in enumerate(alone)]
    assert np.array_equal(seen, first)
    actions = np.random.default_rng(1).uniform(-1, 1, (60, 5, 3)).astype(np.float32)
    for row in actions:
        seen, rewards, terminated, truncated, _ = vector.step(row)
        steps = [one.step(action) for one, action in zip(alone, row)]
        assert np.array_equal(seen, [step[0] for step in steps])
        assert np.array_equal(rewards, [step[1] for step in steps])
        assert np.array_equal(terminated | truncated, [step[2] or step[3] for step in steps])
    assert vector.unwrapped.digests() == [one.digest() for one in alone]


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_a_vector_resets_as_gymnasiums_own_does(short, mode):
    """Gymnasium's vector of single environments is the reference of the three modes."""
    make = lambda: usarsim.gym.TaskEnv(short)  # noqa: E731
    theirs = gymnasium.vector.SyncVectorEnv([make] * 4, autoreset_mode=mode)
    ours = usarsim.gym.TaskVectorEnv(short, 4, autoreset_mode=mode)
    assert ours.metadata["autoreset_mode"] is mode
    assert np.array_equal(theirs.reset(seed=3)[0], ours.reset(seed=3)[0])
    actions = np.random.default_rng(2).uniform(-1, 1, (12, 4, 3)).astype(np.float32)
    for row in actions:
        wanted, got = theirs.step(row), ours.step(row)
        for one, other in zip(wanted[:4], got[:4]):
            assert np.array_equal(one, other), mode
        ended = wanted[2] | wanted[3]
        if mode is AutoresetMode.SAME_STEP and ended.any():
            assert np.array_equal(wanted[4]["_final_obs"], got[4]["_final_obs"])
            last = np.stack([obs for obs, end in zip(wanted[4]["final_obs"], ended) if end])
            assert np.array_equal(last, got[4]["final_obs"][ended])
        if mode is AutoresetMode.DISABLED and ended.any():
            mask = {"reset_mask": ended}
            wanted, got = theirs.reset(options=dict(mask)), ours.reset(options=dict(mask))
            assert np.array_equal(wanted[0], got[0])


def test_seeds_make_episodes_and_none_goes_on():
    environment = gymnasium.make("usarsim/YouBotReach-v0").unwrapped
    first, again = environment.reset(seed=1)[0], environment.reset(seed=1)[0]
    assert np.array_equal(first, again)
    assert not np.array_equal(first, environment.reset()[0])
    assert not np.array_equal(first, environment.reset(seed=2)[0])
    vector = gymnasium.make_vec("usarsim/YouBotReach-v0", num_envs=3)
    by_list = vector.reset(seed=[4, 5, 6])[0]
    assert np.array_equal(by_list, vector.reset(seed=4)[0])


def test_pictures_of_environments(short):
    environment = usarsim.gym.TaskEnv(short, render_mode="rgb_array", size=(64, 48))
    environment.reset(seed=1)
    assert environment.render().shape == (48, 64, 3)
    vector = usarsim.gym.TaskVectorEnv(short, 2, render_mode="rgb_array", size=(64, 48))
    vector.reset(seed=1)
    assert [picture.shape for picture in vector.render()] == [(48, 64, 3)] * 2


def test_wrong_arguments_raise(short):
    with pytest.raises(ValueError, match="render_mode"):
        usarsim.gym.TaskEnv(short, render_mode="human")
    with pytest.raises(ValueError, match="has 3 robots"):
        usarsim.gym.TaskEnv("P3ATTeamExplore")
    environment = usarsim.gym.TaskEnv(short)
    environment.reset()
    with pytest.raises(usarsim.TaskError, match="got an action of NaN"):
        environment.step(np.full(3, np.nan))
    with pytest.raises(usarsim.TaskError, match=r"expected \[1, 3\]"):
        environment.step(np.zeros(2))


def test_pettingzoo_checks_the_team():
    parallel_api_test = pytest.importorskip("pettingzoo.test").parallel_api_test
    from usarsim.pettingzoo import parallel_env

    environment = parallel_env("P3ATTeamExplore")
    parallel_api_test(environment, num_cycles=50)
    first = environment.reset(seed=2)[0]
    assert list(first) == ["robot_0", "robot_1", "robot_2"]
    again = environment.reset(seed=2)[0]
    assert all(np.array_equal(first[agent], again[agent]) for agent in first)
    seen, rewards, terminated, _, _ = environment.step({agent: np.ones(2, np.float32) for agent in environment.agents})
    assert set(seen) == set(rewards) == set(first) and not any(terminated.values())
