"""Environments of Gymnasium: the arm, with the board's own code between it and the policy.

>>> import gymnasium as gym
>>> import armbridge.gym
>>> env = gym.make("Armbridge/Balance-v0", mode="exact")

| id                       | task                                                              |
|--------------------------|-------------------------------------------------------------------|
| `Armbridge/Balance-v0`   | bring the arm upright, and keep it there                          |
| `Armbridge/Reach-v0`     | bring the arm to a target that each episode draws                 |

Both have a vectorised form, `gym.make_vec(.., vectorization_mode="vector_entry_point")`, whose
environments run on all processors.

An action is a command to the board, within its limits: torques in N m (`action="torque"`),
setpoints in rad for its controller (`"setpoint"`), or PWM counts from off (`"pwm"`). It stays for
`ticks` ticks of 1 ms. The observation has the estimated angles in rad and speeds in rad/s, and the
target. The reward of a step is `1 - tanh(distance / 0.1 rad) - 0.05 effort`: 1 at the target without
torque. An episode ends when the board has switched torque off, or, in Balance, when a joint is
0.6 rad off; it is truncated after `steps` steps.

`mode="fast"` runs the tick of the board with constant delays for wire and servos, `mode="exact"` the
whole board with every byte on the wire; `board=` is a board of `armbridge.connect`, real or served,
which moves the arm to the start of each episode by itself. `settings` are parameters of the
board, `plant` is a virtual arm or a sequence of them, of which each episode has one: with
`plant=fit.plants(100)` a policy has to cope with all arms that an identification leaves possible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._native import Board, Environment, Environments, Plant

__all__ = ["ArmEnv", "ArmVectorEnv"]


def _spaces(env: Environment) -> tuple[Any, Any]:
    """Spaces of observations and actions; the type of a Box has all dtypes."""
    low, high = (bound.astype(np.float32) for bound in env.bounds)
    most = np.full(env.observations, np.inf, np.float32)
    return gym.spaces.Box(-most, most, dtype=np.float32), gym.spaces.Box(low, high, dtype=np.float32)


class ArmEnv(gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """One environment."""

    metadata = {"render_modes": []}

    def __init__(
        self,
        task: str,
        *,
        mode: str = "fast",
        action: str = "torque",
        settings: Mapping[str, Any] | None = None,
        plant: str | Plant | Sequence[str | Plant] | None = None,
        ticks: int = 20,
        steps: int = 250,
        board: Board | None = None,
    ) -> None:
        self._env = Environment(
            task, mode=mode, action=action, settings=settings, plant=plant, ticks=ticks, steps=steps, board=board
        )
        self.observation_space, self.action_space = _spaces(self._env)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode; the generator of episodes is seeded with `seed`."""
        super().reset(seed=seed)
        return self._env.reset(seed), self._env.info

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Runs a step. `info` has torque, PWM and fault of the last tick, and the true state of a
        simulated arm."""
        return *self._env.step(action), self._env.info


class ArmVectorEnv(gym.vector.VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """Many environments at once."""

    metadata = {"render_modes": [], "autoreset_mode": gym.vector.AutoresetMode.NEXT_STEP}

    def __init__(self, num_envs: int, task: str, **options: Any) -> None:
        one = Environment(task, **options)
        self._envs = Environments(one, num_envs)
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = _spaces(one)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode in each environment; one seed counts up from the first."""
        if seed is None or isinstance(seed, int):
            seed = [None if seed is None else seed + i for i in range(self.num_envs)]
        return self._envs.reset(list(seed)), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Runs a step of each environment; the step after the end of an episode begins the next."""
        return *self._envs.step(np.asarray(actions, np.float64)), {}


for _name, _task in [("Balance-v0", "balance"), ("Reach-v0", "reach")]:
    gym.register(
        f"Armbridge/{_name}",
        entry_point="armbridge.gym:ArmEnv",
        vector_entry_point="armbridge.gym:ArmVectorEnv",
        kwargs={"task": _task},
    )
