"""The transferred policy pi' = phi o pi (Eq. 7), and phi o p_a that it is held near (Eq. 9)."""

from __future__ import annotations

import copy
import math

import torch
from torch import Tensor, nn

from lfr.mapping.generator import Generator
from lfr.skills.prior import SkillPrior


class StandardNormal(nn.Module):
    """A prior that knows nothing: N(0, I) over the latent space, for observations (B, D)."""

    def __init__(self, latent_dim: int) -> None:
        super().__init__()
        self.latent_dim = latent_dim

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        nothing = observations.new_zeros(len(observations), self.latent_dim)
        return nothing, nothing


class IdentityMap(nn.Module):
    """phi of a method without a generator: (mu, log_sigma) unchanged, (B, Z) each."""

    feature_size = 0

    def features(self, observation: Tensor) -> Tensor:
        """It sees nothing of observations (B, D): (B, 0)."""
        return observation[:, :0]

    def forward(
        self, mu: Tensor, log_sigma: Tensor, features: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        return mu, log_sigma


Phi = Generator | IdentityMap


class MappedPolicy(nn.Module):
    """phi(pi(z|s)): observations (B, D) in the layout's units to (mu, log_sigma), (B, Z) each.

    The Gaussian is not squashed: the divergence to phi(p_a) keeps it where the decoder was trained,
    and a tanh would only add SPiRL's trap of a slope that is not 1 at the mean.

    Attributes:
        min_sigma: is added to sigma in quadrature, sqrt(sigma^2 + min_sigma^2), so that sigma still
            learns everywhere; 0 leaves it as it is. A prior can be surer of itself than steps of
            Adam resolve: then the policy can neither come back to it nor explore around it.
    """

    def __init__(self, pi: nn.Module, phi: Phi, min_sigma: float = 0.0) -> None:
        super().__init__()
        self.pi, self.phi, self.min_sigma = pi, phi, min_sigma

    def forward(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        return self.of_features(self.features(observation))

    def features(self, observation: Tensor) -> Tensor:
        """What pi makes of observations (B, D) before its first parameters, itself if nothing, and
        after it what phi sees of them.
        """
        seen = self.pi.features(observation) if isinstance(self.pi, SkillPrior) else observation
        return torch.cat([seen, self.phi.features(observation)], dim=-1)

    def of_features(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """(mu, log_sigma), (B, Z) each, for the `features` of observations."""
        pi = self.pi.of_features if isinstance(self.pi, SkillPrior) else self.pi
        beside = self.phi.feature_size
        seen, of_phi = features.split([features.shape[-1] - beside, beside], dim=-1)
        mu, log_sigma = self.phi(*pi(seen), of_phi)  # Eq. 7
        if self.min_sigma > 0.0:
            bound = torch.full_like(log_sigma, 2.0 * math.log(self.min_sigma))
            log_sigma = 0.5 * torch.logaddexp(2.0 * log_sigma, bound)
        return mu, log_sigma


def initial_policy(
    prior: nn.Module, phi: Phi, *, train_phi: bool, min_sigma: float = 0.0
) -> MappedPolicy:
    """phi o pi with pi = p_a to begin with: a trainable copy, phi trainable if ``train_phi``."""
    policy = copy.deepcopy(MappedPolicy(prior, phi, min_sigma)).requires_grad_(True)
    policy.phi.requires_grad_(train_phi)
    return policy


def frozen_prior(prior: nn.Module, phi: Phi, min_sigma: float = 0.0) -> MappedPolicy:
    """phi(p_a) of Eq. 9: a copy of its own that never learns.

    Sharing phi with the policy would let it lower the divergence by moving the prior instead.
    """
    return copy.deepcopy(MappedPolicy(prior, phi, min_sigma)).requires_grad_(False).eval()
