"""The skill models that a transfer needs, as jobs: a VAE for each role, then its priors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import torch
from torch import Tensor

from lfr.artifacts import fingerprint
from lfr.data.windows import WindowBatch
from lfr.external import ExternalArm
from lfr.jobs import Job
from lfr.scenarios import Role, Scenario, Transfer, visible_tasks
from lfr.skills.artifacts import Seen, load_vae, save_prior, save_vae
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_visible
from lfr.skills.gaussian import kl_divergence, kl_to_standard_normal
from lfr.skills.params import SkillsParams
from lfr.skills.prior import SkillPrior
from lfr.skills.symmetry import AS_RECORDED
from lfr.skills.training import train_prior, train_vae
from lfr.skills.vae import CHUNK, SkillVAE, reconstruction_rmse


@dataclass(frozen=True)
class ModelJob:
    """A skill VAE to train, or the prior of ``task`` for the VAE that lies in the same folder.

    Attributes:
        folder: of this transfer's models.
        task: None for the VAE.
        datasets: folder of the datasets of arms that this project simulates.
        arm: the robot, where it is external.
    """

    scenario: Scenario
    robot: str
    role: Role
    task: str | None
    params: SkillsParams
    seed: int
    folder: str
    datasets: str
    arm: ExternalArm | None = None

    @property
    def vae(self) -> Path:
        return Path(self.folder) / self.role / "vae"

    @property
    def prior(self) -> Path:
        return Path(self.folder) / self.role / f"prior-{self.task}"


def roles_of(transfer: Transfer) -> dict[Role, str]:
    """The arm in each role of a transfer; no oracle where nobody has shown it the new task."""
    roles: dict[Role, str] = {"source": transfer.source, "target": transfer.target}
    return {**roles, "oracle": transfer.target} if transfer.oracle else roles


def prior_tasks(scenario: Scenario, robot: str, role: Role) -> tuple[str, ...]:
    """The tasks that get a prior: all visible ones, but for the oracle only its new task.

    Its priors of the common tasks would not be used: the mapping is learned without the oracle.
    """
    visible = visible_tasks(scenario, robot, role)
    return visible[-1:] if role == "oracle" else visible


def model_jobs(
    scenario: Scenario,
    transfer: Transfer,
    params: SkillsParams,
    seed: int,
    folder: Path,
    datasets: Path = DATASETS,
    arms: Mapping[str, ExternalArm] = MappingProxyType({}),
) -> list[Job]:
    """Jobs that train source, target and oracle into ``folder/<role>/{vae,prior-<task>}``.

    Args:
        datasets: folder of the datasets of arms that this project simulates.
        arms: those that are external, by name.

    Returns:
        Jobs of `ModelJob`, VAEs first; each prior's needs that of its VAE.
    """

    def spec(role: Role, robot: str, task: str | None = None) -> ModelJob:
        return ModelJob(
            scenario, robot, role, task, _suited(params, arms.get(robot)), seed, str(folder),
            str(datasets), arms.get(robot),
        )  # fmt: skip

    roles = roles_of(transfer)
    vaes = {role: Job(fit_vae, spec(role, robot)) for role, robot in roles.items()}
    priors = [
        Job(fit_prior, spec(role, robot, task), (vaes[role],))
        for role, robot in roles.items()
        for task in prior_tasks(scenario, robot, role)
    ]
    return [*vaes.values(), *priors]


def model_report(found: Mapping[Job, Any]) -> dict[str, dict[str, Any]]:
    """What each of `model_jobs` gave, by role.

    Robot, tasks seen, and on held-out episodes the VAE's reconstruction error per action dimension,
    the divergence of its posterior to N(0, I), and of the posterior to each prior.
    """
    report: dict[str, dict[str, Any]] = {}
    for job, metrics in found.items():
        one: ModelJob = job.spec
        if one.task is None:
            report[one.role] = {"robot": one.robot, **metrics, "prior": {}}
        else:
            report[one.role]["prior"][one.task] = metrics
    return report


def fit_vae(job: ModelJob) -> dict[str, Any]:
    """Train and save a role's skill VAE on everything that it may see; its held-out report."""
    tasks = visible_tasks(job.scenario, job.robot, job.role)
    demonstrations = _read(job, tasks)
    seed = model_seed(job)
    windows = {task: known.training.actions for task, known in demonstrations.items()}
    names = next(iter(demonstrations.values())).actions.names
    vae = train_vae(balanced(windows, seed), names, job.params.vae, seed)
    save_vae(job.vae, vae, _seen(job, demonstrations))
    return {
        "tasks": tasks,
        "datasets": {known.dataset: known.digest for known in demonstrations.values()},
        "held_out": {task: vae_report(vae, known) for task, known in demonstrations.items()},
    }


