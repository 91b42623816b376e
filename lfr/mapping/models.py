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
from lfr.brought import BroughtArm
from lfr.mapping.artifacts import MappingSeen, save_generator
from lfr.mapping.report import common_report, decoded_difference, new_task_report
from lfr.mapping.training import CommonTask, MappingParams, train_mapping
from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.artifacts import load_prior, load_vae
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_visible
from lfr.skills.prior import SkillPrior
from lfr.skills.rows import thinned
from lfr.skills.symmetry import AS_RECORDED


@dataclass(frozen=True)
class MappingJob:
    """G and F of one transfer.

    Attributes:
        held_out: as the skills were trained with, so that what was held out there is here too.
        skills: folder of the transfer's skill models.
        folder: where ``g`` and ``f`` are saved.
        seed: of the skills' split and, with the transfer's name, of this training.
        datasets: folder of the datasets of arms that this project simulates.
        arms: those that are brought, by name.
    """

    scenario: Scenario
    transfer: Transfer
    params: MappingParams
    held_out: float
    seed: int
    skills: str
    folder: str
    datasets: str
    arms: Mapping[str, BroughtArm] = field(default_factory=dict)


def mapping_job(
    scenario: Scenario,
    transfer: Transfer,
    params: MappingParams,
    held_out: float,
    seed: int,
    skills: Path,
    folder: Path,
    datasets: Path = DATASETS,
    arms: Mapping[str, BroughtArm] = MappingProxyType({}),
) -> MappingJob:
    """The job that trains ``folder/{g,f}`` on these arms' demonstrations."""
    return MappingJob(
        scenario, transfer, _suited(params, arms), held_out, seed, str(skills), str(folder),
        str(datasets), dict(arms),
    )  # fmt: skip


def fit_mapping(job: MappingJob) -> dict[str, Any]:
    """Train and save G and F (Algorithm 1), from states of both arms' common demonstrations."""
    transfer, skills = job.transfer, Path(job.skills)
    vaes = load_vae(skills / "source" / "vae"), load_vae(skills / "target" / "vae")
    source = _read(job, transfer.source, "source", (*transfer.common, transfer.task))
    target = _read(job, transfer.target, "target", transfer.common)
    known = _common(job, source, target, "training_states")
    seed = int(fingerprint(transfer.name, job.seed), 16) % 2**31
    windows = None
    if job.params.posterior_share:  # which needs actions that mean the same to both arms
        arms = (("source", source), ("target", target))
        windows = balanced(
            {f"{role}-{task}": thinned(demonstrations[task].training.actions)
             for role, demonstrations in arms for task in transfer.common}, seed,
        )  # fmt: skip
    g, f = train_mapping(list(known.values()), vaes, windows, job.params, seed)

    learned = [arm[task] for arm in (source, target) for task in transfer.common]
    seen = MappingSeen(
        transfer.name, transfer.source, transfer.target, transfer.common,
        {one.dataset: one.digest for one in learned}, seed,
    )  # fmt: skip
    save_generator(Path(job.folder) / "g", g, seen)
    save_generator(Path(job.folder) / "f", f, seen)

    held_out = _common(job, source, target, "held_out_states")
    new = load_prior(skills / "source" / f"prior-{transfer.task}", source[transfer.task].names)
    new_states = source[transfer.task].held_out_states
    spaces = source[transfer.task].actions, target[transfer.common[0]].actions

    def decoded(prior: SkillPrior, states: Tensor) -> dict[str, float]:
        """Nothing where the arms' actions are different things."""
        if spaces[0] != spaces[1]:
            return {}
        rms = decoded_difference(prior, states, g, *vaes).tolist()
        return dict(zip(spaces[0].names, rms, strict=True))

    return {
        "source": transfer.source,
        "target": transfer.target,
        "common": {
            task: {
                **common_report(one, g, f),
                "decoded_difference": decoded(one.prior_x, one.observations),
            }
            for task, one in held_out.items()
        },
        "new": {
            transfer.task: {
                **new_task_report(new, new_states, g, f),
                "decoded_difference": decoded(new, new_states),
            }
        },
    }


def _common(
    job: MappingJob,
    source: Mapping[str, Demonstrations],
    target: Mapping[str, Demonstrations],
    kind: Literal["training_states", "held_out_states"],
) -> dict[str, CommonTask]:
    """Both arms' priors of each common task, with both arms' states of it."""
    tasks = {}
    for task in job.transfer.common:
        folder, names = Path(job.skills), source[task].names
        tasks[task] = CommonTask(
            load_prior(folder / "source" / f"prior-{task}", names),
            load_prior(folder / "target" / f"prior-{task}", names),
            torch.cat([getattr(source[task], kind), getattr(target[task], kind)]),
        )
    return tasks


def _read(
    job: MappingJob, robot: str, role: Role, tasks: tuple[str, ...]
) -> dict[str, Demonstrations]:
    horizon = load_vae(Path(job.skills) / role / "vae").horizon
    return read_visible(
        job.scenario, robot, role, tasks,
        horizon=horizon, held_out=job.held_out, seed=job.seed, folder=Path(job.datasets),
        arm=job.arms.get(robot),
    )  # fmt: skip


def _suited(params: MappingParams, arms: Mapping[str, BroughtArm]) -> MappingParams:
    """Without moved scenes and shared windows where it is not known what they mean to an arm."""
    if all(arm.cartesian for arm in arms.values()):
        return params
    return replace(params, symmetry=AS_RECORDED, posterior_share=0.0)
