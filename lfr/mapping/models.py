"""The mapping that a transfer needs: G and F trained on the common tasks, and their report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import torch

from lfr.artifacts import fingerprint
from lfr.jobs import run_jobs
from lfr.mapping.artifacts import MappingSeen, save_generator
from lfr.mapping.report import common_report, decoded_difference, new_task_report
from lfr.mapping.training import CommonTask, MappingParams, train_mapping
from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.artifacts import load_prior, load_vae
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_visible


@dataclass(frozen=True)
class MappingJob:
    """G and F of one transfer.

    Attributes:
        held_out: as the skills were trained with, so that what was held out there is here too.
        skills: folder of the transfer's skill models.
        folder: where ``g`` and ``f`` are saved.
        seed: of the skills' split and, with the transfer's name, of this training.
    """

    scenario: Scenario
    transfer: Transfer
    params: MappingParams
    held_out: float
    seed: int
    skills: str
    folder: str
    datasets: str


def train_models(
    scenario: Scenario,
    transfer: Transfer,
    params: MappingParams,
    held_out: float,
    seed: int,
    skills: Path,
    work: Path,
    datasets: Path = DATASETS,
) -> dict[str, Any]:
    """Train ``work/models/{g,f}``; the report on held-out states."""
    folder = str(work / "models")
    job = MappingJob(scenario, transfer, params, held_out, seed, str(skills), folder, str(datasets))
    description = f"mapping {transfer.name}"
    return run_jobs(fit_mapping, [job], work=work, description=description, unit="mapping")[0]


def fit_mapping(job: MappingJob) -> dict[str, Any]:
    """Train and save G and F (Algorithm 1), from states of both arms' common demonstrations."""
    transfer, skills = job.transfer, Path(job.skills)
    vaes = load_vae(skills / "source" / "vae"), load_vae(skills / "target" / "vae")
    source = _read(job, transfer.source, "source", (*transfer.common, transfer.task))
    target = _read(job, transfer.target, "target", transfer.common)
    known = _common(job, source, target, "training_states")
    windows = {
        f"{role}-{task}": demonstrations[task].training.actions
        for role, demonstrations in (("source", source), ("target", target))
        for task in transfer.common
    }
    seed = int(fingerprint(transfer.name, job.seed), 16) % 2**31
    g, f = train_mapping(list(known.values()), vaes, balanced(windows, seed), job.params, seed)

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
    return {
        "source": transfer.source,
        "target": transfer.target,
        "common": {
            task: {
                **common_report(one, g, f),
                "decoded_difference": decoded_difference(one.prior_x, one.observations, g, *vaes),
            }
            for task, one in held_out.items()
        },
        "new": {
            transfer.task: {
                **new_task_report(new, new_states, g, f),
                "decoded_difference": decoded_difference(new, new_states, g, *vaes),
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
    )  # fmt: skip
