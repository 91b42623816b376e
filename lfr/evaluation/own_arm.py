"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

from lfr.data.external import selected
from lfr.environments.simulation import external_target
from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.external import ExternalArm
from lfr.jobs import run_jobs
from lfr.skills.model_jobs import ModelJobs, PriorsTraining, model_report
from lfr.skills.skill_policy import SkillFiles


def train_and_measure(
    models: ModelJobs,
    episodes: int,
    work: Path,
    description: str,
    arm: ExternalArm | None = None,
) -> dict[str, dict[str, Any]]:
    """Train the models of a robot, and run every prior on its own arm and task once it is there.

    Args:
        models: as `lfr.skills.model_jobs.model_jobs` gives them.
        episodes: held-out starts of each prior.
        arm: the robot, where it is external; it runs the tasks that it has environments for.

    Returns:
        `lfr.skills.model_jobs.model_report`, with the success of each prior as ``own_arm``.
    """
    trials = {
        (priors, task): trial_jobs(own_arm(priors.spec, task, episodes, arm), (priors,))
        for priors in models.values()
        for task in priors.spec.tasks
        if arm is None or task in arm.environments
    }
    jobs = [*models, *models.values(), *itertools.chain(*trials.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    for (priors, task), trial in trials.items():
        done[priors][task]["own_arm"] = success_rate(trial, done)
    return model_report(models, done)


def own_arm(
    priors: PriorsTraining, task: str, episodes: int, arm: ExternalArm | None = None
) -> Trial:
    """A prior on its own arm and task, with the decoder of the VAE that it was trained for."""
    models, robot = priors.vae.models, priors.vae.robot
    files = SkillFiles(str(models.prior(task)), str(models.vae))
    external = None
    if arm is not None:
        names = selected(arm, task).observation_names
        external = external_target(robot, arm, task, (), names)
    return Trial(files, robot, task, episodes, external=external)
