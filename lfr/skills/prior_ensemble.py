"""The skill priors of one VAE as one network: one evaluation, one gradient."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from lfr.networks.device import CPU
from lfr.networks.stacked import Stacked
from lfr.skills.gaussian import LOG_SIGMA_RANGE, kl_slopes
from lfr.skills.prior import SkillPrior


class PriorEnsemble:
    """E priors of one latent space, which may differ in what they see.

    Attributes:
        networks: what learns of them.
    """

    def __init__(self, priors: Sequence[SkillPrior], device: torch.device = CPU) -> None:
        self.networks = Stacked([prior.network for prior in priors], device)

    @torch.no_grad()
    def gradient(self, inputs: Tensor, mu: Tensor, log_sigma: Tensor) -> Tensor:
        """Of the sum over priors of L_task by all parameters, (P,); overwritten by the next call.

        L_task of Eq. 3 is KL([q(z|a)] || p_a(z|s)), the posterior frozen, mean over the batch. Its
        gradient with respect to the prior is that of SPiRL's negative log-likelihood on z.

        Args:
            inputs: (E, B, in), normalised observations.
            mu, log_sigma: (E, B, Z), the posteriors that the priors should predict.
        """
        outputs, traces = self.networks.evaluate(inputs)
        mu_prior, unbounded = outputs.chunk(2, dim=-1)
        log_sigma_prior = unbounded.clamp(*LOG_SIGMA_RANGE)
        by_mu, by_log_sigma = kl_slopes(mu, log_sigma, mu_prior, log_sigma_prior)
        by_log_sigma *= log_sigma_prior == unbounded  # nothing passes a bound
        by_outputs = torch.cat([by_mu, by_log_sigma], dim=-1) / inputs.shape[1]
        return self.networks.by_parameters(traces, by_outputs)
