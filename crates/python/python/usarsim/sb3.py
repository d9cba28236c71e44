"""Environments for Stable-Baselines3.

>>> from stable_baselines3 import PPO  # doctest: +SKIP
>>> from usarsim.sb3 import TaskVecEnv
>>> model = PPO("MlpPolicy", TaskVecEnv("YouBotReach", 64)).learn(100_000)  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from .gym import TaskVectorEnv


class TaskVecEnv(VecEnv):
    """A task in many worlds, which one call steps on all cores, as a vector of Stable-Baselines3.

    `task` is the name of a shipped task, see `usarsim.tasks()`, or the path of a task.toml. `threads` is 0 for as many as the machine runs
    at a time.
    """

    def __init__(self, task: str, num_envs: int = 1, *, threads: int = 0, render_mode: str | None = None) -> None:
        self._vector = TaskVectorEnv(
            task, num_envs, autoreset_mode=AutoresetMode.SAME_STEP, threads=threads, render_mode=render_mode
        )
        self.render_mode = render_mode
        self._actions = np.zeros((0, 0), np.float32)
        self._returns, self._lengths = np.zeros(num_envs), np.zeros(num_envs, np.int64)
        super().__init__(num_envs, self._vector.single_observation_space, self._vector.single_action_space)

    def reset(self) -> np.ndarray:
        given = [seed for seed in self._seeds if seed is not None]
        observations, _ = self._vector.reset(seed=[int(seed) for seed in given] if given else None)
        self._reset_seeds()
        self._reset_options()
        self._returns[:], self._lengths[:] = 0.0, 0
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, infos = self._vector.step(self._actions)
        ended = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for number in np.flatnonzero(ended):
            told[number] = {
                "terminal_observation": infos["final_obs"][number],
                "TimeLimit.truncated": bool(truncated[number] and not terminated[number]),
                "is_success": bool(infos["is_success"][number]),
                "episode": {"r": float(self._returns[number]), "l": int(self._lengths[number])},
            }
        self._returns[ended], self._lengths[ended] = 0.0, 0
        return observations, rewards.astype(np.float32), ended, told

    def close(self) -> None:
        self._vector.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        return [np.asarray(self._vector.picture(number)) for number in range(self.num_envs)]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        value = getattr(self if attr_name == "render_mode" else self._vector, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise AttributeError(f"{attr_name}: the worlds of a vector have no attributes of their own")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        raise AttributeError(f"{method_name}: the worlds of a vector have no methods of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]
