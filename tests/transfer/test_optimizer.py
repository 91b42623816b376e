"""The flat Adam against torch's on separate tensors."""

import copy

import torch
from torch import nn

from lfr.transfer.optimizer import FlatAdam, flatten_parameters


def test_equals_adam_on_separate_tensors():
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(3, 5), nn.Tanh(), nn.Linear(5, 1))
    reference = copy.deepcopy(network)
    flat, adam = FlatAdam(network, 1e-2), torch.optim.Adam(reference.parameters(), lr=1e-2)
    for _ in range(10):
        x = torch.randn(8, 3)
        flat.step(network(x).square().mean())
        adam.zero_grad()
        reference(x).square().mean().backward()
        adam.step()
    for ours, theirs in zip(network.parameters(), reference.parameters(), strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-5, atol=1e-6)


def test_state_continues_the_same_steps():
    torch.manual_seed(0)
    one = nn.Linear(3, 1)
    other = copy.deepcopy(one)
    first = FlatAdam(one, 1e-2)
    x = torch.randn(8, 3)
    for _ in range(3):
        first.step(one(x).square().mean())
    second = FlatAdam(other, 1e-2)
    second.load_state(first.state())
    for _ in range(3):
        first.step(one(x).square().mean())
        second.step(other(x).square().mean())
    assert torch.equal(one.weight, other.weight)


def test_frozen_parameters_stay_out():
    network = nn.Linear(2, 2)
    network.bias.requires_grad_(False)
    assert flatten_parameters(network).numel() == 4
    assert flatten_parameters(network, trainable=False).numel() == 6
