"""The mapping that a transfer needs: G and F trained on the common tasks, and their report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import torch
from torch import Tensor

from lfr.artifacts import fingerprint
from lfr.embodiments import embodiment, may_share_actions
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.mapping.closed_form import linear
from lfr.mapping.hand_loss import (
    ArmSkills,
    HandLoss,
    SourceTask,
    hand_difference,
    hand_loss,
)
from lfr.mapping.map_quality import common_report, decoded_difference, new_task_report
from lfr.mapping.mapping_params import MappingParams
from lfr.mapping.mapping_training import (
    ActionWindows,
    CommonTask,
    condition_of,
    drawn_pairs,
    train_mapping,
)
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_visible
from lfr.skills.library import RoleModels
from lfr.skills.prior import SkillPrior
from lfr.skills.rows import thinned
from lfr.skills.saved_models import load_jacobian, load_prior, load_vae
from lfr.skills.symmetry import AS_RECORDED, actions_turn_with_base, suited
from lfr.spaces import ROBOT_STATE


@dataclass(frozen=True)
class MappingJob:
    """G and F of one transfer.

    Attributes:
        held_out: as the skills were trained with, so that what was held out there is here too.
        skills: the transfer's skill models.
        folder: where ``g``, ``f`` and ``linear`` are saved.
        seed: of the skills' split and, with the transfer's name, of this training.
        datasets: folder of the datasets of arms that this project simulates.
        arms: those that are external, by name.
    """

    scenario: Scenario
    transfer: Transfer
    params: MappingParams
    held_out: float
    seed: int
    skills: Mapping[Role, RoleModels]
    folder: str
    datasets: str
    arms: Mapping[str, ExternalArm] = field(default_factory=dict)


def mapping_job(
    scenario: Scenario,
    transfer: Transfer,
    params: MappingParams,
    held_out: float,
    seed: int,
    skills: Mapping[Role, RoleModels],
    folder: Path,
    datasets: Path = DATASETS,
    arms: Mapping[str, ExternalArm] = MappingProxyType({}),
) -> MappingJob:
    """The job that trains ``folder/{g,f,linear}`` on these arms' demonstrations."""
    return MappingJob(
        scenario, transfer, _suited(params, transfer, arms), held_out, seed, dict(skills),
        str(folder), str(datasets), dict(arms),
    )  # fmt: skip


@dataclass(frozen=True)
class Material:
    """What a mapping needs of the demonstrations, and no more of them.

    Attributes:
        training, held_out: the common tasks with states of both arms.
        windows: of the common tasks by both arms, if pairs of posteriors are asked for and their
            actions are the same things.
        new, new_training: the source's prior of the new task, and its held-out states of it, or
            those that it was trained on.
        datasets: common dataset's name -> SHA-256 of its rows.
        new_dataset: the same of the source's of the new task.
        action_names: of each dimension, if both arms' actions are the same things.
    """

    training: dict[str, CommonTask]
    held_out: dict[str, CommonTask]
    windows: ActionWindows | None
    new: SourceTask
    new_training: SourceTask
    datasets: dict[str, str]
    new_dataset: dict[str, str]
    action_names: tuple[str, ...] | None


def fit_mapping(job: MappingJob) -> dict[str, Any]:
    """Train and save G and F (Algorithm 1), from states of both arms' common demonstrations.

    Beside them the best linear map of the same pairs, which stands in for G in the chain.
    """
    transfer, arms = job.transfer, (job.skills["source"], job.skills["target"])
    vaes = load_vae(arms[0].vae()), load_vae(arms[1].vae())
    seed = int(fingerprint(transfer.name, job.seed), 16) % 2**31
    known = read_material(job, seed)
    tasks = list(known.training.values())
    pairs = drawn_pairs(tasks, vaes, known.windows, job.params, seed)
    condition = condition_of(tasks, job.params)
    skills = arm_skills(job, "source"), arm_skills(job, "target")
    compared = hands_compared(known, skills, job.params, seed)
    datasets = known.datasets | (known.new_dataset if compared else {})
    g, f = train_mapping(pairs, job.params, seed, condition, compared)
    seen = MappingSeen(
        transfer.name, transfer.source, transfer.target, (arms[0].name, arms[1].name),
        transfer.common, datasets, seed,
    )  # fmt: skip
    save_generator(Path(job.folder) / "g", g, seen)
    save_generator(Path(job.folder) / "f", f, seen)
    save_generator(Path(job.folder) / "linear", linear(pairs, condition), seen)

    def decoded(prior: SkillPrior, states: Tensor) -> dict[str, Any]:
        found: dict[str, Any] = {"decoded_difference": {}}
        if known.action_names is not None:
            rms = decoded_difference(prior, states, g, *vaes).tolist()
            found["decoded_difference"] = dict(zip(known.action_names, rms, strict=True))
        if skills[0] and skills[1]:
            found |= hand_difference(SourceTask(prior, states), g, skills[0], skills[1])
        return found

    return {
        "source": transfer.source,
        "target": transfer.target,
        "common": {
            task: {
                **common_report(one, g, f),
                **decoded(one.prior_x, one.observations),
            }
            for task, one in known.held_out.items()
        },
        "new": {
            transfer.task: {
                **new_task_report(*known.new, g, f),
                **decoded(*known.new),
            }
        },
    }


