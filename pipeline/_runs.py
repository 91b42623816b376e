"""One run of transfer learning, as a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.scenarios import Role, Transfer
from lfr.sim.simulation import simulation
from lfr.skills.library import RoleModels
from lfr.transfer.methods import start_of
from lfr.transfer.methods.start import TrainedModels
from lfr.transfer.model import save_policy
from lfr.transfer.params import TransferParams
from lfr.transfer.starts import evaluation_starts
from lfr.transfer.train import train
from lfr.view.learning import LearningLog
from lfr.view.policy import save_policy_episode
from lfr.view.rollout import roll_out_policy


@dataclass(frozen=True)
class RunJob:
    """One run of a method on a transfer.

    Attributes:
        folder: what the run leaves: the policies ``initial`` and ``policy``, ``learning.rrd`` and
            ``episode-<env_steps>.rrd``; ``checkpoints`` while it learns.
        skills: the transfer's skill models.
        mapping: folder of its G and F.
    """

    transfer: Transfer
    method: str
    seed: int
    params: TransferParams
    folder: str
    skills: Mapping[Role, RoleModels]
    mapping: str


def learn(job: RunJob) -> dict[str, Any]:
    """Run it, or go on where it was killed; counts and the curve, as `lfr.transfer.train` says."""
    transfer, folder = job.transfer, Path(job.folder)
    robot, task = transfer.target, transfer.task
    models = TrainedModels(transfer, job.skills, Path(job.mapping))
    start = start_of(job.method, models, job.params, job.seed)
    about = {"transfer": transfer.name, "method": job.method}
    described = {"robot": robot, "task": task, "seed": job.seed, **about}
    save_policy(folder / "initial", start.actor, described)

    def sample(env_steps: int) -> None:
        shown = simulation(robot, task)
        seed = evaluation_starts(job.seed, 1)[0]
        episode, trace = roll_out_policy(start.actor, shown, seed)
        note = f"{env_steps} environment steps"
        save_policy_episode(folder / f"episode-{env_steps:06d}.rrd", episode, trace, note=note)

    title = f"{transfer.name} {job.method} seed {job.seed}"
    log = LearningLog(folder / "learning.rrd", title, sample)
    result = train(
        start, robot, task, job.params, job.seed,
        out=folder / "policy", work=folder / "checkpoints", about=about, observer=log,
    )  # fmt: skip
    log.catch_up(result["curve"])
    log.close()
    return result
