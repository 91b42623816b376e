"""The first link of every chain: what each skill prior achieves on its own arm and task."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, run_trial, shards_of, summaries
from lfr.jobs import run_jobs
from lfr.skills.models import ModelJob, fit_model, model_report
from lfr.skills.policy import SkillFiles


def train_and_measure(
    models: Sequence[ModelJob],
    needs: dict[int, int],
    episodes: int,
    work: Path,
    description: str,
) -> dict[str, dict[str, Any]]:
    """Train the models of a transfer, and run every prior on its own arm and task once it is there.

    Args:
        models, needs: as `lfr.skills.models.model_jobs` gives them.
        episodes: held-out starts of each prior; 0 runs none, for arms without a simulator.

    Returns:
        `lfr.skills.models.model_report`, with the success of each prior as ``own_arm``.
    """
    shards = [
        (place, shard)
        for place, model in enumerate(models)
        if model.task is not None
        for shard in shards_of(own_arm(model, episodes))
    ]
    after = {**needs, **{len(models) + i: place for i, (place, _) in enumerate(shards)}}
    jobs = [*models, *(shard for _, shard in shards)]
    done = run_jobs(run_part, jobs, after=after, work=work, description=description, unit="part")
    fitted, rolled = done[: len(models)], done[len(models) :]
    for place, found in summaries([place for place, _ in shards], rolled).items():
        fitted[place]["own_arm"] = found
    return model_report(models, fitted)


def own_arm(model: ModelJob, episodes: int) -> Trial:
    """A prior on its own arm and task, with the decoder of its role."""
    assert model.task is not None
    files = SkillFiles(str(model.prior), str(model.vae))
    return Trial(files, model.robot, model.task, episodes)


def run_part(part: ModelJob | Trial) -> Any:
    """A model to train, or a shard of a prior's trial."""
    return fit_model(part) if isinstance(part, ModelJob) else run_trial(part)
