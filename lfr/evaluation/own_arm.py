"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

from lfr.data.external import selected
from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.external_simulation import external_target
from lfr.jobs import run_jobs
from lfr.skills.model_jobs import ModelJobs, PriorsTraining, model_report
from lfr.skills.skill_policy import SkillFiles


def train_and_measure(
    models: ModelJobs, episodes: int, work: Path, description: str
) -> dict[str, dict[str, Any]]:
    """Train the models of a robot, and run every prior on its own arm and task once it is there.

    Args:
        models: as `lfr.skills.model_jobs.model_jobs` gives them.
        episodes: held-out starts of each prior; arms without a simulator run none.

    Returns:
        `lfr.skills.model_jobs.model_report`, with the success of each prior as ``own_arm``.
    """
    trials = {
        (priors, task): trial_jobs(own_arm(priors.spec, task, episodes), (priors,))
        for priors in models.values()
        for task in priors.spec.tasks
        if acts(priors.spec, task)
    }
    jobs = [*models, *models.values(), *itertools.chain(*trials.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    for (priors, task), trial in trials.items():
        done[priors][task]["own_arm"] = success_rate(trial, done)
    return model_report(models, done)


def acts(priors: PriorsTraining, task: str) -> bool:
    """Whether there is a simulator that the arm can do a task in."""
    arm = priors.vae.arm
    return arm is None or task in arm.environments


def own_arm(priors: PriorsTraining, task: str, episodes: int) -> Trial:
    """A prior on its own arm and task, with the decoder of the VAE that it was trained for."""
    models, robot, arm = priors.vae.models, priors.vae.robot, priors.vae.arm
    files = SkillFiles(str(models.prior(task)), str(models.vae))
    external = None
    if arm is not None:
        names = selected(arm, task).observation_names
        external = external_target(robot, arm, task, (), names)
    return Trial(files, robot, task, episodes, external=external)
