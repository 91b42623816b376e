"""The source's policy without G: with its own decoder, or with the target's (part V)."""

from lfr.skills.library import same_actions
from lfr.skills.resized import resized_vae
from lfr.transfer.extended_policy import IdentityMap
from lfr.transfer.methods.initialization import Initialization, TrainedModels, initialize_from
from lfr.transfer.transfer_params import TransferParams


def ap(models: TrainedModels, params: TransferParams) -> Initialization:
    """Adapt the learned Policy (Tables I and II): the source's prior and decoder as they are.

    The source's actions are then carried out by the target, those of other joints joint by joint
    (`lfr.skills.resized`); learning fine-tunes them.
    """
    prior, decoder = models.source_prior(), models.source_vae()
    if not same_actions(models.skills):
        decoder = resized_vae(decoder, models.target_vae().action_dim)
    return initialize_from(prior, IdentityMap(), decoder, params, prior)


def no_generator(models: TrainedModels, params: TransferParams) -> Initialization:
    """Table III: the source's prior, its skills read as the target's own without a translation."""
    prior = models.source_prior()
    return initialize_from(prior, IdentityMap(), models.target_vae(), params, prior)
