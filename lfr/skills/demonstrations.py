"""The demonstrations that a model may see, as windows: the leak rule is held as they are read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

from lfr.artifacts import file_hash
from lfr.columns import ActionSpace
from lfr.data.checks import check_dataset
from lfr.data.episode import FPS, JOINT_POSITION, features_of
from lfr.data.external import read_external
from lfr.data.windows import DemonstrationSet, WindowBatch, Windows, read_dataset
from lfr.embodiments import embodiment
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.scenarios import Role, Scenario, check_visible
from lfr.skills.hand_motion import HandSteps, hand_steps
from lfr.skills.symmetry import actions_turn_with_base
from lfr.tasks import task as task_named

DATASETS = Path("data/lerobot")


@dataclass(frozen=True)
class Demonstrations:
    """One robot's demonstrations of one task.

    Windows lie within an episode, unpadded: a recording lingers beyond its success so that these
    hold its last skill too.

    Attributes:
        dataset: name of the dataset, ``<robot>-<task>`` where it is this project's own.
        digest: SHA-256 of the dataset's rows.
        names: of the observation's dimensions.
        actions: the names of the action's dimensions, and what -1 and 1 stand for.
        training, held_out: windows of different episodes.
        training_states, held_out_states: (N, D), every state of these episodes.
        training_motions, held_out_motions: how joints and hand moved in these episodes, where
            actions are motions of the joints; else None.
    """

    dataset: str
    digest: str
    names: tuple[str, ...]
    actions: ActionSpace
    training: WindowBatch
    held_out: WindowBatch
    training_states: Tensor
    held_out_states: Tensor
    training_motions: HandSteps | None = None
    held_out_motions: HandSteps | None = None


def read_visible(
    scenario: Scenario,
    robot: str,
    role: Role,
    tasks: Sequence[str],
    *,
    horizon: int,
    held_out: float,
    seed: int,
    folder: Path = DATASETS,
    arm: ExternalArm | None = None,
) -> dict[str, Demonstrations]:
    """The robot's demonstrations of ``tasks``, for a model in this role.

    Args:
        horizon: H, actions of a window.
        held_out: share of each dataset's episodes kept from training; which ones depends on
            ``seed`` and the dataset's size alone, so they are the same for every model.
        folder: of the datasets of arms that this project simulates.
        arm: the robot, where it is external; its mapping says where the datasets are.

    Raises:
        LfrError: a task is hidden from this robot in this role; nothing has been read then.
        DataError: a dataset is missing or not what training needs.
    """
    check_visible(scenario, robot, role, tasks)
    return read_tasks(
        robot, tasks, horizon=horizon, held_out=held_out, seed=seed, folder=folder, arm=arm
    )


def read_tasks(
    robot: str,
    tasks: Sequence[str],
    *,
    horizon: int,
    held_out: float,
    seed: int,
    folder: Path = DATASETS,
    arm: ExternalArm | None = None,
) -> dict[str, Demonstrations]:
    """The robot's demonstrations of ``tasks``, whoever asks; `read_visible` holds the leak rule."""
    return {
        task: read_demonstrations(
            dataset_of(robot, task, folder, arm), robot, task,
            horizon=horizon, held_out=held_out, seed=seed, arm=arm,
        )
        for task in tasks
    }  # fmt: skip


def dataset_of(
    robot: str, task: str, folder: Path = DATASETS, arm: ExternalArm | None = None
) -> Path:
    """The dataset of a robot's demonstrations of a task; arguments as of `read_visible`."""
    return arm.dataset(task) if arm else folder / f"{robot}-{task}"


def read_demonstrations(
    path: Path,
    robot: str,
    task: str,
    *,
    horizon: int,
    held_out: float,
    seed: int,
    arm: ExternalArm | None = None,
) -> Demonstrations:
    """One dataset."""
    found = read_external(arm, task) if arm else _read_recorded(path, robot, task)
    training, kept = found.split(held_out, seed)
    windows = [Windows(part, horizon, padded=False).all() for part in (training, kept)]
    if not len(windows[0].actions):
        raise DataError(
            "no episode is as long as a skill", file=path,
            found=f"{int(found.lengths.max())} frames", expected=f"{horizon} or more",
        )  # fmt: skip
    joints = arm is None and actions_turn_with_base(found.action_space.names)
    motions = [hand_steps(part) if joints else None for part in (training, kept)]
    return Demonstrations(
        dataset=path.name,
        digest=file_hash(path / "data"),
        names=found.observation_names,
        actions=found.action_space,
        training=windows[0],
        held_out=windows[1],
        training_states=training.observations,
        held_out_states=kept.observations,
        training_motions=motions[0],
        held_out_motions=motions[1],
    )


def _read_recorded(path: Path, robot: str, task: str) -> DemonstrationSet:
    expected = features_of(embodiment(robot), task_named(task))
    # Joint names differ by project; only where actions are their motions does anything here learn
    # from them.
    used = actions_turn_with_base(embodiment(robot).action.names)
    needed = {key: f for key, f in expected.items() if used or key != JOINT_POSITION}
    check_dataset(path, features=needed, fps=FPS, robot=robot, task=task)
    return read_dataset(path)


def balanced(windows: Mapping[str, Tensor], seed: int) -> Tensor:
    """Action windows (N_t, H, A) by task, as one (N, H, A) in which every task counts alike.

    Windows of tasks with shorter episodes are drawn again until all have as many. Which ones
    follows from the seed and the numbers of windows: what belongs to them, (N_t, S), is so too.
    """
    generator = torch.Generator().manual_seed(seed)
    most = max(len(actions) for actions in windows.values())
    parts = []
    for actions in windows.values():
        extra = torch.randint(len(actions), (most - len(actions),), generator=generator)
        parts += [actions, actions[extra]]
    return torch.cat(parts)
