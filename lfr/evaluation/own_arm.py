"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.jobs import run_jobs
from lfr.skills.model_jobs import ModelJobs, PriorsTraining, model_report
from lfr.skills.skill_policy import SkillFiles


def train_and_measure(
    models: ModelJobs, episodes: int, work: Path, description: str
) -> dict[str, dict[str, Any]]:
    """Train the models of a robot, and run every prior on its own arm and task once it is there.

    Args:
        models: as `lfr.skills.model_jobs.model_jobs` gives them.
        episodes: held-out starts of each prior; 0 runs none, for arms without a simulator.

    Returns:
        `lfr.skills.model_jobs.model_report`, with the success of each prior as ``own_arm``.
    """
    trials = {
        (priors, task): trial_jobs(own_arm(priors.spec, task, episodes), (priors,))
        for priors in models.values()
        for task in (priors.spec.tasks if episodes else ())
    }
    jobs = [*models, *models.values(), *itertools.chain(*trials.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    for (priors, task), trial in trials.items():
        done[priors][task]["own_arm"] = success_rate(trial, done)
    return model_report(models, done)


def own_arm(priors: PriorsTraining, task: str, episodes: int) -> Trial:
    """A prior on its own arm and task, with the decoder of the VAE that it was trained for."""
    models = priors.vae.models
    files = SkillFiles(str(models.prior(task)), str(models.vae))
    return Trial(files, priors.vae.robot, task, episodes)
