"""Closed forms of Eq. 3 and Eq. 9 against torch.distributions."""

import torch
from torch.distributions import Independent, Normal, kl_divergence

from lfr.skills import gaussian


def random_pair(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    return (
        torch.randn(5, 3, generator=generator, dtype=torch.float64),
        torch.randn(5, 3, generator=generator, dtype=torch.float64),
    )


def distribution(mu: torch.Tensor, log_sigma: torch.Tensor) -> Independent:
    return Independent(Normal(mu, log_sigma.exp()), 1)


def test_kl_between_diagonal_gaussians() -> None:
    p, q = random_pair(0), random_pair(1)
    torch.testing.assert_close(
        gaussian.kl_divergence(*p, *q), kl_divergence(distribution(*p), distribution(*q))
    )
    torch.testing.assert_close(
        gaussian.kl_divergence(*p, *p), torch.zeros(5, dtype=torch.float64), atol=1e-12, rtol=0
    )


def test_kl_to_the_standard_normal() -> None:
    p = random_pair(2)
    standard = distribution(torch.zeros_like(p[0]), torch.zeros_like(p[0]))
    torch.testing.assert_close(
        gaussian.kl_to_standard_normal(*p), kl_divergence(distribution(*p), standard)
    )


def test_log_probability() -> None:
    p = random_pair(3)
    z = random_pair(4)[0]
    torch.testing.assert_close(gaussian.log_probability(z, *p), distribution(*p).log_prob(z))


def test_samples_have_the_mean_and_spread_they_should() -> None:
    mu, log_sigma = torch.tensor([1.0, -2.0]), torch.tensor([0.0, -1.0])
    generator = torch.Generator().manual_seed(0)
    z = gaussian.sample(mu.expand(200_000, 2), log_sigma.expand(200_000, 2), generator)
    torch.testing.assert_close(z.mean(0), mu, atol=0.01, rtol=0)
    torch.testing.assert_close(z.std(0), log_sigma.exp(), atol=0.01, rtol=0)
