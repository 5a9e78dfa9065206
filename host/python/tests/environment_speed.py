"""Speed of the environments, beside MuJoCo's on the same arm and Gymnasium's Reacher.

pip install imageio && python host/python/tests/environment_speed.py
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any

import armbridge as ab
import armbridge.gym
import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

# It has no types.
mujoco: Any = importlib.import_module("mujoco")

TICKS = 20


def rate(ticks: int, work: Callable[[], None]) -> float:
    """Ticks a second, the best of three."""
    best = 0.0
    for _ in range(3):
        begun = time.perf_counter()
        work()
        best = max(best, ticks / (time.perf_counter() - begun))
    return best


def setpoint(i: int) -> NDArray[np.float32]:
    """A setpoint that keeps the arm in motion."""
    return np.array([0.2 * np.sin(0.1 * i), -0.2 * np.sin(0.13 * i)], np.float32)


def one(mode: str, steps: int) -> float:
    env = gym.make("Armbridge/Reach-v0", mode=mode, action="setpoint", ticks=TICKS, steps=10**9).unwrapped
    env.reset(seed=1)

    def work() -> None:
        for i in range(steps):
            _, _, terminated, _, _ = env.step(setpoint(i))
            assert not terminated

    return rate(steps * TICKS, work)


def many(count: int, steps: int) -> float:
    envs = gym.make_vec(
        "Armbridge/Reach-v0",
        num_envs=count,
        vectorization_mode="vector_entry_point",
        action="setpoint",
        ticks=TICKS,
        steps=10**9,
    )
    envs.reset(seed=1)
    actions = np.zeros((count, 2), np.float32)

    def work() -> None:
        for i in range(steps):
            actions[:] = setpoint(i)
            _, _, terminated, _, _ = envs.step(actions)
            assert not terminated.any()

    return rate(count * steps * TICKS, work)


def mj_step(steps: int) -> float:
    model = mujoco.MjModel.from_xml_string(ab.Plant().mjcf())
    data = mujoco.MjData(model)

    def work() -> None:
        for i in range(steps):
            data.ctrl[:] = [0.3 * np.sin(0.005 * i), 0.2]
            mujoco.mj_step(model, data)

    return rate(steps, work)


def reacher(steps: int) -> float:
    env = gym.make("Reacher-v5").unwrapped
    env.reset(seed=1)

    def work() -> None:
        for _ in range(steps):
            env.step(np.array([0.01, 0.01]))

    # Each step is two of MuJoCo's.
    return rate(2 * steps, work)


if __name__ == "__main__":
    print(f"exact                    {one('exact', 500):>10,.0f} ticks/s")
    print(f"fast                     {one('fast', 20_000):>10,.0f} ticks/s")
    print(f"fast, 64 at once         {many(64, 500):>10,.0f} ticks/s")
    print(f"MuJoCo's mj_step, 1 ms   {mj_step(100_000):>10,.0f} steps/s")
    print(f"Gymnasium's Reacher-v5   {reacher(20_000):>10,.0f} steps/s")
