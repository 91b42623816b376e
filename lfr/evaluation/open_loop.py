"""What can be said of a mapping without a simulator: open loop, on recorded episodes.

A policy is asked at recorded states what it would do, and held to what was done there. It says
nothing of where its own actions would lead, so it bounds trust from above: what errs here will err
on the arm, what does not may still.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from lfr.columns import ActionSpace
from lfr.data.external import read_external
from lfr.data.windows import DemonstrationSet, WindowBatch, read_dataset
from lfr.mapping.map_quality import common_report, new_task_report
from lfr.mapping.mapping_jobs import MappingJob, read_as
from lfr.mapping.mapping_training import CommonTask
from lfr.mapping.saved_generators import load_generator
from lfr.scenarios import Role
from lfr.skills.demonstrations import Demonstrations, dataset_of
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import load_prior, load_vae
from lfr.skills.skill_policy import SkillPolicy, untranslated

MAPPED, OWN, IDENTITY, MEAN = "mapped", "own prior", "identity", "mean action"
ROLES: tuple[Role, Role] = ("source", "target")
MOST = 4000  # states of a set that others are compared with
QUANTILE = 0.99  # of states that are known to be alike


@dataclass(frozen=True)
class Episode:
    """One held-out episode of the target as it was recorded, and as it would be acted in.

    Attributes:
        task: of the common ones.
        space: the names and bounds of the target's action.
        recorded, mapped, own: (T, A) actions in the dataset's units: what was done, and what the
            mapped policy and the target's own prior would do at the recorded states, a skill at a
            time.
    """

    task: str
    space: ActionSpace
    recorded: Tensor
    mapped: Tensor
    own: Tensor


@dataclass(frozen=True)
class States:
    """States (N, D) in units of the source's demonstrations of the new task, for one picture.

    Attributes:
        common: of the common tasks, by arm.
        new: the source's of the new task.
    """

    common: dict[str, Tensor]
    new: Tensor


def open_loop(job: MappingJob) -> tuple[dict[str, Any], list[Episode], States]:
    """The report of a mapping that has been trained, as JSON holds it, and what its pictures show.

    Raises:
        DataError: a dataset or a model is missing or damaged.
    """
    transfer = job.transfer
    source = read_as(job, transfer.source, "source", (*transfer.common, transfer.task))
    target = read_as(job, transfer.target, "target", transfer.common)
    f = load_generator(Path(job.folder) / "f")
    g = load_generator(Path(job.folder) / "g")
    common, episodes = {}, []
    for task in transfer.common:
        prior_x, prior_y = (load_prior(job.skills[role].prior(task)) for role in ROLES)
        shown = target[task]
        policies = _policies(job, prior_x, prior_y)
        both = torch.cat([source[task].held_out_states, shown.held_out_states])
        cycle = common_report(CommonTask(prior_x, prior_y, both), g, f)
        common[task] = {
            "errors": action_errors(policies, shown),
            "spread": _spread(shown),
            "states_beyond": beyond(
                shown.held_out_states, source[task].training_states, source[task].held_out_states,
                prior_x,
            ),
            "round_trip": cycle["cycle_x"] / cycle["spread_x"],
        }  # fmt: skip
        episodes.append(_episode(job, task, policies))
    prior = load_prior(job.skills["source"].prior(transfer.task))
    new = source[transfer.task]
    known, kept = (
        torch.cat([getattr(arm[task], of) for arm in (source, target) for task in transfer.common])
        for of in ("training_states", "held_out_states")
    )
    cycle = new_task_report(prior, new.held_out_states, g, f)
    report = {
        "source": transfer.source,
        "target": transfer.target,
        "task": transfer.task,
        "actions": list(target[transfer.common[0]].actions.names),
        "common": common,
        "new": {
            "states_beyond": beyond(new.held_out_states, known, kept, prior),
            "dimensions_beyond": dimensions_beyond(new.held_out_states, known, new.names),
            "round_trip": cycle["cycle_x"] / cycle["spread_x"],
        },
    }
    by_arm = {
        robot: torch.cat([arm[task].training_states for task in transfer.common])
        for robot, arm in ((transfer.source, source), (transfer.target, target))
    }
    states = States(
        {robot: _scaled(prior, _some(found)) for robot, found in by_arm.items()},
        _scaled(prior, _some(new.training_states)),
    )
    return report, episodes, states


def action_errors(
    policies: Mapping[str, SkillPolicy], shown: Demonstrations
) -> dict[str, list[float]]:
    """Root-mean-square error of each action dimension in the dataset's units, by policy.

    Over held-out windows, and of a window the steps that are carried out before the next skill is
    chosen. Beside the policies the mean action of the training windows.
    """
    unit = _unit(shown.actions)
    steps = min(policy.decoder.execute for policy in policies.values())
    recorded = shown.held_out.actions[:, :steps]
    answers = {
        name: _skills(policy, shown.held_out)[:, :steps] for name, policy in policies.items()
    }
    answers[MEAN] = shown.training.actions.mean((0, 1)).expand_as(recorded)
    return {
        name: ((answer - recorded).square().mean((0, 1)).sqrt() * unit).tolist()
        for name, answer in answers.items()
    }


def beyond(states: Tensor, seen: Tensor, alike: Tensor, prior: SkillPrior) -> float:
    """The share of ``states`` (N, D) that lie farther from all of ``seen`` than states that are
    known to be alike do.

    Farther than 99 % of ``alike``, which come from where ``seen`` come from: of states like these,
    about 0.01 lie beyond. Distances are to the nearest one, in the prior's units.
    """
    seen = _scaled(prior, _some(seen))
    limit = _nearest(_scaled(prior, _some(alike)), seen).quantile(QUANTILE)
    return float((_nearest(_scaled(prior, _some(states)), seen) > limit).float().mean())


def dimensions_beyond(
    states: Tensor, seen: Tensor, names: tuple[str, ...], least: float = 0.02
) -> dict[str, float]:
    """The share of ``states`` (N, D) outside the range of ``seen``, where it is above ``least``."""
    outside = ((states < seen.amin(0)) | (states > seen.amax(0))).float().mean(0).tolist()
    found = {name: share for name, share in zip(names, outside, strict=True) if share > least}
    return dict(sorted(found.items(), key=lambda one: -one[1]))


def _policies(job: MappingJob, prior_x: SkillPrior, prior_y: SkillPrior) -> dict[str, SkillPolicy]:
    vae_x, vae_y = (load_vae(job.skills[role].vae()) for role in ROLES)
    g = load_generator(Path(job.folder) / "g")
    found = {
        MAPPED: SkillPolicy(prior_x, g.at, vae_y),
        OWN: SkillPolicy(prior_y, untranslated, vae_y),
    }
    if vae_x.action_dim == vae_y.action_dim:
        found[IDENTITY] = SkillPolicy(prior_x, untranslated, vae_x)
    return found


@torch.inference_mode()
def _skills(policy: SkillPolicy, windows: WindowBatch) -> Tensor:
    """(N, H, A) of the skills that begin at the windows' states."""
    states = windows.observations
    mu, _ = policy.translate(*policy.prior(states), states)
    return policy.decoder.reconstruct(mu, states).clamp(-1.0, 1.0)


