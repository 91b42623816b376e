"""SPiRL (Pertsch et al. 2021) on the target alone: nothing comes from the other arm.

But for the units of the critics' inputs, which are the same for every method.
"""

from __future__ import annotations

from lfr.ablations.other_task import load_other_task
from lfr.transfer.methods.start import Start, TrainedModels, new_pi, start_from
from lfr.transfer.params import TransferParams
from lfr.transfer.policy import IdentityMap, StandardNormal
from lfr.transfer.residual_prior import residual_prior


def spirl(models: TrainedModels, params: TransferParams) -> Start:
    """From the target's own prior, which has seen its common tasks and no name of any.

    The prior knows nothing of a goal; the policy that begins with it sees everything.
    """
    prior = load_other_task(models.variant("any_task") / "prior")
    reference, vae = models.source_prior(), models.target_vae()
    return start_from(
        prior, IdentityMap(), vae, params, reference, residual_prior(prior, reference)
    )


def spirl_no_prior(models: TrainedModels, params: TransferParams) -> Start:
    """Skills without a prior: a new policy over the target's latent space, near N(0, I)."""
    reference, vae = models.source_prior(), models.target_vae()
    pi = new_pi(reference, vae.latent_dim, reference.hidden, reference.layers)
    return start_from(
        StandardNormal(vae.latent_dim), IdentityMap(), vae, params, reference, pi
    )  # fmt: skip
