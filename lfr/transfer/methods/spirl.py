"""SPiRL (Pertsch et al. 2021) on the target alone: nothing comes from the other arm.

But for the units of the critics' inputs, which are the same for every method.
"""

from __future__ import annotations

from dataclasses import replace

from lfr.ablations.other_task import load_other_task
from lfr.transfer.methods.start import Start, TrainedModels, new_policy, start_from
from lfr.transfer.params import TransferParams
from lfr.transfer.policy import IdentityMap, StandardNormal


def spirl(models: TrainedModels, params: TransferParams) -> Start:
    """From the target's own prior, which has seen its common tasks and no name of any."""
    prior = load_other_task(models.variant("any_task") / "prior")
    return start_from(
        prior, IdentityMap(), models.target_vae(), params, models.source_prior()
    )  # fmt: skip


def spirl_no_prior(models: TrainedModels, params: TransferParams) -> Start:
    """Skills without a prior: a new policy over the target's latent space, near N(0, I)."""
    reference, vae = models.source_prior(), models.target_vae()
    nothing = StandardNormal(vae.latent_dim)
    start = start_from(nothing, IdentityMap(), vae, params, reference)
    policy = new_policy(reference, vae.latent_dim, reference.hidden, reference.layers)
    return replace(start, actor=replace(start.actor, policy=policy))
