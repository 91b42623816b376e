"""Skills and divergences against torch.distributions."""

import math

import pytest
import torch
from torch.distributions import Normal, TransformedDistribution
from torch.distributions.transforms import TanhTransform

from lfr.errors import UnknownNameError
from lfr.transfer.distribution import GAUSSIAN, SQUASHED, distribution, tempered


@pytest.fixture
def drawn():
    g = torch.Generator().manual_seed(0)
    mu, log_sigma, noise = (torch.randn(64, 7, generator=g) for _ in range(3))
    return mu, 0.5 * log_sigma - 0.5, noise


def test_the_squashed_divergence_is_sac_s_entropy_against_the_uniform(drawn):
    mu, log_sigma, noise = drawn
    nothing = torch.zeros_like(mu)
    action = SQUASHED.skill(mu, log_sigma, noise)
    squashed = TransformedDistribution(Normal(mu, log_sigma.exp()), TanhTransform(cache_size=1))
    latent = mu + log_sigma.exp() * noise
    torch.testing.assert_close(action, torch.tanh(latent))
    uniform = -7 * math.log(2.0)
    log_probability = squashed.base_dist.log_prob(latent) - TanhTransform().log_abs_det_jacobian(
        latent, action
    )
    expected = log_probability.sum(-1) - uniform
    found = SQUASHED.divergence(mu, log_sigma, noise, nothing, nothing)
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-4)


def test_the_squashed_divergence_stays_finite_where_the_action_is_at_its_bound():
    mu = torch.full((1, 7), 30.0, requires_grad=True)
    nothing = torch.zeros(1, 7)
    found = SQUASHED.divergence(mu, nothing, nothing, nothing, nothing)
    assert found.isfinite().all()
    (slope,) = torch.autograd.grad(found.sum(), mu)
    assert slope.isfinite().all()
    assert (slope > 0).all()


def test_the_gaussian_divergence_is_the_mean_of_log_ratios(drawn):
    mu, log_sigma, noise = drawn
    prior = torch.zeros_like(mu), torch.full_like(mu, 0.3)
    found = GAUSSIAN.divergence(mu, log_sigma, noise, *prior)
    p, q = Normal(mu, log_sigma.exp()), Normal(prior[0], prior[1].exp())
    torch.testing.assert_close(found, torch.distributions.kl_divergence(p, q).sum(-1))
    torch.testing.assert_close(GAUSSIAN.skill(mu, log_sigma, None), mu)


def test_distributions_go_by_name():
    assert distribution("squashed") is SQUASHED
    with pytest.raises(UnknownNameError, match="gaussian"):
        distribution("normal")


def test_a_tempered_divergence_grows_by_its_logarithm_beyond_the_limit():
    divergence = torch.tensor([0.0, 3.0, 15.0, 15.0 * math.e, 1.5e5])
    found, slope = tempered(divergence, 15.0)
    expected = torch.tensor([0.0, 3.0, 15.0, 30.0, 15.0 * (1.0 + 4.0 * math.log(10.0))])
    torch.testing.assert_close(found, expected)
    torch.testing.assert_close(slope, torch.tensor([1.0, 1.0, 1.0, 1.0 / math.e, 1e-4]))


def test_a_limit_of_zero_leaves_the_divergence_as_it_is():
    divergence = torch.tensor([0.0, 3.0, 1.5e5])
    found, slope = tempered(divergence, 0.0)
    assert found is divergence
    assert (slope == 1.0).all()


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("drawn_from", [GAUSSIAN, SQUASHED])
def test_slopes_are_autograds(drawn, drawn_from, limited):
    """Of any sum of what is drawn and of what is charged for it, half of it beyond the limit."""
    mu, log_sigma, noise = (one.double() for one in drawn)
    mu, log_sigma = mu.requires_grad_(), log_sigma.requires_grad_()
    prior = [one.double() for one in (drawn[2], drawn[1])]
    by_skill, by_charge = drawn[2].double(), drawn[0][:, 0].double()
    z = drawn_from.skill(mu, log_sigma, noise)
    divergence = drawn_from.divergence(mu, log_sigma, noise, *prior)
    limit = 1.01 * float(divergence.detach().median()) if limited else 0.0
    charged, slope = tempered(divergence, limit)
    wanted = torch.autograd.grad([z, charged], [mu, log_sigma], [by_skill, by_charge])
    found = drawn_from.slopes(mu, log_sigma, noise, *prior, by_skill, slope * by_charge)
    torch.testing.assert_close(found, wanted, rtol=1e-10, atol=1e-10)
