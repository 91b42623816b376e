"""One run of transfer learning, as a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.environments.simulation import ExternalTarget, external_target
from lfr.errors import ParameterError
from lfr.external import ExternalArm
from lfr.params import PARAMS
from lfr.scenarios import Role, Transfer
from lfr.skills.library import RoleModels
from lfr.skills.saved_models import load_prior
from lfr.transfer.log import LearningLog
from lfr.transfer.methods import initialize
from lfr.transfer.methods.initialization import TrainedModels
from lfr.transfer.model import save_policy
from lfr.transfer.train import train
from lfr.transfer.transfer_params import TransferParams


@dataclass(frozen=True)
class RunJob:
    """One run of a method on a transfer.

    Attributes:
        folder: what the run leaves: the policies ``initial`` and ``policy``, and ``learning``, its
            course (`lfr.transfer.log`); ``checkpoints`` while it learns.
        skills: the transfer's skill models.
        mapping: folder of its G and F.
        external: where the target learns, if it is not simulated here.
    """

    transfer: Transfer
    method: str
    seed: int
    params: TransferParams
    folder: str
    skills: Mapping[Role, RoleModels]
    mapping: str
    external: ExternalTarget | None = None


def learn(job: RunJob) -> dict[str, Any]:
    """Run it, or go on where it was killed; counts and the curve, as `lfr.transfer.train` says."""
    transfer, folder = job.transfer, Path(job.folder)
    robot, task = transfer.target, transfer.task
    models = TrainedModels(transfer, job.skills, Path(job.mapping))
    initialization = initialize(job.method, models, job.params, job.seed)
    about = {"transfer": transfer.name, "method": job.method}
    described = {"robot": robot, "task": task, "seed": job.seed, **about}
    save_policy(folder / "initial", initialization.actor, described)

    log = LearningLog(folder / "learning", initialization.actor, described)
    return train(
        initialization, robot, task, job.params, job.seed,
        out=folder / "policy", work=folder / "checkpoints", about=about, observer=log,
        simulate=job.external.simulation if job.external else None,
    )  # fmt: skip


def target_environment(
    transfer: Transfer, skills: Mapping[Role, RoleModels], arms: Mapping[str, ExternalArm]
) -> ExternalTarget | None:
    """Where the target does the new task, if it is external; None if it is simulated here.

    Args:
        arms: the external ones, by name.

    Raises:
        ParameterError: it is external and names no environment for the task.
        DataError: it does not see there what the source's prior is to see.
    """
    if transfer.target not in arms:
        return None
    names = load_prior(skills["source"].prior(transfer.task)).layout_names
    found = external_target(
        transfer.target, arms[transfer.target], transfer.task, transfer.common, names
    )
    if found is None:
        raise ParameterError(
            f"{PARAMS}: external.arms.{transfer.target}.environments: none for {transfer.task}, so "
            f"{transfer.name} has nowhere to learn; take it out of external.learned"
        )
    return found
