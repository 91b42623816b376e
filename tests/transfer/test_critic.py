"""The ensemble against separate networks, Eq. 8 and 9 in the target against torch.distributions."""

import copy

import pytest
import torch
from torch import nn
from torch.distributions import Normal
from torch.distributions.kl import kl_divergence

from lfr.skills.normalizer import Normalizer
from lfr.transfer.critic import CriticEnsemble, critic_loss, pessimistic, td_target

NAMES = [f"number.{name}" for name in "abcd"]


def member(critics: CriticEnsemble, e: int) -> nn.Sequential:
    """The e-th member as plain torch layers."""
    layers: list[nn.Module] = []
    for layer in critics.layers:
        linear = nn.Linear(layer.weight.shape[1], layer.weight.shape[2])
        linear.weight.data = layer.weight[e].t().clone()
        linear.bias.data = layer.bias[e, 0].clone()
        layers.append(linear)
        if layer.scale is not None and layer.shift is not None:
            norm = nn.LayerNorm(layer.scale.shape[2])
            norm.weight.data, norm.bias.data = layer.scale[e, 0].clone(), layer.shift[e, 0].clone()
            layers.append(norm)
        layers.append(nn.ReLU())
    return nn.Sequential(*layers[:-1])


def _critics(layer_norm: bool) -> CriticEnsemble:
    critics = CriticEnsemble(Normalizer(NAMES), 4, 2, 3, (8, 5), layer_norm=layer_norm)
    critics.vector.normal_()  # scale and shift of the norm, too
    return critics


@pytest.mark.parametrize("layer_norm", [False, True])
def test_ensemble_and_its_gradients_equal_separate_networks_and_autograd(layer_norm):
    torch.manual_seed(0)
    critics = _critics(layer_norm)
    observation, target = torch.randn(7, 4), torch.randn(7)
    z = torch.randn(7, 2, requires_grad=True)
    members = nn.ModuleList(member(critics, e) for e in range(3))
    separate = torch.stack([m(torch.cat([observation, z], -1)).squeeze(-1) for m in members])
    q, traces = critics.values(critics.inputs(observation), z.detach())
    torch.testing.assert_close(q, separate.detach(), rtol=1e-4, atol=1e-5)

    loss, slope = critic_loss(q, target)
    expected = torch.stack([nn.functional.mse_loss(one, target) for one in separate]).sum()
    torch.testing.assert_close(loss, expected.detach())
    expected.backward()
    # The members' gradients, put where the ensemble keeps its own.
    gradients = copy.deepcopy(members)
    for parameter, source in zip(gradients.parameters(), members.parameters(), strict=True):
        assert source.grad is not None
        parameter.data = source.grad
    found = critics.clone()
    found.vector.copy_(critics.by_parameters(traces, slope))
    for e in range(3):
        pairs = zip(member(found, e).parameters(), gradients[e].parameters(), strict=True)
        for one, other in pairs:
            torch.testing.assert_close(one, other, rtol=1e-3, atol=1e-4)
    torch.testing.assert_close(critics.by_skill(traces, slope), z.grad, rtol=1e-3, atol=1e-4)


def test_a_clone_changes_alone():
    critics = _critics(True)
    other, x, z = critics.clone(), torch.randn(5, 4), torch.randn(5, 2)
    before, _ = critics.values(x, z)
    other.vector.mul_(2.0)
    assert torch.equal(critics.values(x, z)[0], before)
    assert not torch.equal(other.values(x, z)[0], before)


def test_initialised_as_torch_does():
    critics = CriticEnsemble(Normalizer(NAMES), 4, 2, 2, (64,), layer_norm=True)
    reference = nn.Linear(6, 64).weight
    first = critics.layers[0]
    assert first.weight.abs().max() <= 6**-0.5
    assert first.weight.std().item() == pytest.approx(reference.std().item(), rel=0.2)
    assert first.scale is not None
    assert (first.scale == 1).all()


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
