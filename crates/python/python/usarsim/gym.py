"""Environments for Gymnasium.

>>> import gymnasium
>>> import usarsim.gym  # registers the environments
>>> environment = gymnasium.make("usarsim/YouBotReach-v0")
>>> observation, info = environment.reset(seed=1)
>>> observation, reward, terminated, truncated, info = environment.step(environment.action_space.sample())

`gymnasium.make_vec("usarsim/YouBotReach-v0", num_envs=1024)` steps all environments in one call on all cores. Environment `i` of a vector
with the seed `s` is the same as one alone with the seed `s + i`, bit by bit.
"""

from __future__ import annotations

from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _native
from ._picture import Picture

_SIZE = (480, 320)
_MODES: dict[AutoresetMode, Literal["next_step", "same_step", "disabled"]] = {
    AutoresetMode.NEXT_STEP: "next_step",
    AutoresetMode.SAME_STEP: "same_step",
    AutoresetMode.DISABLED: "disabled",
}


def _spaces(core: _native.Environments) -> tuple[spaces.Box, spaces.Box]:
    """Returns the spaces of observations and actions of one robot."""
    seen = spaces.Box(-np.inf, np.inf, (core.observations,), np.float32)
    return seen, spaces.Box(-1.0, 1.0, (core.actions,), np.float32)


def _check_render_mode(mode: str | None) -> None:
    if mode not in (None, "rgb_array"):
        raise ValueError(f"render_mode: got {mode!r}, expected None or 'rgb_array'")


def _check_one_robot(core: _native.Environments) -> None:
    if core.robots != 1:
        text = f"{core.name} has {core.robots} robots: expected one; usarsim.pettingzoo.parallel_env takes several"
        raise ValueError(text)


class TaskEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """A task in one world.

    `task` is the name of a shipped task, see `usarsim.tasks()`, or the path of a task.toml.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(self, task: str, render_mode: str | None = None, size: tuple[int, int] = _SIZE) -> None:
        _check_render_mode(render_mode)
        self._core = _native.Environments(task, 1, threads=1)
        _check_one_robot(self._core)
        self._arrays = self._core.arrays()
        self.observation_space, self.action_space = _spaces(self._core)
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self._core.control_interval)}
        self.render_mode = render_mode
        self._size = size
        self._is_seeded = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        if seed is None and not self._is_seeded:
            seed = int(self.np_random.integers(2**63))
        self._is_seeded = True
        observations = self._arrays[0]
        self._core.reset(observations, None if seed is None else [seed])
        return observations[0].copy(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        observations, rewards, terminated, truncated, successes, last = self._arrays
        actions = np.asarray(action, np.float32).reshape(1, -1)
        self._core.step(actions, "disabled", observations, rewards, terminated, truncated, successes, last)
        info = {"is_success": bool(successes[0])}
        return observations[0].copy(), float(rewards[0, 0]), bool(terminated[0]), bool(truncated[0]), info

    def render(self) -> np.ndarray | None:
        if self.render_mode is None:
            gymnasium.logger.warn("render() without render_mode='rgb_array' draws nothing")
            return None
        return np.asarray(self._core.picture(0, list(self._size)))

    def digest(self) -> str:
        """Returns a hash of the bits of every body."""
        return self._core.digests[0]


class TaskVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """A task in many worlds, which one call steps on all cores.

    `threads` is the number of threads; 0 takes as many as the machine runs at a time. With `copy=False` the arrays that `step` returns are
    those of the next step, too.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25, "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        threads: int = 0,
        copy: bool = True,
        size: tuple[int, int] = _SIZE,
    ) -> None:
        _check_render_mode(render_mode)
        self._core = _native.Environments(task, num_envs, threads=threads)
        _check_one_robot(self._core)
        self._arrays = self._core.arrays()
        self._copy = copy
        self._size = size
        self._is_seeded = False
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        fps = round(1.0 / self._core.control_interval)
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space, self.single_action_space = _spaces(self._core)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed if isinstance(seed, int) else None)
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = np.ascontiguousarray(mask, np.bool_)
        self._core.reset(self._arrays[0], self._seeds(seed), mask)
        return self._given(self._arrays[0]), {}

    def _seeds(self, seed: int | list[int | None] | None) -> list[int] | None:
        """Returns a seed for each environment, or None to let their random numbers go on."""
        if seed is None:
            if self._is_seeded:
                return None
            seed = int(self.np_random.integers(2**62))
        self._is_seeded = True
        if isinstance(seed, (int, np.integer)):
            return [int(seed) + number for number in range(self.num_envs)]
        drawn = self.np_random.integers(2**62, size=self.num_envs)
        return [int(drawn[number]) if one is None else int(one) for number, one in enumerate(seed)]

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        observations, rewards, terminated, truncated, successes, last = self._arrays
        actions = np.ascontiguousarray(actions, np.float32)
        mode = _MODES[self.autoreset_mode]
        self._core.step(actions, mode, observations, rewards, terminated, truncated, successes, last)
        infos: dict[str, Any] = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            ended = terminated | truncated
            if ended.any():
                infos["final_obs"], infos["_final_obs"] = last.copy(), ended
                infos["final_info"] = {"is_success": successes.copy(), "_is_success": ended}
                infos["_final_info"] = ended.copy()
        infos["is_success"], infos["_is_success"] = self._given(successes), np.ones(self.num_envs, np.bool_)
        given = self._given
        return given(observations), given(rewards[:, 0]), given(terminated), given(truncated), infos

    def _given(self, array: np.ndarray) -> np.ndarray:
        return array.copy() if self._copy else array

    def render(self) -> tuple[np.ndarray, ...] | None:
        if self.render_mode is None:
            gymnasium.logger.warn("render() without render_mode='rgb_array' draws nothing")
            return None
        return tuple(np.asarray(self._core.picture(number, list(self._size))) for number in range(self.num_envs))

    def picture(self, number: int = 0) -> Picture:
        """Draws the world of one environment."""
        return self._core.picture(number, list(self._size))

    def digests(self) -> list[str]:
        """Returns a hash of the bits of every body, a world each."""
        return self._core.digests


def register_envs() -> None:
    """Registers `usarsim/<task>-v0` for every shipped task of one robot. This module does so when it is imported."""
    for task in _native.tasks():
        name = f"usarsim/{task}-v0"
        if "Team" not in task and name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="usarsim.gym:TaskEnv",
                vector_entry_point="usarsim.gym:TaskVectorEnv",
                kwargs={"task": task},
            )


register_envs()
