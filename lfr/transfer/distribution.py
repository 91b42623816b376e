"""How a policy's (mu, log_sigma) become a skill, and how far they are from the prior."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor
from torch.nn import functional as F

from lfr.errors import UnknownNameError
from lfr.skills.gaussian import kl_divergence, kl_slopes_of_first


class Distribution(Protocol):
    """What an actor draws its skills from."""

    @property
    def name(self) -> str: ...

    def skill(self, mu: Tensor, log_sigma: Tensor, noise: Tensor | None) -> Tensor:
        """z (B, Z), reparameterised, for standard normal noise (B, Z); without it the mean's."""
        ...

    def divergence(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor,
    ) -> Tensor:  # fmt: skip
        """KL to the prior, (B,), in nats; ``noise`` is what the skill was drawn with."""
        ...

    def slopes(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor, by_skill: Tensor, by_divergence: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        """dL/dmu and dL/dlog_sigma (B, Z), for dL/dz (B, Z) and dL/dKL (B,) of what was drawn."""
        ...


@dataclass(frozen=True)
class Gaussian:
    """A skill is a point of the latent space, its prior a Gaussian (Eq. 8 and 9)."""

    name: str = "gaussian"

    def skill(self, mu: Tensor, log_sigma: Tensor, noise: Tensor | None) -> Tensor:
        return mu if noise is None else mu + log_sigma.exp() * noise

    def divergence(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor,
    ) -> Tensor:  # fmt: skip
        return kl_divergence(mu, log_sigma, prior_mu, prior_log_sigma)

    def slopes(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor, by_skill: Tensor, by_divergence: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        # z = mu + sigma epsilon: dz/dmu = 1, dz/dlog sigma = sigma epsilon
        by_mu, by_log_sigma = kl_slopes_of_first(mu, log_sigma, prior_mu, prior_log_sigma)
        by_mu = by_skill + by_divergence[:, None] * by_mu
        by_log_sigma = by_skill * log_sigma.exp() * noise + by_divergence[:, None] * by_log_sigma
        return by_mu, by_log_sigma


@dataclass(frozen=True)
class SquashedGaussian:
    """a = tanh(u), u ~ N(mu, sigma), as in SAC; its prior is the uniform distribution on [-1, 1]^A.

    The divergence is log pi(a|s) + A log 2 of the action drawn, so Eq. 9 is then SAC's entropy
    term: a target divergence of A (1 + log 2) nats is SAC's target entropy of -A (Haarnoja et al.
    2018, applications, table 1). The Gaussian prior that it is given says nothing and is not asked.
    """

    name: str = "squashed"

    def skill(self, mu: Tensor, log_sigma: Tensor, noise: Tensor | None) -> Tensor:
        return torch.tanh(mu if noise is None else mu + log_sigma.exp() * noise)

    def divergence(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor,
    ) -> Tensor:  # fmt: skip
        u = mu + log_sigma.exp() * noise
        log_normal = -0.5 * noise.square() - log_sigma - 0.5 * math.log(2.0 * math.pi)
        # log(1 - tanh(u)^2), without its rounding to log 0
        log_slope = 2.0 * (math.log(2.0) - u - F.softplus(-2.0 * u))
        return (log_normal - log_slope + math.log(2.0)).sum(-1)

    def slopes(
        self, mu: Tensor, log_sigma: Tensor, noise: Tensor, prior_mu: Tensor,
        prior_log_sigma: Tensor, by_skill: Tensor, by_divergence: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        # a = tanh(u), u = mu + sigma epsilon: da/du = 1 - a^2, and dKL/du = 2 a
        spread = log_sigma.exp() * noise  # du/dlog sigma
        a = torch.tanh(mu + spread)
        by_u = by_skill * (1.0 - a.square()) + by_divergence[:, None] * 2.0 * a
        return by_u, by_u * spread - by_divergence[:, None]


def tempered(divergence: Tensor, limit: float) -> tuple[Tensor, Tensor]:
    """D, and beyond the limit c its logarithm, c (1 + ln(D / c)): (B,) nats to (B,) nats.

    Value and slope are continuous at c. A prior is sure of itself where no demonstration has been
    too, and there a state's D reaches 1e5 nats and more: untempered, one such state in a batch
    outweighs all others in Eq. 9 and in the TD target. By D ~ |mu - mu_p|^2 the slope beyond c
    falls as 2c / |mu - mu_p|, so the policy is still pulled back. SPiRL clips instead, at 100
    nats, where the pull ends. A limit of 0 leaves D as it is (the paper).

    Returns:
        The value, and its slope by D, 1 or beyond the limit c / D.
    """
    if limit == 0.0:
        return divergence, torch.ones_like(divergence)
    beyond = (divergence / limit).clamp_(min=1.0)  # D / c, 1 below the limit
    return torch.add(divergence.clamp(max=limit), beyond.log(), alpha=limit), beyond.reciprocal()


GAUSSIAN, SQUASHED = Gaussian(), SquashedGaussian()
DISTRIBUTIONS: dict[str, Distribution] = {one.name: one for one in (GAUSSIAN, SQUASHED)}


def distribution(name: str) -> Distribution:
    """The distribution called ``name``.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in DISTRIBUTIONS:
        raise UnknownNameError("distribution", name, DISTRIBUTIONS)
    return DISTRIBUTIONS[name]
