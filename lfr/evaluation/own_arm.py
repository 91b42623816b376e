"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.jobs import run_jobs
from lfr.skills.model_jobs import ModelJobs, PriorTraining, model_report
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
    priors = list(itertools.chain(*models.values()))
    shards = {
        prior: trial_jobs(own_arm(prior.spec, episodes), (prior,)) for prior in priors if episodes
    }
    jobs = [*models, *priors, *itertools.chain(*shards.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    for prior, trial in shards.items():
        done[prior]["own_arm"] = success_rate(trial, done)
    return model_report(models, done)


def own_arm(prior: PriorTraining, episodes: int) -> Trial:
    """A prior on its own arm and task, with the decoder of the VAE that it was trained for."""
    models = prior.vae.models
    files = SkillFiles(str(models.prior(prior.task)), str(models.vae))
    return Trial(files, prior.vae.robot, prior.task, episodes)
