"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.jobs import Job, run_jobs
from lfr.skills.models import ModelJob, model_report
from lfr.skills.policy import SkillFiles


def train_and_measure(
    models: Sequence[Job], episodes: int, work: Path, description: str
) -> dict[str, dict[str, Any]]:
    """Train the models of a transfer, and run every prior on its own arm and task once it is there.

    Args:
        models: as `lfr.skills.models.model_jobs` gives them.
        episodes: held-out starts of each prior; 0 runs none, for arms without a simulator.

    Returns:
        `lfr.skills.models.model_report`, with the success of each prior as ``own_arm``.
    """
    priors = [job for job in models if job.spec.task is not None] if episodes else []
    shards = {prior: trial_jobs(own_arm(prior.spec, episodes), (prior,)) for prior in priors}
    jobs = [*models, *itertools.chain(*shards.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    for prior, trial in shards.items():
        done[prior]["own_arm"] = success_rate(trial, done)
    return model_report({job: done[job] for job in models})


def own_arm(model: ModelJob, episodes: int) -> Trial:
    """A prior on its own arm and task, with the decoder of its role."""
    assert model.task is not None
    files = SkillFiles(str(model.prior), str(model.vae))
    return Trial(files, model.robot, model.task, episodes)
