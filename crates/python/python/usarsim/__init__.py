"""A robot simulator that is right about wheels: Mecanum, skid steering, tracks.

>>> import usarsim
>>> world = usarsim.World(usarsim.Scene("rough"))
>>> robot = world.spawn("YouBot", position=(0, 0, 0))
>>> robot.drive_twist(forward=0.3)
>>> world.run(seconds=2.0)
>>> bool(0.5 < robot.position[0] < 0.6)
True

The frame is that of USARSim: x forward, y to the right, z down. Units are metres, kilograms, seconds and radians.
"""

from __future__ import annotations

import json
import os
from typing import Any, Literal

from ._native import (
    Batch,
    CommandError,
    Environments,
    Error,
    LogError,
    Object,
    Reading,
    Robot,
    SaveError,
    Scene,
    SceneError,
    TaskError,
    UsarsimWarning,
    World,
    __version__,
    _fit,
    _replay,
    _run_experiment,
    _validate,
    maps,
    robots,
    scenarios,
    tasks,
)
from ._picture import Picture
from ._view import View

DriveModel = Literal["articulated", "analytic", "kinematic", "kinematic-textbook", "bodies"]

__all__ = [
    "Batch",
    "CommandError",
    "Environments",
    "Error",
    "LogError",
    "Object",
    "Picture",
    "Reading",
    "Robot",
    "SaveError",
    "Scene",
    "SceneError",
    "TaskError",
    "UsarsimWarning",
    "View",
    "World",
    "__version__",
    "describe",
    "fit",
    "maps",
    "replay",
    "robots",
    "scenarios",
    "run_experiment",
    "tasks",
    "validate",
]


def describe(scene: Scene, class_name: str | None = None) -> dict[str, Any]:
    """Returns every number of a robot class, or of the map, as `usarsim show` prints them.

    >>> describe(Scene("rough"), "P3AT")["steering"]
    'Skid'
    """
    numbers: dict[str, Any] = json.loads(scene._map_json() if class_name is None else scene._robot_json(class_name))
    return numbers


def replay(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Repeats the run of a log and compares every state and reading.

    Returns `same` (bool), `seconds`, `digest`, `recorded` (the log's digest or None), `states` (how many were compared) and
    `first_difference` (s or None).
    """
    result: dict[str, Any] = json.loads(_replay(path))
    return result


def validate(
    robot: str | os.PathLike[str] = "YouBotArm",
    *,
    drive_model: DriveModel | None = None,
    set: list[str] | None = None,
    checks: list[int] | None = None,
    seconds: float = 20.0,
    time_step: float = 0.002,
) -> list[dict[str, Any]]:
    """Runs the physical checks of a robot on wheels, as `usarsim validate` does.

    Returns a list of findings with `check`, `name`, `what`, `measured`, `least`, `most`, `passes` and `reason`.
    """
    text = _validate(
        os.fspath(robot), drive_model=drive_model, set=set or [], checks=checks, seconds=seconds, time_step=time_step
    )
    findings: list[dict[str, Any]] = json.loads(text)
    return findings


def run_experiment(
    file: str | os.PathLike[str], out: str | os.PathLike[str], *, jobs: int | None = None
) -> list[dict[str, Any]]:
    """Runs an experiment file into the folder `out`, with tables, plots and a report, and returns the outcome of each run.

    Finished runs in the folder are kept, as with `usarsim experiment run`.
    """
    outcomes: list[dict[str, Any]] = json.loads(_run_experiment(file, out, jobs=jobs or os.cpu_count() or 1))
    return outcomes


def fit(
    file: str | os.PathLike[str], *, drive_model: DriveModel | None = None, jobs: int | None = None
) -> dict[str, Any]:
    """Fits parameters of a robot so that simulated steps match measured ones, as `usarsim experiment fit` does."""
    found: dict[str, Any] = json.loads(_fit(file, drive_model=drive_model, jobs=jobs or os.cpu_count() or 1))
    return found
