"""The skill models of a robot, as jobs: a VAE for each set of tasks seen, then its priors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from lfr.artifacts import fingerprint
from lfr.data.windows import WindowBatch
from lfr.embodiments import embodiment
from lfr.external import ExternalArm
from lfr.jobs import Job
from lfr.networks.device import device_named
from lfr.skills.condition import GIVEN_NOTHING, POSE_NAMES, Condition
from lfr.skills.demonstrations import DATASETS, Demonstrations, balanced, read_tasks
from lfr.skills.gaussian import kl_divergence, kl_to_standard_normal
from lfr.skills.hand_motion import HandJacobian, HandSteps, jacobian_error, train_jacobian
from lfr.skills.library import SkillFolder, skill_folder, tasks_name
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import (
    Seen,
    load_jacobian,
    load_vae,
    save_jacobian,
    save_prior,
    save_vae,
)
from lfr.skills.skill_params import SkillsParams, VAEParams
from lfr.skills.skill_training import PriorMaterial, train_priors, train_vae
from lfr.skills.symmetry import AS_RECORDED, actions_turn_with_base
from lfr.skills.vae import CHUNK, SkillVAE, reconstruction_rmse

ModelJobs = Mapping[Job, Job]
"""Jobs of skill VAEs, each with that of its priors, which needs it."""


@dataclass(frozen=True)
class VAETraining:
    """A skill VAE to train on all that a robot was shown of some tasks.

    Attributes:
        tasks: in order.
        folder: of all skill models.
        datasets: folder of the datasets of arms that this project simulates.
        arm: the robot, where it is external.
    """

    robot: str
    tasks: tuple[str, ...]
    params: SkillsParams
    seed: int
    folder: str
    datasets: str = str(DATASETS)
    arm: ExternalArm | None = None

    @property
    def models(self) -> SkillFolder:
        return skill_folder(Path(self.folder), self.robot, self.tasks)


@dataclass(frozen=True)
class PriorsTraining:
    """The skill priors of some tasks to train for the latent space of a VAE that has been."""

    vae: VAETraining
    tasks: tuple[str, ...]


def model_jobs(
    robot: str,
    needed: Mapping[tuple[str, ...], tuple[str, ...]],
    params: SkillsParams,
    seed: int,
    folder: Path,
    datasets: Path = DATASETS,
    arm: ExternalArm | None = None,
) -> ModelJobs:
    """Jobs that train a robot's models into ``folder``.

    Args:
        needed: as `lfr.skills.library.needed_models` gives it.
        datasets: folder of the datasets of arms that this project simulates.
        arm: the robot, where it is external.
    """
    jobs = {}
    for tasks, priors in needed.items():
        spec = VAETraining(
            robot, tasks, _suited(params, arm), seed, str(folder), str(datasets), arm
        )
        vae = Job(fit_vae, spec)
        jobs[vae] = Job(fit_priors, PriorsTraining(spec, priors), (vae,))
    return jobs


def model_report(jobs: ModelJobs, done: Mapping[Job, Any]) -> dict[str, dict[str, Any]]:
    """What `model_jobs` gave, by the names of the tasks seen (`lfr.skills.library.tasks_name`).

    The tasks, and on held-out episodes the VAE's reconstruction error per action dimension, the
    divergence of its posterior to N(0, I), and of the posterior to each prior; of joint motions the
    Jacobian's error, too.
    """
    return {
        tasks_name(vae.spec.tasks): {**done[vae], "prior": done[priors]}
        for vae, priors in jobs.items()
    }


def fit_vae(spec: VAETraining) -> dict[str, Any]:
    """Train and save a skill VAE; its held-out report."""
    demonstrations = _read(spec, spec.tasks)
    seed = model_seed(spec)
    windows = {task: known.training.actions for task, known in demonstrations.items()}
    names = next(iter(demonstrations.values())).actions.names
    seen = _seen(spec.robot, demonstrations, seed)
    jacobian, report = _fit_jacobian(spec, demonstrations, seed)
    poses = None
    if jacobian is not None:
        save_jacobian(spec.models.jacobian, jacobian, seen)
        begins = {
            task: known.training.observations[:, : len(POSE_NAMES)]
            for task, known in demonstrations.items()
        }
        poses = balanced(begins, seed)
    vae = train_vae(
        balanced(windows, seed), names, spec.params.vae, seed, device_named(spec.params.device),
        poses, vae_condition(spec.params.vae, names),
        jacobian if spec.params.vae.error == "hand" else None,
    )  # fmt: skip
    save_vae(spec.models.vae, vae, seen)
    return {
        "tasks": spec.tasks,
        "datasets": {known.dataset: known.digest for known in demonstrations.values()},
        "held_out": {task: vae_report(vae, known) for task, known in demonstrations.items()},
        **report,
    }


def _fit_jacobian(
    spec: VAETraining, demonstrations: Mapping[str, Demonstrations], seed: int
) -> tuple[HandJacobian | None, dict[str, Any]]:
    """The hand's Jacobian, of an arm whose actions are motions of its joints, and its report."""
    steps = [one.training_motions for one in demonstrations.values() if one.training_motions]
    if not steps:
        return None, {}
    together = HandSteps(*(torch.cat(part) for part in zip(*steps, strict=True)))
    scale = embodiment(spec.robot).action_scale
    jacobian = train_jacobian(together, scale, spec.params.jacobian, seed)
    errors = {
        task: jacobian_error(jacobian, known.held_out_motions)
        for task, known in demonstrations.items()
        if known.held_out_motions is not None and len(known.held_out_motions.poses)
    }
    return jacobian, {"jacobian": errors}


