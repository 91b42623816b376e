"""One arm as both sides of a mapping: what of the problem is the latents' arbitrary rotation alone?

X and Y are the latent spaces of two skill VAEs of the *source* arm, from two whole repetitions. No
embodiment differs, so what a mapping between them loses is not the arms' doing.
"""

from __future__ import annotations

from pathlib import Path

import torch

from lfr.mapping.hand_loss import SourceTask
from lfr.mapping.mapping_jobs import MappingJob, Material
from lfr.mapping.mapping_training import ActionWindows, CommonTask
from lfr.skills.demonstrations import balanced, read_visible
from lfr.skills.library import RoleModels
from lfr.skills.prior import SkillPrior
from lfr.skills.rows import thinned
from lfr.skills.saved_models import load_prior, load_vae
from lfr.skills.vae import SkillVAE
from lfr.spaces import ROBOT_STATE


def material_between(
    job: MappingJob, other: RoleModels, seed: int
) -> tuple[Material, tuple[SkillVAE, SkillVAE]]:
    """What `lfr.mapping.mapping_jobs.read_material` gives, the source arm being both arms.

    Args:
        job: names the first repetition; its split of the demonstrations is used. The other's models
            may have seen what is held out here.
        other: the source's skill models of the other repetition.
    """
    transfer, arms = job.transfer, (job.skills["source"], other)
    vaes = load_vae(arms[0].vae()), load_vae(arms[1].vae())
    known = read_visible(
        job.scenario, transfer.source, "source", (*transfer.common, transfer.task),
        horizon=vaes[0].horizon, held_out=job.held_out, seed=job.seed, folder=Path(job.datasets),
        arm=job.arms.get(transfer.source),
    )  # fmt: skip

    def common(states: dict[str, torch.Tensor]) -> dict[str, CommonTask]:
        def prior(of: RoleModels, task: str) -> SkillPrior:
            return load_prior(of.prior(task), known[task].names)

        x, y = arms
        return {
            task: CommonTask(prior(x, task), prior(y, task), states[task])
            for task in transfer.common
        }

    windows = {task: thinned(known[task].training.actions) for task in transfer.common}
    new = known[transfer.task]
    states = {
        task: thinned(known[task].training.observations[:, : ROBOT_STATE.size])
        for task in transfer.common
    }
    shared = ActionWindows(balanced(windows, seed), new.actions.names, balanced(states, seed))
    prior = load_prior(arms[0].prior(transfer.task), new.names)
    material = Material(
        training=common({task: known[task].training_states for task in transfer.common}),
        held_out=common({task: known[task].held_out_states for task in transfer.common}),
        windows=shared if job.params.posterior_share else None,
        new=SourceTask(prior, new.held_out_states),
        new_training=SourceTask(prior, new.training_states),
        datasets={known[task].dataset: known[task].digest for task in transfer.common},
        new_dataset={new.dataset: new.digest},
        action_names=new.actions.names,
    )
    return material, vaes
