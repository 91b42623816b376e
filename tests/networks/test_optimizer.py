"""The flat Adam against torch's on separate tensors."""

import copy

import pytest
import torch
from torch import nn

from lfr.networks.optimizer import (
    FlatAdam,
    annealed,
    clip_norm,
    flatten_parameters,
    trainable,
)


def _gradient(network: nn.Module, loss: torch.Tensor) -> torch.Tensor:
    return torch.cat([g.reshape(-1) for g in torch.autograd.grad(loss, trainable(network))])


@pytest.mark.parametrize("weight_decay", [0.0, 0.1])
def test_equals_adamw_on_separate_tensors_annealed_and_clipped(weight_decay: float) -> None:
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(3, 5), nn.Tanh(), nn.Linear(5, 1))
    reference = copy.deepcopy(network)
    flat = FlatAdam(flatten_parameters(network), 1e-2, weight_decay=weight_decay)
    adam = torch.optim.AdamW(reference.parameters(), lr=1e-2, weight_decay=weight_decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(adam, 10)
    for step in range(10):
        x = 10.0 * torch.randn(8, 3)
        flat.lr = annealed(1e-2, step, 10)
        flat.descend(clip_norm(_gradient(network, network(x).square().mean()), 0.05))
        adam.zero_grad()
        reference(x).square().mean().backward()
        nn.utils.clip_grad_norm_(reference.parameters(), 0.05)
        adam.step()
        schedule.step()
    for ours, theirs in zip(network.parameters(), reference.parameters(), strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-5, atol=1e-6)


def test_state_continues_the_same_steps():
    torch.manual_seed(0)
    one, gradients = FlatAdam(torch.randn(4), 1e-2), torch.randn(6, 4)
    for gradient in gradients[:3]:
        one.descend(gradient)
    other = FlatAdam(torch.zeros(4), 1e-2)
    other.load_state(one.state())
    for gradient in gradients[3:]:
        one.descend(gradient)
        other.descend(gradient)
    assert torch.equal(one.flat, other.flat)


def test_frozen_parameters_stay_out():
    network = nn.Linear(2, 2)
    network.bias.requires_grad_(False)
    assert flatten_parameters(network).numel() == 4
