"""Learn from Robot with one part exchanged: phi's data, the latent space, or the prior."""

from __future__ import annotations

from collections.abc import Callable

from lfr.ablations.other_task import load_other_task
from lfr.mapping.artifacts import load_generator
from lfr.skills.artifacts import load_prior, load_vae
from lfr.transfer.methods.start import Start, TrainedModels, start_from
from lfr.transfer.params import TransferParams
from lfr.transfer.policy import IdentityMap
from lfr.transfer.residual_prior import residual_prior


def only(task: str) -> Callable[[TrainedModels, TransferParams], Start]:
    """Table III: G has learned from one common task alone."""

    def start(models: TrainedModels, params: TransferParams) -> Start:
        prior, g = models.source_prior(), load_generator(models.variant(f"only_{task}") / "g")
        return start_from(prior, g, models.target_vae(), params, prior)

    return start


def shared_vae(models: TrainedModels, params: TransferParams) -> Start:
    """One latent space of both arms, so that nothing has to be translated."""
    folder = models.variant("shared_vae")
    prior, vae = load_prior(folder / "prior"), load_vae(folder / "vae")
    return start_from(prior, IdentityMap(), vae, params, prior)


def wrong_task(models: TrainedModels, params: TransferParams) -> Start:
    """The source's prior of another task, mapped: what is it worth to know the right one?"""
    prior = load_other_task(models.variant("wrong_task") / "prior")
    reference, vae = models.source_prior(), models.target_vae()
    pi = residual_prior(
        prior, reference
    )  # what the wrong task has not, the policy sees all the same
    return start_from(prior, models.generator(), vae, params, reference, pi)
