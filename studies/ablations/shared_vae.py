"""One skill VAE for both arms: a single latent space, in which the source's prior needs no phi."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import fingerprint
from lfr.scenarios import Role, Scenario, Transfer, visible_tasks
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_visible
from lfr.skills.model_jobs import divergence, vae_report
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.skill_params import SkillsParams
from lfr.skills.skill_training import PriorMaterial, train_priors, train_vae
from lfr.skills.symmetry import actions_turn_with_base


@dataclass(frozen=True)
class SharedJob:
    """A VAE of both arms and, for it, the source's prior of the new task.

    Attributes:
        folder: where ``vae`` and ``prior`` are saved.
    """

    scenario: Scenario
    transfer: Transfer
    params: SkillsParams
    seed: int
    folder: str
    datasets: str = str(DATASETS)


def read_shared(job: SharedJob) -> dict[tuple[Role, str], Demonstrations]:
    """By role and task what both arms may show: of the target its common tasks alone.

    Raises:
        DataError: a dataset is missing or not what training needs.
    """
    roles: dict[Role, str] = {"source": job.transfer.source, "target": job.transfer.target}
    known = {}
    for role, robot in roles.items():
        tasks = visible_tasks(job.scenario, robot, role)
        found = read_visible(
            job.scenario, robot, role, tasks,
            horizon=job.params.vae.horizon, held_out=job.params.held_out, seed=job.seed,
            folder=Path(job.datasets),
        )  # fmt: skip
        known |= {(role, task): one for task, one in found.items()}
    return known


def fit_shared(job: SharedJob) -> dict[str, Any]:
    """Train and save the VAE, every arm and task counting alike, then the prior."""
    transfer, known = job.transfer, read_shared(job)
    seed = int(fingerprint("shared_vae", transfer.name, job.seed), 16) % 2**31
    windows = {f"{role}-{task}": one.training.actions for (role, task), one in known.items()}
    names = known["source", transfer.task].actions.names
    vae = train_vae(balanced(windows, seed), names, job.params.vae, seed)
    folder = Path(job.folder)
    save_vae(folder / "vae", vae, _seen(job, known, seed))

    new = known["source", transfer.task]
    start, actions = new.training.observations, new.training.actions
    turned = actions_turn_with_base(names)
    material = PriorMaterial(start, actions, new.names, names, seed, turned)
    (prior,) = train_priors(vae, [material], job.params.prior)
    digests = {new.dataset: new.digest}
    seen = Seen(transfer.source, (transfer.task,), digests, seed, new.actions)
    save_prior(folder / "prior", prior, seen)
    return {
        "datasets": {one.dataset: one.digest for one in known.values()},
        "held_out": {one.dataset: vae_report(vae, one) for one in known.values()},
        "kl_held_out": float(divergence(vae, prior, new.held_out).mean()),
    }


def _seen(job: SharedJob, known: Mapping[tuple[Role, str], Demonstrations], seed: int) -> Seen:
    """Of two arms: which showed which task is told by the datasets' names."""
    arms = f"{job.transfer.source} and {job.transfer.target}"
    tasks = tuple(dict.fromkeys(task for _, task in known))
    digests = {one.dataset: one.digest for one in known.values()}
    actions = next(iter(known.values())).actions
    return Seen(arms, tasks, digests, seed, actions)
