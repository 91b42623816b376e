"""SPiRL's prior (Pertsch et al. 2021): one for all that an arm has been shown, told no task.

It sees what every task has, the hand and the manipulated object, and learns from windows of all of
the target's common tasks. In the new task it is asked like any other task's prior.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from lfr.artifacts import fingerprint
from lfr.scenarios import Scenario, Transfer
from lfr.skills.demonstrations import DATASETS, balanced, read_visible
from lfr.skills.library import RoleModels
from lfr.skills.saved_models import Seen, load_vae
from lfr.skills.skill_params import PriorParams
from lfr.skills.skill_training import PriorMaterial, train_priors
from lfr.skills.symmetry import actions_turn_with_base
from lfr.spaces import ROBOT_STATE, axis, displacement, position
from lfr.tasks import Task
from lfr.tasks import task as task_named
from studies.spirl.other_task import asked_about, counterparts, save_other_task

OBJECT = "object"
ANY_TASK_NAMES: tuple[str, ...] = (
    *ROBOT_STATE.names,
    *position(OBJECT).names,
    *axis(OBJECT).names,
    *displacement("eef", OBJECT).names,
)
"""What is observed in all tasks: `observation.state`, and the manipulated object."""


@dataclass(frozen=True)
class AnyTaskJob:
    """The prior of all of the target's common tasks, for the target's own VAE.

    Attributes:
        skills: the target's.
        folder: where ``prior`` is saved.
    """

    scenario: Scenario
    transfer: Transfer
    params: PriorParams
    held_out: float
    seed: int
    skills: RoleModels
    folder: str
    datasets: str = str(DATASETS)


def any_task_places(task: Task) -> tuple[int, ...]:
    """Where each of `ANY_TASK_NAMES` stands in a task's observation."""
    names = task.observation.names
    return counterparts(ANY_TASK_NAMES, OBJECT, names, task.manipulated)


def fit_any_task(job: AnyTaskJob) -> dict[str, Any]:
    """Train and save the prior, ready for the new task's observations."""
    transfer = job.transfer
    vae = load_vae(job.skills.vae())
    known = read_visible(
        job.scenario, transfer.target, "target", transfer.common,
        horizon=vae.horizon, held_out=job.held_out, seed=job.seed, folder=Path(job.datasets),
    )  # fmt: skip
    seed = int(fingerprint("any_task", transfer.name, job.seed), 16) % 2**31
    rows = {
        task: _rows(task, one.training.observations, one.training.actions)
        for task, one in known.items()
    }
    together = balanced(rows, seed)
    observations, actions = together.tensor_split([len(ANY_TASK_NAMES)], dim=1)
    actions = actions.reshape(len(actions), vae.horizon, vae.action_dim)
    names = known[transfer.common[0]].actions.names
    turned = actions_turn_with_base(names)
    material = PriorMaterial(observations, actions, ANY_TASK_NAMES, names, seed, turned)
    (inner,) = train_priors(vae, [material], job.params)
    new = task_named(transfer.task)
    prior = asked_about(inner, OBJECT, new.observation.names, new.manipulated)
    digests = {one.dataset: one.digest for one in known.values()}
    actions = known[transfer.common[0]].actions
    seen = Seen(transfer.target, tuple(known), digests, seed, actions)
    save_other_task(Path(job.folder) / "prior", prior, seen)
    return {"tasks": list(known), "windows": len(observations)}


def _rows(task: str, observations: Tensor, actions: Tensor) -> Tensor:
    """(N, D + H A): what all tasks observe, and the window's actions."""
    places = list(any_task_places(task_named(task)))
    return torch.cat([observations[:, places], actions.flatten(1)], dim=-1)
