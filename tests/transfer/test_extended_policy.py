"""Eq. 7: pi' = phi o pi; the frozen phi(p_a) of Eq. 9 is out of reach."""

import dataclasses

import torch

from lfr.mapping.generator import Generator
from lfr.transfer.extended_policy import IdentityMap, frozen_prior, initial_policy
from lfr.transfer.learner import Learner
from lfr.transfer.replay import Batch

from .point import NAMES, lfr_initialization


def _batch(size=16):
    g = torch.Generator().manual_seed(3)

    def draw(*shape):
        return torch.randn(*shape, generator=g)

    return Batch(
        draw(size, 3), draw(size, 2), draw(size), torch.full((size,), 0.9), draw(size, 3),
        draw(size, 2), draw(size, 2), draw(size, 2), draw(size, 2),
    )  # fmt: skip


def test_policy_is_phi_after_pi(artifacts):
    observation = torch.randn(5, 3)
    policy = initial_policy(artifacts.source_prior, artifacts.generator, train_phi=True)
    expected = artifacts.generator(*artifacts.source_prior(observation))
    torch.testing.assert_close(policy(observation), expected)


def test_phi_that_sees_the_state_is_given_it(artifacts):
    """G(k, s): through its features, as the learner keeps them, and at once."""
    torch.manual_seed(1)
    g = Generator(2, 8, 3, state_names=NAMES[:2])
    g.fit_scales(torch.randn(9, 4), torch.randn(9, 4), torch.randn(9, 2))
    policy = initial_policy(artifacts.source_prior, g, train_phi=True)
    observation = torch.randn(5, 3)
    expected = g.at(*artifacts.source_prior(observation), observation)
    torch.testing.assert_close(policy(observation), expected)
    torch.testing.assert_close(policy.of_features(policy.features(observation)), expected)
    moved = observation + torch.tensor([0.0, 0.5, 0.0])
    assert not torch.allclose(g.features(moved), g.features(observation))


def test_identity_map_leaves_the_prior(artifacts):
    observation = torch.randn(5, 3)
    policy = initial_policy(artifacts.source_prior, IdentityMap(), train_phi=True)
    torch.testing.assert_close(policy(observation), artifacts.source_prior(observation))


def test_the_least_sigma_is_added_in_quadrature(artifacts):
    observation = torch.randn(200, 3)
    mu, log_sigma = artifacts.source_prior(observation)
    least = float(log_sigma.exp().median())
    expected = (log_sigma.exp().square() + least**2).sqrt()
    for policy in (
        initial_policy(artifacts.source_prior, IdentityMap(), train_phi=True, min_sigma=least),
        frozen_prior(artifacts.source_prior, IdentityMap(), least),
    ):
        found_mu, found = policy(observation)
        torch.testing.assert_close(found_mu, mu)
        torch.testing.assert_close(found.exp(), expected)


def test_sigma_learns_however_small_it_is(artifacts):
    class Sure(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.log_sigma = torch.nn.Parameter(torch.tensor([[-3.0, -1.0]]))

        def forward(self, observation):
            return torch.zeros(1, 2), self.log_sigma

    policy = initial_policy(Sure(), IdentityMap(), train_phi=True, min_sigma=0.2)
    policy(torch.zeros(1, 3))[1].sum().backward()
    # d log sigma' / d log sigma = sigma^2 / (sigma^2 + min_sigma^2)
    square = torch.tensor([[-3.0, -1.0]]).exp().square()
    torch.testing.assert_close(policy.pi.log_sigma.grad, square / (square + 0.04))


def test_learning_leaves_prior_and_artifacts_as_they_were(artifacts, params):
    start = lfr_initialization(artifacts, params)
    observation = torch.randn(5, 3)
    before = start.actor.prior(observation)
    learner = Learner(start.actor.policy, start.normalizer, 3, 2, params, torch.Generator())
    for _ in range(3):
        learner.update(_batch())
    after = start.actor.prior(observation)
    for one, other in zip(before, after, strict=True):
        assert torch.equal(one, other)
        assert not other.requires_grad
    assert not torch.equal(start.actor.policy(observation)[0], before[0])
    expected = artifacts.generator(*artifacts.source_prior(observation))
    torch.testing.assert_close(after, expected)


def test_phi_learns_only_when_asked_to(artifacts, params):
    for train_phi in (True, False):
        start = lfr_initialization(artifacts, dataclasses.replace(params, train_phi=train_phi))
        policy = start.actor.policy
        learner = Learner(policy, start.normalizer, 3, 2, params, torch.Generator())
        for _ in range(params.policy_every):
            learner.update(_batch())
        moved = [
            not torch.equal(a, b)
            for a, b in zip(policy.phi.parameters(), artifacts.generator.parameters(), strict=True)
        ]
        assert any(moved) == train_phi


def test_frozen_prior_shares_nothing(artifacts):
    frozen = frozen_prior(artifacts.source_prior, artifacts.generator)
    shared = {p.data_ptr() for p in artifacts.generator.parameters()}
    assert not shared & {p.data_ptr() for p in frozen.parameters()}
