"""One run of learning by any method, as a job."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from lfr.scenarios import Role, Transfer
from lfr.skills.library import RoleModels
from lfr.transfer.methods import initialize
from lfr.transfer.methods.initialization import TrainedModels
from lfr.transfer.train import train
from lfr.transfer.transfer_params import TransferParams
from studies.methods import methods
from studies.retargeted import RetargetedSimulation


@dataclass(frozen=True)
class LearningJob:
    """One run of a method on a transfer.

    Attributes:
        folder: of the ``policy`` that it leaves, and of ``checkpoints`` while it learns.
        skills: the transfer's skill models.
        mapping: folder of its G and F.
        spirl_prior: folder of SPiRL's prior.
    """

    transfer: Transfer
    method: str
    seed: int
    params: TransferParams
    folder: str
    skills: Mapping[Role, RoleModels]
    mapping: str
    spirl_prior: str


def learn(job: LearningJob) -> dict[str, Any]:
    """Run it, or go on where it was killed; counts and the curve, as `lfr.transfer.train` says."""
    transfer, folder = job.transfer, Path(job.folder)
    models = TrainedModels(transfer, job.skills, Path(job.mapping))
    known = methods(Path(job.spirl_prior))
    initialization = initialize(job.method, models, job.params, job.seed, known)
    ends = transfer.source, transfer.target, transfer.task
    done = train(
        initialization, transfer.target, transfer.task, job.params, job.seed,
        out=folder / "policy", work=folder / "checkpoints",
        about={"transfer": transfer.name, "method": job.method},
        simulate=partial(RetargetedSimulation, *ends) if job.method == "retarget" else None,
    )  # fmt: skip
    shutil.rmtree(folder / "checkpoints", ignore_errors=True)  # large replay buffers
    return done