def hands_compared(
    known: Material,
    skills: tuple[ArmSkills | None, ArmSkills | None],
    params: MappingParams,
    seed: int,
) -> HandLoss | None:
    """L_hand over the source's skills for the common tasks and the new one; None where it is not
    asked for, or not known of an arm what its skills do to its hand.
    """
    source, target = skills
    if not params.hand.weight or source is None or target is None:
        return None
    common = [SourceTask(one.prior_x, one.observations) for one in known.training.values()]
    return hand_loss([*common, known.new_training], source, target, params, seed)


def arm_skills(job: MappingJob, role: Role) -> ArmSkills | None:
    """How an arm carries out its skills, by its models; None where it is not known what these do to
    its hand: of an external arm, whose observation may not say where that is.

    Raises:
        DataError: L_hand is asked for, and models of joint motions have no Jacobian beside them.
    """
    models = job.skills[role]
    if models.robot in job.arms:
        return None
    folder, vae = models.jacobian(), load_vae(models.vae())
    if folder is not None:
        return ArmSkills(vae, load_jacobian(folder))
    if not actions_turn_with_base(embodiment(models.robot).action.names):
        return ArmSkills(vae, None)
    if job.params.hand.weight:
        raise DataError("no Jacobian of the hand; train the skills again", file=models.vae().parent)
    return None


def read_material(job: MappingJob, seed: int) -> Material:
    """Read both arms' demonstrations and keep what the mapping needs of them."""
    transfer = job.transfer
    source = read_as(job, transfer.source, "source", (*transfer.common, transfer.task))
    target = read_as(job, transfer.target, "target", transfer.common)
    new = source[transfer.task]
    prior = load_prior(job.skills["source"].prior(transfer.task), new.names)
    spaces = new.actions, target[transfer.common[0]].actions
    alike = spaces[0] == spaces[1] and may_share_actions(transfer.source, transfer.target)
    action_names = spaces[0].names if alike else None
    windows = None
    if job.params.posterior_share and action_names is not None:
        arms = (("source", source), ("target", target))
        shown = {
            f"{role}-{task}": demonstrations[task].training
            for role, demonstrations in arms
            for task in transfer.common
        }
        actions = {name: thinned(part.actions) for name, part in shown.items()}
        states = {
            name: thinned(part.observations[:, : ROBOT_STATE.size]) for name, part in shown.items()
        }
        windows = ActionWindows(balanced(actions, seed), action_names, balanced(states, seed))
    learned = [arm[task] for arm in (source, target) for task in transfer.common]
    return Material(
        training=_common(job, source, target, "training_states"),
        held_out=_common(job, source, target, "held_out_states"),
        windows=windows,
        new=SourceTask(prior, new.held_out_states),
        new_training=SourceTask(prior, new.training_states),
        datasets={one.dataset: one.digest for one in learned},
        new_dataset={new.dataset: new.digest},
        action_names=action_names,
    )


def _common(
    job: MappingJob,
    source: Mapping[str, Demonstrations],
    target: Mapping[str, Demonstrations],
    kind: Literal["training_states", "held_out_states"],
) -> dict[str, CommonTask]:
    """Both arms' priors of each common task, with both arms' states of it."""
    tasks = {}
    for task in job.transfer.common:
        names = source[task].names
        tasks[task] = CommonTask(
            load_prior(job.skills["source"].prior(task), names),
            load_prior(job.skills["target"].prior(task), names),
            torch.cat([getattr(source[task], kind), getattr(target[task], kind)]),
        )
    return tasks


def read_as(
    job: MappingJob, robot: str, role: Role, tasks: tuple[str, ...]
) -> dict[str, Demonstrations]:
    """An arm's demonstrations as its models in a role have seen them; raises as `read_visible`."""
    horizon = load_vae(job.skills[role].vae()).horizon
    return read_visible(
        job.scenario, robot, role, tasks,
        horizon=horizon, held_out=job.held_out, seed=job.seed, folder=Path(job.datasets),
        arm=job.arms.get(robot),
    )  # fmt: skip


def _suited(
    params: MappingParams, transfer: Transfer, arms: Mapping[str, ExternalArm]
) -> MappingParams:
    """Scenes moved as both arms' actions allow, and no shared windows of what is not known."""
    if arms:  # whose observation may not say where the hand is
        params = replace(params, condition="none", hand=replace(params.hand, weight=0.0))
    if not all(arm.cartesian for arm in arms.values()):
        return replace(params, symmetry=AS_RECORDED, posterior_share=0.0)
    symmetry = params.symmetry
    actions = [embodiment(robot).action.names for robot in (transfer.source, transfer.target)
               if robot not in arms]  # fmt: skip
    joints = [actions_turn_with_base(names) for names in actions]
    if any(joints) and not all(joints):  # one arm's skills turn with the scene, the other's do not
        return replace(params, symmetry=replace(symmetry, shift=0.0, mirror=False))
    for names in actions:
        symmetry = suited(symmetry, names)
    return replace(params, symmetry=symmetry)
