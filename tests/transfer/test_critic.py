"""The ensemble against separate networks, Eq. 8 and 9 in the target against torch.distributions."""

import pytest
import torch
from torch import nn
from torch.distributions import Normal
from torch.distributions.kl import kl_divergence

from lfr.skills.prior import Normalizer
from lfr.transfer.critic import (
    CriticEnsemble,
    EnsembleLayerNorm,
    EnsembleLinear,
    critic_loss,
    pessimistic,
    td_target,
)


def _member(critics: CriticEnsemble, e: int) -> nn.Sequential:
    """The e-th member as plain torch layers."""
    layers: list[nn.Module] = []
    for part in critics.network:
        if isinstance(part, EnsembleLinear):
            linear = nn.Linear(part.weight.shape[1], part.weight.shape[2])
            linear.weight.data = part.weight.data[e].t().clone()
            linear.bias.data = part.bias.data[e, 0].clone()
            layers.append(linear)
        elif isinstance(part, EnsembleLayerNorm):
            norm = nn.LayerNorm(part.features)
            norm.weight.data = part.scale.data[e, 0].clone()
            norm.bias.data = part.shift.data[e, 0].clone()
            layers.append(norm)
        else:
            layers.append(nn.ReLU())
    return nn.Sequential(*layers)


@pytest.mark.parametrize("layer_norm", [False, True])
def test_ensemble_equals_separate_networks(layer_norm):
    critics = CriticEnsemble(
        Normalizer(["a", "b", "c", "d"]), 4, 2, 3, (8, 5), layer_norm=layer_norm
    )
    for parameter in critics.parameters():  # scale and shift of the norm, too
        nn.init.normal_(parameter)
    observation, z, target = torch.randn(7, 4), torch.randn(7, 2), torch.randn(7)
    members = [_member(critics, e) for e in range(3)]
    separate = torch.stack([m(torch.cat([observation, z], -1)).squeeze(-1) for m in members])
    torch.testing.assert_close(critics(observation, z), separate, rtol=1e-4, atol=1e-5)
    loss = sum(nn.functional.mse_loss(q, target) for q in separate)
    torch.testing.assert_close(critic_loss(critics(observation, z), target), loss)


def test_initialised_as_torch_does():
    critics = CriticEnsemble(Normalizer(["a", "b", "c", "d"]), 4, 2, 2, (64,), layer_norm=False)
    reference = nn.Linear(6, 64).weight
    weight = next(critics.parameters())
    assert weight.abs().max() <= 6**-0.5
    assert weight.std().item() == pytest.approx(reference.std().item(), rel=0.2)


def test_pessimistic_is_the_minimum_over_the_chosen():
    q = torch.tensor([[1.0, 5.0], [2.0, 3.0], [0.0, 4.0]])
    assert pessimistic(q).tolist() == [0.0, 3.0]
    assert pessimistic(q, torch.tensor([0, 1])).tolist() == [1.0, 3.0]


def test_target_is_reward_plus_discounted_value_less_divergence():
    """Against Eq. 9 by torch.distributions, and against its Monte Carlo estimate (Eq. 8)."""
    torch.manual_seed(0)
    from lfr.skills.gaussian import kl_divergence as ours

    mu, log_sigma, prior_mu, prior_log_sigma = torch.randn(4, 6, 3).unbind(0)
    policy, prior = Normal(mu, log_sigma.exp()), Normal(prior_mu, prior_log_sigma.exp())
    divergence = kl_divergence(policy, prior).sum(-1)
    reward, q, alpha = torch.rand(6), torch.randn(6), torch.tensor(0.3)
    discount = torch.tensor([0.99, 0.99, 0.0, 0.99, 0.0, 0.99])
    y = td_target(reward, discount, q, alpha, ours(mu, log_sigma, prior_mu, prior_log_sigma))
    torch.testing.assert_close(y, reward + discount * (q - 0.3 * divergence))
    assert torch.equal(y[discount == 0], reward[discount == 0])

    z = policy.sample((200_000,))
    sampled = (policy.log_prob(z) - prior.log_prob(z)).sum(-1)
    error = (sampled.mean(0) - divergence).abs() / (sampled.std(0) / len(z) ** 0.5)
    assert error.max() < 5