def fit_priors(spec: PriorsTraining) -> dict[str, dict[str, Any]]:
    """Train and save skill priors; their held-out reports by task."""
    vae, training = load_vae(spec.vae.models.vae), spec.vae
    materials = (_material(training, task) for task in spec.tasks)  # read one after the other
    device = device_named(training.params.device)
    priors = train_priors(vae, materials, training.params.prior, device)
    reports = {}
    for task, prior in zip(spec.tasks, priors, strict=True):
        demonstrations = _read(training, (task,))
        known = demonstrations[task]
        seen = _seen(training.robot, demonstrations, model_seed(training, task))
        save_prior(training.models.prior(task), prior, seen)
        reports[task] = {
            "kl_training": _mean(divergence(vae, prior, known.training)),
            "kl_held_out": _mean(divergence(vae, prior, known.held_out)),
        }
    return reports


def _material(spec: VAETraining, task: str) -> PriorMaterial:
    known = _read(spec, (task,))[task]
    windows, names = known.training, known.actions.names
    turned = spec.arm is None and actions_turn_with_base(names)
    return PriorMaterial(
        windows.observations, windows.actions, known.names, names, model_seed(spec, task), turned,
        load_jacobian(spec.models.jacobian) if spec.models.jacobian.is_dir() else None,
    )  # fmt: skip


def vae_condition(params: VAEParams, action_names: Sequence[str]) -> Condition:
    """What a VAE of actions called ``action_names`` sees of the state: nothing of the hand's own
    motions, which are the same wherever it is.
    """
    if params.condition == "none" or not actions_turn_with_base(action_names):
        return GIVEN_NOTHING
    return Condition(POSE_NAMES, turned=True)


@torch.no_grad()
def divergence(vae: SkillVAE, prior: SkillPrior, windows: WindowBatch) -> Tensor:
    """KL(q(z|a) || p_a(z|s)) of every window, (B,), some at a time to spare memory."""
    pairs = zip(windows.actions.split(CHUNK), windows.observations.split(CHUNK), strict=True)
    return torch.cat([kl_divergence(*vae.encode(a, seen), *prior(seen)) for a, seen in pairs])


def vae_report(vae: SkillVAE, known: Demonstrations) -> dict[str, Any]:
    """Reconstruction error per action dimension and KL(q || N(0, I)), on held-out windows."""
    observations, actions, _ = known.held_out
    rmse = reconstruction_rmse(vae, actions, observations).tolist()
    kl = kl_to_standard_normal(*vae.encode_all(actions, observations))
    return {"rmse": dict(zip(known.actions.names, rmse, strict=True)), "kl": _mean(kl)}


def model_seed(spec: VAETraining, prior: str | None = None) -> int:
    """A seed of its own for each model: a VAE, or its prior of a task.

    Equal seeds would start two arms' VAEs from the same weights and hand the mapping an alignment
    that nobody has earned.
    """
    return int(fingerprint(spec.robot, spec.tasks, prior, spec.seed), 16) % 2**31


def _read(spec: VAETraining, tasks: tuple[str, ...]) -> dict[str, Demonstrations]:
    return read_tasks(
        spec.robot, tasks,
        horizon=spec.params.vae.horizon, held_out=spec.params.held_out, seed=spec.seed,
        folder=Path(spec.datasets), arm=spec.arm,
    )  # fmt: skip


def _seen(robot: str, demonstrations: Mapping[str, Demonstrations], seed: int) -> Seen:
    digests = {known.dataset: known.digest for known in demonstrations.values()}
    actions = next(iter(demonstrations.values())).actions
    return Seen(robot, tuple(demonstrations), digests, seed, actions)


def _suited(params: SkillsParams, arm: ExternalArm | None) -> SkillsParams:
    """Of an external arm: its observation may say no pose, and only of a Cartesian one is it known
    how its actions move with the scene.
    """
    if arm is None:
        return params
    params = replace(params, vae=replace(params.vae, condition="none"))
    if arm.cartesian:
        return params
    vae, prior = replace(params.vae, augment=0.0), replace(params.prior, symmetry=AS_RECORDED)
    return replace(params, vae=vae, prior=prior)


def _mean(values: Tensor) -> float | None:
    """None where no held-out episode is long enough for a window."""
    return float(values.mean()) if len(values) else None