def _episode(job: MappingJob, task: str, policies: Mapping[str, SkillPolicy]) -> Episode:
    """The first one that was held out of training."""
    robot = job.transfer.target
    arm = job.arms.get(robot)
    path = dataset_of(robot, task, Path(job.datasets), arm)
    found = read_external(arm, task) if arm else read_dataset(path)
    kept = found.split(job.held_out, job.seed)[1].select([0])
    space = found.action_space
    acted = {name: _acted(policies[name], kept) for name in (MAPPED, OWN)}
    physical = [torch.from_numpy(space.physical(one.numpy()))
                for one in (kept.actions, acted[MAPPED], acted[OWN])]  # fmt: skip
    return Episode(task, space, *physical)


def _acted(policy: SkillPolicy, episode: DemonstrationSet) -> Tensor:
    """(T, A): a skill is chosen where the last has been carried out."""
    states, acted = episode.observations.numpy(), []
    while len(acted) < len(states):
        acted += list(torch.from_numpy(policy.act(states[len(acted)])).float())
    return torch.stack(acted[: len(states)])


def _spread(shown: Demonstrations) -> list[float]:
    deviation = shown.held_out.actions.flatten(0, 1).std(0, correction=0)
    return (deviation * _unit(shown.actions)).tolist()


def _unit(space: ActionSpace) -> Tensor:
    """What a step of 1 of a normalised action is in the dataset's units, (A,)."""
    return 0.5 * (torch.tensor(space.high) - torch.tensor(space.low)).abs()


def _scaled(prior: SkillPrior, states: Tensor) -> Tensor:
    normalizer = prior.normalizer
    return (normalizer.at_azimuth_zero(states) - normalizer.mean) / normalizer.std


def _some(states: Tensor) -> Tensor:
    """At most MOST of them, evenly."""
    return states[:: -(-len(states) // MOST)]


def _nearest(states: Tensor, seen: Tensor) -> Tensor:
    return torch.cat([torch.cdist(some, seen).amin(1) for some in states.split(1000)])