def fit_prior(job: ModelJob) -> dict[str, Any]:
    """Train and save a role's skill prior of one task; its held-out report."""
    assert job.task is not None
    demonstrations = _read(job, (job.task,))
    known = demonstrations[job.task]
    vae = load_vae(job.vae)
    seed = model_seed(job)
    start, actions = known.training.observations, known.training.actions
    prior = train_prior(
        vae, start, actions, known.names, known.actions.names, job.params.prior, seed
    )
    save_prior(job.prior, prior, _seen(job, demonstrations))
    return {
        "kl_training": _mean(divergence(vae, prior, known.training)),
        "kl_held_out": _mean(divergence(vae, prior, known.held_out)),
    }


@torch.no_grad()
def divergence(vae: SkillVAE, prior: SkillPrior, windows: WindowBatch) -> Tensor:
    """KL(q(z|a) || p_a(z|s)) of every window, (B,), some at a time to spare memory."""
    pairs = zip(windows.actions.split(CHUNK), windows.observations.split(CHUNK), strict=True)
    return torch.cat([kl_divergence(*vae.encode(a), *prior(seen)) for a, seen in pairs])


def vae_report(vae: SkillVAE, known: Demonstrations) -> dict[str, Any]:
    """Reconstruction error per action dimension and KL(q || N(0, I)), on held-out windows."""
    actions = known.held_out.actions
    rmse = reconstruction_rmse(vae, actions).tolist()
    kl = kl_to_standard_normal(*vae.encode_all(actions))
    return {"rmse": dict(zip(known.actions.names, rmse, strict=True)), "kl": _mean(kl)}


def model_seed(job: ModelJob) -> int:
    """A seed of its own for each model.

    Equal seeds would start two arms' VAEs from the same weights and hand the mapping an alignment
    that nobody has earned.
    """
    name = (job.scenario.name, job.robot, job.role, job.task, job.seed)
    return int(fingerprint(*name), 16) % 2**31


def _read(job: ModelJob, tasks: tuple[str, ...]) -> Mapping[str, Demonstrations]:
    return read_visible(
        job.scenario, job.robot, job.role, tasks,
        horizon=job.params.vae.horizon, held_out=job.params.held_out, seed=job.seed,
        folder=Path(job.datasets), arm=job.arm,
    )  # fmt: skip


def _seen(job: ModelJob, demonstrations: Mapping[str, Demonstrations]) -> Seen:
    digests = {known.dataset: known.digest for known in demonstrations.values()}
    scenario, tasks = job.scenario.name, tuple(demonstrations)
    actions = next(iter(demonstrations.values())).actions
    return Seen(scenario, job.robot, job.role, tasks, digests, model_seed(job), actions)


def _suited(params: SkillsParams, arm: ExternalArm | None) -> SkillsParams:
    """Without moved scenes where it is not known how this arm's actions move with them."""
    if arm is None or arm.cartesian:
        return params
    vae, prior = replace(params.vae, augment=0.0), replace(params.prior, symmetry=AS_RECORDED)
    return replace(params, vae=vae, prior=prior)


def _mean(values: Tensor) -> float | None:
    """None where no held-out episode is long enough for a window."""
    return float(values.mean()) if len(values) else None
