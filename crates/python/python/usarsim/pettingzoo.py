"""Environments of several robots for PettingZoo.

>>> from usarsim.pettingzoo import parallel_env
>>> environment = parallel_env("P3ATTeamExplore")
>>> observations, infos = environment.reset(seed=1)
>>> environment.agents
['robot_0', 'robot_1', 'robot_2']
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv  # type: ignore[import-untyped]

from . import _native


class TaskParallelEnv(ParallelEnv[str, np.ndarray, np.ndarray]):  # type: ignore[misc]
    """A task of one or more robots in one world. All robots' episodes end together.

    `task` is the name of a shipped task, see `usarsim.tasks()`, or the path of a task.toml.
    """

    metadata = {"name": "usarsim_v0", "render_modes": ["rgb_array"], "is_parallelizable": True, "render_fps": 25}

    def __init__(self, task: str, render_mode: str | None = None, size: tuple[int, int] = (480, 320)) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode: got {render_mode!r}, expected None or 'rgb_array'")
        self._core = _native.Environments(task, 1, threads=1)
        self._arrays = self._core.arrays()
        self._size = size
        self._is_seeded = False
        self.render_mode = render_mode
        fps = max(1, round(1.0 / self._core.control_interval))
        self.metadata = {**self.metadata, "name": self._core.name, "render_fps": fps}
        self.possible_agents = [f"robot_{number}" for number in range(self._core.robots)]
        self.agents: list[str] = []
        seen = (self._core.observations,)
        self.observation_spaces = {
            agent: spaces.Box(-np.inf, np.inf, seen, np.float32) for agent in self.possible_agents
        }
        self.action_spaces = {
            agent: spaces.Box(-1.0, 1.0, (self._core.actions,), np.float32) for agent in self.possible_agents
        }

    def observation_space(self, agent: str) -> spaces.Box:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        if seed is None and not self._is_seeded:
            seed = int(np.random.default_rng().integers(2**62))
        self._is_seeded = True
        self._core.reset(self._arrays[0], None if seed is None else [seed])
        self.agents = list(self.possible_agents)
        return self._observations(), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, np.ndarray]
    ) -> tuple[
        dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        if not self.agents:
            return {}, {}, {}, {}, {}
        still = np.zeros(self._core.actions, np.float32)
        given = [np.asarray(actions.get(agent, still), np.float32) for agent in self.possible_agents]
        observations, rewards, terminated, truncated, successes, last = self._arrays
        row = np.concatenate(given).reshape(1, -1)
        self._core.step(row, "disabled", observations, rewards, terminated, truncated, successes, last)
        agents = self.agents
        result = (
            self._observations(),
            {agent: float(rewards[0, number]) for number, agent in enumerate(agents)},
            {agent: bool(terminated[0]) for agent in agents},
            {agent: bool(truncated[0]) for agent in agents},
            {agent: {"is_success": bool(successes[0])} for agent in agents},
        )
        if terminated[0] or truncated[0]:
            self.agents = []
        return result

    def _observations(self) -> dict[str, np.ndarray]:
        rows = self._arrays[0].reshape(len(self.possible_agents), -1)
        return {agent: rows[number].copy() for number, agent in enumerate(self.possible_agents)}

    def render(self) -> np.ndarray | None:
        return None if self.render_mode is None else np.asarray(self._core.picture(0, list(self._size)))

    def close(self) -> None:
        pass


def parallel_env(task: str, **options: Any) -> TaskParallelEnv:
    """Creates the environment of a task."""
    return TaskParallelEnv(task, **options)
