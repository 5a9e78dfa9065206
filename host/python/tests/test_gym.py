"""Environments of Gymnasium, simulated and on a board."""

from __future__ import annotations

import warnings
from typing import Any

import armbridge as ab
import armbridge.gym
import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

IDS = ["Armbridge/Balance-v0", "Armbridge/Reach-v0"]


def make(name: str, **options: Any) -> Any:
    return gym.make(name, **options).unwrapped


@pytest.mark.parametrize("mode", ["fast", "exact"])
@pytest.mark.parametrize("name", IDS)
def test_the_checker_of_gymnasium_accepts_them(name: str, mode: str) -> None:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        check_env(make(name, mode=mode))
    # It recommends actions without a unit, and would have bounds for speeds.
    known = ["symmetric and normalized", "minimum value is -infinity", "maximum value is infinity"]
    texts = [str(warning.message) for warning in found]
    assert [text for text in texts if not any(it in text for it in known)] == []


def episode(env: Any, seed: int, steps: int = 30) -> NDArray[np.float32]:
    rows = [env.reset(seed=seed)[0]]
    for i in range(steps):
        rows.append(env.step(np.array([0.3 * np.sin(0.3 * i), 0.2], np.float32))[0])
    return np.array(rows)


@pytest.mark.parametrize("mode", ["fast", "exact"])
def test_equal_seeds_give_equal_bits(mode: str) -> None:
    first, second = make(IDS[1], mode=mode), make(IDS[1], mode=mode)
    assert np.array_equal(episode(first, 3), episode(second, 3))
    # The next episode is another, and the same in both.
    assert np.array_equal(episode_after(first), episode_after(second))
    assert not np.array_equal(episode(first, 3), episode(second, 4))


def episode_after(env: Any) -> NDArray[np.float32]:
    return np.array(env.reset()[0])


def balance(observation: NDArray[np.float32]) -> NDArray[np.float32]:
    """A state feedback for both joints, in N m."""
    torque = -np.array([2.5, 2.0]) * observation[0:2] - np.array([0.3, 0.3]) * observation[2:4]
    return torque.astype(np.float32)


@pytest.mark.parametrize("mode", ["fast", "exact"])
def test_a_feedback_balances_the_arm_and_no_torque_lets_it_fall(mode: str) -> None:
    env = make(IDS[0], mode=mode)
    observation, _ = env.reset(seed=1)
    rewards = []
    for _ in range(150):
        observation, reward, terminated, truncated, _ = env.step(balance(observation))
        assert not terminated
        rewards.append(reward)
    assert np.mean(rewards[-50:]) > 0.4
    env.reset(seed=1)
    ends = [env.step(np.zeros(2, np.float32))[2] for _ in range(150)]
    assert any(ends)


