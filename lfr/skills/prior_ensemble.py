"""The skill priors of one VAE as one network: stacked weights, one evaluation, one gradient."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from lfr.networks.ensemble import Layer, Shape, differentiate, evaluate
from lfr.skills.gaussian import kl_slopes
from lfr.skills.prior import NEGATIVE_SLOPE, SkillPrior
from lfr.skills.vae import LOG_SIGMA_RANGE


class PriorEnsemble:
    """E priors of one latent space and one shape but for what they see, which may differ.

    Inputs are filled up with zeros to the widest; the weights of these learn nothing.

    Attributes:
        vector: all parameters (P,); a change in place is a change of the ensemble.
    """

    def __init__(self, priors: Sequence[SkillPrior]) -> None:
        one = priors[0]
        self._priors = list(priors)
        self.inputs = max(prior.normalizer.size for prior in priors)
        widths = (self.inputs, *[one.hidden] * one.layers)
        self.shape = Shape(len(priors), widths, outputs=2 * one.latent_dim, slope=NEGATIVE_SLOPE)
        self.vector = self.shape.initial()
        self._gradient = torch.zeros_like(self.vector)
        self._layers, self._slopes = (
            self.shape.layers(vector) for vector in (self.vector, self._gradient)
        )
        for member, prior in enumerate(priors):
            for linear, layer in zip(_linears(prior), self._layers, strict=True):
                layer.weight[member].zero_()[: linear.in_features] = linear.weight.detach().T
                layer.bias[member, 0] = linear.bias.detach()

    def stacked(self, inputs: Sequence[Tensor]) -> Tensor:
        """Normalised observations of each prior (..., in) as (E, ..., in of the widest)."""
        widths = (self.inputs - one.shape[-1] for one in inputs)
        return torch.stack(
            [functional.pad(one, (0, width)) for one, width in zip(inputs, widths, strict=True)]
        )

    @torch.no_grad()
    def gradient(self, inputs: Tensor, mu: Tensor, log_sigma: Tensor) -> Tensor:
        """Of the sum over priors of L_task by ``vector``, (P,); overwritten by the next call.

        L_task of Eq. 3 is KL([q(z|a)] || p_a(z|s)), the posterior frozen, mean over the batch. Its
        gradient with respect to the prior is that of SPiRL's negative log-likelihood on z.

        Args:
            inputs: (E, B, in), normalised and stacked.
            mu, log_sigma: (E, B, Z), the posteriors that the priors should predict.
        """
        slope = self.shape.slope
        outputs, traces = evaluate(self._layers, inputs, slope)
        mu_p, unbounded = outputs.chunk(2, dim=-1)
        log_sigma_p = unbounded.clamp(*LOG_SIGMA_RANGE)
        by_mu, by_log_sigma = kl_slopes(mu, log_sigma, mu_p, log_sigma_p)
        by_log_sigma *= log_sigma_p == unbounded  # nothing passes a bound
        by_outputs = torch.cat([by_mu, by_log_sigma], dim=-1) / inputs.shape[1]
        differentiate(self._layers, traces, by_outputs, into=self._slopes, slope=slope)
        return self._gradient

    def clipped(self, gradient: Tensor, limit: float) -> Tensor:
        """A gradient (P,), each prior's part scaled in place to a norm of at most ``limit``."""
        if float(torch.linalg.vector_norm(gradient)) > limit:
            for member in range(self.shape.ensemble):
                parts = [tensor[member] for layer in self._slopes for tensor in _tensors(layer)]
                norm = float(torch.stack([p.square().sum() for p in parts]).sum().sqrt())
                for part in parts if norm > limit else []:
                    part.mul_(limit / norm)
        return gradient

    def priors(self) -> list[SkillPrior]:
        """The priors that this was made of, with the parameters that they have by now."""
        with torch.no_grad():
            for member, prior in enumerate(self._priors):
                for linear, layer in zip(_linears(prior), self._layers, strict=True):
                    linear.weight.copy_(layer.weight[member, : linear.in_features].T)
                    linear.bias.copy_(layer.bias[member, 0])
        return self._priors


def _linears(prior: SkillPrior) -> list[nn.Linear]:
    return [module for module in prior.network if isinstance(module, nn.Linear)]


def _tensors(layer: Layer) -> list[Tensor]:
    return [tensor for tensor in layer if tensor is not None]
