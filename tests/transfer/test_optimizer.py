"""The flat Adam against torch's on separate tensors."""

import copy

import torch
from torch import nn

from lfr.transfer.optimizer import FlatAdam, flatten_parameters, trainable


def _gradient(network: nn.Module, loss: torch.Tensor) -> torch.Tensor:
    return torch.cat([g.reshape(-1) for g in torch.autograd.grad(loss, trainable(network))])


def test_equals_adam_on_separate_tensors():
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(3, 5), nn.Tanh(), nn.Linear(5, 1))
    reference = copy.deepcopy(network)
    flat = FlatAdam(flatten_parameters(network), 1e-2)
    adam = torch.optim.Adam(reference.parameters(), lr=1e-2)
    for _ in range(10):
        x = torch.randn(8, 3)
        flat.descend(_gradient(network, network(x).square().mean()))
        adam.zero_grad()
        reference(x).square().mean().backward()
        adam.step()
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
