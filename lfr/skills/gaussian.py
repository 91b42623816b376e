"""Diagonal Gaussians over the latent space, as pairs ``(mu, log_sigma)`` of shape (..., Z)."""

from __future__ import annotations

import math

import torch
from torch import Tensor

LOG_SIGMA_RANGE = (-6.0, 2.0)
"""That networks are held to, by which a distribution is predicted."""


def kl_divergence(mu_p: Tensor, log_sigma_p: Tensor, mu_q: Tensor, log_sigma_q: Tensor) -> Tensor:
    """KL(p || q) of diagonal Gaussians in closed form, summed over the latent dimensions, (...,).

    Used for the second and third term of Eq. 3 and for the divergence of Eq. 8 and 9.
    """
    difference = (mu_p - mu_q) * torch.exp(-log_sigma_q)
    log_ratio = 2.0 * (log_sigma_p - log_sigma_q)  # of the variances
    each = torch.addcmul(torch.expm1(log_ratio) - log_ratio, difference, difference)
    return 0.5 * each.sum(-1)


def kl_slopes(
    mu_p: Tensor, log_sigma_p: Tensor, mu_q: Tensor, log_sigma_q: Tensor
) -> tuple[Tensor, Tensor]:
    """The gradient of `kl_divergence` by q's mu and log_sigma, (..., Z) each."""
    precision = torch.exp(-2.0 * log_sigma_q)
    difference = mu_q - mu_p
    by_mu = difference * precision
    ratio = torch.exp(2.0 * log_sigma_p) * precision
    return by_mu, 1.0 - ratio - difference * by_mu


def kl_slopes_of_first(
    mu_p: Tensor, log_sigma_p: Tensor, mu_q: Tensor, log_sigma_q: Tensor
) -> tuple[Tensor, Tensor]:
    """The gradient of `kl_divergence` by p's mu and log_sigma, (..., Z) each."""
    by_mu = (mu_p - mu_q) * torch.exp(-2.0 * log_sigma_q)
    return by_mu, torch.exp(2.0 * (log_sigma_p - log_sigma_q)) - 1.0


def kl_to_standard_normal(mu: Tensor, log_sigma: Tensor) -> Tensor:
    """KL(N(mu, sigma) || N(0, I)), summed over the latent dimensions, (...,)."""
    return 0.5 * (torch.exp(2.0 * log_sigma) + mu.square() - 1.0).sum(-1) - log_sigma.sum(-1)


def log_probability(z: Tensor, mu: Tensor, log_sigma: Tensor) -> Tensor:
    """log N(z; mu, sigma), summed over the latent dimensions, (...,)."""
    standardised = (z - mu) * torch.exp(-log_sigma)
    return -(0.5 * standardised.square() + log_sigma + 0.5 * math.log(2.0 * math.pi)).sum(-1)


def sample(mu: Tensor, log_sigma: Tensor, generator: torch.Generator | None = None) -> Tensor:
    """A reparameterised sample z = mu + sigma * epsilon, of mu's shape."""
    # drawn on the CPU, so that it is the same on any device
    epsilon = torch.randn(mu.shape, generator=generator, dtype=mu.dtype).to(mu.device)
    return mu + torch.exp(log_sigma) * epsilon
