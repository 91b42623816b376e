"""Learn from Robot: pi' = phi o pi from the source's prior (Eq. 7), near phi(p_a) (Eq. 9)."""

from lfr.transfer.methods.initialization import Initialization, TrainedModels, initialize_from
from lfr.transfer.transfer_params import TransferParams


def lfr(models: TrainedModels, params: TransferParams) -> Initialization:
    """The source's prior of the new task, through G, with the target's decoder."""
    prior = models.source_prior()
    return initialize_from(prior, models.generator(), models.target_vae(), params, prior)
