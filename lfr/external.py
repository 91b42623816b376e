"""Arms that this project does not simulate: section ``external`` of params.yaml.

Each is known by LeRobot datasets alone. Skill models and mappings are learned from these; what
needs a simulator, such as success rates and transfer learning, is there where the arm names one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from lfr.columns import ActionPart, Columns, Part
from lfr.embodiments import is_known
from lfr.errors import UnknownNameError
from lfr.params import PARAMS, read_yaml
from lfr.records import from_mapping

SECTION = "external"


@dataclass(frozen=True)
class EnvironmentParams:
    """A Gymnasium environment in which an arm does a task.

    Its action is the dataset's action as it was recorded.

    Attributes:
        id: as `gymnasium.make` takes it; ``module:name`` imports the module that registers it.
        kwargs: that it is made with.
        observation: column of the dataset -> entry of the environment's observation, with dots
            where dictionaries are nested; {} where the observation itself is the only column.
        success: entry of ``info`` that is true where the task has succeeded.
        success_reward: instead, the reward from which on it has.
        horizon: control steps of an episode; None takes the environment's own.
    """

    id: str
    kwargs: dict[str, Any] = field(default_factory=dict)
    observation: dict[str, str] = field(default_factory=dict)
    success: str = "is_success"
    success_reward: float | None = None
    horizon: int | None = None


@dataclass(frozen=True)
class ExternalTask:
    """An arm's demonstrations of one task.

    Attributes:
        instruction: the task in the dataset's words; None takes all episodes of the dataset.
        path: the dataset, where it is not the arm's.
        observation: its parts, where they are not the arm's.
    """

    instruction: str | None = None
    path: Path | None = None
    observation: tuple[Part, ...] = ()


@dataclass(frozen=True)
class ExternalArm:
    """An arm by its LeRobot v3.0 datasets.

    Attributes:
        fps: control steps per second, which every dataset and environment must have.
        tasks: by their names in scenarios.
        observation: parts of the observation, for tasks that name none of their own.
        action: the action.
        path: the dataset, for tasks that name none of their own.
        robot_type: what every dataset must say of its robot; None takes any.
        resample: control steps per second that models see and choose, fewer than ``fps``; None is
            as many (`lfr.data.resample`).
        environments: task -> where the arm can do it, also one that it has no dataset of.
        cartesian: actions and observations are named and scaled as this project's own
            (docs/data.md), so demonstrations of turned, mirrored and shifted scenes count too.
    """

    fps: int | float
    tasks: dict[str, ExternalTask]
    observation: tuple[Part, ...] = ()
    action: ActionPart = field(default_factory=ActionPart)
    path: Path | None = None
    robot_type: str | None = None
    resample: float | None = None
    environments: dict[str, EnvironmentParams] = field(default_factory=dict)
    cartesian: bool = False

    def __post_init__(self) -> None:
        for name, task in self.tasks.items():
            for what in ("path", "observation"):
                if not (getattr(task, what) or getattr(self, what)):
                    raise ValueError(f"no {what} for task {name!r}, nor one of the arm")
        if self.resample is not None and not 0 < self.resample <= self.fps:
            raise ValueError(
                f"resample: fewer than the {self.fps:g} control steps a second that were recorded, "
                f"found {self.resample:g}; resample the faster one of two arms"
            )
        if (self.resample is None) != (self.action.deltas is None):
            raise ValueError(
                "'resample' and the action's 'deltas' go together: of the numbers of the action, "
                "those that are changes or speeds are averaged over a step ([]: none is)"
            )

    @property
    def rate(self) -> float:
        """Control steps per second, as models see them."""
        return self.resample or self.fps

    def dataset(self, task: str) -> Path:
        """The folder of a task's dataset."""
        path = self._task(task).path or self.path
        assert path is not None
        return path

    def columns(self, task: str) -> Columns:
        """How the rows of a task's dataset become observations and actions."""
        return Columns(self._task(task).observation or self.observation, self.action)

    def instruction(self, task: str) -> str | None:
        """Which episodes of the dataset are of this task; None: all."""
        return self._task(task).instruction

    def _task(self, name: str) -> ExternalTask:
        if name not in self.tasks:
            raise UnknownNameError("task", name, self.tasks)
        return self.tasks[name]


@dataclass(frozen=True)
class External:
    """Section ``external`` of params.yaml.

    Attributes:
        arms: by name.
        scenarios: as section ``scenarios``, of these arms; `lfr.scenarios` reads them.
        transfers: those whose skill models and mapping the pipeline trains.
        learned: of these, those that are learned in the target's environment.
    """

    arms: dict[str, ExternalArm] = field(default_factory=dict)
    scenarios: dict[str, Any] = field(default_factory=dict)
    transfers: tuple[str, ...] = ()
    learned: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        taken = sorted(filter(is_known, self.arms))
        if taken:
            raise ValueError(
                f"{', '.join(taken)} is an arm that this project simulates; "
                "give the one of your datasets another name"
            )
        lost = [name for name in self.learned if name not in self.transfers]
        if lost:
            raise ValueError(f"learned: {', '.join(lost)} is not among transfers")


def without_environments(arm: ExternalArm) -> ExternalArm:
    """The arm as its models know it: where it is judged changes nothing of what it learns."""
    return replace(arm, environments={})


def external(path: Path = PARAMS) -> External:
    """The section as it stands in a YAML file; empty where there is none.

    Raises:
        ParameterError: it has an unknown, missing or mistyped key, or contradicts itself.
    """
    section = read_yaml(path).get(SECTION)
    if section is None:
        return External()
    return from_mapping(External, section, f"{path}: {SECTION}")


def external_arms(robots: Iterable[str], path: Path = PARAMS) -> dict[str, ExternalArm]:
    """Those of ``robots`` that are external, by name."""
    known = external(path).arms
    return {robot: known[robot] for robot in robots if robot in known}
