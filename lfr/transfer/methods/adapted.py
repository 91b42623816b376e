"""The source's policy without G: with its own decoder, or with the target's (part V)."""

from lfr.errors import LfrError
from lfr.skills.library import same_actions
from lfr.transfer.extended_policy import IdentityMap
from lfr.transfer.methods.initialization import Initialization, TrainedModels, initialize_from
from lfr.transfer.transfer_params import TransferParams


def ap(models: TrainedModels, params: TransferParams) -> Initialization:
    """Adapt the learned Policy (Tables I and II): the source's prior and decoder as they are.

    The source's actions are then carried out by the target; learning fine-tunes them.

    Raises:
        LfrError: they are other things than the target's, such as motions of other joints.
    """
    if not same_actions(models.skills):
        source, target = models.transfer.source, models.transfer.target
        raise LfrError(
            f"ap: {target} cannot carry out the actions of {source}; "
            "choose a method that translates them, such as lfr"
        )
    prior = models.source_prior()
    return initialize_from(prior, IdentityMap(), models.source_vae(), params, prior)


def no_generator(models: TrainedModels, params: TransferParams) -> Initialization:
    """Table III: the source's prior, its skills read as the target's own without a translation."""
    prior = models.source_prior()
    return initialize_from(prior, IdentityMap(), models.target_vae(), params, prior)