def test_an_episode_is_truncated_after_its_steps() -> None:
    env = make(IDS[1], action="setpoint", steps=5)
    env.reset(seed=1)
    ends = [env.step(np.zeros(2, np.float32))[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]


def test_pwm_is_the_torque_that_the_calibration_makes_of_it() -> None:
    torque, pwm = make(IDS[0]), make(IDS[0], action="pwm")
    torque.reset(seed=1)
    pwm.reset(seed=1)
    assert pwm.action_space.high[0] == 1000 and torque.action_space.high[0] == pytest.approx(1.0, abs=0.5)
    pwm.step(np.array([100, -100], np.float32))
    torque.step(np.array(pwm._env.info["torque_nm"], np.float32))
    assert list(pwm._env.info["pwm"]) == list(torque._env.info["pwm"])
    assert abs(int(pwm._env.info["pwm"][0]) - 1100) <= 1


def test_many_at_once_are_what_each_is_alone() -> None:
    count = 5
    many = gym.make_vec(IDS[1], num_envs=count, vectorization_mode="vector_entry_point", action="setpoint", steps=60)
    assert many.observation_space.shape == (count, 6)
    alone = [make(IDS[1], action="setpoint", steps=60) for _ in range(count)]
    together, _ = many.reset(seed=7)
    apart = np.array([env.reset(seed=7 + i)[0] for i, env in enumerate(alone)])
    assert np.array_equal(together, apart)
    ended = [False] * count
    last = np.zeros(count)
    for _ in range(150):
        actions = together[:, 4:6]
        together, rewards, terminated, truncated, _ = many.step(actions)
        for i, env in enumerate(alone):
            if ended[i]:
                row, reward, ended[i] = env.reset()[0], 0.0, False
            else:
                row, reward, end, cut, _ = env.step(actions[i])
                assert (end, cut) == (terminated[i], truncated[i])
                ended[i] = end or cut
            assert np.array_equal(together[i], row) and rewards[i] == reward
        last = np.where(truncated, rewards, last)
    # A setpoint at the target brings it there by the end of an episode.
    assert last.mean() > 0.5


def test_each_episode_has_one_of_the_arms() -> None:
    arms = [ab.Plant().varied(0.3, seed) for seed in range(8)]
    assert arms[1] == ab.Plant().varied(0.3, 1) and arms[1] != arms[2]
    env = make(IDS[0], plant=arms)
    env.reset(seed=1)
    falls = set()
    for _ in range(10):
        env.reset(options={})
        for _ in range(20):
            env.step(np.array([0.3, 0.1], np.float32))
        start = env._env.info["true_angle_rad"]
        falls.add(tuple(np.round(start, 6)))
    assert len(falls) == 10


def test_a_connected_board_has_the_same_spaces_and_limits() -> None:
    simulated = make(IDS[1], action="setpoint")
    with ab.connect("sim:") as board:
        env = make(IDS[1], action="setpoint", board=board, ticks=50)
        assert env.observation_space == simulated.observation_space
        assert env.action_space == simulated.action_space
        observation, _ = env.reset(seed=2)
        start, _ = simulated.reset(seed=2)
        # It has moved there by itself, and has the same target.
        assert np.abs(observation[:2] - start[:2]).max() < 0.05
        assert np.array_equal(observation[4:], start[4:])
        reward = 0.0
        for _ in range(30):
            observation, reward, terminated, _, _ = env.step(observation[4:])
            assert not terminated
        # The controller of its own settings does not know the friction.
        assert reward > 0.3
        with pytest.raises(ValueError, match="a connected board is one environment"):
            gym.make_vec(IDS[1], num_envs=2, vectorization_mode="vector_entry_point", board=board)
        board.stop()
        _, _, terminated, _, info = env.step(observation[4:])
        assert terminated and info["fault"] is not None
        # The next episode clears the fault; the arm may have fallen too far for the board.
        board.lift()
    with pytest.raises(ab.ClosedError):
        make(IDS[1], board=board)


def test_what_is_no_action_is_an_error() -> None:
    env = make(IDS[0])
    with pytest.raises(RuntimeError, match="call reset before step"):
        env._env.step([0.0, 0.0])
    env.reset(seed=1)
    for action, error in [
        ([np.nan, 0.0], ValueError),
        ([0.0], ValueError),
        (0.0, TypeError),
        (["a", "b"], TypeError),
    ]:
        with pytest.raises(error):
            env._env.step(action)
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"mode": "quick"}, "expected exact or fast"),
        ({"action": "voltage"}, "expected torque"),
        ({"ticks": 0}, "out of range"),
        ({"ticks": 100_000}, "out of range"),
        ({"plant": []}, "at least one"),
        ({"plant": "none"}, "no virtual arm"),
        ({"settings": {"no.such": 1}}, "no.such"),
    ]
    for options, match in wrong:
        with pytest.raises(ValueError, match=match):
            make(IDS[0], **options)
    many = ab._native.Environments(make(IDS[1])._env, 2)
    with pytest.raises(ValueError, match="expected 2 seeds"):
        many.reset([1])
    many.reset([1, 2])
    with pytest.raises(ValueError, match=r"shape \(2, 2\)"):
        many.step(np.zeros((3, 2)))
    with pytest.raises(TypeError):
        whole: Any = np.zeros((2, 2), np.int64)
        many.step(whole)
